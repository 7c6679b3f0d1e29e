"""A sheet as a grid of rows that keep their identity, the steps that change them, and what the editors are told."""

from __future__ import annotations

import difflib
import secrets
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import groupby, pairwise

from rrp_sheets.documents.marks import CellMarks, Mark, look_edit, restoring
from rrp_sheets.errors import SheetsError
from rrp_sheets.model import japanese
from rrp_sheets.model.names import key
from rrp_sheets.texts import N_
from rrp_sheets.workbook.comments import Thread, merged
from rrp_sheets.workbook.edits import DeleteRows, Edit, InsertRows, MoveRows, SetCell, SetComments, parse_typed
from rrp_sheets.workbook.looks import Look
from rrp_sheets.workbook.raw import RawSheet
from rrp_sheets.workbook.schema import Recognised


@dataclass(frozen=True, slots=True)
class CellText:
    """A cell's new text, by the row's id and the sheet's own column number.

    Attributes:
        was: what stood there when its author began to type; None to overwrite whatever stands there.
    """

    row: str
    column: int
    text: str
    was: str | None = None


@dataclass(frozen=True, slots=True)
class SheetChange:
    """Change of a sheet as a whole.

    Attributes:
        what: `added`, `deleted`, `renamed`, `moved`; `reshaped` when columns came or went.
        name: its name now.
        kind: of a sheet that was added: `behaviour`, `devices`, …; empty for one of the user's own.
        was: the name of a renamed one until now.
    """

    what: str
    name: str
    kind: str = ""
    was: str = ""


@dataclass(frozen=True, slots=True)
class Changed:
    """Changes that an edit made in a sheet: ids of rows, in the order of the sheet.

    Attributes:
        inserted: each new row with the row it stands before (None: at the end), in the order to insert them.
        moved: each moved row with the row it now stands before.
        grown: blank rows at the end, so that there is always room below the last filled row.
        cells: the cells that have other texts now, as row and column; empty where whole rows came or went.
        about: what `cells` have anew: texts, `comments`, or `looks`.
        heads: columns with another header, and that; a blank one where the column is gone.
        cursor: the cell that is to be filled in next, as row and column.
        then: what was changed after that, when one edit does several things.
        change: what became of the sheet itself.
        devices: the streams that were added to the sheet Devices with it.
    """

    sheet: str
    touched: tuple[str, ...] = ()
    inserted: tuple[tuple[str, str | None], ...] = ()
    removed: tuple[str, ...] = ()
    moved: tuple[tuple[str, str | None], ...] = ()
    grown: tuple[str, ...] = ()
    cells: tuple[tuple[str, int], ...] = ()
    about: str = "texts"
    heads: tuple[tuple[int, str], ...] = ()
    cursor: tuple[str, int] | None = None
    then: tuple[Changed, ...] = ()
    change: SheetChange | None = None
    devices: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Clash:
    """A cell that someone else has changed meanwhile: what is wanted, what stands there, and who put it there."""

    row: str
    column: int
    mine: str
    theirs: str
    by: str = ""


class Refused(SheetsError):
    """An edit that was not made, and why; `clashes` are the cells that someone else has changed meanwhile."""

    def __init__(self, message: str, remedy: str = "", clashes: tuple[Clash, ...] = ()) -> None:
        super().__init__(message, remedy)
        self.clashes = clashes


class SheetMissing(Refused):
    """An edit of a sheet that is not there any more, with the name that it had last."""

    def __init__(self, sheet: str) -> None:
        self.sheet = sheet
        super().__init__(N_("There is no sheet “{sheet}” any more.", sheet=sheet), N_("Reload the page."))


HEADER = "header"
"""Stands for the id of the row of headers, whose cells have comments; it is none of a grid's rows."""
BLANK_ROWS = 20  # at least, below the last filled row, so that there is always room to go on


