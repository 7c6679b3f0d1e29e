"""`rrp-sheets new FILE`."""

from __future__ import annotations

from pathlib import Path

import click


@click.command(name="new")
@click.argument("file", type=click.Path(path_type=Path))
@click.option(
    "--template", default="guided", show_default=True, help="guided, empty, or a workbook that comes along: greeter, …"
)
@click.option("--robot", default="nao", show_default=True, help="the robot it is for")
def command(file: Path, template: str, robot: str) -> None:
    """Make FILE: a workbook with a small working behaviour, drop-downs and explanations.

    The template “guided” explains itself; “empty” has the sheets without rows; the others are the workbooks that come
    with the program, ready to be changed (simple-tracking, greeter, …). An existing file is never overwritten.
    """
    from rrp_sheets import api

    made = api.new(file, robot, template)
    click.echo(f"Made {made}. Open it in Excel or LibreOffice, and try it with:")
    click.echo(f'  rrp-sheets run "{made}"')
