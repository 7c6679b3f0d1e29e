"""A workbook under edit by several people: every edit is checked, journalled, stored in the file, and can be undone."""

from __future__ import annotations

import threading
from collections.abc import Iterable, Sequence
from itertools import groupby
from pathlib import Path

from rrp_sheets.documents.changes import CellText, Changed, Clash, Refused
from rrp_sheets.documents.grid import Grid, make_grid
from rrp_sheets.documents.journal import Journal, Version
from rrp_sheets.documents.undo import Added, Cells, Gone, Moved, Step, Steps
from rrp_sheets.errors import SheetsError
from rrp_sheets.model.names import key
from rrp_sheets.workbook import Reading, read
from rrp_sheets.workbook.editing import edit
from rrp_sheets.workbook.edits import DeleteRows, Edit, InsertRows, MoveRows, SetCell
from rrp_sheets.workbook.headers import recognise
from rrp_sheets.workbook.patch.values import typed

_AGAIN = "Look at it, and change it again if you still want to."


class Document:
    """One workbook. Safe to use from several threads.

    Args:
        path: of the file.
        journal: of its folder; what a killed server left there is stored first.

    Attributes:
        grids: its sheets by name, in the order of the file.
        version: grows with every change.

    Raises:
        UnreadableFile: when the file cannot be read.
    """

    def __init__(self, path: Path, journal: Journal) -> None:
        self.path = path
        self._journal = journal
        self._lock = threading.RLock()
        self._steps = Steps()
        self._stamp = (0, 0)
        self.grids: dict[str, Grid] = {}
        self.version = 0
        self._recover()
        self._reading: Reading | None = None
        self._digest = ""
        self._take_over()

    @property
    def reading(self) -> Reading:
        """The workbook as its file says it now; read again only when it has changed."""
        with self._lock:
            if self._reading is None:
                self._stamp = _stamp(self.path)
                self._reading = read(self.path)
                self._digest = self._reading.digest
            return self._reading

    # ---- editing

    def set_cells(self, author: str, sheet: str, cells: Sequence[CellText]) -> Changed:
        """Change cells of a sheet, all or none.

        Raises:
            Refused: when someone has changed one of them meanwhile, or the file does not allow it.
        """
        return self._new(author, Cells(sheet, tuple(cells)))

    def insert(self, author: str, sheet: str, before: str | None, count: int) -> Changed:
        """Insert blank rows before a row; None: at the end."""
        with self._lock:
            grid = self._grid(sheet)
            if before is None:
                added = grid.add_blank(count)
                return Changed(sheet, inserted=tuple((row, None) for row in added))
            self._must_have(grid, [before])
            return self._new(author, Gone(sheet, tuple((grid.new_id(), {}) for _ in range(count)), before))

    def delete(self, author: str, sheet: str, rows: Sequence[str]) -> Changed:
        """Delete rows with everything in them."""
        return self._new(author, Added(sheet, tuple(rows)))

    def move(self, author: str, sheet: str, rows: Sequence[str], before: str | None) -> Changed:
        """Move rows before another one; None: to the end."""
        return self._new(author, Moved(sheet, tuple(rows), before))

    def undo(self, author: str, *, again: bool = False) -> Changed | None:
        """Take back one's own newest edit (or make it again); None when there is nothing to take back."""
        with self._lock:
            step = self._steps.last(author, again=again)
            if step is None:
                return None
            changed, inverse = self._make(author, step)
            (self._steps.redone if again else self._steps.undone)(author, inverse)
            return changed

    def can_undo(self, author: str) -> tuple[bool, bool]:
        """Whether somebody has something to undo, and to redo."""
        return self._steps.can(author)

    # ---- the file

    def poll(self) -> list[Changed]:
        """Take over what another program has written into the file meanwhile; what changed by that."""
        with self._lock:
            return self._synchronise()

    def keep_version(self, author: str, name: str) -> None:
        """Keep the workbook as it is now under a name."""
        with self._lock:
            self._journal.keep_version(self.path.name, name, author, self._digest, self.path.read_bytes())

    def versions(self) -> list[Version]:
        """The named versions, the newest first."""
        return self._journal.versions(self.path.name)

    def _new(self, author: str, step: Step) -> Changed:
        with self._lock:
            changed, inverse = self._make(author, step)
            self._steps.did(author, inverse)
            return changed

    def _make(self, author: str, step: Step) -> tuple[Changed, Step]:
        self._synchronise()
        grid = self._grid(step.sheet)
        if isinstance(step, Cells):
            return self._put(author, grid, step)
        if isinstance(step, Gone):
            return self._bring(author, grid, step)
        self._must_have(grid, step.rows)
        return self._remove(author, grid, step) if isinstance(step, Added) else self._shift(author, grid, step)

    def _put(self, author: str, grid: Grid, step: Cells) -> tuple[Changed, Step]:
        self._must_have(grid, [c.row for c in step.back])
        clashes = [
            Clash(c.row, c.column, c.text, now, grid.authors.get((c.row, c.column), ""))
            for c in step.back
            if c.was is not None and (now := grid.text(c.row, c.column)) not in (c.was, c.text)
        ]
        if clashes:
            raise self._clash(grid, clashes)
        numbers = grid.numbers()
        columns = {c.number for c in grid.columns}
        if any(c.column not in columns for c in step.back):
            raise Refused("There is no such column.", "Reload the page.")
        edits = [SetCell(grid.name, numbers[c.row], c.column, typed(c.text)) for c in step.back]
        self._store(author, edits)
        back = tuple(CellText(c.row, c.column, grid.text(c.row, c.column), c.text) for c in step.back)
        for c in step.back:
            grid.put(c.row, c.column, c.text)
            grid.authors[c.row, c.column] = author
        return Changed(grid.name, touched=tuple(dict.fromkeys(c.row for c in step.back))), Cells(grid.name, back)

    def _bring(self, author: str, grid: Grid, step: Gone) -> tuple[Changed, Step]:
        """Insert rows, with their texts when they were deleted before."""
        place = grid.rows.index(step.before) if step.before and grid.has(step.before) else len(grid.rows)
        number = grid.first + place
        ids = [row for row, _ in step.rows]
        insert = InsertRows(grid.name, number, len(ids))
        texts = [
            SetCell(grid.name, number + i, column, typed(text))
            for i, (_, cells) in enumerate(step.rows)
            for column, text in cells.items()
        ]
        self._store(author, [insert, *texts])
        grid.carry_out(insert, ids)
        for row, cells in step.rows:
            for column, text in cells.items():
                grid.put(row, column, text)
        return Changed(grid.name, inserted=tuple((row, step.before) for row in ids)), Added(grid.name, tuple(ids))

    def _remove(self, author: str, grid: Grid, step: Added) -> tuple[Changed, Step]:
        blocks = _blocks(sorted(grid.number(row) for row in step.rows))
        if len(blocks) > 1:
            raise Refused(
                "Only rows that follow each other can be deleted at once.", "Delete them one block at a time."
            )
        first, count = blocks[0]
        place = first - grid.first
        gone = tuple((row, dict(grid.texts[row])) for row in grid.rows[place : place + count])
        removal = DeleteRows(grid.name, first, count)
        self._store(author, [removal])
        grid.carry_out(removal)
        removed = tuple(row for row, _ in gone)
        return Changed(grid.name, removed=removed), Gone(grid.name, gone, grid.before(place))

    def _shift(self, author: str, grid: Grid, step: Moved) -> tuple[Changed, Step]:
        blocks = _blocks(sorted(grid.number(row) for row in step.rows))
        if len(blocks) > 1:
            raise Refused("Only rows that follow each other can be moved at once.", "Move them one block at a time.")
        first, count = blocks[0]
        after = grid.before(first - grid.first + count)
        target = grid.number(step.before) if step.before and grid.has(step.before) else grid.first + len(grid.rows)
        move = MoveRows(grid.name, first, count, target)
        if move.moves:
            self._store(author, [move])
            grid.carry_out(move)
        return Changed(grid.name, moved=tuple((row, step.before) for row in step.rows)), Moved(
            grid.name, step.rows, after
        )

    def _store(self, author: str, edits: Sequence[Edit]) -> None:
        """Into the journal, then into the file; when the file does not take it, out of the journal again."""
        seq = self._journal.add(self.path.name, author, edits, self._digest)
        try:
            edited = edit(self.path, edits, expected_digest=self._digest)
        except SheetsError as error:
            self._journal.drop(seq)
            raise Refused(error.message, error.remedy) from error
        self._journal.stored(seq)
        self._digest, self._stamp, self._reading = edited.digest, _stamp(self.path), None
        self.version += 1

    def _synchronise(self) -> list[Changed]:
        if _stamp(self.path) == self._stamp:
            return []
        before, self._reading = self._digest, None
        if self.reading.digest == before:
            return []
        self.version += 1
        return self._take_over()

    def _take_over(self) -> list[Changed]:
        """Bring the grids up to what the file says; rows that are the same keep their ids."""
        tables = self.reading.workbook.tables
        found: dict[str, Grid] = {}
        changes = []
        for sheet in self.reading.sheets:
            recognised = recognise(sheet)
            kind = recognised.kind.name if recognised.kind else "table" if key(sheet.name) in tables else ""
            if not kind:
                continue
            fresh = make_grid(sheet, recognised, kind)
            old = self.grids.get(sheet.name)
            if old is None or (old.kind, old.first, old.columns) != (fresh.kind, fresh.first, fresh.columns):
                found[sheet.name] = fresh
                changes.append(Changed(sheet.name))
                continue
            found[sheet.name] = old
            rows = list(old.rows)
            if old.load(sheet):
                kept = set(old.rows)
                changes.append(Changed(sheet.name, removed=tuple(r for r in rows if r not in kept)))
        self.grids = found
        return changes

    def _recover(self) -> None:
        """Store what a killed server had accepted and not stored."""
        for entry in self._journal.waiting(self.path.name):
            if read(self.path).digest == entry.before:
                edit(self.path, entry.edits, expected_digest=entry.before)
            self._journal.stored(entry.seq)

    # ---- refusing

    def _grid(self, sheet: str) -> Grid:
        grid = self.grids.get(sheet)
        if grid is None:
            raise Refused(f"There is no sheet “{sheet}” any more.", "Reload the page.")
        return grid

    def _must_have(self, grid: Grid, rows: Iterable[str]) -> None:
        if not all(grid.has(row) for row in rows):
            raise Refused("A row that this changes was deleted meanwhile.", _AGAIN)

    def _clash(self, grid: Grid, clashes: list[Clash]) -> Refused:
        first = clashes[0]
        by = first.by or "Someone"
        where = f"{grid.name}, row {grid.number(first.row)}"
        return Refused(
            f"{by} has changed this cell meanwhile ({where}): it is “{first.theirs}” now; yours was “{first.mine}”.",
            _AGAIN, tuple(clashes),
        )  # fmt: skip


def _stamp(path: Path) -> tuple[int, int]:
    try:
        status = path.stat()
    except OSError:
        return (0, 0)
    return (status.st_mtime_ns, status.st_size)


def _blocks(numbers: list[int]) -> list[tuple[int, int]]:
    """Consecutive numbers as (first, count).

    >>> _blocks([2, 3, 5])
    [(2, 2), (5, 1)]
    """
    blocks = []
    for _, group in groupby(enumerate(numbers), lambda pair: pair[1] - pair[0]):
        members = [n for _, n in group]
        blocks.append((members[0], len(members)))
    return blocks
