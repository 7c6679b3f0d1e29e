"""`rrp-sheets explain FILE`."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from rrp_sheets.cli.terminal import WorkbookArgument
from rrp_sheets.errors import SheetsError
from rrp_sheets.model.languages import LANGUAGES


@click.command(name="explain")
@click.argument("file", type=WorkbookArgument())
@click.option("-o", "--output", type=click.Path(path_type=Path), help="a text file to write instead of printing")
@click.option("--behaviour", default="", help="only this behaviour (a sheet's name)")
@click.option("--language", type=click.Choice(list(LANGUAGES)), default=None, help="instead of the Protocol's Language")
def command(file: Path, output: Path | None, behaviour: str, language: str | None) -> None:
    """Say in plain words what FILE does: a paragraph per behaviour and a sentence per row.

    Exit code: 0, or 1 when the workbook has errors (what is understood is told), 2 when it cannot be read.
    """
    from rrp_sheets import api
    from rrp_sheets.cli.check import print_findings
    from rrp_sheets.workbook.atomic import refuse_workbook, write_atomically

    if output is not None:
        refuse_workbook(output, file)
    text, checked = api.explain(file, behaviour, language or "")
    print_findings(checked.report.errors, err=True, language=language or checked.run.language)
    if output is None:
        click.echo(text)
    else:
        try:
            write_atomically(output, (text + "\n").encode())
        except OSError as error:
            raise SheetsError(f"“{output}” cannot be written ({error.strerror}).", "Name another file.") from None
        click.echo(f"Written: {output}")
    sys.exit(1 if checked.report.errors else 0)
