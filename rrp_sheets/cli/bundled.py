"""FILE of a command: a workbook, or a bundle, which is unpacked into a private folder while the command goes on."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

_MOST_NOTES = 20


class Workbook(click.ParamType):  # type: ignore[type-arg]  # generic for its stubs only, not when it runs
    """A workbook's path; of a bundle the path of the workbook within it, which is unpacked."""

    name = "path"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Path:
        """The path. What is to be known of a bundle is told on the way."""
        path = Path(value)
        if path.suffix.casefold() != ".zip" or not path.is_file() or ctx is None:
            return path
        from rrp_sheets.runs.bundle.unpacking import unpacked

        bundle = ctx.with_resource(unpacked(path))
        ctx.meta[__name__] = path
        for note in bundle.notes[:_MOST_NOTES]:
            click.echo(f"{click.style('Note:', fg='yellow')} {note}", err=True)
        if len(bundle.notes) > _MOST_NOTES:
            click.echo(f"… and {len(bundle.notes) - _MOST_NOTES:,} more.", err=True)
        return bundle.workbook


def home_of(ctx: click.Context) -> Path | None:
    """The folder of the bundle that a command was given; None when it was given a workbook."""
    source: Path | None = ctx.meta.get(__name__)
    return None if source is None else source.resolve().parent
