"""`rrp-sheets new FILE`."""

from __future__ import annotations

from pathlib import Path

import click


@click.command(name="new")
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--robot", default="nao", show_default=True, help="the robot it is for")
def command(file: Path, robot: str) -> None:
    """Make FILE: a workbook with a small working behaviour, drop-downs and explanations.

    An existing file is never overwritten.
    """
    from rrp_sheets import api

    made = api.new(file, robot)
    click.echo(f"Made {made}. Open it in Excel or LibreOffice, and try it with:")
    click.echo(f'  rrp-sheets run "{made}"')