@dataclass(frozen=True, slots=True)
class GridColumn:
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
        marks: comments and looks of cells.
        authors: who changed a cell last, by (row id, column), since the document was opened.
        version: grows with each insert, delete or move, and over a restart. Who reads it without the lock reads it
            before `rows`, which are then of that version or a later one.
    """

    name: str
    kind: str
    first: int
    columns: tuple[GridColumn, ...]
    rows: list[str] = field(default_factory=list)
    texts: dict[str, dict[int, str]] = field(default_factory=dict)
    marks: CellMarks = field(default_factory=CellMarks)
    authors: dict[tuple[str, int], str] = field(default_factory=dict)
    version: int = field(default_factory=lambda: time.time_ns() // 1_000_000, compare=False)
    _below: dict[str, str | None] = field(default_factory=dict, compare=False)
    _count: int = 0
    _mine: str = field(default_factory=lambda: secrets.token_hex(3), compare=False)

    def new_id(self) -> str:
        """An id that no row of this sheet has had, nor one of a page that is left from another start of the server."""
        self._count += 1
        return f"w{self._mine}-{self._count}"

    def text(self, row: str, column: int) -> str:
        """Return the text of a cell; empty for a blank one."""
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
        if row == HEADER:
            return self.first - 1
        return self.first + self.rows.index(row)

    def numbers(self) -> dict[str, int]:
        """All rows' numbers by id, in order."""
        return {row: self.first + i for i, row in enumerate(self.rows.copy())}

    def has(self, row: str) -> bool:
        """Return whether the row exists."""
        return row in self.texts

    def row_at(self, index: int) -> str | None:
        """Return the row at an index, or None beyond the end."""
        return self.rows[index] if index < len(self.rows) else None

    def knows(self, row: str) -> bool:
        """Return whether the row exists, or existed until it was deleted."""
        return self.has(row) or row in self._below

    def index_of(self, row: str | None) -> int:
        """Return the index of a row; of a deleted row, that of the next one below it. None means the end."""
        while row is not None and not self.has(row):
            row = self._below.get(row)
        return len(self.rows) if row is None else self.rows.index(row)

    def add_blank(self, count: int, ids: Iterable[str] = ()) -> list[str]:
        """Blank rows at the end; nothing changes in the file. `ids`: of the rows, when they have some already."""
        added = list(ids) or [self.new_id() for _ in range(count)]
        self.texts.update((row, {}) for row in added)
        self.rows = [*self.rows, *added]
        self.version += 1
        return added

    def filled(self) -> int:
        """Return the number of rows up to the last one with a text."""
        blank = next((i for i, row in enumerate(reversed(self.rows)) if self.texts[row]), len(self.rows))
        return len(self.rows) - blank

    @property
    def free(self) -> int:
        """The number of the first column to the right of all that is filled."""
        return 1 + max(
            (c for cells in [{c.number for c in self.columns}, *self.texts.values()] for c in cells), default=0
        )

    def fill_up(self) -> list[str]:
        """The blank rows that were missing below the last filled row, and are there now."""
        missing = self.filled() + BLANK_ROWS - len(self.rows)
        return self.add_blank(missing) if missing > 0 else []

    def carry_out(self, edit: InsertRows | DeleteRows | MoveRows, ids: Iterable[str] = ()) -> list[str]:
        """The same as the edit does in the file; the rows that came, went or moved. `ids`: of rows that come back."""
        if isinstance(edit, InsertRows):
            place, given = edit.before - self.first, list(ids)
            new = given or [self.new_id() for _ in range(edit.count)]
            self.texts.update((row, {}) for row in new)
            self.marks.copy_looks(new, self.row_at(max(place - 1, 0)))
            self.rows = [*self.rows[:place], *new, *self.rows[place:]]
            self.version += 1
            return new
        place = edit.first - self.first
        block, others = self.rows[place : place + edit.count], self.rows[:place] + self.rows[place + edit.count :]
        if isinstance(edit, DeleteRows):
            self._drop(block, others)
            return block
        to = edit.before - self.first
        to -= edit.count if to > place else 0
        self.rows = others[:to] + block + others[to:]
        self.version += 1
        return block

    def adopt(self, ids: Sequence[str], edits: Iterable[Edit]) -> None:
        """Give the rows the ids from before a restart of the server; `edits` were made since these were kept."""
        kept = Grid(self.name, self.kind, self.first, self.columns, list(ids), {row: {} for row in ids})
        for edit in edits:
            if isinstance(edit, InsertRows | DeleteRows | MoveRows) and edit.sheet == self.name:
                kept.carry_out(edit)
        if len(kept.rows) < self.filled():  # they are of another file
            return
        more = self.rows[len(kept.rows) :]
        lines = [self.texts[row] for row in self.rows] + [{} for _ in range(len(kept.rows) - len(self.rows))]
        self.rows = kept.rows + more
        self.texts = dict(zip(self.rows, lines, strict=True))
        self.version += 1
        self.fill_up()

    def _drop(self, gone: Sequence[str], others: Sequence[str]) -> None:
        """Take rows away; what is said to stand before one of them stands before the next row that is left."""
        left, below = set(others), None
        for row in reversed(self.rows):
            if row in left:
                below = row
            else:
                self._below[row] = below
        self.rows = list(others)
        for row in gone:
            del self.texts[row]
        self.marks.drop(gone)
        self.version += 1

    def load(self, sheet: RawSheet) -> Changed | None:
        """Take over what the file says now; rows that are the same keep their ids. Gives what is new, if anything."""
        found = dict(_lines(sheet, self.first, self.columns))
        last = max(found, default=self.first - 1)
        lines = [found.get(n, {}) for n in range(self.first, last + 1)]
        was = self.rows
        old = [self.texts[row] for row in was[: self.filled()]]
        if lines == old and was:
            return None
        places = match(old, lines)
        ending = max((n for n, place in enumerate(places, 1) if place is not None), default=0)
        # below the last row that is still there, rows are told by their numbers: blank ones too
        below = was[1 + max((place for place in places if place is not None), default=-1) :]
        rows = [was[place] if place is not None else self.new_id() for place in places[:ending]] + below
        rows += [self.new_id() for _ in range(len(lines) - len(rows))]
        new: dict[str, dict[int, str]] = {row: {} for row in rows} | dict(zip(rows, lines, strict=False))
        touched = tuple(row for row in rows if row in self.texts and self.texts[row] != new[row])
        before, followers = set(was), dict(pairwise([*rows, None]))
        came = tuple((row, followers[row]) for row in reversed(rows) if row not in before)
        gone = tuple(row for row in was if row not in new)
        for row in touched:
            changed = {column for column, _ in self.texts[row].items() ^ new[row].items()}
            for column in changed:
                self.authors.pop((row, column), None)
        self.texts.update(new)
        if gone:
            self._drop(gone, [row for row in was if row in new])
        if came:
            self.rows = rows
            self.version += 1
        return Changed(self.name, touched, inserted=came, removed=gone, grown=tuple(self.fill_up()))


