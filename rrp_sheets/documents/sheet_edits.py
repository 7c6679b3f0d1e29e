"""The sheets of a document: added, renamed, moved, duplicated, deleted."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from pathlib import Path

from rrp_sheets.documents.changes import Changed, Refused
from rrp_sheets.documents.sheet_templates import added_sheet, naming
from rrp_sheets.documents.sheetsteps import Sheets
from rrp_sheets.documents.undo import SheetNamed, SheetOut, SheetPlaced, SheetStep
from rrp_sheets.workbook.beginnings import SINGLE
from rrp_sheets.workbook.sheet_names import free_name


class SheetEdits:
    """What can be done to the sheets of a document; each is one edit, and is undone as one.

    Args:
        lock: the document's.
        make: makes an author's step.
        sheets: the sheets as they are now.
        path: of the file.
    """

    def __init__(
        self,
        lock: threading.RLock,  # type: ignore[valid-type,unused-ignore]
        make: Callable[[str, SheetStep], Changed],
        sheets: Callable[[], Sheets],
        path: Path,
    ) -> None:
        self._lock, self._make, self._sheets, self._path = lock, make, sheets, path

    def add(self, author: str, kind: str, name: str = "", rows: Sequence[Sequence[str]] = ()) -> Changed:
        """Add a sheet of a kind (`behaviour`, …, `table` for one of the user's own); see `beginning.added_sheet`."""
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
            if grid is None or grid.kind in SINGLE:
                raise Refused("This sheet cannot be duplicated.", "A workbook has one sheet of that kind.")
            last = max((i for i, row in enumerate(grid.rows) if grid.texts[row]), default=-1)
            width = max(c.number for c in grid.columns)
            headers = {c.number: c.header for c in grid.columns}
            lines = [headers, *(grid.texts[row] for row in grid.rows[: last + 1])]
            rows = [[line.get(c, "") for c in range(1, width + 1)] for line in lines]
            return self.add(author, grid.kind, free_name(sheet, self._sheets().reading.workbook.sheets, 2), rows)

    def naming(self, sheet: str) -> list[str]:
        """What in the workbook refers to a sheet, in words."""
        with self._lock:
            return naming(self._sheets(), self._path, sheet)
