"""One change of a workbook's file and what became of it; and a copy in which the findings stand in the cells."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from rrp_sheets.checks import check_workbook
from rrp_sheets.diagnostics import Report
from rrp_sheets.errors import SheetsError
from rrp_sheets.model.cells import Address
from rrp_sheets.workbook import read
from rrp_sheets.workbook.editing import SetCell, edit, read_sheets, typed
from rrp_sheets.workbook.text_patch import sheet_named
from rrp_sheets.workbook.xlsx_sheet import place


@dataclass(frozen=True)
class CellSet:
    """A cell that was set.

    Attributes:
        address: of the cell.
        before: what stood there, as typed.
        after: what stands there now.
        report: what is wrong with the workbook now.
    """

    address: Address
    before: str
    after: str
    report: Report


def set_cell(path: Path, cell: str, value: str, sheet: str = "") -> CellSet:
    """Put a typed text into a cell, and check the workbook.

    Args:
        path: of the workbook.
        cell: `Tracking!C5`, or `C5`.
        value: what one would type; `=` begins no live formula.
        sheet: where `cell` names none; the default is the first behaviour.

    Raises:
        SheetsError: there is no such cell, it cannot be changed, or the file cannot be written.
        UnreadableFile: the file cannot be read.
    """
    reading = read(path)
    named, found, spot = cell.rpartition("!")
    named = named.strip("'").replace("''", "'") if found else sheet
    names = reading.workbook.sheets
    behaviours = reading.workbook.behaviours
    name = sheet_named(names, named) if named else behaviours[0].name if behaviours else names[0]
    at = place(spot.strip().upper())
    if at is None:
        raise SheetsError(f"“{cell}” is no cell.", "Write a cell as C5, or with its sheet as Tracking!C5.")
    before = _text(path, name, at)
    edit(path, [SetCell(name, *at, typed(value))], expected_digest=reading.digest)
    after = read(path)
    report = check_workbook(after.workbook, after.report).report
    return CellSet(Address(name, *at), before, _text(path, name, at), report)


def _text(path: Path, sheet: str, at: tuple[int, int]) -> str:
    cells = next(s.cells for s in read_sheets(path) if s.name == sheet)
    return cells[at].typed if at in cells else ""
