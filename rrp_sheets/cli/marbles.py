"""`rrp-sheets marbles TRACE|FILE -o x.svg`."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

import click

from rrp_sheets.cli.terminal import told
from rrp_sheets.model.durations import parse_duration


@click.command(name="marbles")
@click.argument("source", metavar="TRACE|FILE", type=click.Path(path_type=Path))
@click.option("-o", "--output", type=click.Path(path_type=Path),
              help="the picture: .svg, .pdf, .png or .txt; without it, text in the terminal")  # fmt: skip
@click.option("--behaviour", default="", help="only this behaviour (a sheet's name)")
@click.option("--from", "first", default="", help="from this time on, for example 5s")
@click.option("--to", "last", default="", help="up to this time, for example 8s")
@click.option("--streams", default="", help="only these streams, with commas between them")
def command(source: Path, output: Path | None, behaviour: str, first: str, last: str, streams: str) -> None:
    """Draw what came on the streams, a line for each: of a recorded run, or of a workbook's tests.

    TRACE is a run's folder or its trace.jsonl. Of a FILE the tests are run, and each is drawn.

    Exit code: 0, or 1 when the workbook has errors or no tests, 2 when it cannot be read.
    """
    from rrp_sheets import api
    from rrp_sheets.render.output import text_of

    window = (_time(first, "--from"), _time(last, "--to"))
    names = [n.strip() for n in streams.split(",") if n.strip()]
    with told(f"Reading {source.name} …"):
        checked, scores = api.marbles(source, behaviour=behaviour, window=window, streams=names)
    if scores is None:
        from rrp_sheets.cli.check import print_findings

        errors = checked.report.errors if checked else []
        print_findings(errors, err=True)
        click.echo("The workbook has errors." if errors else "This workbook has no tests to draw.", err=True)
        sys.exit(1)
    if output is None:
        columns = max(60, min(200, shutil.get_terminal_size((110, 24)).columns - 1))
        click.echo(text_of(scores, columns), nl=False)
        return
    with told(f"Drawing {output.name} …"):
        notes = api.draw_marbles(scores, output)
    for note in notes:
        click.echo(f"Note: {note}", err=True)
    click.echo(f"Drawn: {output}")


def _time(text: str, option: str) -> int | None:
    if not text:
        return None
    us = parse_duration(text, bare="s")
    if us is None:
        raise click.BadParameter(f"“{text}” is not a time; write for example 5s or 500 ms.", param_hint=option)
    return us
