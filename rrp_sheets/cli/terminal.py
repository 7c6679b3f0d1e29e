"""Commands at the terminal: texts that cannot steer it, a message while something takes long, bundles as FILE."""

from __future__ import annotations

import io
import re
import sys
import threading
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import click

from rrp_sheets.cli.language import speak, translated
from rrp_sheets.errors import SheetsError
from rrp_sheets.model.durations import parse_duration
from rrp_sheets.texts import N_, listed, sentences

if TYPE_CHECKING:
    from rrp_sheets.services.bundles import Bundle

AFTER = 2.0  # s: what is quicker needs no word
_MOST_NOTES = 20
_OURS = r"\x1b(?!\[(?:0|1|2|3[0-7]|9[0-7])m)"  # the colours of click.style pass
_STEERING = re.compile(_OURS + "|[\x00-\x08\x0b\x0c\x0e-\x1a\x1c-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]|\r(?!\n)")


def plain_text(text: str) -> str:
    r"""A text for the terminal: what could steer it is shown as a sign instead (colours of ours excepted).

    >>> plain_text("\x1b[31mred\x1b[0m, \x1b]0;title\x07") == "\x1b[31mred\x1b[0m, \ufffd]0;title\ufffd"
    True
    """
    return _STEERING.sub("\ufffd", text)


class _PlainWriter(io.TextIOWrapper):
    """A stream on which nothing steers the terminal, and a letter that it cannot show is a question mark."""

    def write(self, text: str) -> int:
        super().write(plain_text(text))
        return len(text)


def plain_output() -> None:
    """Let everything that this process prints be plain; JSON that a program reads stays as it is."""
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if not isinstance(stream, io.TextIOWrapper):
            continue  # closed, or somebody else's
        if name == "stdout" and "--json" in sys.argv and not stream.isatty():
            stream.reconfigure(errors="replace")
            continue
        buffered = stream.line_buffering
        encoding = stream.encoding
        setattr(sys, name, _PlainWriter(stream.detach(), encoding, "replace", line_buffering=buffered))


@contextmanager
def said_when_slow(words: str, after: float = AFTER) -> Iterator[None]:
    """Say on the error channel what is being done, when it takes longer than a moment."""
    timer = threading.Timer(after, click.echo, (translated(words),), {"err": True})
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()


def speak_as_run(place: Path) -> None:
    """Print in the language of a recorded run, its folder or its trace, if the reader has named none."""
    from rrp_sheets.recording.metadata import stamp_of

    speak(stamp_of(place if place.is_dir() else place.parent).language)


def say(*parts: str, err: bool = False) -> None:
    """Print texts of the program on one line, in the language of this command."""
    click.echo(" ".join(map(translated, parts)), err=err)


def styled(text: str, **style: Any) -> str:
    """Return a text of the program in the language of this command, coloured for the terminal."""
    return click.style(translated(text), **style)


def usage_error(text: str, option: str = "") -> click.UsageError:
    """Return the error for a command that is typed wrongly; with an option, for what was typed for it."""
    return click.BadParameter(translated(text), param_hint=option) if option else click.UsageError(translated(text))


class WorkbookArgument(click.ParamType):  # type: ignore[type-arg]  # generic for its stubs only, not when it runs
    """A workbook's path; of a bundle the path of the workbook within it, which is unpacked."""

    name = "path"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Path:
        """Return the path of the workbook, which is unpacked first if it is in a bundle."""
        return Path(value) if ctx is None else opened(Path(value), is_file=isinstance(param, click.Argument))


def opened(path: Path, *, is_file: bool = True) -> Path:
    """Return a workbook's path as `WorkbookArgument` does; `is_file` tells that it is the command's FILE.

    Raises:
        UnreadableFile: when it is no bundle.
    """
    if not is_bundle(path):
        return path
    if is_file:
        click.get_current_context().meta[__name__] = path
    return _opened(path).workbook


def is_bundle(path: Path) -> bool:
    """Return whether a path is that of a bundle: an existing .zip file."""
    return path.suffix.casefold() == ".zip" and path.is_file()


def runs_of(path: Path) -> tuple[Path, ...]:
    """The folders of the recorded runs in a bundle, unpacked as long as the command goes on.

    Raises:
        UnreadableFile: when it is no bundle.
        SheetsError: when there is no run in it.
    """
    runs = _opened(path).runs
    if not runs:
        message = N_("There is no recorded run in “{name}”.", name=path.name)
        raise SheetsError(message, N_("Pack it with one: rrp-sheets pack FILE --run RUN"))
    return runs


def _opened(path: Path) -> Bundle:
    from rrp_sheets.services.bundles import unpacked

    bundle = click.get_current_context().with_resource(unpacked(path))
    print_notes(bundle.notes[:_MOST_NOTES])
    if len(bundle.notes) > _MOST_NOTES:
        say(N_("… and {n:,} more.", n=len(bundle.notes) - _MOST_NOTES), err=True)
    return bundle


def quoted(*states: str) -> str:
    """Return the text of a cell in quotes, before and after a change if two are given: `empty → “Say parameter”`."""
    return listed([N_("“{text}”", text=text) if text else N_("empty") for text in states], "→")


def seconds_of(text: str, option: str) -> float | None:
    """Return the seconds of a duration as typed for an option; None when it was left out."""
    us = parse_duration(text, bare="s")
    if text and not us:
        raise usage_error(N_("“{text}” is not a duration; write for example 1.5, 20s or 2 min.", text=text), option)
    return us / 1e6 if us else None


def print_notes(notes: Iterable[str], *, err: bool = True) -> None:
    """Print notes, on the error channel unless they belong to what the command prints."""
    for note in notes:
        say(N_("Note: {note}", note=note), err=err)


def fail(error: SheetsError, code: int) -> NoReturn:
    """Print an error, and exit with a code."""
    say(sentences(styled(N_("Error:"), fg="red", bold=True), error.message), err=True)
    if error.remedy:
        say("  →", error.remedy, err=True)
    sys.exit(code)


def home_of(ctx: click.Context) -> Path | None:
    """The folder of the bundle that a command was given as FILE; None when it was given a workbook."""
    source: Path | None = ctx.meta.get(__name__)
    return None if source is None else source.resolve().parent
