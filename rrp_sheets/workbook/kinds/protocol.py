"""The Protocol sheet: what the session is about, and how it is run."""

from __future__ import annotations

from collections.abc import Mapping

from rrp_sheets.model.cells import Cell
from rrp_sheets.model.names import key
from rrp_sheets.workbook.columns import Line, Table
from rrp_sheets.workbook.raw import Kind


def read_protocol(table: Table, fields: dict[str, Cell], names: dict[str, str]) -> None:
    """Add the fields of a Protocol sheet to `fields` (cells by key) and `names` (as spelt); dates may be values."""
    lines = list(table.lines())
    table.report_hidden({line.number: line for line in lines})
    for line in lines:
        name = table.name(line, "Field")
        value = _value(table, line, table.columns)
        k = key(name.text)
        if not name:
            table.add("SHEET013", name.address, what="field name")
        elif k in fields:
            table.add("SHEET015", name.address, field=name.text, first=str(fields[k].address))
        else:
            fields[k], names[k] = value, name.text


def _value(table: Table, line: Line, columns: Mapping[str, int]) -> Cell:
    column = columns["Value"]
    raw = line.cells.get(column)
    if raw is not None and raw.kind is Kind.DATE:  # the date of an approval, say, is meant as a date
        return Cell(raw.text, table.address(line.number, column), raw.typed)
    return table.prose(line, "Value")
