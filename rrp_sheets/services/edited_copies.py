"""Changes of a workbook's file: setting a cell, a copy marked with the findings, and a copy with fixes applied."""

from __future__ import annotations

import re
from collections.abc import Collection
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

from rrp_sheets.checks import Checked, renaming
from rrp_sheets.checks.fixing import CellChange, Chosen, apply_fixes
from rrp_sheets.checks.table_columns import rename_column
from rrp_sheets.diagnostics import Report
from rrp_sheets.diagnostics.report import Put
from rrp_sheets.documents.copies import as_xlsx, convert
from rrp_sheets.documents.grid import Grid, GridColumn, make_grid
from rrp_sheets.errors import SheetsError
from rrp_sheets.model.names import argument_name, key
from rrp_sheets.model.workbook import Address
from rrp_sheets.robots import load_robot
from rrp_sheets.runs.check_worker import read_and_check
from rrp_sheets.texts import N_, listed
from rrp_sheets.workbook import Reading, read
from rrp_sheets.workbook.annotated_copy import is_marked_copy, marked_copy
from rrp_sheets.workbook.edits import SetCell, parse_typed
from rrp_sheets.workbook.files import WORKBOOK_SUFFIXES, already_there, edit, file_bytes, read_sheets, write_atomically
from rrp_sheets.workbook.maker import sheet_titles
from rrp_sheets.workbook.schema import recognise
from rrp_sheets.workbook.sheet_names import sheet_named
from rrp_sheets.workbook.xlsx import place


@dataclass(frozen=True)
class CellSet:
    """A cell that was set: its text as typed before and now; what is wrong with the workbook now, and its language."""

    address: Address
    before: str
    after: str
    report: Report
    language: str


@dataclass(frozen=True)
class Renamed:
    """A new name, and the findings that the workbook has now."""

    renaming: renaming.Renaming
    report: Report
    language: str


def set_cell(path: Path, cell: str, value: str, sheet: str = "") -> CellSet:
    """Put a typed text into a cell (`Tracking!C5`, or `C5`), and check the workbook.

    In `value` a `=` begins no live formula. `sheet` is for a cell that names none; the default is the first behaviour.

    Raises:
        SheetsError: there is no such cell, it cannot be changed, or the file cannot be written.
        UnreadableFile: the file cannot be read.
    """
    reading = read(path)
    named, found, spot = cell.rpartition("!")
    named = named.strip("'").replace("''", "'") if found else sheet
    names = reading.workbook.sheets
    behaviours = [behaviour.name for behaviour in reading.workbook.behaviours]
    name = sheet_named(names, named) if named else (behaviours or names)[0]
    at = place(spot.strip().upper())
    if at is None:
        remedy = N_("Write a cell as C5, or with its sheet as Tracking!C5.")
        raise SheetsError(N_("“{cell}” is not a cell.", cell=cell), remedy)
    before = _text(path, name, at)
    edit(path, [SetCell(name, *at, parse_typed(value))], expected_digest=reading.digest)
    _, checked = read_and_check(path)
    return CellSet(Address(name, *at), before, _text(path, name, at), checked.report, checked.run.language)


def rename(
    path: Path, old: str, new: str, sheet: str = "", also: Collection[str] = (), *, preview: bool = False
) -> Renamed:
    """Give a stream, a helper or a column of a table another name in all cells that have it, and check the workbook.

    `old` may be written with its sheet (`Tracking!Far`, `Parts[Zone]`); `also` are cells where it is uncertain whether
    they read the column. With `preview` nothing is written.

    Raises:
        SheetsError: nothing has that name, the new one cannot be used, or the file cannot be written.
        UnreadableFile: the file cannot be read.
    """
    reading, checked = read_and_check(path)
    named, found, name = old.rpartition("!")
    field = None if renaming.is_named(checked, name) else _FIELD.fullmatch(old)  # names may have brackets too
    if field:
        sheet, name = field.groups()
    elif found:
        sheet = named
    tables = _tables(reading)
    must = bool(field) or key(sheet) in tables  # be a column
    column = _column(tables, name, sheet, must=must) if must or not renaming.is_named(checked, name) else None
    if column is None:
        done = renaming.rename(checked, name, new.strip(), sheet)
    else:
        grid, header = column
        done = rename_column(checked, grid.name, header.header, new.strip(), [c.header for c in grid.columns])
        put = Put(Address(grid.name, grid.first - 1, header.number), new.strip(), header.header)
        done = replace(done, edits=(put, *done.edits) if put.text != put.was else done.edits)
    if wrong := [cell for cell in also if cell not in map(str, (e.address for e in done.unsure))]:
        message = N_("{cell} is not one of the uncertain cells.", cell=wrong[0])
        raise SheetsError(message, N_("Use --preview to see them."))
    done = done.including(also)
    if not preview and done.edits:
        edits = [SetCell(e.address.sheet, e.address.row, e.address.column, parse_typed(e.text)) for e in done.edits]
        edit(path, edits, expected_digest=reading.digest)
        _, checked = read_and_check(path)
    return Renamed(done, checked.report, checked.run.language)


