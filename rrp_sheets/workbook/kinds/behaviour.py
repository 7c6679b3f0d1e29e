"""Behaviour sheets: rows of input streams, connector, formula and output stream."""

from __future__ import annotations

import math
from collections.abc import Sequence

from rrp_sheets.diagnostics.fix import Fix, Insert, Put
from rrp_sheets.model.truths import truth_of
from rrp_sheets.model.workbook import Behaviour, Row
from rrp_sheets.workbook.columns import FilledRow, OwnTable
from rrp_sheets.workbook.raw import Kind


def read_behaviour(table: OwnTable) -> Behaviour:
    """The behaviour that a sheet describes."""
    rows = [_row(table, line) for line in table.lines()]
    for line in table.comments():
        _report_buried(table, line)
    table.report_hidden({row.number: row for row in rows if row.on})
    header = table.address(table.header_row, table.columns["Input streams"])
    return Behaviour(table.sheet.name, tuple(rows), header, _headings(table, rows))


def _headings(table: OwnTable, rows: Sequence[Row]) -> dict[int, str]:
    """The comments above rows, by the number of the row that follows them."""
    comments = {line.number: _comment(line) for line in table.comments()}
    numbers = {row.number for row in rows}
    found: dict[int, str] = {}
    waiting: list[str] = []
    for number in sorted(numbers | comments.keys()):
        if number in numbers:
            if waiting:
                found[number] = " ".join(waiting)
            waiting = []
        elif comments[number]:
            waiting.append(comments[number])
    return found


def _comment(line: FilledRow) -> str:
    """A comment's text without its sign."""
    first = next((cell for cell in line.cells.values() if cell.text.strip().startswith("#")), None)
    return "" if first is None or first.kind is not Kind.TEXT else first.text.strip().lstrip("#").strip()


def _report_buried(table: OwnTable, line: FilledRow) -> None:
    """Warn of a row that was written into a comment; one after a lone `#` is switched off in this way on purpose."""
    on, inputs, connector, output = (
        table.columns.get(header, 0) for header in ("On", "Input streams", "Connector", "Output stream")
    )
    texts = {column: cell.typed for column, cell in line.cells.items() if cell.typed.strip()}
    comment = texts.get(on, "").strip()
    if (
        not (comment.startswith("#") and comment.strip("# "))
        or connector not in texts
        or not (inputs in texts or output in texts)
    ):
        return
    columns = sorted(table.ours - {on})
    emptied = (Put(table.address(line.number, c), "", was=texts.get(c, "")) for c in columns)
    mine = tuple((c, texts[c]) for c in columns if c in texts)
    apart = Fix("own-row", "Put it into a row of its own", (*emptied, Insert(table.sheet.name, line.number + 1, mine)))
    table.add("SHEET022", table.address(line.number, connector), fixes=(apart,), row=line.number)


def _row(table: OwnTable, line: FilledRow) -> Row:
    inputs = table.name(line, "Input streams")
    return Row(
        number=line.number,
        inputs=table.names(inputs),
        inputs_cell=inputs,
        connector=table.name(line, "Connector"),
        formula=table.formula(line, "Formula"),
        output=table.name(line, "Output stream"),
        on=_is_on(table, line),
        priority=_priority(table, line),
        notes=table.notes(line),
    )


def _is_on(table: OwnTable, line: FilledRow) -> bool:
    cell = table.name(line, "On")
    on = truth_of(cell.text)
    if on is None and cell:
        table.add("SHEET011", cell.address, value=cell.text)
    return on is not False


def _priority(table: OwnTable, line: FilledRow) -> float:
    cell = table.name(line, "Priority")
    if not cell:
        return 0.0
    try:
        priority = float(cell.text)
    except ValueError:
        priority = math.nan
    if not math.isfinite(priority) or "_" in cell.text:
        table.add("SHEET012", cell.address, value=cell.text)
        return 0.0
    return priority
