"""The language of the command line: the reader's own, in which it prints, explains its options and says what is wrong.

It is that of `--language`, else that of the environment (LANGUAGE, LC_ALL, LC_MESSAGES, LANG, or Windows), else that of
the workbook in question. What click prints has its translations in the same catalogue.
"""

from __future__ import annotations

import gettext
import inspect
import locale
import os
import re
import sys
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from copy import copy

import click

from rrp_sheets.render.style import columns
from rrp_sheets.texts import LANGUAGES, LOCALE, LazyMessage, translate

_readers: ContextVar[str] = ContextVar("reader's language", default="")
_spoken: ContextVar[str] = ContextVar("language", default="en")
_NAME = "--language"
_VARIABLES = ("LC_ALL", "LC_MESSAGES", "LANG")
gettext.bindtextdomain("messages", str(LOCALE))  # in which click looks for its texts


def speak(language: str) -> None:
    """Print in the language of the reader from now on; in this one, a workbook's, if the reader has named none."""
    _spoken.set(_readers.get() or language)


def readers_language() -> str:
    """Return the code of the language that the reader has named; empty for none."""
    return _readers.get()


def spoken() -> str:
    """Return the code of the language in which this command prints."""
    return _spoken.get()


def translated(text: str) -> str:
    """Return a text of the program in the language of this command."""
    return translate(text, _spoken.get())


@contextmanager
def readers_words(arguments: Sequence[str]) -> Iterator[None]:
    """Speak the language that the arguments of the program or its environment name, to the end of the block."""
    before = os.environ.get("LANGUAGE")
    named = _named(arguments) or of_environment()
    tokens = _readers.set(named), _spoken.set(named or "en")
    os.environ["LANGUAGE"] = named or "en"  # by which click finds its texts, whose errors are shown at the very end
    try:
        yield
    finally:
        _readers.reset(tokens[0])
        _spoken.reset(tokens[1])
        if before is None:
            del os.environ["LANGUAGE"]
        else:
            os.environ["LANGUAGE"] = before


def _named(arguments: Sequence[str]) -> str:
    """Return the language of the last `--language ja` or `--language=ja`; click refuses one that there is not."""
    found = ""
    for at, one in enumerate(arguments):
        if one == "--":
            break
        name, equals, value = one.partition("=")
        if name == _NAME:
            value = value if equals else next(iter(arguments[at + 1 :]), "")
            found = value if value in LANGUAGES else found
    return found


def of_environment() -> str:
    """Return the code of the language that the environment names, as gettext reads it; empty for none that there is."""
    name = next((value for variable in _VARIABLES if (value := os.environ.get(variable))), "")
    if not name and sys.platform == "win32":
        import ctypes

        name = locale.windows_locale.get(ctypes.windll.kernel32.GetUserDefaultUILanguage(), "")
    if _code(name) in ("C", "POSIX"):
        return ""
    wanted = [*os.environ.get("LANGUAGE", "").split(":"), name]
    return next((code for code in map(_code, wanted) if code in LANGUAGES), "")


def _code(name: str) -> str:
    """Return the language of a locale's name: `ja` of `ja_JP.UTF-8`."""
    return re.split(r"[_.@-]", name, maxsplit=1)[0]


# ---- help
def in_readers_language(command: click.Command) -> click.Command:
    """Return a command that takes `--language`, with its help and errors in the reader's language."""
    own = copy(command)
    own.context_class = _Context
    own._help_option = None  # the text of one that was used already is in the language of then
    own.help = "\n\n".join(map(_shown, paragraphs(command.help)))
    own.short_help = _shown(command.short_help or "") or None
    own.params = [*map(_in_words, command.params)]
    if not any(_NAME in param.opts for param in own.params):
        own.params.append(_in_words(language_option()))
    if isinstance(own, click.Group):
        own.commands = {name: in_readers_language(one) for name, one in own.commands.items()}
    return own


def language_option() -> click.Option:
    """Return the option of commands that do not use the language themselves."""
    choices, about = click.Choice(list(LANGUAGES)), "the language of messages  [default: your computer's]"
    return click.Option([_NAME], type=choices, expose_value=False, help=about)


def _in_words(param: click.Parameter) -> click.Parameter:
    if not isinstance(param, click.Option) or not param.help:
        return param
    own = copy(param)
    own.help = _shown(param.help)
    return own


def _shown(text: str) -> str:
    return text if "\b" in text else translated(LazyMessage(text)) if text else ""


def paragraphs(text: str | None) -> list[str]:
    """Return the paragraphs of a help, each on one line; of commands to be typed, after a backspace, as they are."""
    found = inspect.cleandoc(text or "").split("\n\n")
    return [one if "\b" in one else " ".join(one.split()) for one in found if one]


_WIDE = "\u3000-\u9fff\uff00-\uffef"
_PIECE = re.compile(
    rf"[「『（]*(?:[{_WIDE}]|[^\s{_WIDE}]+)[、。，．）」』！？：；・ー…々\])ぁぃぅぇぉっゃゅょァィゥェォッャュョ]*\s*"
)
"""What a line may end after: a word, or a Japanese letter with the signs that belong to it."""


def _wrapped(text: str, room: int) -> list[str]:
    """Cut a text without blanks between its words into lines of so many columns.

    >>> _wrapped("ブックの問題を表示します。", 12)
    ['ブックの問題', 'を表示しま', 'す。']
    """
    lines = [""]
    for piece in _PIECE.findall(text):
        if lines[-1] and columns((lines[-1] + piece).rstrip()) > room:
            lines.append("")
        lines[-1] += piece
    return [line.rstrip() for line in lines]


class _Formatter(click.HelpFormatter):
    """Wraps Japanese texts by the columns that they take; click would count letters, and cut at blanks alone."""

    def write_text(self, text: str) -> None:
        for number, paragraph in enumerate(text.split("\n\n")):
            if number:
                self.write("\n")
            if len(paragraph) == columns(paragraph):
                super().write_text(paragraph)
            else:
                indent = " " * self.current_indent
                lines = _wrapped(paragraph, self.width - self.current_indent)
                self.write("".join(f"{indent}{line}\n" for line in lines))

    def write_dl(self, rows: Iterable[tuple[str, str]], col_max: int = 30, col_spacing: int = 2) -> None:
        rows = list(rows)
        if all(len(text) == columns(text) for row in rows for text in row):
            super().write_dl(rows, col_max, col_spacing)
            return
        first = min(max(columns(term) for term, _ in rows), col_max) + col_spacing
        outer, inner = " " * self.current_indent, " " * (self.current_indent + first)
        for term, text in rows:
            fits = columns(term) <= first - col_spacing
            start = outer + term + (" " * (first - columns(term)) if fits else f"\n{inner}")
            self.write(start + f"\n{inner}".join(_wrapped(text, max(self.width - first - 2, 10))) + "\n")


class _Context(click.Context):
    formatter_class = _Formatter
