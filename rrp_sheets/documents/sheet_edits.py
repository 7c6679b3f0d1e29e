"""The sheets of a document: added, renamed, moved, duplicated, deleted; the cells that refer to them."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, suppress
from dataclasses import dataclass, replace
from pathlib import Path

from rrp_sheets.checks.tests import quoted_sheet
from rrp_sheets.documents.grid import CellText, Changed, Grid, Refused, SheetChange, SheetMissing, Store
from rrp_sheets.documents.marks import look_edit
from rrp_sheets.errors import SheetsError
from rrp_sheets.formulas.problems import FormulaProblem
from rrp_sheets.formulas.tokens import Hole, Token, tokenize
from rrp_sheets.model.names import argument_name, key
from rrp_sheets.model.workbook import Address, Cell, Workbook
from rrp_sheets.robots import load_robot, robot_names
from rrp_sheets.texts import N_
from rrp_sheets.workbook import Reading
from rrp_sheets.workbook.comments import Thread, with_new_ids
from rrp_sheets.workbook.edits import (
    AddSheet,
    BringSheet,
    DeleteSheet,
    MoveSheet,
    RenameSheet,
    SetCell,
    SetComments,
    SetLook,
    parse_typed,
)
from rrp_sheets.workbook.looks import PLAIN_LOOK
from rrp_sheets.workbook.raw import text_sheet
from rrp_sheets.workbook.schema import TITLES, is_single, language_of, recognise, title_of
from rrp_sheets.workbook.sheet_names import free_name, sheet_name
from rrp_sheets.workbook.sheet_readers import words
from rrp_sheets.workbook.template import beginning, place_of


@dataclass(eq=False, repr=False)
class SheetEdits:
    """Operations on the sheets of a document; each is one edit, and is undone as one."""

    _lock: AbstractContextManager[bool]
    _make: Callable[[str, SheetStep], Changed]
    _sheets: Callable[[], Sheets]
    _path: Path

    def add(self, author: str, kind: str, name: str = "", rows: Sequence[Sequence[str]] = ()) -> Changed:
        """Add a sheet of a kind (`behaviour`, …, `table` for one of the user's own).

        Without a name it has a proposed one, without rows it begins as usual.
        """
        with self._lock:
            return self._make(author, _added_sheet(self._sheets(), kind, name, rows))

    def rename(self, author: str, sheet: str, name: str) -> Changed:
        """Give a sheet another name; everything that names it follows."""
        return self._make(author, RenameSheetStep(sheet, name))

    def move(self, author: str, sheet: str, before: str) -> Changed:
        """Let a sheet stand before another one; empty: at the end."""
        return self._make(author, MoveSheetStep(sheet, before))

    def delete(self, author: str, sheet: str) -> Changed:
        """Delete a sheet with everything in it; `naming` tells what refers to it."""
        return self._make(author, DeleteSheetStep(sheet))

    def duplicate(self, author: str, sheet: str) -> Changed:
        """Add a sheet with the same texts, comments and looks."""
        with self._lock:
            grid = self._sheets().grids.get(sheet)
            if grid is None or is_single(grid.kind):
                raise Refused(N_("This sheet cannot be duplicated."), N_("A workbook has one sheet of that kind."))
            width = max(c.number for c in grid.columns)
            headers = {c.number: c.header for c in grid.columns}
            lines = [headers, *(grid.texts[row] for row in grid.rows[: grid.filled()])]
            rows = [[line.get(c, "") for c in range(1, width + 1)] for line in lines]
            name = free_name(sheet, self._sheets().reading.workbook.sheets, 2)
            step = _added_sheet(self._sheets(), grid.kind, name, rows)
            return self._make(author, replace(step, marks=tuple(_copied_marks(grid, step.sheet))))

    def naming(self, sheet: str) -> list[str]:
        """Return the references to a sheet in the workbook, in words, each with its place."""
        with self._lock:
            sheets = self._sheets()
            book = sheets.reading.workbook
            named = _renamed_cells(book, sheets.text, sheet, f"{sheet} {len(book.sheets)}")
            places = dict.fromkeys([*named, *(cell.address for cell in _users(book, sheet))])
            listed = [f"{at}: {_short(sheets.text(at))}" for at in places if key(at.sheet) != key(sheet)]
            if self._path.suffix.casefold() == ".xlsx":
                from rrp_sheets.workbook.patch.sheets import referring

                with suppress(SheetsError, OSError):  # told when it is to be deleted
                    listed += referring(self._path.read_bytes(), self._path.name, sheet)
            return listed


_MOST_COLUMNS = 30


def _added_sheet(sheets: Sheets, kind: str, name: str, rows: Sequence[Sequence[str]]) -> AddSheetStep:
    """Return the step that adds a sheet; a new behaviour goes into the Protocol's Run, where that lists names."""
    if kind not in TITLES:
        raise Refused(N_("There is no such kind of sheet."), N_("Reload the page."))
    alike = next((grid for grid in sheets.grids.values() if grid.kind == kind), None)
    if is_single(kind) and alike is not None:
        message = N_("There is “{sheet}” already, and a workbook has one sheet of that kind.", sheet=alike.name)
        raise Refused(message, N_("Write into that one."))
    book = sheets.reading.workbook
    if kind == "table" and rows:
        _refuse_columns(rows[0])
    if not rows and alike is not None and kind in ("behaviour", "test"):  # so that all of this kind look the same
        rows = [[c.header for c in alike.columns if c.name]]
    language = language_of_sheets(sheets.grids.values())
    rows = rows or beginning(kind, book.protocol.robot or "nao", language)
    kinds = {n: sheets.grids[n].kind if n in sheets.grids else "" for n in book.sheets}
    name = _named(name or proposed_name(kind, kinds, language), book.sheets, kind)
    cells: SheetCells = ()
    run = _run_cell(book) if kind == "behaviour" else None
    if run is not None and run.address.sheet in sheets.grids:
        cells = (sheets.cell(run.address, f"{sheets.text(run.address).rstrip().rstrip(',;')}, {name}"),)
    return AddSheetStep(name, AddSheet(name, tuple(map(tuple, rows)), place_of(kind, kinds)), cells)


def language_of_sheets(grids: Iterable[Grid]) -> str:
    """Return the code of the language of the headers of a workbook's sheets, in which a new one begins."""
    return language_of(c.header for grid in grids if grid.kind for c in grid.columns if c.name)


def proposed_name(kind: str, kinds: Mapping[str, str], language: str = "en") -> str:
    """A name for a new sheet of a kind; the second behaviour is “Behaviour 2”, whatever the first is called.

    >>> proposed_name("behaviour", {"Tracking": "behaviour", "Lists": ""}), proposed_name("table", {"Table": ""})
    ('Behaviour 2', 'Table 2')
    """
    count = list(kinds.values()).count(kind) if kind in ("behaviour", "test") else 0
    return free_name(title_of(kind, language), kinds, count + 1)


def _copied_marks(grid: Grid, sheet: str) -> Iterator[SetComments | SetLook]:
    """Yield the edits that give a copy of a sheet, whose header is its first row, the comments and looks of cells."""
    numbers = {row: number for number, row in enumerate(grid.rows[: grid.filled()], 2)}
    for row, column, thread, look in grid.marks.of(numbers):
        if thread:
            yield SetComments(sheet, numbers[row], column, with_new_ids(thread))
        if look != PLAIN_LOOK:
            yield look_edit(sheet, numbers[row], column, PLAIN_LOOK, look)


def _refuse_columns(headers: Sequence[str]) -> None:
    if len(headers) > _MOST_COLUMNS:
        raise Refused(N_("A table has at most {n} columns.", n=_MOST_COLUMNS), N_("Name fewer."))
    kind = recognise(text_sheet("", [headers])).kind
    if kind is not None:
        message = N_("Columns of these names make a sheet {kind}.", kind=kind.shown)
        raise Refused(message, N_("Name the columns otherwise."))


def _short(text: str) -> str:
    line = " ".join(text.split())
    return line if len(line) <= 60 else f"{line[:59]}…"


SheetCells = tuple[tuple[str, CellText], ...]
"""Texts of cells, each with the name of its sheet."""
SheetTexts = tuple[tuple[tuple[tuple[int, str], ...], ...], tuple[Thread, ...]]
"""Texts of a sheet by row, and its comments."""


@dataclass(frozen=True, slots=True)
class AddSheetStep:
    """Add a sheet, or bring back one that was deleted, as it was."""

    sheet: str
    edit: AddSheet | BringSheet
    cells: SheetCells = ()  # that change with it (the Protocol's Run), if they still say there what they did
    grid: Grid | None = None  # of the sheet that comes back, whose rows keep their ids
    marks: tuple[SetComments | SetLook, ...] = ()  # of a copy


@dataclass(frozen=True, slots=True)
class DeleteSheetStep:
    """Delete a sheet; with `texts` only if nothing else stands in it by now."""

    sheet: str
    texts: SheetTexts | None = None


@dataclass(frozen=True, slots=True)
class RenameSheetStep:
    """Give a sheet another name."""

    sheet: str
    name: str
    cells: SheetCells = ()  # that name it, as they were spelt, if they still do so


@dataclass(frozen=True, slots=True)
class MoveSheetStep:
    """Move a sheet before another one (empty: to the end)."""

    sheet: str
    before: str


SheetStep = AddSheetStep | DeleteSheetStep | RenameSheetStep | MoveSheetStep


@dataclass
class Sheets:
    """Sheets that the steps work on, with the ways to store and to read them again."""

    grids: Mapping[str, Grid]
    reading: Reading
    store: Store
    renew: Callable[[Mapping[str, Grid]], Mapping[str, Grid]]  # the grids as the file says them now, from these
    current: Callable[[str], str]  # the name that a sheet has now, which may have been renamed since a step was kept

    def find(self, sheet: str) -> str:
        """Return the name that a sheet has now; raise Refused when it is gone."""
        found = self.current(sheet)
        if found not in self.reading.workbook.sheets:
            raise SheetMissing(found)
        return found

    def text(self, at: Address) -> str:
        """Return the typed text of a cell."""
        grid = self.grids.get(at.sheet)
        place = at.row - grid.first if grid is not None else -1
        return grid.text(grid.rows[place], at.column) if grid is not None and 0 <= place < len(grid.rows) else ""

    def cell(self, at: Address, text: str) -> tuple[str, CellText]:
        """A cell's new text, by its row's id."""
        grid = self.grids[at.sheet]
        return at.sheet, CellText(grid.rows[at.row - grid.first], at.column, text, self.text(at))


def make_sheet_step(sheets: Sheets, author: str, step: SheetStep) -> tuple[Changed, SheetStep]:
    """Make a step; return what it changed, and the step that takes it back. Raise Refused when it cannot be made."""
    if isinstance(step, AddSheetStep | RenameSheetStep):
        step = replace(step, cells=tuple((sheets.current(name), c) for name, c in step.cells))
    match step:
        case AddSheetStep():
            return _bring_in(sheets, author, step)
        case DeleteSheetStep():
            return _take_out(sheets, author, replace(step, sheet=sheets.find(step.sheet)))
        case RenameSheetStep():
            return _rename(sheets, author, replace(step, sheet=sheets.find(step.sheet)))
        case MoveSheetStep():
            before = sheets.find(step.before) if step.before else ""
            return _move(sheets, author, MoveSheetStep(sheets.find(step.sheet), before))


def _bring_in(sheets: Sheets, author: str, step: AddSheetStep) -> tuple[Changed, SheetStep]:
    cells = _still(sheets, step.cells)
    sheets.store(author, [*_edits(sheets, cells), step.edit, *step.marks])
    sheets.grids = sheets.renew({**sheets.grids, **({step.sheet: step.grid} if step.grid is not None else {})})
    new = sheets.grids.get(step.sheet)
    change = SheetChange("added", step.sheet, new.kind if new else "")
    return _changed(sheets, author, step.sheet, change, cells), DeleteSheetStep(step.sheet, _texts(new))


def _take_out(sheets: Sheets, author: str, step: DeleteSheetStep) -> tuple[Changed, SheetStep]:
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
    return changed, AddSheetStep(step.sheet, BringSheet(step.sheet, kept), back, grid)


def _rename(sheets: Sheets, author: str, step: RenameSheetStep) -> tuple[Changed, SheetStep]:
    old, book = step.sheet, sheets.reading.workbook
    new = _named(step.name, [n for n in book.sheets if n != old], sheets.grids[old].kind if old in sheets.grids else "")
    found = _renamed_cells(book, sheets.text, old, new)
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
    return _changed(sheets, author, new, change, cells), RenameSheetStep(new, old, back)


def _move(sheets: Sheets, author: str, step: MoveSheetStep) -> tuple[Changed, SheetStep]:
    names = list(sheets.reading.workbook.sheets)
    after = names[names.index(step.sheet) + 1 :][:1]
    sheets.store(author, [MoveSheet(step.sheet, step.before)])
    sheets.grids = sheets.renew(sheets.grids)
    changed = Changed(step.sheet, change=SheetChange("moved", step.sheet))
    return changed, MoveSheetStep(step.sheet, after[0] if after else "")


def _named(name: str, others: Sequence[str], kind: str) -> str:
    """The name as it is used; a behaviour's is written in the Protocol's Run, where commas stand between names."""
    if kind == "behaviour" and (mark := next((c for c in name if c in ",;"), "")):
        message = N_("A behaviour's name has no “{mark}”: it stands between names.", mark=mark)
        raise Refused(message, N_("Leave it out."))
    try:
        return sheet_name(name, others)
    except SheetsError as error:
        raise Refused(error.message, error.remedy) from error


def _run_without(sheets: Sheets, sheet: str) -> list[tuple[str, CellText]]:
    """The Protocol's Run without a sheet, where it lists others too; alone it stays, as all would run without it."""
    run = _run_cell(sheets.reading.workbook)
    if run is None or run.address.sheet not in sheets.grids or run.address.sheet == sheet:
        return []
    names = _run_names(sheets.text(run.address))
    left = [name for name in names if key(name) != key(sheet)]
    return [sheets.cell(run.address, ", ".join(left))] if left and len(left) < len(names) else []


def _still(sheets: Sheets, cells: SheetCells) -> SheetCells:
    """Those whose rows and texts are as they were when the step was kept."""
    return tuple(
        (name, c)
        for name, c in cells
        if (grid := sheets.grids.get(name)) is not None and grid.has(c.row) and grid.text(c.row, c.column) == c.was
    )


def _edits(sheets: Sheets, cells: SheetCells) -> list[SetCell]:
    return [SetCell(name, sheets.grids[name].number(c.row), c.column, parse_typed(c.text)) for name, c in cells]


def _changed(sheets: Sheets, author: str, sheet: str, change: SheetChange, cells: SheetCells) -> Changed:
    then = []
    for name, c in cells:
        grid = sheets.grids.get(name)
        if grid is not None and grid.has(c.row):
            grid.authors[c.row, c.column] = author
            then.append(Changed(name, touched=(c.row,), cells=((c.row, c.column),)))
    return Changed(sheet, change=change, then=tuple(then))


def _texts(grid: Grid | None) -> SheetTexts | None:
    """Return the texts in a sheet by row, whatever the ids of its rows, and the comments."""
    if grid is None:
        return None
    texts = tuple(tuple(sorted(grid.texts[row].items())) for row in grid.rows if grid.texts[row])
    return texts, tuple(thread for _, _, thread, _ in grid.marks.of(grid.rows) if thread)


_SEPARATORS = re.compile(r"([,;\n])")


def _renamed_cells(workbook: Workbook, texts: Callable[[Address], str], old: str, new: str) -> dict[Address, str]:
    """Return the cells that name a sheet, with what they say when it has another name; `texts`: what was typed."""
    k = key(old)
    found: dict[Address, str] = {}
    for cell in _tests(workbook, k):
        text = texts(cell.address)
        head, bang, stream = text.rpartition("!")
        if bang:
            found[cell.address] = f"{_spaced(head, quoted_sheet(new))}!{stream}"
    for cell in _switches(workbook, k):
        found[cell.address] = _spaced(texts(cell.address), new)
    run = _run_cell(workbook)
    if run is not None and any(key(name) == k for name in _run_names(run.text)):
        found[run.address] = "".join(
            _spaced(part, new) if key(part) == k else part for part in _SEPARATORS.split(texts(run.address))
        )
    for cell in _formulas(workbook, k):
        text = texts(cell.address)
        if (changed := _renamed_table(text, old, new)) != text:
            found[cell.address] = changed
    return {at: text for at, text in found.items() if text != texts(at)}


def _tests(workbook: Workbook, k: str) -> Iterator[Cell]:
    for test in workbook.tests:
        for row in test.rows:
            sheet, bang, _ = row.stream.text.rpartition("!")
            if bang and key(sheet.strip().strip("'")) == k:
                yield row.stream


def _switches(workbook: Workbook, k: str) -> Iterator[Cell]:
    name = workbook.protocol.robot
    robot = load_robot(name if name in robot_names() else "nao")
    for device in workbook.devices:
        found = robot.find(device.device.text)
        for setting, cell in device.settings.items():
            known = found.type.settings.get(setting) if found else None
            if known is not None and known.kind == "behaviour" and cell and key(cell.text) == k:
                yield cell


def _formulas(workbook: Workbook, k: str) -> Iterator[Cell]:
    """The formulas that may name a table; a name that is an input or a helper means that one."""
    if k not in workbook.tables or any(key(h.name.text) == k for h in workbook.helpers):
        return
    for behaviour in workbook.behaviours:
        yield from (r.formula for r in behaviour.rows if r.formula and not _has(r.inputs, k))
    yield from (h.formula for h in workbook.helpers if h.formula and not _has(h.inputs, k))


def _users(workbook: Workbook, sheet: str) -> Iterator[Cell]:
    """Yield the cells that use what a sheet makes: its streams, devices and helpers, by their names."""
    k = key(sheet)
    made = {key(r.output.text) for b in workbook.behaviours if key(b.name) == k for r in b.rows if r.output}
    yield from (r.stream for t in workbook.tests if key(t.name) != k for r in t.rows if key(r.stream.text) in made)
    streams = {key(d.stream.text) for d in workbook.devices if key(d.stream.address.sheet) == k}
    rows = [(b, r) for b in workbook.behaviours for r in b.rows if key(b.name) != k]
    yield from (cell for _, r in rows for cell in (*r.inputs, r.output) if cell and key(cell.text) in streams)
    helpers = {key(h.name.text) for h in workbook.helpers if key(h.name.address.sheet) == k}
    yield from (r.formula for _, r in rows if r.formula and helpers & words([r.formula.text]))


def _has(names: Sequence[Cell], k: str) -> bool:
    return any(key(argument_name(name.text)) == k for name in names)


def _renamed_table(formula: str, old: str, new: str) -> str:
    """A formula in which a table has another name; one that cannot be understood stays as it is.

    >>> _renamed_table('XLOOKUP(step; Steps[Steps]; Steps) & "Steps" & f"{ROWS(Steps)}"', "Steps", "My steps")
    'XLOOKUP(step; mySteps[Steps]; mySteps) & "Steps" & f"{ROWS(mySteps)}"'
    """
    keys = {key(old), key(argument_name(old))}
    name = new if new.isidentifier() else argument_name(new)
    try:
        tokens = tokenize(formula, lambda word: key(word) in keys)
    except FormulaProblem:
        return formula
    spans = sorted(_spans(tokens, keys), reverse=True)
    for start, end in spans:
        formula = formula[:start] + name + formula[end:]
    return formula


def _spans(tokens: Sequence[Token], keys: set[str]) -> Iterator[tuple[int, int]]:
    before = ""
    for token in tokens:
        if token.kind == "name" and key(token.text) in keys and before != ".":
            yield token.start, token.end
        elif token.kind == "column" and key(str(token.parts[0])) in keys:
            yield token.start, token.start + len(str(token.parts[0]))
        elif token.kind == "texts":
            for part in token.parts:
                if isinstance(part, Hole):
                    yield from _spans(part.tokens, keys)
        before = token.text


def _run_cell(workbook: Workbook) -> Cell | None:
    """Return the Protocol's Run, when it lists names."""
    cell = workbook.protocol.fields.get("run")
    return cell if cell and key(cell.text) != "all" else None


def _run_names(text: str) -> list[str]:
    return [name for part in _SEPARATORS.split(text)[::2] if (name := part.strip())]


def _spaced(text: str, new: str) -> str:
    """A name instead of a text, with the text's spaces around it."""
    bare = text.strip()
    return text.replace(bare, new, 1) if bare else new
