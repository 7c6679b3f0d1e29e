"""One sheet as a grid: rows that keep their identity whatever is inserted above them, and texts as they were typed."""

from __future__ import annotations

import difflib
import secrets
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from rrp_sheets.workbook.edits import DeleteRows, Edit, InsertRows, MoveRows
from rrp_sheets.workbook.headers import Recognised
from rrp_sheets.workbook.raw import RawSheet

BLANK_ROWS = 20  # below the last filled row, so that there is always room to go on


@dataclass(frozen=True, slots=True)
class Column:
    """A column of a grid: its number in the sheet, its header as it stands there, and our name for it (or empty)."""

    number: int
    header: str
    name: str = ""


@dataclass
class Grid:
    """A sheet under edit. Who edits locks the document; who only looks need not, and sees each row as it is or was.

    Attributes:
        kind: `behaviour`, `devices`, …, or `table` for one of the user's own that formulas name.
        first: the number of the first row below the header.
        rows: the rows' ids, in order; the row at place i has the number `first + i`.
        texts: by row id, by column number; blank cells are not there.
        authors: who changed a cell last, by (row id, column), since the document was opened.
    """

    name: str
    kind: str
    first: int
    columns: tuple[Column, ...]
    rows: list[str] = field(default_factory=list)
    texts: dict[str, dict[int, str]] = field(default_factory=dict)
    authors: dict[tuple[str, int], str] = field(default_factory=dict)
    _count: int = 0
    _mine: str = field(default_factory=lambda: secrets.token_hex(3), compare=False)

    def new_id(self) -> str:
        """An id that no row of this sheet has had, nor one of a page that is left from another start of the server."""
        self._count += 1
        return f"w{self._mine}-{self._count}"

    def text(self, row: str, column: int) -> str:
        """What stands in a cell."""
        return self.texts.get(row, {}).get(column, "")

    def put(self, row: str, column: int, text: str) -> None:
        """Change a cell; an empty text empties it."""
        cells = self.texts.setdefault(row, {})
        if text:
            cells[column] = text
        else:
            cells.pop(column, None)

    def number(self, row: str) -> int:
        """A row's number in the sheet."""
        return self.first + self.rows.index(row)

    def numbers(self) -> dict[str, int]:
        """All rows' numbers by id, in order."""
        return {row: self.first + i for i, row in enumerate(self.rows.copy())}

    def has(self, row: str) -> bool:
        """Whether there is such a row."""
        return row in self.texts

    def before(self, place: int) -> str | None:
        """The row at a place, or None beyond the end."""
        return self.rows[place] if place < len(self.rows) else None

    def add_blank(self, count: int) -> list[str]:
        """Blank rows at the end; nothing changes in the file."""
        added = [self.new_id() for _ in range(count)]
        self.rows += added
        self.texts.update((row, {}) for row in added)
        return added

    def carry_out(self, edit: InsertRows | DeleteRows | MoveRows, ids: Iterable[str] = ()) -> list[str]:
        """The same as the edit does in the file; the rows that came, went or moved. `ids`: of rows that come back."""
        if isinstance(edit, InsertRows):
            place, given = edit.before - self.first, list(ids)
            new = given or [self.new_id() for _ in range(edit.count)]
            self.rows[place:place] = new
            self.texts.update((row, {}) for row in new)
            return new
        place = edit.first - self.first
        block, others = self.rows[place : place + edit.count], self.rows[:place] + self.rows[place + edit.count :]
        if isinstance(edit, DeleteRows):
            self.rows = others
            for row in block:
                del self.texts[row]
            return block
        to = edit.before - self.first
        to -= edit.count if to > place else 0
        self.rows = others[:to] + block + others[to:]
        return block

    def adopt(self, ids: Sequence[str], edits: Iterable[Edit]) -> None:
        """Give the rows the ids that they had before a restart of the server.

        Args:
            ids: of all rows, as they were kept.
            edits: what was edited after that.
        """
        kept = Grid(self.name, self.kind, self.first, self.columns, list(ids), {row: {} for row in ids})
        for edit in edits:
            if isinstance(edit, InsertRows | DeleteRows | MoveRows) and edit.sheet == self.name:
                kept.carry_out(edit)
        filled = max((place for place, row in enumerate(self.rows, 1) if self.texts[row]), default=0)
        if len(kept.rows) < filled:  # they are of another file
            return
        more = self.rows[len(kept.rows) :]
        lines = [self.texts[row] for row in self.rows] + [{} for _ in range(len(kept.rows) - len(self.rows))]
        self.rows = kept.rows + more
        self.texts = dict(zip(self.rows, lines, strict=True))

    def load(self, sheet: RawSheet) -> bool:
        """Take over what the file says now; rows that are the same keep their ids. True when anything is new."""
        found = dict(_lines(sheet, self.first, self.columns))
        last = max(found, default=self.first - 1)
        lines = [found.get(n, {}) for n in range(self.first, last + 1)]
        old = [self.texts[row] for row in self.rows]
        while old and not old[-1]:
            old.pop()
        if lines == old and self.rows:
            return False
        ids: list[str] = []
        matcher = difflib.SequenceMatcher(None, [_tag(c) for c in old], [_tag(c) for c in lines], autojunk=False)
        for op, a, b, c, d in matcher.get_opcodes():
            kept = self.rows[a:b] if op in ("equal", "replace") else []
            ids += kept[: d - c] + [self.new_id() for _ in range(d - c - len(kept))]
        self.rows = ids
        self.texts = dict(zip(ids, lines, strict=True))
        self.add_blank(BLANK_ROWS)
        return True


def make_grid(sheet: RawSheet, found: Recognised, kind: str) -> Grid:
    """The grid of a sheet: the columns that have a header, and the rows below it."""
    names = {column: name for name, column in found.columns.items()}
    row = found.row or min((r for r, _ in sheet.cells), default=1)
    headers = sorted((c, cell.typed) for (r, c), cell in sheet.cells.items() if r == row and cell.typed.strip())
    grid = Grid(sheet.name, kind, row + 1, tuple(Column(c, text.strip(), names.get(c, "")) for c, text in headers))
    grid.load(sheet)
    return grid


def _lines(sheet: RawSheet, first: int, columns: tuple[Column, ...]) -> Iterator[tuple[int, dict[int, str]]]:
    known = {c.number for c in columns}
    for number, cells in sheet.rows().items():
        if number >= first:
            texts = {c: cell.typed for c, cell in cells.items() if c in known and cell.typed}
            if texts:
                yield number, texts


def _tag(cells: Mapping[int, str]) -> tuple[tuple[int, str], ...]:
    return tuple(sorted(cells.items()))
