"""Gestures sheets: the user's own gestures as keyframes, with a column for every joint."""

from __future__ import annotations

from rrp_sheets.model.workbook import GestureRow
from rrp_sheets.workbook.columns import Table, header_keys


def read_gestures(table: Table) -> tuple[GestureRow, ...]:
    """The keyframes of a Gestures sheet; a blank joint is not among a keyframe's joints."""
    keys = header_keys(table)
    lines = list(table.lines())
    table.report_hidden({line.number: line for line in lines})
    headers = {keys[c]: table.others[c].strip() for c in sorted(keys)}
    rows = []
    for line in lines:
        name, time = table.name(line, "Name"), table.duration(line, "Time (s)")
        for cell, what in ((name, "name"), (time, "time")):
            if not cell:
                table.add("SHEET013", cell.address, what=what)
        joints = {keys[c]: table.other(line, c) for c in sorted(keys) if c in line.cells}
        rows.append(GestureRow(name, time, {k: cell for k, cell in joints.items() if cell}, headers))
    return tuple(rows)
