"""Steps of edits, made in the file and then in the grid; each gives the step that undoes it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby

from rrp_sheets.documents.grid import CellText, Changed, Clash, Grid, Refused, SheetChange
from rrp_sheets.documents.sheet_references import renamed_cells, run_cell, run_names
from rrp_sheets.errors import SheetsError
from rrp_sheets.model.names import key
from rrp_sheets.model.workbook import Address
from rrp_sheets.texts import N_
from rrp_sheets.workbook import Reading
from rrp_sheets.workbook.edits import (
    AddSheet,
    BringSheet,
    DeleteRows,
    DeleteSheet,
    Edit,
    InsertRows,
    MoveRows,
    MoveSheet,
    RenameSheet,
    SetCell,
    typed,
)
from rrp_sheets.workbook.sheet_names import sheet_name

MOST = 500  # steps back per person


@dataclass(frozen=True, slots=True)
class Cells:
    """Texts were changed: put those of `back` in again, if `now` still stands there."""

    sheet: str
    back: tuple[CellText, ...]


@dataclass(frozen=True, slots=True)
class RemoveRows:
    """Rows were inserted: delete them again; `texts` are those that they had then, None where that does not matter."""

    sheet: str
    rows: tuple[str, ...]
    texts: tuple[dict[int, str], ...] | None = None


@dataclass(frozen=True, slots=True)
class RestoreRows:
    """Rows were deleted: insert them again, with their ids and texts, before a row (None: at the end)."""

    sheet: str
    rows: tuple[tuple[str, dict[int, str]], ...]
    before: str | None


@dataclass(frozen=True, slots=True)
class Moved:
    """Rows were moved: move them back before a row (None: to the end)."""

    sheet: str
    rows: tuple[str, ...]
    before: str | None


@dataclass(frozen=True, slots=True)
class Batch:
    """Several steps, one after the other, that are one for people; `sheet` is that of the first."""

    sheet: str
    steps: tuple[Cells | RemoveRows | RestoreRows | Moved, ...]


@dataclass(frozen=True, slots=True)
class SheetIn:
    """A sheet is missing: add it, or bring it back as it was.

    Attributes:
        cells: what changes with it, by sheet (the Protocol's Run), where it still stands there as it did.
        grid: of the sheet that comes back, whose rows keep their ids.
    """

    sheet: str
    edit: AddSheet | BringSheet
    cells: tuple[tuple[str, CellText], ...] = ()
    grid: Grid | None = None


@dataclass(frozen=True, slots=True)
class SheetOut:
    """A sheet is there: delete it; with `texts` only if nothing else stands in it by now."""

    sheet: str
    texts: tuple[tuple[tuple[int, str], ...], ...] | None = None


@dataclass(frozen=True, slots=True)
class SheetNamed:
    """A sheet has this name: give it another one.

    Attributes:
        cells: how the cells that name it were spelt, by sheet, where they still say what they do.
    """

    sheet: str
    name: str
    cells: tuple[tuple[str, CellText], ...] = ()


@dataclass(frozen=True, slots=True)
class SheetPlaced:
    """A sheet stands somewhere: let it stand before another one (empty: at the end)."""

    sheet: str
    before: str


SheetStep = SheetIn | SheetOut | SheetNamed | SheetPlaced
Step = Cells | RemoveRows | RestoreRows | Moved | Batch | SheetStep


class Steps:
    """Steps of each person that can be undone, and those that were undone and can be made again."""

    def __init__(self) -> None:
        self._back: dict[str, list[Step]] = {}
        self._again: dict[str, list[Step]] = {}

    def did(self, author: str, step: Step) -> None:
        """Note a new step; what was undone before it cannot be made again."""
        self._push(self._back, author, step)
        self._again.pop(author, None)

    def undone(self, author: str, step: Step) -> None:
        """Note an undo: `step` would make the change again."""
        self._push(self._again, author, step)

    def redone(self, author: str, step: Step) -> None:
        """Note a redo: `step` would undo it again."""
        self._push(self._back, author, step)

    def last(self, author: str, *, again: bool) -> Step | None:
        """Remove and return the newest step to undo or redo; None when there is none."""
        pile = (self._again if again else self._back).get(author)
        return pile.pop() if pile else None

    @staticmethod
    def _push(piles: dict[str, list[Step]], author: str, step: Step) -> None:
        pile = piles.setdefault(author, [])
        pile.append(step)
        del pile[:-MOST]


@dataclass
class Sheets:
    """Sheets that the steps work on, with the ways to store and to read them again.

    Attributes:
        grids: of the sheets of ours.
        reading: the workbook as it is.
        store: puts an author's edits into the file; what brings deleted sheets back.
        renew: the grids as the file says them now, starting from these.
    """

    grids: Mapping[str, Grid]
    reading: Reading
    store: Callable[[str, Sequence[Edit]], tuple[str, ...]]
    renew: Callable[[Mapping[str, Grid]], Mapping[str, Grid]]

    def text(self, at: Address) -> str:
        """Return the typed text of a cell."""
        grid = self.grids.get(at.sheet)
        place = at.row - grid.first if grid is not None else -1
        return grid.text(grid.rows[place], at.column) if grid is not None and 0 <= place < len(grid.rows) else ""

    def cell(self, at: Address, text: str) -> tuple[str, CellText]:
        """A cell's new text, by its row's id."""
        grid = self.grids[at.sheet]
        return at.sheet, CellText(grid.rows[at.row - grid.first], at.column, text, self.text(at))


Texts = tuple[tuple[str, CellText], ...]


def make_sheet_step(sheets: Sheets, author: str, step: SheetStep) -> tuple[Changed, SheetStep]:
    """Make a step; what it changed, and the step that takes it back.

    Raises:
        Refused: it cannot be made, and why.
    """
    match step:
        case SheetIn():
            return _bring_in(sheets, author, step)
        case SheetOut():
            return _take_out(sheets, author, step)
        case SheetNamed():
            return _rename(sheets, author, step)
        case SheetPlaced():
            return _move(sheets, author, step)


def _bring_in(sheets: Sheets, author: str, step: SheetIn) -> tuple[Changed, SheetStep]:
    cells = _still(sheets, step.cells)
    sheets.store(author, [*_edits(sheets, cells), step.edit])
    sheets.grids = sheets.renew({**sheets.grids, **({step.sheet: step.grid} if step.grid is not None else {})})
    new = sheets.grids.get(step.sheet)
    change = SheetChange("added", step.sheet, new.kind if new else "")
    return _changed(sheets, author, step.sheet, change, cells), SheetOut(step.sheet, _texts(new))


def _take_out(sheets: Sheets, author: str, step: SheetOut) -> tuple[Changed, SheetStep]:
    grid = sheets.grids.get(step.sheet)
    if step.texts is not None and _texts(grid) != step.texts:
        names = sorted({who for who in grid.authors.values() if who != author}) if grid else []
        message = N_("“{sheet}” was changed since, so it stays.", sheet=step.sheet)
        if names:
            by = " and ".join(names[:3])
            message = N_("“{sheet}” was changed since by {names}, so it stays.", sheet=step.sheet, names=by)
        raise Refused(message, N_("Delete it in the menu of its tab."))
    cells = tuple(_run_without(sheets, step.sheet))
    (kept,) = sheets.store(author, [*_edits(sheets, cells), DeleteSheet(step.sheet)])
    back = tuple((name, replace(c, text=c.was or "", was=c.text)) for name, c in cells)
    sheets.grids = sheets.renew({n: g for n, g in sheets.grids.items() if n != step.sheet})
    changed = _changed(sheets, author, step.sheet, SheetChange("deleted", step.sheet), cells)
    return changed, SheetIn(step.sheet, BringSheet(step.sheet, kept), back, grid)


def _rename(sheets: Sheets, author: str, step: SheetNamed) -> tuple[Changed, SheetStep]:
    old, book = step.sheet, sheets.reading.workbook
    new = _named(step.name, [n for n in book.sheets if n != old], sheets.grids[old].kind if old in sheets.grids else "")
    found = renamed_cells(book, sheets.text, old, new)
    spelt = {(name, c.row, c.column, c.was): c.text for name, c in step.cells}
    cells = tuple(
        (name, replace(c, text=spelt.get((name, c.row, c.column, c.was), c.text)))
        for name, c in (sheets.cell(at, text) for at, text in found.items() if at.sheet in sheets.grids)
    )
    sheets.store(author, [*_edits(sheets, cells), RenameSheet(old, new)])
    grids = {new if n == old else n: g for n, g in sheets.grids.items()}
    if new in grids:
        grids[new].name = new
    sheets.grids = sheets.renew(grids)
    cells = tuple((new if name == old else name, c) for name, c in cells)
    back = tuple((name, replace(c, text=c.was or "", was=c.text)) for name, c in cells)
    change = SheetChange("renamed", new, was=old)
    return _changed(sheets, author, new, change, cells), SheetNamed(new, old, back)


def _move(sheets: Sheets, author: str, step: SheetPlaced) -> tuple[Changed, SheetStep]:
    names = list(sheets.reading.workbook.sheets)
    if step.before and step.before not in names:
        raise Refused(N_("There is no sheet “{sheet}” any more.", sheet=step.before), N_("Reload the page."))
    after = names[names.index(step.sheet) + 1 :][:1]
    sheets.store(author, [MoveSheet(step.sheet, step.before)])
    sheets.grids = sheets.renew(sheets.grids)
    changed = Changed(step.sheet, change=SheetChange("moved", step.sheet))
    return changed, SheetPlaced(step.sheet, after[0] if after else "")


def added(sheets: Sheets, edit: AddSheet, kind: str) -> SheetIn:
    """The step that adds a sheet; a new behaviour goes into the Protocol's Run, where that lists names."""
    name = _named(edit.sheet, sheets.reading.workbook.sheets, kind)
    run = run_cell(sheets.reading.workbook) if kind == "behaviour" else None
    cells: Texts = ()
    if run is not None and run.address.sheet in sheets.grids:
        now = sheets.text(run.address)
        cells = (sheets.cell(run.address, f"{now.rstrip().rstrip(',;')}, {name}"),)
    return SheetIn(name, replace(edit, sheet=name), cells)


def _named(name: str, others: Sequence[str], kind: str) -> str:
    """The name as it is used; a behaviour's is written in the Protocol's Run, where commas stand between names."""
    if kind == "behaviour" and (mark := next((c for c in name if c in ",;"), "")):
        raise Refused(
            N_("A behaviour's name has no “{mark}”: it stands between names.", mark=mark), N_("Leave it out.")
        )
    try:
        return sheet_name(name, others)
    except SheetsError as error:
        raise Refused(error.message, error.remedy) from error


def _run_without(sheets: Sheets, sheet: str) -> list[tuple[str, CellText]]:
    """The Protocol's Run without a sheet, where it lists others too; alone it stays, as all would run without it."""
    run = run_cell(sheets.reading.workbook)
    if run is None or run.address.sheet not in sheets.grids or run.address.sheet == sheet:
        return []
    names = run_names(sheets.text(run.address))
    left = [name for name in names if key(name) != key(sheet)]
    return [sheets.cell(run.address, ", ".join(left))] if left and len(left) < len(names) else []


def _still(sheets: Sheets, cells: Texts) -> Texts:
    """Those whose rows and texts are as they were when the step was kept."""
    return tuple(
        (name, c)
        for name, c in cells
        if (grid := sheets.grids.get(name)) is not None and grid.has(c.row) and grid.text(c.row, c.column) == c.was
    )


def _edits(sheets: Sheets, cells: Texts) -> list[SetCell]:
    return [SetCell(name, sheets.grids[name].number(c.row), c.column, typed(c.text)) for name, c in cells]


def _changed(sheets: Sheets, author: str, sheet: str, change: SheetChange, cells: Texts) -> Changed:
    then = []
    for name, c in cells:
        grid = sheets.grids.get(name)
        if grid is not None and grid.has(c.row):
            grid.authors[c.row, c.column] = author
            then.append(Changed(name, touched=(c.row,), cells=((c.row, c.column),)))
    return Changed(sheet, change=change, then=tuple(then))


def _texts(grid: Grid | None) -> tuple[tuple[tuple[int, str], ...], ...] | None:
    """Return the texts in a sheet by row, whatever the ids of its rows."""
    if grid is None:
        return None
    return tuple(tuple(sorted(grid.texts[row].items())) for row in grid.rows if grid.texts[row])


def cell_edits(grid: Grid, cells: Sequence[CellText], before: Mapping[tuple[str, str, int], str]) -> list[SetCell]:
    """Return the file's edits for new texts; `before`: texts that come before them and are not in the grid yet.

    Raises:
        Refused: when someone has changed one of them meanwhile, or it is gone.
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
    return [SetCell(grid.name, numbers[c.row], c.column, typed(c.text)) for c in cells]


def put_texts(author: str, grid: Grid, cells: Sequence[CellText]) -> tuple[Changed, Cells]:
    """Put texts that are in the file already into the grid; returns the change and the step back."""
    back = tuple(CellText(c.row, c.column, grid.text(c.row, c.column), c.text) for c in cells)
    for c in cells:
        grid.put(c.row, c.column, c.text)
        grid.authors[c.row, c.column] = author
    rows, places = dict.fromkeys(c.row for c in cells), tuple((c.row, c.column) for c in cells)
    return Changed(grid.name, touched=tuple(rows), cells=places), Cells(grid.name, back)


Store = Callable[[str, Sequence[Edit]], object]
"""Puts an author's edits into the file; raises Refused when it does not take them."""


def bring(store: Store, author: str, grid: Grid, step: RestoreRows) -> tuple[Changed, Step]:
    """Insert rows, with their texts when they were deleted before."""
    place = grid.place(step.before)
    number = grid.first + place
    ids = [row for row, _ in step.rows]
    insert = InsertRows(grid.name, number, len(ids))
    texts = [
        SetCell(grid.name, number + i, column, typed(text))
        for i, (_, cells) in enumerate(step.rows)
        for column, text in cells.items()
    ]
    store(author, [insert, *texts])
    grid.carry_out(insert, ids)
    for row, cells in step.rows:
        for column, text in cells.items():
            grid.put(row, column, text)
    back = RemoveRows(grid.name, tuple(ids), tuple(cells for _, cells in step.rows))
    return Changed(grid.name, inserted=tuple((row, step.before) for row in ids)), back


def remove(store: Store, author: str, grid: Grid, step: RemoveRows) -> tuple[Changed, Step]:
    """Delete rows that follow each other.

    Raises:
        Refused: when somebody has changed one of them since it came.
    """
    _unchanged(author, grid, step)
    place, count = grid.place(step.rows[0]), len(step.rows)
    first = grid.first + place
    gone = tuple((row, dict(grid.texts[row])) for row in grid.rows[place : place + count])
    removal = DeleteRows(grid.name, first, count)
    store(author, [removal])
    grid.carry_out(removal)
    removed = tuple(row for row, _ in gone)
    return Changed(grid.name, removed=removed), RestoreRows(grid.name, gone, grid.before(place))


def shift(store: Store, author: str, grid: Grid, step: Moved) -> tuple[Changed, Step]:
    """Move rows that follow each other."""
    place, count = grid.place(step.rows[0]), len(step.rows)
    first, after = grid.first + place, grid.before(place + count)
    target = grid.first + grid.place(step.before)
    move = MoveRows(grid.name, first, count, target)
    if move.moves:
        store(author, [move])
        grid.carry_out(move)
    return Changed(grid.name, moved=tuple((row, step.before) for row in step.rows)), Moved(grid.name, step.rows, after)


def blocks(grid: Grid, step: RemoveRows | Moved) -> list[RemoveRows] | list[Moved]:
    """A step of rows as one step for each of those that follow each other: others may have come between them."""
    places = sorted({grid.place(row) for row in step.rows})
    groups = [list(group) for _, group in groupby(enumerate(places), lambda pair: pair[1] - pair[0])]
    parts = [tuple(grid.rows[place] for _, place in group) for group in groups]
    if isinstance(step, Moved):
        return [replace(step, rows=rows) for rows in parts]
    if step.texts is None:
        return [replace(step, rows=rows) for rows in parts]
    texts = dict(zip(step.rows, step.texts, strict=True))
    return [replace(step, rows=rows, texts=tuple(texts[row] for row in rows)) for rows in parts]


def _unchanged(author: str, grid: Grid, step: RemoveRows) -> None:
    for row, texts in zip(step.rows, step.texts or (), strict=False):
        now = grid.texts[row]
        others = (grid.authors.get((row, c)) for c in {*now, *texts} if now.get(c, "") != texts.get(c, ""))
        by = next((who for who in others if who != author), author)
        if by != author:
            raise Refused(
                N_(
                    "{who} has changed row {row} since, so it stays.",
                    who=by or N_("Another program"),
                    row=grid.number(row),
                ),
                N_("Delete it if it is to go."),
            )


_AGAIN = N_("Look at it, and change it again if you still want to.")


def must_have(grid: Grid, rows: Iterable[str]) -> None:
    """Refuse when one of the rows is gone."""
    if not all(grid.has(row) for row in rows):
        raise Refused(N_("A row that this changes was deleted meanwhile."), _AGAIN)


def clash(grid: Grid, clashes: list[Clash]) -> Refused:
    """Return the refusal for cells that somebody has changed meanwhile."""
    first = clashes[0]
    return Refused(
        N_("{who} has changed this cell meanwhile ({sheet}, row {row}): it is “{theirs}” now; yours was “{mine}”.",
           who=first.by or N_("Someone"), sheet=grid.name, row=grid.number(first.row), theirs=first.theirs,
           mine=first.mine),
        _AGAIN, tuple(clashes),
    )  # fmt: skip