def make_grid(sheet: RawSheet, found: Recognised, kind: str) -> Grid:
    """Return the grid of a sheet: the columns that have a header, and the rows below it."""
    names = {column: name for name, column in found.columns.items()}
    row = found.row or min((r for r, _ in sheet.cells), default=1)
    headers = sorted((c, cell.typed) for (r, c), cell in sheet.cells.items() if r == row and cell.typed.strip())
    grid = Grid(sheet.name, kind, row + 1, tuple(GridColumn(c, text.strip(), names.get(c, "")) for c, text in headers))
    grid.load(sheet)
    return grid


def _lines(sheet: RawSheet, first: int, columns: tuple[GridColumn, ...]) -> Iterator[tuple[int, dict[int, str]]]:
    known = {c.number for c in columns}
    for number, cells in sheet.rows().items():
        texts = {c: cell.typed for c, cell in cells.items() if c in known and cell.typed}
        if number >= first and texts:
            yield number, texts


RowTexts = Mapping[int, str]
_MOST = 10_000  # pairs of rows that are compared cell by cell; beyond, rows are paired in their order


def match(old: Sequence[RowTexts], new: Sequence[RowTexts]) -> list[int | None]:
    """For each new row the place of the old row that it was; None for a row that came.

    Equal rows are the same row; of the others between two equal ones, those that share most cells.

    >>> match([{1: "a"}, {1: "b", 2: "x"}], [{1: "new"}, {1: "a"}, {1: "b", 2: "y"}])
    [None, 0, 1]
    >>> match([{1: "x", 2: "y"}, {1: "a", 2: "b"}], [{1: "a", 2: "c"}])
    [1]
    """
    top, most = 0, min(len(old), len(new))
    while top < most and old[top] == new[top]:
        top += 1
    end = 0
    while end < most - top and old[-1 - end] == new[-1 - end]:
        end += 1
    found: list[int | None] = [*range(top), *([None] * (len(new) - top - end)), *range(len(old) - end, len(old))]
    left, right = old[top : len(old) - end], new[top : len(new) - end]
    matcher = difflib.SequenceMatcher(None, [_tag(c) for c in left], [_tag(c) for c in right], autojunk=False)
    for op, a, b, c, d in matcher.get_opcodes():
        pairs = zip(range(a, b), range(c, d), strict=True) if op == "equal" else _alike(left, right, (a, b), (c, d))
        for i, j in pairs:
            found[top + j] = top + i
    return found


