"""`rrp-sheets convert FILE OUT`."""

from __future__ import annotations

from pathlib import Path

import click


@click.command(name="convert")
@click.argument("file", type=click.Path(path_type=Path))
@click.argument("out", type=click.Path(path_type=Path))
def command(file: Path, out: Path) -> None:
    """Write FILE in another format: OUT is an .xlsx file, a Markdown file (.md), or a folder for CSV files.

    All cells of all sheets are carried over, and the behaviour is the same. Formats, pictures and drop-downs exist
    only in .xlsx. Nothing that exists is overwritten.
    """
    from rrp_sheets import api

    made = api.convert(file, out, replace=False)
    click.echo(f"Made {made}.")
