"""Sheets of the user's own that formulas name as tables."""

from __future__ import annotations

import re
from collections.abc import Iterable

from rrp_sheets.diagnostics import Report
from rrp_sheets.model.cells import Address
from rrp_sheets.model.names import argument_name, key
from rrp_sheets.workbook import limits
from rrp_sheets.workbook.cleaning import clean_prose
from rrp_sheets.workbook.raw import RawSheet

_TEXT = re.compile(r"""(?<![fF])(?:"(?:[^"]|"")*"|“[^“”]*”|(?<!\w)'(?:[^']|'')*')""")


def words(texts: Iterable[str]) -> set[str]:
    """The keys of all words in formulas, without those in texts: a text that says “notes” names no sheet.

    >>> sorted(words(['INDEX(Parts; step) & "notes"']))
    ['index', 'parts', 'step']
    """
    return {key(word) for text in texts for word in _words(_TEXT.sub(" ", text))}


def _words(text: str) -> list[str]:
    # not by \w alone, which leaves out the vowel signs of many scripts
    between = {ord(c): " " for c in set(text) if not (c.isalnum() or c == "_" or f"a{c}".isidentifier())}
    return text.translate(between).split()


def is_named(sheet: str, named: set[str]) -> bool:
    """Return whether a sheet's name is one of the words, as it can be written in a formula."""
    return key(sheet) in named or key(argument_name(sheet)) in named


def read_table(sheet: RawSheet, report: Report) -> tuple[tuple[str, ...], ...]:
    """Header and rows to the first blank one, as texts; a blank cell is an empty text, a text too long is cut."""
    filled = {at: text for at, cell in sheet.cells.items() if (text := clean_prose(cell.text or cell.formula))}
    if not filled:
        report.add("SHEET020", Address(sheet.name), sheet=sheet.name)
        return ()
    top = min(row for row, _ in filled)
    header = sorted(column for row, column in filled if row == top)
    left, right = header[0], header[-1]
    if right - left >= limits.TABLE_COLUMNS:
        right = left + limits.TABLE_COLUMNS - 1
        _too_large(sheet, report, Address(sheet.name, top, right + 1), limits.TABLE_COLUMNS, "columns")
    _check_header(sheet, report, {c: filled.get((top, c), "") for c in range(left, right + 1)}, top, filled)
    rows = []
    present = {row for row, column in filled if left <= column <= right}
    row = top
    while row in present:
        if row > top + limits.TABLE_ROWS:
            _too_large(sheet, report, Address(sheet.name, row, left), limits.TABLE_ROWS, "rows")
            break
        rows.append(tuple(_text(sheet, (row, column), filled, report) for column in range(left, right + 1)))
        row += 1
    if len(rows) < 2:
        report.add("SHEET020", Address(sheet.name, top, left), sheet=sheet.name)
    return tuple(rows)


def _text(sheet: RawSheet, at: tuple[int, int], filled: dict[tuple[int, int], str], report: Report) -> str:
    text = filled.get(at, "")
    if len(text) > limits.TABLE_TEXT:
        report.add("SHEET016", Address(sheet.name, *at), count=f"{len(text):,}", limit=f"{limits.TABLE_TEXT:,}")
    return text[: limits.TABLE_TEXT]


def _check_header(
    sheet: RawSheet, report: Report, titles: dict[int, str], top: int, filled: dict[tuple[int, int], str]
) -> None:
    """Columns that formulas cannot reach: without a name, or with the name of another."""
    seen: set[str] = set()
    used = {column for row, column in filled if row == top + 1}
    for column, title in titles.items():
        if key(title) in seen:
            report.add("FORM023", Address(sheet.name, top, column), table=sheet.name, title=title)
        elif not key(title) and column in used:
            report.add("FORM024", Address(sheet.name, top, column), table=sheet.name)
        seen |= {key(title)} - {""}


def _too_large(sheet: RawSheet, report: Report, address: Address, limit: int, what: str) -> None:
    report.add("SHEET019", address, sheet=sheet.name, limit=f"{limit:,}", what=what)
