"""Making a styled .xlsx from plain rows: text cells, drop-downs, prompts, print setup."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rrp_sheets.model.cells import column_letters
from rrp_sheets.model.names import key
from rrp_sheets.workbook import style
from rrp_sheets.workbook.atomic import write_atomically
from rrp_sheets.workbook.headers import Recognised, recognise
from rrp_sheets.workbook.package import packed
from rrp_sheets.workbook.raw import RawCell, RawSheet
from rrp_sheets.workbook.sheet_maker import SheetMaker
from rrp_sheets.workbook.style import Offers

_FORBIDDEN = re.compile(r"[\[\]:*?/\\\x00-\x1f]")
_TITLE_LENGTH = 31


def make_workbook(
    sheets: Mapping[str, Sequence[Sequence[str]]],
    path: Path | str,
    offers: Offers | None = None,
    *,
    language: str = "en",
    replace: bool = True,
) -> Path:
    """Write rows of texts as a workbook that opens, looks right and prints well; the same rows give the same bytes.

    Args:
        sheets: the rows by sheet name; which row is the header is found as in reading. A Lists sheet that the program
            has made is made again.
        path: of the .xlsx.
        offers: names for the drop-downs.
        language: of the texts, for the file's properties.
        replace: whether a file of that name may be replaced.

    Returns:
        The path.

    Raises:
        SheetsError: when a text is too long for a cell, or the file cannot be written.
    """
    from openpyxl import Workbook

    path = Path(path)
    if offers is not None:
        sheets = {name: rows for name, rows in sheets.items() if not offers.made(name, rows)}
    book = Workbook()
    book.remove(book.worksheets[0])
    taken = {name.casefold() for name in sheets}
    lists_name = "Lists" if "lists" not in taken else "Lists for drop-downs"
    titles = sheet_titles([*sheets, lists_name])
    recognised = {name: recognise(_raw(name, rows)) for name, rows in sheets.items()}
    lists = _name_lists(book, titles[lists_name], offers, _streams(sheets, recognised, titles))
    for name, rows in sheets.items():
        SheetMaker(book.create_sheet(titles[name]), rows, recognised[name], lists).make()
    if offers is not None:
        _make_lists(book, offers, titles[lists_name])
    book.properties.language = language
    book.properties.creator = "RRP Sheets"
    write_atomically(path, packed(book), replace=replace)
    return path


def sheet_titles(names: Sequence[str]) -> dict[str, str]:
    r"""Names that Excel accepts: at most 31 characters, no `[ ] : * ? / \`, no two alike.

    >>> sheet_titles(["Ask: yes/no?", "ask_ yes_no_"])
    {'Ask: yes/no?': 'Ask_ yes_no_', 'ask_ yes_no_': 'ask_ yes_no_ 2'}
    """
    titles: dict[str, str] = {}
    taken: set[str] = set()
    for name in names:
        stem = _FORBIDDEN.sub("_", name).strip().strip("'")[:_TITLE_LENGTH] or "Sheet"
        title, number = stem, 2
        while title.casefold() in taken or title.casefold() == "history":  # Excel keeps that name for itself
            title, number = f"{stem[: _TITLE_LENGTH - len(str(number)) - 1]} {number}", number + 1
        taken.add(title.casefold())
        titles[name] = title
    return titles


def _raw(name: str, rows: Sequence[Sequence[str]]) -> RawSheet:
    return RawSheet(name, {(r, c): RawCell(t) for r, row in enumerate(rows, 1) for c, t in enumerate(row, 1) if t})


def _streams(
    sheets: Mapping[str, Sequence[Sequence[str]]], recognised: Mapping[str, Recognised], titles: Mapping[str, str]
) -> str:
    """The range of the first Devices sheet's streams; empty when there is no such sheet."""
    for name, what in recognised.items():
        if what.kind and what.kind.name == "devices":
            letter, first = column_letters(what.columns["Stream"]), what.row + 1
            last = max(len(sheets[name]), what.row + style.ROWS)
            quoted = titles[name].replace("'", "''")
            return f"'{quoted}'!${letter}${first}:${letter}${last}"
    return ""


def _name_lists(book: Any, title: str, offers: Offers | None, streams: str) -> dict[str, str]:
    """Define a name for every list, and one for the streams of the Devices sheet; the names by the lists' titles."""
    from openpyxl.workbook.defined_name import DefinedName

    places = {"Streams": streams} if streams else {}
    for column, (name, entries) in enumerate(offers.lists().items() if offers else (), 1):
        letter = column_letters(column)
        places[name] = f"'{title}'!${letter}$2:${letter}${len(entries) + 1}"
    names = {}
    for name, place in places.items():
        names[name] = "List_" + re.sub(r"\W", "_", key(name))
        book.defined_names[names[name]] = DefinedName(names[name], attr_text=place)
    return names


def _make_lists(book: Any, offers: Offers, title: str) -> None:
    lists = offers.lists()
    length = max(map(len, lists.values()))
    rows = [list(lists), *([n[i] if i < len(n) else "" for n in lists.values()] for i in range(length))]
    sheet = SheetMaker(book.create_sheet(title), rows, Recognised(), {})
    sheet.last = len(rows)
    sheet.make()
