"""Changes of a workbook's file: setting a cell, a copy marked with the findings, and a copy with fixes applied."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

from rrp_sheets.checks import Checked, renaming
from rrp_sheets.checks.fixing import CellChange, Chosen, apply_fixes
from rrp_sheets.diagnostics import Report
from rrp_sheets.documents.copies import as_xlsx, convert
from rrp_sheets.errors import SheetsError
from rrp_sheets.model.workbook import Address
from rrp_sheets.robots import load_robot
from rrp_sheets.runs.check_worker import read_and_check
from rrp_sheets.texts import N_, listed
from rrp_sheets.workbook import read
from rrp_sheets.workbook.annotated_copy import is_marked_copy, marked_copy
from rrp_sheets.workbook.edits import SetCell, parse_typed
from rrp_sheets.workbook.files import WORKBOOK_SUFFIXES, already_there, edit, file_bytes, read_sheets, write_atomically
from rrp_sheets.workbook.maker import sheet_titles
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


def rename(path: Path, old: str, new: str, sheet: str = "", *, preview: bool = False) -> Renamed:
    """Give a stream or a helper another name in all cells that have it, and check the workbook.

    `old` may be written with its sheet (`Tracking!Far`); with `preview` nothing is written.

    Raises:
        SheetsError: nothing has that name, the new one cannot be used, or the file cannot be written.
        UnreadableFile: the file cannot be read.
    """
    reading, checked = read_and_check(path)
    named, found, name = old.rpartition("!")
    done = renaming.rename(checked, name if found else old, new.strip(), named if found else sheet)
    if not preview and done.edits:
        edits = [SetCell(e.address.sheet, e.address.row, e.address.column, parse_typed(e.text)) for e in done.edits]
        edit(path, edits, expected_digest=reading.digest)
        _, checked = read_and_check(path)
    return Renamed(done, checked.report, checked.run.language)


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
