"""Sheets that came or went and are told by no row: the user's own, and those of ours that are empty."""

from __future__ import annotations

from rrp_sheets.compare.changes import Change
from rrp_sheets.compare.side import Side
from rrp_sheets.model.names import key
from rrp_sheets.workbook.headers import recognise
from rrp_sheets.workbook.raw import RawSheet

OWN = "a sheet of one's own, which the robot does not read"
EMPTY = "it has no rows"
_OURS = ("devices", "helpers", "gestures")
_LISTS = ("lists", "listsfordropdowns")  # with what drop-downs offer: made by the program, not by people


def sheet_changes(first: Side, second: Side) -> list[Change]:
    """The sheets that only one of both has."""
    out = []
    for word, here, other in (("added", second, first), ("removed", first, second)):
        there = {key(name) for name in other.workbook.sheets}
        for name, note in _untold(here).items():
            if key(name) not in there:
                out.append(Change(word, "sheet", name, effect=False, note=note))
    return out


def _untold(side: Side) -> dict[str, str]:
    found = {}
    for sheet in side.reading.sheets:
        what = recognise(sheet)
        if what.kind is None and key(sheet.name) not in {*side.workbook.tables, *_LISTS} and sheet.cells:
            found[sheet.name] = OWN
        elif what.kind is not None and what.kind.name in _OURS and not _filled(sheet, what.row):
            found[sheet.name] = EMPTY
    return found


def _filled(sheet: RawSheet, header: int) -> bool:
    return any(row > header for row, _ in sheet.cells)
