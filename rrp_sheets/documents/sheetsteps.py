"""Adding, deleting, renaming, moving sheets: in the file first, then here; each gives the step that takes it back."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

from rrp_sheets.documents.changes import CellText, Changed, Refused, SheetChange
from rrp_sheets.documents.grid import Grid
from rrp_sheets.documents.sheet_references import renamed_cells, run_cell, run_names
from rrp_sheets.documents.undo import SheetIn, SheetNamed, SheetOut, SheetPlaced, SheetStep
from rrp_sheets.errors import SheetsError
from rrp_sheets.model.cells import Address
from rrp_sheets.model.names import key
from rrp_sheets.workbook import Reading
from rrp_sheets.workbook.edits import AddSheet, BringSheet, DeleteSheet, Edit, MoveSheet, RenameSheet, SetCell
from rrp_sheets.workbook.patch.values import typed
from rrp_sheets.workbook.sheet_names import sheet_name


@dataclass
class Sheets:
    """What the steps work on.

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
        """What is typed in a cell."""
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
        by = f" by {' and '.join(names[:3])}" if names else ""
        raise Refused(f"“{step.sheet}” was changed since{by}, so it stays.", "Delete it in the menu of its tab.")
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
        raise Refused(f"There is no sheet “{step.before}” any more.", "Reload the page.")
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
        raise Refused(f"A behaviour's name has no “{mark}”: it stands between names.", "Leave it out.")
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
    """What stands in a sheet, whatever the ids of its rows."""
    if grid is None:
        return None
    return tuple(tuple(sorted(grid.texts[row].items())) for row in grid.rows if grid.texts[row])
