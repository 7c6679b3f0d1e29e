"""`rrp-sheets export RUN… -o FILE`."""

from __future__ import annotations

from pathlib import Path

import click

from rrp_sheets.cli.terminal import told


@click.command(name="export")
@click.argument("runs", metavar="TRACE…", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option("-o", "--output", required=True, type=click.Path(path_type=Path),
              help=".xlsx or .csv: a table; .svg, .pdf or .png: plots")  # fmt: skip
@click.option("--streams", default="", help="of plots: only these streams, with commas between them")
def command(runs: tuple[Path, ...], output: Path, streams: str) -> None:
    """Write what was recorded as a table, or as plots of its numbers.

    TRACE is a run's folder or its trace.jsonl. Several runs become one table, with run, participant and condition in
    its first columns: `rrp-sheets export runs/* -o study.csv`. Times are seconds since the run began. The column
    `blank` names the columns in which a blank came; `ended` and `complete` say how the run ended.

    Every export says which workbook ran (its SHA-256), program, mode, seed, participant, condition and operator: a CSV
    in its columns, an .xlsx on the sheet “About this run”, a picture at its foot and in its metadata.

    Exit code: 0, or 2 when a run cannot be read or the file not be written.
    """
    from rrp_sheets import api

    names = [n.strip() for n in streams.split(",") if n.strip()]
    with told(f"Writing {output.name} …"):
        notes = api.export(runs, output, streams=names)
    for note in notes:
        click.echo(f"Note: {note}", err=True)
    click.echo(f"Written: {output}")
