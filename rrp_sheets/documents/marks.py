"""Comments and looks of the cells of a grid, by the rows' ids."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields

from rrp_sheets.workbook.comments import Thread, Threads
from rrp_sheets.workbook.edits import SetLook
from rrp_sheets.workbook.looks import PLAIN_LOOK, Look, SheetLooks

Mark = tuple[str, int, Thread, Look]
"""Row's id, column, comments and look of a cell that has comments or looks otherwise than its column."""


@dataclass
class CellMarks:
    """Comments and looks by row id and column; cells without any are not there.

    Attributes:
        columns: looks of whole columns; `looks` has the cells that look otherwise.
    """

    threads: dict[str, dict[int, Thread]] = field(default_factory=dict)
    looks: dict[str, dict[int, Look]] = field(default_factory=dict)
    columns: dict[int, Look] = field(default_factory=dict)

    def thread(self, row: str, column: int) -> Thread:
        """Return the comments of a cell."""
        return self.threads.get(row, {}).get(column, ())

    def look(self, row: str, column: int) -> Look:
        """Return the look of a cell."""
        return self.looks.get(row, {}).get(column) or self.columns.get(column, PLAIN_LOOK)

    def set_thread(self, row: str, column: int, thread: Thread) -> None:
        """Give a cell other comments; an empty thread is none."""
        cells = self.threads.setdefault(row, {})
        cells.pop(column, None)
        if thread:
            cells[column] = thread
        elif not cells:
            del self.threads[row]

    def set_look(self, row: str, column: int, look: Look) -> None:
        """Give a cell another look."""
        cells = self.looks.setdefault(row, {})
        cells.pop(column, None)
        if look != self.columns.get(column, PLAIN_LOOK):
            cells[column] = look
        elif not cells:
            del self.looks[row]

    def of(self, rows: Iterable[str]) -> tuple[Mark, ...]:
        """Return the marks of rows."""
        places = [(r, c) for r in rows for c in sorted({*self.threads.get(r, ()), *self.looks.get(r, ())})]
        return tuple((row, column, self.thread(row, column), self.look(row, column)) for row, column in places)

    def drop(self, rows: Iterable[str]) -> None:
        """Forget rows that are deleted."""
        for row in rows:
            self.threads.pop(row, None)
            self.looks.pop(row, None)

    def copy_looks(self, rows: Iterable[str], pattern: str | None) -> None:
        """Let new rows look like another one."""
        if pattern is not None and (looks := self.looks.get(pattern)):
            self.looks.update((row, dict(looks)) for row in rows)

    def load(self, rows: Mapping[int, str], threads: Threads, looks: SheetLooks) -> list[str]:
        """Take over what the file says of rows (ids by number); return those that have other marks now."""
        new = CellMarks(columns=looks.columns)
        for (number, column), thread in threads.items():
            if number in rows:
                new.set_thread(rows[number], column, thread)
        for (number, column), look in looks.cells.items():
            if number in rows:
                new.set_look(rows[number], column, look)
        changed = [
            row for row in rows.values()
            if self.threads.get(row) != new.threads.get(row) or self.looks.get(row) != new.looks.get(row)
        ]  # fmt: skip
        if self.columns != new.columns:
            changed = list(rows.values())
        self.threads, self.looks, self.columns = new.threads, new.looks, new.columns
        return changed


def look_edit(sheet: str, row: int, column: int, was: Look, look: Look) -> SetLook:
    """Return the file's edit that changes a look into another one; what is the same in both stays as it is there."""
    parts = {f.name: getattr(look, f.name) for f in fields(Look) if getattr(was, f.name) != getattr(look, f.name)}
    return SetLook(sheet, row, column, **parts)


def restoring(sheet: str, numbers: Mapping[str, int], marks: CellMarks, wanted: Sequence[Mark]) -> list[SetLook]:
    """Return the edits that give rows the looks that they had; new rows look like the one above them."""
    looks = {(row, column): look for row, column, _, look in wanted}
    places = dict.fromkeys([*((row, c) for row in numbers for c in marks.looks.get(row, ())), *looks])
    found = []
    for row, column in places:
        was, look = marks.look(row, column), looks.get((row, column), marks.columns.get(column, PLAIN_LOOK))
        if was != look:
            found.append(look_edit(sheet, numbers[row], column, was, look))
    return found
