"""`rrp-sheets pack FILE`."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path

import click

from rrp_sheets.cli.terminal import WorkbookArgument, told


@click.command(name="pack")
@click.argument("file", type=click.Path(path_type=Path))
@click.option("-o", "--output", type=click.Path(path_type=Path), help="the bundle's file (.zip)")
@click.option("--run", "runs", multiple=True, metavar="RUN",
              help="put a recorded run in: its folder, or its name in runs beside FILE; may come again")  # fmt: skip
@click.option("--against", type=WorkbookArgument(), help="the approved version, for the printed list of changes")
@click.option("--date", "day", type=click.DateTime(["%Y-%m-%d"]), help="the day that is printed; by default today")
def command(file: Path, output: Path | None, runs: tuple[str, ...], against: Path | None, day: datetime | None) -> None:
    """Make one zip of FILE and all that is needed to run it elsewhere: a bundle.

    In it: the workbook as it is, the printed protocol, the robot's catalogue, the sounds and pictures that the workbook
    names, the chosen runs, and the versions of everything. The same files give the same bytes on the same day.

    \b
    Then, on any machine with the program:  rrp-sheets run BUNDLE.zip
                                            rrp-sheets replay BUNDLE.zip

    check, diagram, explain, test, print and diff take a bundle as well.

    Exit code: 0, or 2 when the workbook cannot be read or the bundle cannot be written.
    """  # noqa: D301 – click takes the backspace for "leave these lines as they are"
    from rrp_sheets import api

    with told(f"Packing {file.name} and printing its protocol …"):
        packed = api.pack(file, output, runs=runs, against=against, today=day.date() if day else None)
    for note in packed.notes:
        click.echo(f"Note: {note}", err=True)
    if runs:
        click.echo(
            "Note: A run holds what was recorded of its participant, pictures and what was said included. "
            "Look at it before you pass the bundle on.",
            err=True,
        )
    size = packed.path.stat().st_size
    click.echo(f"Packed: {packed.path} ({len(packed.files)} files, {size / 1e6:.1f} MB)")
