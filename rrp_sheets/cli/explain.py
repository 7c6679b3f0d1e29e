"""`rrp-sheets explain FILE`."""

from __future__ import annotations

from pathlib import Path

import click


@click.command(name="explain")
@click.argument("file", type=click.Path(path_type=Path))
@click.option("-o", "--output", type=click.Path(path_type=Path), help="a text file to write instead of printing")
@click.option("--behaviour", default="", help="only this behaviour (a sheet's name)")
def command(file: Path, output: Path | None, behaviour: str) -> None:
    """Say in plain words what FILE does: a paragraph per behaviour and a sentence per row."""
    from rrp_sheets import api
    from rrp_sheets.cli.check import print_findings

    text, checked = api.explain(file, behaviour)
    print_findings(checked.report.errors, err=True)
    if output is None:
        click.echo(text)
    else:
        output.write_text(text + "\n", encoding="utf-8")
        click.echo(f"Written: {output}")
