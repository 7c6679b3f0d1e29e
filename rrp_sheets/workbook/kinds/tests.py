"""Test sheets: what is sent when, and what must come out."""

from __future__ import annotations

from rrp_sheets.model.workbook import TestRow, TestSheet
from rrp_sheets.workbook.columns import Table


def read_test(table: Table) -> TestSheet:
    """The rows of a test sheet. Send and Expect are written like formulas (`zone="Head"`) or as plain texts."""
    lines = list(table.lines())
    table.report_hidden({line.number: line for line in lines})
    return TestSheet(
        table.sheet.name,
        tuple(
            TestRow(
                table.duration(line, "Time (ms)"), table.name(line, "Stream"), table.fields(line, "Send"),
                table.fields(line, "Expect"),
            )
            for line in lines
        ),
    )  # fmt: skip
