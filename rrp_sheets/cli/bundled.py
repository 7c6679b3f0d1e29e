"""FILE of a command: a workbook, or a bundle, which is unpacked into a private folder while the command runs."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rrp_sheets.errors import SheetsError

if TYPE_CHECKING:
    from rrp_sheets.runs.bundle.unpacking import Bundle

_MOST_NOTES = 20


class WorkbookArgument(click.ParamType):  # type: ignore[type-arg]  # generic for its stubs only, not when it runs
    """A workbook's path; of a bundle the path of the workbook within it, which is unpacked."""

    name = "path"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Path:
        """Return the path of the workbook, which is unpacked first if it is in a bundle."""
        path = Path(value)
        if ctx is None or not is_bundle(path):
            return path
        if isinstance(param, click.Argument):
            ctx.meta[__name__] = path
        return _opened(ctx, path).workbook


def opened(path: Path, *, is_file: bool = True) -> Path:
    """Return a workbook's path as `WorkbookArgument` does; `is_file` tells that it is the command's FILE.

    Raises:
        UnreadableFile: when it is no bundle.
    """
    ctx = click.get_current_context()
    if not is_bundle(path):
        return path
    if is_file:
        ctx.meta[__name__] = path
    return _opened(ctx, path).workbook


def is_bundle(path: Path) -> bool:
    """Return whether a path is that of a bundle: an existing .zip file."""
    return path.suffix.casefold() == ".zip" and path.is_file()


def runs_of(path: Path) -> tuple[Path, ...]:
    """The folders of the recorded runs in a bundle, unpacked as long as the command goes on.

    Raises:
        UnreadableFile: when it is no bundle.
        SheetsError: when there is no run in it.
    """
    runs = _opened(click.get_current_context(), path).runs
    if not runs:
        raise SheetsError(
            f"There is no recorded run in “{path.name}”.", "Pack it with one: rrp-sheets pack FILE --run RUN"
        )
    return runs


def _opened(ctx: click.Context, path: Path) -> Bundle:
    """Unpack a bundle, and print the notes on it."""
    from rrp_sheets.runs.bundle.unpacking import unpacked

    bundle = ctx.with_resource(unpacked(path))
    for note in bundle.notes[:_MOST_NOTES]:
        click.echo(f"{click.style('Note:', fg='yellow')} {note}", err=True)
    if len(bundle.notes) > _MOST_NOTES:
        click.echo(f"… and {len(bundle.notes) - _MOST_NOTES:,} more.", err=True)
    return bundle


def home_of(ctx: click.Context) -> Path | None:
    """The folder of the bundle that a command was given as FILE; None when it was given a workbook."""
    source: Path | None = ctx.meta.get(__name__)
    return None if source is None else source.resolve().parent
