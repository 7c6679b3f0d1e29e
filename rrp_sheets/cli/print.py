"""`rrp-sheets print FILE -o protocol.pdf`."""

from __future__ import annotations

import sys
from datetime import datetime
from pathlib import Path

import click

from rrp_sheets.cli.terminal import WorkbookArgument, home_of
from rrp_sheets.model.languages import LANGUAGES


@click.command(name="print")
@click.argument("file", type=WorkbookArgument())
@click.option("-o", "--output", type=click.Path(path_type=Path), help="the PDF; by default beside FILE, with its name")
@click.option("--against", metavar="APPROVED", type=WorkbookArgument(), help="mark what changed since then")
@click.option("--paper", type=click.Choice(["a4", "letter"]), default="a4", show_default=True, help="the paper's size")
@click.option("--language", type=click.Choice(list(LANGUAGES)), default=None, help="by default the Protocol's")
@click.option("--draft", is_flag=True, help="mark every page as a draft; the workbook may have errors then")
@click.option("--date", "day", type=click.DateTime(["%Y-%m-%d"]), help="the day that is printed; by default today")
def command(
    file: Path, output: Path | None, against: Path | None, paper: str, language: str | None, draft: bool,
    day: datetime | None,
) -> None:  # fmt: skip
    """Print FILE for an ethics board: an accessible PDF that says what the robot senses, keeps, says and does.

    It has the diagrams, the rows in words and as tables, what the operator drives by hand, how it stops, what is still
    open, and what changed since the approved version. The SHA-256 of FILE stands on the first page,
    its first 16 digits on every page.

    Exit code: 0, or 1 when the workbook has errors (nothing is printed, unless as a draft), 2 when it cannot be read.
    """
    from rrp_sheets.cli.check import print_findings
    from rrp_sheets.cli.main import fail
    from rrp_sheets.printing import HasErrors, print_pack
    from rrp_sheets.workers.worker_loop import lift_limit

    home = home_of(click.get_current_context())
    beside = home / file.name if home else file
    target = output or (beside if beside.name else beside.resolve()).with_suffix(".pdf")
    if target.suffix.casefold() != ".pdf":
        raise click.UsageError("The file ends with .pdf: rrp-sheets print FILE -o protocol.pdf")
    try:
        made = print_pack(
            file, target, against=against, paper="letter" if paper == "letter" else "a4", language=language or "",
            draft=draft, today=day.date() if day else None, gathered=lift_limit,
        )  # fmt: skip
    except HasErrors as error:
        print_findings(error.checked.report.errors, err=True, language=language or error.checked.run.language)
        fail(error, 1)
    print_findings(made.checked.report.errors, err=True, language=language or made.checked.run.language)
    for note in made.notes:
        click.echo(f"Note: {note}", err=True)
    click.echo(f"Printed: {target}")
    sys.exit(1 if made.checked.report.errors else 0)
