"""`rrp-sheets diagram FILE -o x.svg`."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from rrp_sheets.cli.terminal import WorkbookArgument
from rrp_sheets.model.languages import LANGUAGES


@click.command(name="diagram")
@click.argument("file", type=WorkbookArgument())
@click.option("-o", "--output", type=click.Path(path_type=Path), help="the picture: .svg, .pdf, .png or .dot")
@click.option("--behaviour", default="", help="only this behaviour (a sheet's name)")
@click.option("--language", type=click.Choice(list(LANGUAGES)), default=None, help="instead of the Protocol's Language")
def command(file: Path, output: Path | None, behaviour: str, language: str | None) -> None:
    """Draw the behaviours of FILE: sensors at the top, actuators at the bottom, rows numbered as in the sheet.

    A workbook with errors is drawn as far as it is understood, with flags at the rows in question.

    Exit code: 0, or 1 when the workbook has errors, 2 when it cannot be read.
    """
    from rrp_sheets import api
    from rrp_sheets.cli.check import print_findings

    target = output or Path(file.name).with_suffix(".svg")
    checked, lacks = api.draw(file, target, behaviour, language or "")
    print_findings(checked.report.errors, err=True, language=language or checked.run.language)
    for note in lacks:
        click.echo(f"Note: {note}", err=True)
    click.echo(f"Drawn: {target}")
    sys.exit(1 if checked.report.errors else 0)
