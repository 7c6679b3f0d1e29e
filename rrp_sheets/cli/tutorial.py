"""`rrp-sheets tutorial [FOLDER]`."""

from __future__ import annotations

from pathlib import Path

import click

from rrp_sheets.cli.serve import command as serve
from rrp_sheets.errors import SheetsError


@click.command(name="tutorial")
@click.argument("folder", type=click.Path(path_type=Path), default=".")
@click.option("--anew", is_flag=True, help="begin with a fresh copy; the one that is there stays")
@click.option("--port", type=click.IntRange(1, 65535), help="the port; without it a free one is taken")
@click.option("--no-browser", is_flag=True, help="only print the address, do not open a browser")
@click.pass_context
def command(ctx: click.Context, folder: Path, anew: bool, port: int | None, no_browser: bool) -> None:
    """Learn in ten short lessons how a robot behaves by the rows of a table.

    Makes tutorial.xlsx in FOLDER (by default this one) and opens it in the browser, as `rrp-sheets serve` does. Each
    lesson has a test that turns green when it is done. When there is a tutorial in FOLDER already, you go on with it.

    Ctrl-C ends the server; what you have done is in the file.
    """
    from rrp_sheets.documents.tutorial import begin, latest

    if not folder.is_dir():
        raise SheetsError(f"There is no folder {folder}.", "Make it first, or name another.")
    there = None if anew else latest(folder)
    path = there or begin(folder)
    click.echo(f"You go on with {path}; --anew begins with a fresh copy." if there else f"Made {path}.")
    ctx.invoke(serve, folder=path, port=port, lan=False, no_browser=no_browser)
