"""`rrp-sheets diff A B`."""

from __future__ import annotations

import hashlib
import json
import re
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rrp_sheets.cli.terminal import opened
from rrp_sheets.errors import UnreadableFile
from rrp_sheets.model.names import key
from rrp_sheets.texts import N_, sentences
from rrp_sheets.workbook import Reading
from rrp_sheets.workbook.raw import RawSheet
from rrp_sheets.workbook.schema import recognise

if TYPE_CHECKING:
    from rrp_sheets.services.changes_drawn import Compared


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
@click.option("-q", "--quiet", is_flag=True, help="leave out what has no effect on the behaviour")
@click.option("--text", "text_form", is_flag=True, help="print the one workbook A as text, for git (see below)")
def diff_command(
    first: Path, second: Path | None, as_json: bool, as_html: bool, as_svg: bool, output: Path | None, quiet: bool,
    text_form: bool,
) -> None:  # fmt: skip
    """Say what is different between the workbooks A (before) and B (after), by what they mean.

    Rows are recognised wherever they stand, streams whatever they are called, formulas in either spelling. Names,
    notes, tests and spelling make no other behaviour, but are told.

    --html makes a page with the changes drawn on the diagrams, beside the rows; --svg only the pictures. In them + is
    new, − is gone, ~ is changed.

    \b
    For git, once:  git config diff.rrp-sheets.textconv "rrp-sheets diff --text"
                    echo "*.xlsx diff=rrp-sheets" >> .gitattributes
    Then `git diff`, `git log -p` and `git show` compare workbooks row by row, and
    `git difftool -x "rrp-sheets diff"` by what they mean. A file that is no workbook is
    shown as one line, so that git goes on.

    Exit code: 0 same behaviour, 1 different, 2 a workbook cannot be read.
    """  # noqa: D301 – click takes the backspace for "leave these lines as they are"
    if text_form:
        if second is not None or as_json or as_html or as_svg:
            raise click.UsageError("--text prints one workbook: rrp-sheets diff --text FILE")
        click.echo(_text(first), nl=False)
        return
    if second is None:
        raise click.UsageError("Two workbooks are compared: rrp-sheets diff A B")
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
        raise click.UsageError("--html has the pictures in it; leave out --svg, or ask twice.")
    suffix = output.suffix.casefold() if output is not None else ""
    wanted = "svg" if as_svg else "html" if as_html else {".svg": "svg"}.get(suffix, "html" if suffix else "")
    fitting = {"svg": (".svg",), "html": (".html", ".htm")}.get(wanted, ())
    if output is not None and suffix not in fitting:
        kind, ending = ("picture", "svg") if wanted == "svg" else ("page", "html")
        raise click.UsageError(f"The {kind}'s file ends with .{ending}: rrp-sheets diff A B -o changes.{ending}")
    return wanted


def _text(path: Path) -> str:
    from rrp_sheets.compare.side import open_workbook

    try:
        return text_form(open_workbook(opened(path)))
    except UnreadableFile as error:
        if not path.is_file():
            raise
        return unreadable_text(path, error)  # git would stop at a failure, also in the middle of a log


def _show(found: Compared, form: str, as_json: bool, output: Path | None, quiet: bool) -> None:
    from rrp_sheets.compare.as_text import as_dict, as_text, verdict
    from rrp_sheets.workbook.atomic import write_atomically

    comparison = found.comparison
    made = _made(found, form) if output is not None or (form and not as_json) else ""
    if output is not None:
        write_atomically(output, made.encode())
    if as_json:
        click.echo(json.dumps(as_dict(comparison), ensure_ascii=False, indent=2))
    elif output is not None:
        click.echo(sentences(verdict(comparison), N_("Written: {path}", path=output)))
    elif form:
        click.echo(made, nl=False)
    else:
        click.echo(as_text(comparison, brief=quiet, style=lambda text, role: click.style(text, **_STYLES[role])))


def _made(found: Compared, form: str) -> str:
    """The page, or the picture."""
    from rrp_sheets.compare.as_html import as_html
    from rrp_sheets.workers.worker_loop import lift_limit

    lift_limit()  # no formula is looked at any more, and drawing may take what memory it needs
    return found.svg() if form == "svg" else as_html(found.comparison, found.html())


def text_form(reading: Reading) -> str:
    """The workbook as Markdown text."""
    parts = []
    tables = reading.workbook.tables
    for sheet in reading.sheets:
        table = _lines(tables[key(sheet.name)]) if key(sheet.name) in tables else _table(sheet)
        if table:
            parts.append(f"## {_heading(sheet.name)}\n" + "\n".join(table) + "\n")
    return "\n".join(parts)


def unreadable_text(path: Path, error: UnreadableFile) -> str:
    """Return the line shown for a file that is no readable workbook; it differs for different contents."""
    digest = hashlib.sha256()
    with path.open("rb") as file:
        while block := file.read(1 << 20):
            digest.update(block)
    return f"Not a workbook that can be read ({error.code}). SHA-256 {digest.hexdigest()}\n"


def _heading(name: str) -> str:
    return " ".join(name.split())


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
    lines = ["| " + " | ".join(_cell(text) for text in row) + " |" for row in rows]
    return [*lines[:1], "|" + "---|" * len(rows[0]), *lines[1:]] if rows else []


def _cell(text: str) -> str:
    """A cell that reads back as the same text."""
    text = re.sub(r"\r\n?", "\n", text.strip())
    return text.replace("|", "\\|").replace("\n", "<br>")
