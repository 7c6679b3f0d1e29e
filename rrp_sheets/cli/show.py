"""Commands that show what a workbook does, `explain`, `diagram`, `marbles`, `print`, and what changed in it, `diff`."""

from __future__ import annotations

import hashlib
import json
import re
import shutil
import sys
from collections.abc import Sequence
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rrp_sheets.cli.language import readers_language, speak, translated
from rrp_sheets.cli.terminal import (
    WorkbookArgument,
    fail,
    home_of,
    opened,
    print_notes,
    said_when_slow,
    say,
    speak_as_run,
    styled,
    usage_error,
)
from rrp_sheets.errors import UnreadableFile
from rrp_sheets.model.durations import parse_duration
from rrp_sheets.model.names import key
from rrp_sheets.texts import LANGUAGES, N_
from rrp_sheets.workbook import Reading
from rrp_sheets.workbook.raw import RawSheet
from rrp_sheets.workbook.schema import recognise
from rrp_sheets.workbook.text_books import to_markdown

if TYPE_CHECKING:
    from rrp_sheets.checks import Checked
    from rrp_sheets.services.changes_drawn import Compared


@click.command(name="explain")
@click.argument("file", type=WorkbookArgument())
@click.option("-o", "--output", type=click.Path(path_type=Path), help="a text file to write instead of printing")
@click.option("--behaviour", default="", help="only this behaviour (a sheet's name)")
@click.option(
    "--language",
    type=click.Choice(list(LANGUAGES)),
    default=None,
    help="the language  [default: your computer's, then the Protocol's]",
)
def explain_command(file: Path, output: Path | None, behaviour: str, language: str | None) -> None:
    """Explain in plain words what FILE does: a paragraph for each behaviour and a sentence for each row.

    Exit code: 0 explained, 1 the workbook has errors (the other rows are explained), 2 it cannot be read.
    """
    from rrp_sheets import api
    from rrp_sheets.cli.check import print_findings
    from rrp_sheets.render.output import explain
    from rrp_sheets.workbook.files import refuse_workbook, write_atomically

    if output is not None:
        refuse_workbook(output, file)
    speak(language or "en")
    checked = api.check(file)
    speak(language or checked.run.language)
    text = explain(checked, behaviour, language or readers_language())
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
@click.option(
    "--language", type=click.Choice(list(LANGUAGES)), default=None, help="the language  [default: the Protocol's]"
)
def diagram_command(file: Path, output: Path | None, behaviour: str, language: str | None) -> None:
    """Draw the behaviours of FILE: sensors at the top, actuators at the bottom, rows numbered as on the sheet.

    Rows with errors are marked with flags.

    Exit code: 0 drawn, 1 the workbook has errors, 2 it cannot be read.
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
              help="the picture: .svg, .pdf, .png or .txt  [default: text in the terminal]")  # fmt: skip
@click.option("--behaviour", default="", help="only this behaviour (a sheet's name)")
@click.option("--from", "first", default="", help="from this time, for example 5s")
@click.option("--to", "last", default="", help="up to this time, for example 8s")
@click.option("--streams", default="", help="only these streams, separated by commas")
def marbles_command(source: Path, output: Path | None, behaviour: str, first: str, last: str, streams: str) -> None:
    """Draw the values of the streams over time, one line for each stream: of a recorded run, or of the tests.

    TRACE is a run's folder or its trace.jsonl. For a FILE its tests are run, and each test is drawn.

    Exit code: 0 drawn, 1 the workbook has errors or no tests, 2 it cannot be read.
    """
    from rrp_sheets import api
    from rrp_sheets.render.output import text_of

    window = (_time(first, "--from"), _time(last, "--to"))
    names = [n.strip() for n in streams.split(",") if n.strip()]
    speak_as_run(source)
    with said_when_slow(N_("Reading {name} …", name=source.name)):
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
    with said_when_slow(N_("Drawing {name} …", name=output.name)):
        notes = api.draw_marbles(scores, output)
    print_notes(notes)
    say(N_("Drawn: {path}", path=output))


def _time(text: str, option: str) -> int | None:
    if not text:
        return None
    us = parse_duration(text, bare="s")
    if us is None:
        raise usage_error(N_("“{text}” is not a time; write for example 5s or 500 ms.", text=text), option)
    return us


@click.command(name="print")
@click.argument("file", type=WorkbookArgument())
@click.option("-o", "--output", type=click.Path(path_type=Path), help="the PDF; by default beside FILE, with its name")
@click.option("--against", metavar="APPROVED", type=WorkbookArgument(), help="mark the changes since this version")
@click.option("--paper", type=click.Choice(["a4", "letter"]), default="a4", show_default=True, help="the paper's size")
@click.option(
    "--language", type=click.Choice(list(LANGUAGES)), default=None, help="the language  [default: the Protocol's]"
)
@click.option(
    "--for",
    "reader",
    type=click.Choice(["board", "participants"]),
    default="board",
    show_default=True,
    help="the protocol for an ethics board, or one page for participants in plain language",
)
@click.option("--draft", is_flag=True, help="mark every page as a draft; the workbook may have errors")
@click.option("--date", "day", type=click.DateTime(["%Y-%m-%d"]), help="the day that is printed; by default today")
def print_command(
    file: Path, output: Path | None, against: Path | None, paper: str, language: str | None, reader: str,
    draft: bool, day: datetime | None,
) -> None:  # fmt: skip
    """Print FILE for an ethics board: an accessible PDF that says what the robot senses, saves, says and does.

    It has the study, its risks, the diagrams, the rows in words and as tables, what the operator controls by hand, how
    to stop, what is still open, and what changed since the approved version. The first page lists what is missing and
    shows the SHA-256 of FILE; every page has its first 16 digits.

    --for participants prints one page in large type and plain language, for people of 9 years and more.

    Exit code: 0 printed, 1 the workbook has errors (only a draft is printed), 2 it cannot be read.
    """
    from rrp_sheets.cli.check import print_findings
    from rrp_sheets.services.printing import HasErrors, print_pack
    from rrp_sheets.workers.worker_loop import lift_limit

    home = home_of(click.get_current_context())
    beside = home / file.name if home else file
    target = output or (beside if beside.name else beside.resolve()).with_suffix(".pdf")
    if reader == "participants":
        if against is not None:
            raise usage_error(N_("--against belongs to the protocol for a board, not to --for participants."))
        target = output or target.with_name(f"{target.stem}-participants.pdf")
    if target.suffix.casefold() != ".pdf":
        raise usage_error(N_("The file ends with .pdf: rrp-sheets print FILE -o protocol.pdf"))
    speak(language or "en")

    def gathered(checked: Checked) -> None:
        lift_limit()  # no formula is evaluated any more
        speak(language or checked.run.language)

    try:
        made = print_pack(
            file, target, against=against, paper="letter" if paper == "letter" else "a4", language=language or "",
            draft=draft, today=day.date() if day else None, gathered=gathered,
            reader="participants" if reader == "participants" else "board",
        )  # fmt: skip
    except HasErrors as error:
        speak(language or error.checked.run.language)
        print_findings(error.checked.report.errors, err=True)
        fail(error, 1)
    print_findings(made.checked.report.errors, err=True)
    print_notes(made.notes)
    say(N_("Printed: {path}", path=target))
    sys.exit(1 if made.checked.report.errors else 0)


_STYLES: dict[str, dict[str, Any]] = {
    "added": {"fg": "green"}, "removed": {"fg": "red"}, "changed": {"fg": "yellow"}, "quiet": {"dim": True},
    "verdict": {"bold": True},
}  # fmt: skip


@click.command(name="diff")
@click.argument("first", metavar="A", type=click.Path(path_type=Path))
@click.argument("second", metavar="[B]", required=False, type=click.Path(path_type=Path))
@click.option("--json", "as_json", is_flag=True, help="print everything as JSON")
@click.option("--html", "as_html", is_flag=True, help="make a page to read, print or send")
@click.option("--svg", "as_svg", is_flag=True, help="draw what changed on the diagrams")
@click.option("-o", "--output", type=click.Path(path_type=Path), help="the file (.html or .svg) instead of printing it")
@click.option("-q", "--quiet", is_flag=True, help="leave out changes without effect on the behaviour")
@click.option("--text", "text_form", is_flag=True, help="print the one workbook A as text, for git (see below)")
def diff_command(
    first: Path, second: Path | None, as_json: bool, as_html: bool, as_svg: bool, output: Path | None, quiet: bool,
    text_form: bool,
) -> None:  # fmt: skip
    """Compare the workbooks A (before) and B (after) by what they mean.

    Rows are recognised when they were moved, streams when they were renamed, and formulas in either spelling. Changes
    of names, notes, tests and spelling are listed as changes without effect.

    --html makes a page with the changes on the diagrams, beside the rows. --svg makes only the pictures. In them + is
    new, − is removed, ~ is changed.

    To use it with git, once:

    \b
      git config diff.rrp-sheets.textconv "rrp-sheets diff --text"
      echo "*.xlsx diff=rrp-sheets" >> .gitattributes

    Then `git diff`, `git log -p` and `git show` compare workbooks row by row, and `git difftool -x "rrp-sheets diff"`
    by what they mean. A file that is not a workbook is shown as one line.

    Exit code: 0 same behaviour, 1 different, 2 a workbook cannot be read.
    """  # noqa: D301 – click takes the backspace for "leave these lines as they are"
    if text_form:
        if second is not None or as_json or as_html or as_svg:
            raise usage_error(N_("--text prints one workbook: rrp-sheets diff --text FILE"))
        click.echo(_text(first), nl=False)
        return
    if second is None:
        raise usage_error(N_("Two workbooks are compared: rrp-sheets diff A B"))
    form = _form(as_html, as_svg, output)
    from rrp_sheets import api

    try:
        found = api.diff_in_detail(*(opened(path, is_file=False) for path in (first, second)))
    except UnreadableFile as error:
        if not as_json:
            raise
        entry = {"code": error.code, "message": error.message, "remedy": error.remedy}
        click.echo(json.dumps({"schema": 1, "error": entry}, ensure_ascii=False, indent=2))
        sys.exit(2)
    _show(found, form, as_json, output, quiet)
    sys.exit(0 if found.comparison.same else 1)


def _form(as_html: bool, as_svg: bool, output: Path | None) -> str:
    """`html`, `svg`, or nothing: what was asked for, or what the file's name asks for."""
    if as_html and as_svg:
        raise usage_error(N_("--html has the pictures in it. Leave out --svg, or run the command twice."))
    suffix = output.suffix.casefold() if output is not None else ""
    wanted = "svg" if as_svg else "html" if as_html else {".svg": "svg"}.get(suffix, "html" if suffix else "")
    fitting = {"svg": (".svg",), "html": (".html", ".htm")}.get(wanted, ())
    if output is not None and suffix not in fitting:
        picture = N_("The picture's file ends with .svg: rrp-sheets diff A B -o changes.svg")
        page = N_("The page's file ends with .html: rrp-sheets diff A B -o changes.html")
        raise usage_error(picture if wanted == "svg" else page)
    return wanted


