"""`rrp-sheets set FILE CELL VALUE`."""

from __future__ import annotations

from pathlib import Path

import click

_SHOWN = 3  # findings


@click.command(name="set", context_settings={"ignore_unknown_options": True})
@click.argument("file", type=click.Path(path_type=Path))
@click.argument("cell")
@click.argument("value")
@click.option("--sheet", default="", help="the sheet, where CELL does not name it; default: the first behaviour")
def command(file: Path, cell: str, value: str, sheet: str) -> None:
    """Put VALUE into one CELL of FILE (Tracking!C5, or C5) and leave everything else in the file as it is.

    A number stays a number, TRUE and FALSE too; everything else is a text, also what begins with “=”. An empty VALUE
    ("") empties the cell.
    """
    from rrp_sheets import api
    from rrp_sheets.cli.check import print_findings, verdict

    done = api.set_cell(file, cell, value, sheet)
    was, now = (f"“{text}”" if text else "empty" for text in (done.before, done.after))
    click.echo(f"{done.address}: {was} → {now}" if was != now else f"{done.address} is {now} already.")
    click.echo(f"Check: {verdict(done.report)}")
    found = [d for d in done.report if d.severity.value != "info"]
    found.sort(key=lambda d: (d.severity.value != "error", d.address != done.address))  # those of this cell first
    print_findings(found[:_SHOWN])
    if len(found) > _SHOWN:
        click.echo(f'All of them: rrp-sheets check "{file}"')
