"""Commands that show what a workbook does: `explain`, `diagram`, `marbles`, `print`."""

from __future__ import annotations

import shutil
import sys
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rrp_sheets.cli.terminal import (
    WorkbookArgument,
    fail,
    home_of,
    print_notes,
    said_when_slow,
    say,
    speak,
    speak_as_run,
)
from rrp_sheets.model.durations import parse_duration
from rrp_sheets.texts import LANGUAGES, N_

if TYPE_CHECKING:
    from rrp_sheets.checks import Checked


@click.command(name="explain")
@click.argument("file", type=WorkbookArgument())
@click.option("-o", "--output", type=click.Path(path_type=Path), help="a text file to write instead of printing")
@click.option("--behaviour", default="", help="only this behaviour (a sheet's name)")
@click.option("--language", type=click.Choice(list(LANGUAGES)), default=None, help="instead of the Protocol's Language")
def explain_command(file: Path, output: Path | None, behaviour: str, language: str | None) -> None:
    """Say in plain words what FILE does: a paragraph per behaviour and a sentence per row.

    Exit code: 0, or 1 when the workbook has errors (what is understood is told), 2 when it cannot be read.
    """
    from rrp_sheets import api
    from rrp_sheets.cli.check import print_findings
    from rrp_sheets.render.output import explain
    from rrp_sheets.workbook.atomic import refuse_workbook, write_atomically

    if output is not None:
        refuse_workbook(output, file)
    speak(language or "en")
    checked = api.check(file)
    speak(language or checked.run.language)
    text = explain(checked, behaviour, language or "")
    print_findings(checked.report.errors, err=True)
    if output is None:
        click.echo(text)
    else:
        write_atomically(output, (text + "\n").encode())
        say(N_("Written: {path}", path=output))
    sys.exit(1 if checked.report.errors else 0)


@click.command(name="diagram")
@click.argument("file", type=WorkbookArgument())
@click.option("-o", "--output", type=click.Path(path_type=Path), help="the picture: .svg, .pdf, .png or .dot")
@click.option("--behaviour", default="", help="only this behaviour (a sheet's name)")
@click.option("--language", type=click.Choice(list(LANGUAGES)), default=None, help="instead of the Protocol's Language")
def diagram_command(file: Path, output: Path | None, behaviour: str, language: str | None) -> None:
    """Draw the behaviours of FILE: sensors at the top, actuators at the bottom, rows numbered as in the sheet.

    A workbook with errors is drawn as far as it is understood, with flags at the rows in question.

    Exit code: 0, or 1 when the workbook has errors, 2 when it cannot be read.
    """
    from rrp_sheets import api
    from rrp_sheets.cli.check import print_findings
    from rrp_sheets.render.output import draw

    target = output or Path(file.name).with_suffix(".svg")
    speak(language or "en")
    checked = api.check(file)
    speak(language or checked.run.language)
    lacks = draw(checked, target, behaviour, language or "")
    print_findings(checked.report.errors, err=True)
    print_notes(lacks)
    say(N_("Drawn: {path}", path=target))
    sys.exit(1 if checked.report.errors else 0)


@click.command(name="marbles")
@click.argument("source", metavar="TRACE|FILE", type=click.Path(path_type=Path))
@click.option("-o", "--output", type=click.Path(path_type=Path),
              help="the picture: .svg, .pdf, .png or .txt; without it, text in the terminal")  # fmt: skip
@click.option("--behaviour", default="", help="only this behaviour (a sheet's name)")
@click.option("--from", "first", default="", help="from this time on, for example 5s")
@click.option("--to", "last", default="", help="up to this time, for example 8s")
@click.option("--streams", default="", help="only these streams, with commas between them")
def marbles_command(source: Path, output: Path | None, behaviour: str, first: str, last: str, streams: str) -> None:
    """Draw what came on the streams, a line for each: of a recorded run, or of a workbook's tests.

    TRACE is a run's folder or its trace.jsonl. Of a FILE the tests are run, and each is drawn.

    Exit code: 0, or 1 when the workbook has errors or no tests, 2 when it cannot be read.
    """
    from rrp_sheets import api
    from rrp_sheets.render.output import text_of

    window = (_time(first, "--from"), _time(last, "--to"))
    names = [n.strip() for n in streams.split(",") if n.strip()]
    speak_as_run(source)
    with said_when_slow(f"Reading {source.name} …"):
        checked, scores = api.marbles(source, behaviour=behaviour, window=window, streams=names)
    if checked is not None:
        speak(checked.run.language)
    if scores is None:
        from rrp_sheets.cli.check import print_findings

        errors = checked.report.errors if checked else []
        print_findings(errors, err=True)
        none = N_("This workbook has no tests to draw.")
        say(N_("The workbook has errors.") if errors else none, err=True)
        sys.exit(1)
    if output is None:
        columns = max(60, min(200, shutil.get_terminal_size((110, 24)).columns - 1))
        click.echo(text_of(scores, columns), nl=False)
        return
    with said_when_slow(f"Drawing {output.name} …"):
        notes = api.draw_marbles(scores, output)
    print_notes(notes)
    say(N_("Drawn: {path}", path=output))


def _time(text: str, option: str) -> int | None:
    if not text:
        return None
    us = parse_duration(text, bare="s")
    if us is None:
        raise click.BadParameter(f"“{text}” is not a time; write for example 5s or 500 ms.", param_hint=option)
    return us


@click.command(name="print")
@click.argument("file", type=WorkbookArgument())
@click.option("-o", "--output", type=click.Path(path_type=Path), help="the PDF; by default beside FILE, with its name")
@click.option("--against", metavar="APPROVED", type=WorkbookArgument(), help="mark what changed since then")
@click.option("--paper", type=click.Choice(["a4", "letter"]), default="a4", show_default=True, help="the paper's size")
@click.option("--language", type=click.Choice(list(LANGUAGES)), default=None, help="by default the Protocol's")
@click.option("--draft", is_flag=True, help="mark every page as a draft; the workbook may have errors then")
@click.option("--date", "day", type=click.DateTime(["%Y-%m-%d"]), help="the day that is printed; by default today")
def print_command(
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
    from rrp_sheets.services.printing import HasErrors, print_pack
    from rrp_sheets.workers.worker_loop import lift_limit

    home = home_of(click.get_current_context())
    beside = home / file.name if home else file
    target = output or (beside if beside.name else beside.resolve()).with_suffix(".pdf")
    if target.suffix.casefold() != ".pdf":
        raise click.UsageError("The file ends with .pdf: rrp-sheets print FILE -o protocol.pdf")
    speak(language or "en")

    def gathered(checked: Checked) -> None:
        lift_limit()  # no formula is evaluated any more
        speak(language or checked.run.language)

    try:
        made = print_pack(
            file, target, against=against, paper="letter" if paper == "letter" else "a4", language=language or "",
            draft=draft, today=day.date() if day else None, gathered=gathered,
        )  # fmt: skip
    except HasErrors as error:
        speak(language or error.checked.run.language)
        print_findings(error.checked.report.errors, err=True)
        fail(error, 1)
    print_findings(made.checked.report.errors, err=True)
    print_notes(made.notes)
    say(N_("Printed: {path}", path=target))
    sys.exit(1 if made.checked.report.errors else 0)