def _text(path: Path) -> str:
    from rrp_sheets.compare.side import open_workbook

    try:
        return text_form(open_workbook(opened(path)))
    except UnreadableFile as error:
        if not path.is_file():
            raise
        with path.open("rb") as file:  # git would stop at a failure, also in the middle of a log
            digest = hashlib.file_digest(file, "sha256").hexdigest()  # which differs for different contents
        unread = N_("Not a workbook that can be read ({code}). SHA-256 {digest}", code=error.code, digest=digest)
        return f"{translated(unread)}\n"


def _show(found: Compared, form: str, as_json: bool, output: Path | None, quiet: bool) -> None:
    from rrp_sheets.compare.as_html import as_html
    from rrp_sheets.compare.as_text import as_dict, as_text, verdict
    from rrp_sheets.workbook.files import write_atomically
    from rrp_sheets.workers.worker_loop import lift_limit

    comparison = found.comparison
    made = ""
    if output is not None or (form and not as_json):
        lift_limit()  # no formula is looked at any more, and drawing may take what memory it needs
        made = found.svg() if form == "svg" else as_html(comparison, found.html())
    if output is not None:
        write_atomically(output, made.encode())
    if as_json:
        click.echo(json.dumps(as_dict(comparison), ensure_ascii=False, indent=2))
    elif output is not None:
        say(verdict(comparison), N_("Written: {path}", path=output))
    elif form:
        click.echo(made, nl=False)
    else:
        click.echo(as_text(comparison, brief=quiet, style=lambda text, role: styled(text, **_STYLES[role])))