_FIELD = re.compile(r"(.+?)\[(.+)\]")  # a column as formulas write it


def _tables(reading: Reading) -> dict[str, Grid]:
    """Return the tables that formulas read, by the keys of the names by which they do."""
    tables = [sheet for sheet in reading.sheets if key(sheet.name) in reading.workbook.tables]
    grids = [make_grid(sheet, recognise(sheet), "table") for sheet in tables]
    return {k: grid for grid in grids for k in (key(argument_name(grid.name)), key(grid.name))}


def _column(tables: dict[str, Grid], name: str, sheet: str, *, must: bool) -> tuple[Grid, GridColumn] | None:
    """Return the column of a name, in the table `sheet` if that is given; None for none, which `must` refuses."""
    grids = {id(grid): grid for k, grid in tables.items() if key(sheet) in ("", k)}.values()
    found = [(grid, column) for grid in grids for column in grid.columns if key(column.header) == key(name)]
    if len(found) > 1 and not must:
        message = N_("“{name}” is a name in {sheets}.", name=name, sheets=listed([g.name for g, _ in found], "and"))
        raise SheetsError(message, N_("Write which one: {example}.", example=f"{found[0][0].name}[{name}]"))
    if found or not must:
        return found[0] if found else None
    if not grids:
        message = N_("No formula reads a table “{name}”.", name=sheet)
        raise SheetsError(message, N_("Write its sheet as its tab shows it."))
    columns = listed([column.header for grid in grids for column in grid.columns])
    message = N_("The table “{sheet}” has no column “{name}”.", sheet=sheet, name=name)
    raise SheetsError(message, N_("Its columns are: {names}.", names=columns))


def _text(path: Path, sheet: str, at: tuple[int, int]) -> str:
    cells = next(s.cells for s in read_sheets(path) if s.name == sheet)
    return cells[at].typed if at in cells else ""


def write_marked(path: Path, target: Path, report: Report, language: str = "en") -> Path:
    """Write a copy of a workbook in which its findings stand beside their rows and their cells are marked.

    CSV and Markdown are converted. An earlier such copy is replaced, no other file is.

    Raises:
        SheetsError: the copy cannot be written, or its name is taken.
    """
    if target.suffix.casefold() != ".xlsx":
        message = N_("The copy's name ends in .xlsx; “{name}” does not.", name=target.name)
        raise SheetsError(message, N_("Try “{name}.xlsx”.", name=target.stem))
    if target.exists() and not is_marked_copy(target):
        raise already_there(target)
    findings = list(report)
    if path.is_dir() or path.suffix.casefold() != ".xlsx":
        reading = read(path)
        titles = sheet_titles([s.name for s in reading.sheets])
        for n, finding in enumerate(findings):
            if at := finding.address:
                findings[n] = replace(finding, address=replace(at, sheet=titles.get(at.sheet, at.sheet)))
        with TemporaryDirectory() as folder:
            data = as_xlsx(reading, load_robot(), Path(folder) / "copy.xlsx").read_bytes()
    else:
        data = file_bytes(path)
    write_atomically(target, marked_copy(data, path.name, findings, language))
    return target


def fix_copy(path: Path, target: Path, chosen: Chosen) -> tuple[list[CellChange], Checked]:
    """Make a copy in which all safe fixes are applied, and the chosen ones: by code, the id of the fix that is wanted.

    The copy is one file, in the format that its name tells; what has its name is replaced.

    Raises:
        SheetsError: when the copy would be the workbook itself, or cannot be written.
        UnreadableFile: when the workbook cannot be read.
    """
    read(path)  # whatever keeps it from being read is told about the file that the user named
    suffix = target.suffix.casefold()
    if suffix not in WORKBOOK_SUFFIXES:
        message = N_("“{name}” is not a name for the copy.", name=target.name)
        remedy = N_("Let the file's name end with one of: {suffixes}.", suffixes=listed(WORKBOOK_SUFFIXES))
        raise SheetsError(message, remedy)
    if target.exists() and target.resolve() == path.resolve():
        raise SheetsError(N_("The copy would replace the workbook itself."), N_("Give the copy another name."))
    with TemporaryDirectory(prefix="rrp-fix-") as folder:
        work = Path(folder) / target.name
        if path.is_file() and path.suffix.casefold() == suffix:
            work.write_bytes(path.read_bytes())
        else:
            convert(path, load_robot(), work)
        changes, checked = apply_fixes(work, lambda file: read_and_check(file)[1], chosen)
        write_atomically(target, work.read_bytes())
    return changes, checked
