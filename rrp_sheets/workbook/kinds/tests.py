"""Test sheets: what is sent when, and what must come out."""

from __future__ import annotations

from rrp_sheets.model.workbook import TestRow, TestSheet
from rrp_sheets.workbook.columns import Line, Table


def read_test(table: Table) -> TestSheet:
    """The rows of a test sheet. Send and Expect are written like formulas (`zone="Head"`) or as plain texts."""
    lines = list(table.lines())
    table.report_hidden({line.number: line for line in lines})
    return TestSheet(table.sheet.name, tuple(_row(table, line) for line in lines))


def _row(table: Table, line: Line) -> TestRow:
    time, stream = table.duration(line, "Time (ms)"), table.name(line, "Stream")
    for cell, what in ((time, "time"), (stream, "stream")):
        if not cell:
            table.add("SHEET013", cell.address, what=what)
    return TestRow(time, stream, table.fields(line, "Send"), table.fields(line, "Expect"), table.notes(line))