def _alike(
    old: Sequence[RowTexts], new: Sequence[RowTexts], some: tuple[int, int], others: tuple[int, int]
) -> Iterator[tuple[int, int]]:
    """Pairs of rows in their order, as many as there can be, so that they share as many cells as possible."""
    (a, b), (c, d) = some, others
    if (b - a) * (d - c) > _MOST:
        yield from zip(range(a, b), range(c, d), strict=False)
        return
    best = [[0] * (d - c + 1) for _ in range(b - a + 1)]
    for i in range(b - a - 1, -1, -1):
        for j in range(d - c - 1, -1, -1):
            paired = best[i + 1][j + 1] + _likeness(old[a + i], new[c + j])
            best[i][j] = max(paired, best[i + 1][j], best[i][j + 1])
    i = j = 0
    while i < b - a and j < d - c:
        if best[i][j] == best[i + 1][j + 1] + _likeness(old[a + i], new[c + j]):
            yield a + i, c + j
            i, j = i + 1, j + 1
        elif best[i][j] == best[i + 1][j]:
            i += 1
        else:
            j += 1


def _likeness(one: RowTexts, other: RowTexts) -> int:
    """One for being a pair at all, and much more for each cell with the same text."""
    return 1 + 1000 * sum(other.get(column) == text for column, text in one.items())


def _tag(cells: RowTexts) -> tuple[tuple[int, str], ...]:
    return tuple(sorted(cells.items()))


@dataclass(frozen=True, slots=True)
class PutTexts:
    """Put texts into cells, if each still has the text `was`."""

    sheet: str
    cells: tuple[CellText, ...]


@dataclass(frozen=True, slots=True)
class RemoveRows:
    """Delete rows; with `texts` only if nobody else has changed these, which they had when they were inserted.

    The same holds for their comments in `marks`.
    """

    sheet: str
    rows: tuple[str, ...]
    texts: tuple[dict[int, str], ...] | None = None
    marks: tuple[Mark, ...] = ()


@dataclass(frozen=True, slots=True)
class AddRows:
    """Insert rows with these ids and texts before a row (None: at the end).

    With `marks` they have these comments and looks; without, they look like the row above.
    """

    sheet: str
    rows: tuple[tuple[str, dict[int, str]], ...]
    before: str | None
    marks: tuple[Mark, ...] | None = None


