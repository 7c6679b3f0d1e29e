"""The sheets of a document: added, renamed, moved, duplicated, deleted."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from rrp_sheets.documents.grid import Changed, Refused
from rrp_sheets.documents.sheet_references import renamed_cells, users
from rrp_sheets.documents.steps import SheetIn, SheetNamed, SheetOut, SheetPlaced, Sheets, SheetStep, added
from rrp_sheets.errors import SheetsError
from rrp_sheets.model.names import key
from rrp_sheets.texts import N_
from rrp_sheets.workbook.edits import AddSheet
from rrp_sheets.workbook.raw import text_sheet
from rrp_sheets.workbook.schema import TITLES, is_single, recognise
from rrp_sheets.workbook.sheet_names import free_name
from rrp_sheets.workbook.template import beginning, place_of


class SheetEdits:
    """Operations on the sheets of a document; each is one edit, and is undone as one."""

    def __init__(
        self,
        lock: threading.RLock,  # type: ignore[valid-type,unused-ignore]
        make: Callable[[str, SheetStep], Changed],
        sheets: Callable[[], Sheets],
        path: Path,
    ) -> None:
        self._lock, self._make, self._sheets, self._path = lock, make, sheets, path

    def add(self, author: str, kind: str, name: str = "", rows: Sequence[Sequence[str]] = ()) -> Changed:
        """Add a sheet of a kind (`behaviour`, …, `table` for one of the user's own); see `added_sheet`."""
        with self._lock:
            return self._make(author, added_sheet(self._sheets(), kind, name, rows))

    def rename(self, author: str, sheet: str, name: str) -> Changed:
        """Give a sheet another name; everything that names it follows."""
        return self._make(author, SheetNamed(sheet, name))

    def move(self, author: str, sheet: str, before: str) -> Changed:
        """Let a sheet stand before another one; empty: at the end."""
        return self._make(author, SheetPlaced(sheet, before))

    def delete(self, author: str, sheet: str) -> Changed:
        """Delete a sheet with everything in it; `naming` tells what refers to it."""
        return self._make(author, SheetOut(sheet))

    def duplicate(self, author: str, sheet: str) -> Changed:
        """Add a sheet with the same texts."""
        with self._lock:
            grid = self._sheets().grids.get(sheet)
            if grid is None or is_single(grid.kind):
                raise Refused(N_("This sheet cannot be duplicated."), N_("A workbook has one sheet of that kind."))
            last = max((i for i, row in enumerate(grid.rows) if grid.texts[row]), default=-1)
            width = max(c.number for c in grid.columns)
            headers = {c.number: c.header for c in grid.columns}
            lines = [headers, *(grid.texts[row] for row in grid.rows[: last + 1])]
            rows = [[line.get(c, "") for c in range(1, width + 1)] for line in lines]
            return self.add(author, grid.kind, free_name(sheet, self._sheets().reading.workbook.sheets, 2), rows)

    def naming(self, sheet: str) -> list[str]:
        """Return the references to a sheet in the workbook, in words."""
        with self._lock:
            return naming(self._sheets(), self._path, sheet)


_MOST_COLUMNS = 30


def added_sheet(sheets: Sheets, kind: str, name: str, rows: Sequence[Sequence[str]] = ()) -> SheetIn:
    """The step that adds a sheet; without a name it has a proposed one, without rows it begins as usual.

    Raises:
        Refused: there can be no such sheet.
    """
    if kind not in TITLES:
        raise Refused(N_("There is no such kind of sheet."), N_("Reload the page."))
    there = next((grid.name for grid in sheets.grids.values() if grid.kind == kind), "")
    if is_single(kind) and there:
        raise Refused(
            N_("There is “{sheet}” already, and a workbook has one sheet of that kind.", sheet=there),
            N_("Write into that one."),
        )
    book = sheets.reading.workbook
    if kind == "table" and rows:
        _refuse_columns(rows[0])
    if not rows:
        rows = _as_there(sheets, kind) or beginning(kind, book.protocol.robot or "nao")
    kinds = {n: sheets.grids[n].kind if n in sheets.grids else "" for n in book.sheets}
    edit = AddSheet(name or proposed_name(kind, kinds), tuple(map(tuple, rows)), place_of(kind, kinds))
    return added(sheets, edit, kind)


def proposed_name(kind: str, kinds: Mapping[str, str]) -> str:
    """A name for a new sheet of a kind; the second behaviour is “Behaviour 2”, whatever the first is called.

    >>> proposed_name("behaviour", {"Tracking": "behaviour", "Lists": ""}), proposed_name("table", {"Table": ""})
    ('Behaviour 2', 'Table 2')
    """
    count = list(kinds.values()).count(kind) if kind in ("behaviour", "test") else 0
    return free_name(TITLES[kind], kinds, count + 1)


def _as_there(sheets: Sheets, kind: str) -> list[list[str]]:
    """The columns of the sheets of this kind that there are, so that all look the same."""
    grid = next((g for g in sheets.grids.values() if g.kind == kind and g.kind in ("behaviour", "test")), None)
    return [[c.header for c in grid.columns if c.name]] if grid is not None else []


def _refuse_columns(headers: Sequence[str]) -> None:
    if len(headers) > _MOST_COLUMNS:
        raise Refused(N_("A table has at most {n} columns.", n=_MOST_COLUMNS), N_("Name fewer."))
    kind = recognise(text_sheet("", [headers])).kind
    if kind is not None:
        raise Refused(
            N_("Columns of these names make a sheet {kind}.", kind=kind.shown), N_("Name the columns otherwise.")
        )


def naming(sheets: Sheets, path: Path, sheet: str) -> list[str]:
    """Return the references to a sheet, in words, each with its place."""
    book = sheets.reading.workbook
    named = renamed_cells(book, sheets.text, sheet, f"{sheet} {len(book.sheets)}")
    places = dict.fromkeys([*named, *(cell.address for cell in users(book, sheet))])
    listed = [f"{at}: {_short(sheets.text(at))}" for at in places if key(at.sheet) != key(sheet)]
    if path.suffix.casefold() == ".xlsx":
        from rrp_sheets.workbook.patch.sheets import referring

        try:
            listed += referring(path.read_bytes(), path.name, sheet)
        except (SheetsError, OSError):  # told when it is to be deleted
            return listed
    return listed


def _short(text: str) -> str:
    line = " ".join(text.split())
    return line if len(line) <= 60 else f"{line[:59]}…"
