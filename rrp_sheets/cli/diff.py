"""`rrp-sheets diff A B`."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rrp_sheets.cli.bundled import Workbook
from rrp_sheets.errors import SheetsError, UnreadableFile

if TYPE_CHECKING:
    from rrp_sheets.compare import Comparison

_STYLES: dict[str, dict[str, Any]] = {
    "added": {"fg": "green"}, "removed": {"fg": "red"}, "changed": {"fg": "yellow"}, "quiet": {"dim": True},
    "verdict": {"bold": True},
}  # fmt: skip


@click.command(name="diff")
@click.argument("first", metavar="A", type=Workbook())
@click.argument("second", metavar="[B]", required=False, type=Workbook())
@click.option("--json", "as_json", is_flag=True, help="print everything as JSON")
@click.option("--html", "as_html", is_flag=True, help="make a page to read, print or send")
@click.option("-o", "--output", type=click.Path(path_type=Path), help="the page's file (.html) instead of printing it")
@click.option("-q", "--quiet", is_flag=True, help="leave out what has no effect on the behaviour")
@click.option("--text", "text_form", is_flag=True, help="print the one workbook A as text, for git (see below)")
def command(
    first: Path, second: Path | None, as_json: bool, as_html: bool, output: Path | None, quiet: bool, text_form: bool
) -> None:
    """Say what is different between the workbooks A (before) and B (after), by what they mean.

    Rows are recognised wherever they stand, streams whatever they are called, formulas in either spelling. Names,
    notes, tests and spelling make no other behaviour, but are told.

    \b
    For git, once:  git config diff.rrp-sheets.textconv "rrp-sheets diff --text"
                    echo "*.xlsx diff=rrp-sheets" >> .gitattributes
    Then `git diff`, `git log -p` and `git show` compare workbooks row by row, and
    `git difftool -x "rrp-sheets diff"` by what they mean. A file that is no workbook is
    shown as one line, so that git goes on.

    Exit code: 0 same behaviour, 1 different, 2 a workbook cannot be read.
    """  # noqa: D301 – click takes the backspace for "leave these lines as they are"
    if text_form:
        if second is not None or as_json or as_html:
            raise click.UsageError("--text prints one workbook: rrp-sheets diff --text FILE")
        click.echo(_text(first), nl=False)
        return
    if second is None:
        raise click.UsageError("Two workbooks are compared: rrp-sheets diff A B")
    if output is not None and output.suffix.casefold() not in (".html", ".htm"):
        raise click.UsageError("The page's file ends with .html: rrp-sheets diff A B -o changes.html")
    from rrp_sheets import api

    try:
        comparison = api.diff(first, second)
    except UnreadableFile as error:
        if not as_json:
            raise
        entry = {"code": error.code, "message": error.message, "remedy": error.remedy}
        click.echo(json.dumps({"schema": 1, "error": entry}, ensure_ascii=False, indent=2))
        sys.exit(2)
    _show(comparison, as_json, as_html, output, quiet)
    sys.exit(0 if comparison.same else 1)


def _text(path: Path) -> str:
    from rrp_sheets.compare.opening import open_workbook
    from rrp_sheets.compare.text_form import text_form, unreadable_text

    try:
        return text_form(open_workbook(path))
    except UnreadableFile as error:
        if not path.is_file():
            raise
        return unreadable_text(path, error)  # git would stop at a failure, also in the middle of a log


def _show(comparison: Comparison, as_json: bool, as_html: bool, output: Path | None, quiet: bool) -> None:
    from rrp_sheets.compare.as_html import as_html as page
    from rrp_sheets.compare.as_text import as_text, verdict

    if output is not None:
        _write(output, page(comparison))
    if as_json:
        click.echo(json.dumps(comparison.as_dict(), ensure_ascii=False, indent=2))
    elif as_html and output is None:
        click.echo(page(comparison), nl=False)
    elif output is not None:
        click.echo(f"{verdict(comparison)} Written: {output}")
    else:
        click.echo(as_text(comparison, brief=quiet, style=lambda text, role: click.style(text, **_STYLES[role])))


def _write(output: Path, page: str) -> None:
    from rrp_sheets.workbook.atomic import write_atomically

    try:
        write_atomically(output, page.encode())
    except OSError as error:
        raise SheetsError(f"“{output}” cannot be written ({error.strerror}).", "Name another file.") from None