@dataclass(frozen=True, slots=True)
class PlaceRows:
    """Move rows before a row (None: to the end)."""

    sheet: str
    rows: tuple[str, ...]
    before: str | None


@dataclass(frozen=True, slots=True)
class PutThread:
    """Change the comments of a cell from `before` to `after`; what others have changed of them stays."""

    sheet: str
    row: str
    column: int
    before: Thread
    after: Thread


@dataclass(frozen=True, slots=True)
class PutLooks:
    """Change looks of cells (row, column), each from the first to the second as far as these differ."""

    sheet: str
    cells: tuple[tuple[str, int, Look, Look], ...]


@dataclass(frozen=True, slots=True)
class PutHeader:
    """Give a column of a table another header, if it still has the one that it had (`was`).

    A sheet gets a further column in this way, after all others, and loses it again with a blank header.
    """

    sheet: str
    column: int
    text: str
    was: str


RowStep = PutTexts | RemoveRows | AddRows | PlaceRows | PutThread | PutLooks | PutHeader
"""A step of the rows of one sheet, made in the file and then in the grid; each gives the step that undoes it."""


@dataclass(frozen=True, slots=True)
class Batch:
    """Several steps, one after the other, that are one for people; `sheet` is that of the first."""

    sheet: str
    steps: tuple[RowStep, ...]


def cell_edits(grid: Grid, cells: Sequence[CellText], before: Mapping[tuple[str, str, int], str]) -> list[SetCell]:
    """Return the file's edits for new texts; raise Refused when someone has changed one meanwhile, or it is gone.

    `before`: texts that come before them and are not in the grid yet.
    """
    must_have(grid, [c.row for c in cells])
    columns = {c.number for c in grid.columns}
    if any(c.column not in columns for c in cells):
        raise Refused(N_("There is no such column."), N_("Reload the page."))
    clashes = []
    for c in cells:
        now = before.get((grid.name, c.row, c.column), grid.text(c.row, c.column))
        if c.was is not None and now not in (c.was, c.text):
            clashes.append(Clash(c.row, c.column, c.text, now, grid.authors.get((c.row, c.column), "")))
    if clashes:
        raise clash(grid, clashes)
    numbers = grid.numbers()
    return [SetCell(grid.name, numbers[c.row], c.column, parse_typed(c.text)) for c in cells]


def put_texts(author: str, grid: Grid, cells: Sequence[CellText]) -> tuple[Changed, PutTexts]:
    """Put texts that are in the file already into the grid; returns the change and the step back."""
    back = tuple(CellText(c.row, c.column, grid.text(c.row, c.column), c.text) for c in cells)
    for c in cells:
        grid.put(c.row, c.column, c.text)
        grid.authors[c.row, c.column] = author
    rows, places = dict.fromkeys(c.row for c in cells), tuple((c.row, c.column) for c in cells)
    return Changed(grid.name, touched=tuple(rows), cells=places), PutTexts(grid.name, back)


Store = Callable[[str, Sequence[Edit]], tuple[str, ...]]
"""Puts an author's edits into the file, and returns what brings deleted sheets back; raises Refused."""


def bring(store: Store, author: str, grid: Grid, step: AddRows) -> tuple[Changed, RemoveRows]:
    """Insert rows, with their texts, comments and looks when they were deleted before."""
    number = grid.first + grid.index_of(step.before)
    ids = [row for row, _ in step.rows]
    numbers = {row: number + i for i, row in enumerate(ids)}
    insert = InsertRows(grid.name, number, len(ids))
    texts = [(row, column, text) for row, cells in step.rows for column, text in cells.items()]
    edits: list[Edit] = [insert]
    edits += [SetCell(grid.name, numbers[row], column, parse_typed(text)) for row, column, text in texts]
    if step.marks is not None:
        new = CellMarks(columns=grid.marks.columns)
        new.looks.update(grid.marks.looks)
        new.copy_looks(ids, grid.row_at(max(number - grid.first - 1, 0)))
        edits += restoring(grid.name, numbers, new, step.marks)
        edits += [SetComments(grid.name, numbers[r], c, thread) for r, c, thread, _ in step.marks if thread]
    store(author, edits)
    grid.carry_out(insert, ids)
    for row, column, text in texts:
        grid.put(row, column, text)
    if step.marks is not None:
        grid.marks.drop(ids)
        for row, column, thread, look in step.marks:
            grid.marks.set_thread(row, column, thread)
            grid.marks.set_look(row, column, look)
    back = RemoveRows(grid.name, tuple(ids), tuple(cells for _, cells in step.rows), step.marks or ())
    return Changed(grid.name, inserted=tuple((row, step.before) for row in ids)), back


