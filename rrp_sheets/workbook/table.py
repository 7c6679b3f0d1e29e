"""Writing a plain table as .xlsx: one header row, then rows of numbers and texts, as analysts want them.

openpyxl makes the file; the rows, of which there may be a million, are written as XML here: that takes a third.
"""

from __future__ import annotations

import io
import math
import os
import re
import zipfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any

from rrp_sheets.workbook.xlsx import IMPOSSIBLE, escape_literal

_MOST_ROWS = 1_000_000  # of a sheet, which holds 1,048,576: some may come while it is written
_PIECE = 2_000  # rows that are written at once
_LONGEST, _LONGEST_PROPERTY = 32_767, 255
_ESCAPED = str.maketrans({"&": "&amp;", "<": "&lt;", ">": "&gt;", "\r": "&#13;"})
_ROWS_END = b"</sheetData>"
# what XML does not take as it is:
_WORK = re.compile("[&<>\r\x00-\x08\x0b\x0c\x0e-\x1f\ud800-\udfff\ufffe\uffff]|^\\s|\\s$|_x")


@dataclass(frozen=True)
class MoreSheet:
    """A further, short sheet of a table's file."""

    title: str
    header: Sequence[str]
    rows: Sequence[Sequence[Any]]
    widths: Sequence[float]


def write_table(
    path: Path, title: str, header: Sequence[str], rows: Iterable[Sequence[Any]], widths: Sequence[float],
    more: Sequence[MoreSheet] = (), properties: Mapping[str, str] | None = None, count: int = 0,
) -> None:  # fmt: skip
    """Write the table atomically; more than a million rows go on in further sheets, `more` stand behind them.

    In rows numbers stay numbers, everything else is text (never a live formula), None is an empty cell. Widths are in
    characters; properties of the document are `title`, `subject`, `description`, `keywords`, `creator`. `count` tells
    how many rows there are, about: what comes beyond a million of them needs to be known before.
    """
    sheets = max(1, math.ceil(count / _MOST_ROWS))
    tables = [MoreSheet(title if n == 1 else f"{title} {n}", header, (), widths) for n in range(1, sheets + 1)]
    half = path.with_name(path.name + ".part")
    coming = iter(rows)
    try:
        with (
            zipfile.ZipFile(io.BytesIO(_frame([*tables, *more], properties or {}))) as frame,
            zipfile.ZipFile(half, "w", zipfile.ZIP_DEFLATED, compresslevel=4) as packed,
        ):
            for entry in frame.infolist():
                found = re.fullmatch(r"xl/worksheets/sheet(\d+)\.xml", entry.filename)
                number = int(found[1]) if found else 0
                if not 0 < number <= sheets:
                    packed.writestr(entry.filename, frame.read(entry))
                    continue
                begin, _, end = frame.read(entry).partition(_ROWS_END)
                with packed.open(entry.filename, "w", force_zip64=True) as file:
                    file.write(begin)
                    for piece in _pieces(coming if number == sheets else islice(coming, _MOST_ROWS), len(header)):
                        file.write(piece)
                    file.write(_ROWS_END + end)
        os.replace(half, path)
    finally:
        half.unlink(missing_ok=True)


def _frame(sheets: Sequence[MoreSheet], properties: Mapping[str, str]) -> bytes:
    """The file with all sheets, of the tables only their headers."""
    from openpyxl import Workbook
    from openpyxl.cell import WriteOnlyCell
    from openpyxl.styles import Font, PatternFill
    from openpyxl.utils import get_column_letter

    book = Workbook(write_only=True)
    font, fill = Font(name="Calibri", size=11, bold=True), PatternFill("solid", fgColor="DDE6F0")
    for one in sheets:
        sheet = book.create_sheet(one.title)
        sheet.freeze_panes = "A2"
        for i, width in enumerate(one.widths, 1):
            sheet.column_dimensions[get_column_letter(i)].width = width
        heads = [WriteOnlyCell(sheet, _text(name)) for name in one.header]
        for cell in heads:
            cell.data_type, cell.font, cell.fill = "s", font, fill
        sheet.append(heads)
        for row in one.rows:
            sheet.append([_cell(WriteOnlyCell, sheet, value) for value in row])
    for name, text in properties.items():
        setattr(book.properties, name, IMPOSSIBLE.sub("\ufffd", text)[:_LONGEST_PROPERTY])
    target = io.BytesIO()
    book.save(target)
    return target.getvalue()


def _pieces(rows: Iterator[Sequence[Any]], columns: int) -> Iterator[bytes]:
    from openpyxl.utils import get_column_letter

    letters = [get_column_letter(n) for n in range(1, columns + 1)]
    number = 2
    while some := list(islice(rows, _PIECE)):
        yield "".join(_row(n, letters, row) for n, row in enumerate(some, number)).encode("utf-8", "replace")
        number += len(some)


def _row(number: int, letters: Sequence[str], values: Sequence[Any]) -> str:
    """A row as XML.

    >>> _row(2, "ABCD", [1.5, None, "a<b", True])[:67]
    '<row r="2"><c r="A2"><v>1.5</v></c><c r="C2" t="inlineStr"><is><t x'
    """
    cells = [
        f'<c r="{letter}{number}"{_content(value)}</c>'
        for letter, value in zip(letters, values, strict=False)
        if value is not None
    ]
    return f'<row r="{number}">{"".join(cells)}</row>'


def _content(value: Any) -> str:
    """The rest of a cell, from behind its place."""
    if isinstance(value, bool):
        return f' t="b"><v>{value:d}</v>'
    if isinstance(value, (int, float)) and math.isfinite(value):
        number = float.__repr__(value) if isinstance(value, float) else repr(value)
        return f"><v>{number}</v>"
    text = str(value)
    if len(text) <= _LONGEST and not _WORK.search(text):
        return f' t="inlineStr"><is><t>{text}</t></is>'
    return f' t="inlineStr"><is><t xml:space="preserve">{_text(text).translate(_ESCAPED)}</t></is>'


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
    return escape_literal(IMPOSSIBLE.sub("\ufffd", str(value))[:_LONGEST])
