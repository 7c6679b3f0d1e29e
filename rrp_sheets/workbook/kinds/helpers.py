"""Helpers sheets: named formulas and constants."""

from __future__ import annotations

from rrp_sheets.model.workbook import Helper
from rrp_sheets.workbook.columns import Table


def read_helpers(table: Table) -> tuple[Helper, ...]:
    """The rows of a Helpers sheet."""
    lines = list(table.lines())
    table.report_hidden({line.number: line for line in lines})
    return tuple(
        Helper(table.name(line, "Name"), table.names(table.name(line, "Inputs")), table.formula(line, "Formula"))
        for line in lines
    )