def remove(store: Store, author: str, grid: Grid, step: RemoveRows) -> tuple[Changed, AddRows]:
    """Delete rows that follow each other; raise Refused when somebody has changed one of them since it came."""
    _unchanged(author, grid, step)
    place, count = grid.index_of(step.rows[0]), len(step.rows)
    gone = tuple((row, dict(grid.texts[row])) for row in grid.rows[place : place + count])
    marks = grid.marks.of(row for row, _ in gone)
    removal = DeleteRows(grid.name, grid.first + place, count)
    store(author, [removal])
    grid.carry_out(removal)
    back = AddRows(grid.name, gone, grid.row_at(place), marks)
    return Changed(grid.name, removed=tuple(row for row, _ in gone)), back


def put_thread(store: Store, author: str, grid: Grid, step: PutThread) -> tuple[Changed, PutThread]:
    """Change the comments of a cell or a header; raise Refused when others have changed the same comment."""
    must_have(grid, {step.row} - {HEADER})
    now = grid.marks.thread(step.row, step.column)
    try:
        after = merged(now, step.before, step.after)
    except SheetsError as error:
        raise Refused(error.message, error.remedy) from error
    store(author, [SetComments(grid.name, grid.number(step.row), step.column, after)])
    grid.marks.set_thread(step.row, step.column, after)
    changed = Changed(grid.name, touched=(step.row,), cells=((step.row, step.column),), about="comments")
    return changed, PutThread(grid.name, step.row, step.column, after, now)


def put_header(store: Store, author: str, grid: Grid, step: PutHeader) -> tuple[Changed, PutHeader]:
    """Give a column of a table another header; raise Refused for one that is gone or was changed."""
    back = PutHeader(grid.name, step.column, step.was, step.text)
    there = {c.number: c.header for c in grid.columns}
    comes_or_goes = not (step.was and step.text)
    if there.get(step.column, "") != step.was or not (grid.kind if comes_or_goes else grid.kind == "table"):
        raise Refused(N_("The header of this column was changed."), _AGAIN)
    store(author, [SetCell(grid.name, grid.first - 1, step.column, step.text)])
    if comes_or_goes:
        new = (GridColumn(step.column, step.text),) if step.text else ()
        grid.columns = (*(c for c in grid.columns if c.number != step.column), *new)
        change = SheetChange("reshaped", grid.name, grid.kind)
        return Changed(grid.name, heads=((step.column, step.text),), change=change), back
    grid.columns = tuple(replace(c, header=step.text) if c.number == step.column else c for c in grid.columns)
    return Changed(grid.name, heads=((step.column, step.text),)), back


def put_looks(store: Store, author: str, grid: Grid, step: PutLooks) -> tuple[Changed, PutLooks]:
    """Change looks of cells."""
    must_have(grid, [row for row, *_ in step.cells])
    numbers, edits, back = grid.numbers(), list[Edit](), list[tuple[str, int, Look, Look]]()
    for row, column, was, look in step.cells:
        now = grid.marks.look(row, column)
        new = replace(now, **{n: getattr(look, n) for n in Look.__slots__ if getattr(was, n) != getattr(look, n)})
        edits.append(look_edit(grid.name, numbers[row], column, now, new))
        back.append((row, column, new, now))
    store(author, edits)
    for row, column, new, _ in back:
        grid.marks.set_look(row, column, new)
    rows, places = tuple(dict.fromkeys(row for row, *_ in back)), tuple((row, column) for row, column, *_ in back)
    return Changed(grid.name, touched=rows, cells=places, about="looks"), PutLooks(grid.name, tuple(back))


