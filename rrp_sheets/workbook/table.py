"""Writing a plain table as .xlsx: one header row, then rows of numbers and texts, as analysts want them."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

_MOST_ROWS = 1_000_000  # a sheet holds 1,048,576
_CONTROL = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\ufffe\uffff]")
_LONGEST = 32_767
_LONGEST_PROPERTY = 255


@dataclass(frozen=True)
class MoreSheet:
    """A further, short sheet of a table's file."""

    title: str
    header: Sequence[str]
    rows: Sequence[Sequence[Any]]
    widths: Sequence[float]


def write_table(
    path: Path, title: str, header: Sequence[str], rows: Iterable[Sequence[Any]], widths: Sequence[float],
    more: Sequence[MoreSheet] = (), properties: Mapping[str, str] | None = None,
) -> None:  # fmt: skip
    """Write the table atomically; more than a million rows go on in further sheets.

    Args:
        path: of the .xlsx.
        title: of the sheet.
        header: the column names.
        rows: numbers stay numbers, everything else is text (never a live formula), None is an empty cell.
        widths: of the columns, in characters.
        more: further sheets, behind it.
        properties: of the document: `title`, `subject`, `description`, `keywords`, `creator`.
    """
    from openpyxl import Workbook
    from openpyxl.cell import WriteOnlyCell
    from openpyxl.styles import Font, PatternFill
    from openpyxl.utils import get_column_letter

    book = Workbook(write_only=True)
    sheet: Any = None
    written = _MOST_ROWS
    number = 0
    for row in rows if rows else ():
        if written >= _MOST_ROWS:
            number += 1
            sheet = _new_sheet(book, title if number == 1 else f"{title} {number}", widths, get_column_letter)
            sheet.append([_head(WriteOnlyCell, sheet, name, Font, PatternFill) for name in header])
            written = 1
        sheet.append([_cell(WriteOnlyCell, sheet, value) for value in row])
        written += 1
    if sheet is None:
        sheet = _new_sheet(book, title, widths, get_column_letter)
        sheet.append([_head(WriteOnlyCell, sheet, name, Font, PatternFill) for name in header])
    for one in more:
        sheet = _new_sheet(book, one.title, one.widths, get_column_letter)
        sheet.append([_head(WriteOnlyCell, sheet, name, Font, PatternFill) for name in one.header])
        for row in one.rows:
            sheet.append([_cell(WriteOnlyCell, sheet, value) for value in row])
    for name, text in (properties or {}).items():
        setattr(book.properties, name, _CONTROL.sub("\ufffd", text)[:_LONGEST_PROPERTY])
    half = path.with_name(path.name + ".part")
    try:
        book.save(half)
        os.replace(half, path)
    finally:
        half.unlink(missing_ok=True)


def _new_sheet(book: Any, title: str, widths: Sequence[float], letter: Any) -> Any:
    sheet = book.create_sheet(title)
    sheet.freeze_panes = "A2"
    for i, width in enumerate(widths, 1):
        sheet.column_dimensions[letter(i)].width = width
    return sheet


def _head(make: Any, sheet: Any, name: str, font: Any, fill: Any) -> Any:
    cell = make(sheet, _text(name))
    cell.data_type = "s"
    cell.font = font(name="Calibri", size=11, bold=True)
    cell.fill = fill("solid", fgColor="DDE6F0")
    return cell


def _cell(make: Any, sheet: Any, value: Any) -> Any:
    if value is None or isinstance(value, (int, float)):
        return value
    text = _text(value)
    if not text.startswith("="):
        return text
    cell = make(sheet, text)
    cell.data_type = "s"  # after the value: a text that begins with = must not become a formula
    return cell


def _text(value: Any) -> str:
    return _CONTROL.sub("\ufffd", str(value))[:_LONGEST]