def text_form(reading: Reading) -> str:
    """The workbook as Markdown text."""
    parts = []
    tables = reading.workbook.tables
    for sheet in reading.sheets:
        table = _lines(tables[key(sheet.name)]) if key(sheet.name) in tables else _table(sheet)
        if table:
            parts.append("\n".join([f"## {' '.join(sheet.name.split())}", *table, ""]))
    return "\n".join(parts)


def _table(sheet: RawSheet) -> list[str]:
    recognised = recognise(sheet)
    rows = {n: cells for n, cells in sheet.rows().items() if n >= (recognised.row or 1)}
    if not rows:
        return []
    width = max(column for cells in rows.values() for column in cells)
    head = min(rows)
    header = rows.pop(head)
    names = {at: header_name for header_name, at in recognised.columns.items()} if recognised.kind else {}
    top = [names.get(c) or (header[c].text if c in header else "") for c in range(1, width + 1)]
    texts = [[cells[c].typed if c in cells else "" for c in range(1, width + 1)] for cells in rows.values()]
    return _lines([top, *texts])


def _lines(rows: Sequence[Sequence[str]]) -> list[str]:
    texts = [[to_markdown(re.sub(r"\r\n?", "\n", text)) for text in row] for row in rows]  # reads back as the same
    lines = [f"| {' | '.join(row)} |" for row in texts]
    return [*lines[:1], "|" + "---|" * len(rows[0]), *lines[1:]] if rows else []