def shift(store: Store, author: str, grid: Grid, step: PlaceRows) -> tuple[Changed, PlaceRows]:
    """Move rows that follow each other."""
    place, count = grid.index_of(step.rows[0]), len(step.rows)
    after = grid.row_at(place + count)
    move = MoveRows(grid.name, grid.first + place, count, grid.first + grid.index_of(step.before))
    if move.moves:
        store(author, [move])
        grid.carry_out(move)
    moved = tuple((row, step.before) for row in step.rows)
    return Changed(grid.name, moved=moved), PlaceRows(grid.name, step.rows, after)


def blocks(grid: Grid, step: RemoveRows | PlaceRows) -> Sequence[RemoveRows | PlaceRows]:
    """A step of rows as one step for each of those that follow each other: others may have come between them."""
    places = sorted({grid.index_of(row) for row in step.rows})
    groups = [list(group) for _, group in groupby(enumerate(places), lambda pair: pair[1] - pair[0])]
    parts = [tuple(grid.rows[place] for _, place in group) for group in groups]
    if isinstance(step, PlaceRows) or step.texts is None:
        return [replace(step, rows=rows) for rows in parts]
    texts = dict(zip(step.rows, step.texts, strict=True))
    return [
        replace(
            step, rows=rows, texts=tuple(texts[row] for row in rows), marks=tuple(m for m in step.marks if m[0] in rows)
        )
        for rows in parts
    ]


def _unchanged(author: str, grid: Grid, step: RemoveRows) -> None:
    for row, texts in zip(step.rows, step.texts or (), strict=False):
        now = grid.texts[row]
        others = (grid.authors.get((row, c)) for c in {*now, *texts} if now.get(c, "") != texts.get(c, ""))
        by = next((who for who in others if who != author), author)
        if by != author:
            who, number = by or N_("Another program"), grid.number(row)
            message = N_("{who} has changed row {row} since, so it stays.", who=who, row=number)
            raise Refused(message, N_("Delete it if it is to go."))
    if step.texts is None:
        return
    known = {c.id for _, _, thread, _ in step.marks for c in thread}
    for row, _, thread, _ in grid.marks.of(step.rows):
        if who := next((c.author for c in thread if c.id not in known and c.author != author), ""):
            message = N_("{who} has commented on row {row} since, so it stays.", who=who, row=grid.number(row))
            raise Refused(message, N_("Delete it if it is to go."))


_AGAIN = N_("Look at it, and change it again if you still want to.")


def must_have(grid: Grid, rows: Iterable[str]) -> None:
    """Refuse when one of the rows is gone."""
    if not all(grid.has(row) for row in rows):
        raise Refused(N_("A row that this changes has been deleted."), _AGAIN)


def clash(grid: Grid, clashes: list[Clash]) -> Refused:
    """Return the refusal for cells that somebody has changed meanwhile."""
    first = clashes[0]
    message = N_(
        "{who} has also changed this cell ({sheet}, row {row}). It is now “{theirs}”; yours was “{mine}”.",
        who=first.by or N_("Someone"), sheet=grid.name, row=grid.number(first.row), theirs=first.theirs,
        mine=first.mine,
    )  # fmt: skip
    return Refused(message, _AGAIN, tuple(clashes))


def setting_columns(grid: Grid) -> dict[str, int]:
    """Return the numbers of a sheet's columns by the keys of their English names."""
    return {key(c.name or japanese.standard(japanese.SETTINGS, c.header)): c.number for c in grid.columns}
