"""`rrp-sheets convert FILE OUT`."""

from __future__ import annotations

from pathlib import Path

import click


@click.command(name="convert")
@click.argument("file", type=click.Path(path_type=Path))
@click.argument("out", required=False, type=click.Path(path_type=Path))
@click.option("-o", "--output", type=click.Path(path_type=Path), help="the same as OUT, as the other commands have it")
def command(file: Path, out: Path | None, output: Path | None) -> None:
    """Write FILE in another format: OUT is an .xlsx file, a Markdown file (.md), or a folder for CSV files.

    All cells of all sheets are carried over, and the behaviour is the same. Formats, pictures, drop-downs and their
    sheet Lists exist only in .xlsx. Nothing that exists is overwritten.
    """
    from rrp_sheets import api

    if (out is None) == (output is None):
        raise click.UsageError("Name one file or folder to write: OUT, or -o OUT.")
    target = out or output
    assert target is not None
    made = api.convert(file, target, replace=False)
    click.echo(f"Made {made}.")
