"""Helpers, Devices, Scene, test, Gestures and Protocol sheets: from their rows to the model."""

from __future__ import annotations

from collections.abc import Mapping

from rrp_sheets.model.cells import Cell
from rrp_sheets.model.names import key
from rrp_sheets.model.workbook import Device, GestureRow, Helper, SceneRow, TestRow, TestSheet
from rrp_sheets.workbook.columns import FilledRow, OwnTable, header_keys
from rrp_sheets.workbook.raw import Kind


def read_helpers(table: OwnTable) -> tuple[Helper, ...]:
    """The rows of a Helpers sheet."""
    lines = list(table.lines())
    table.report_hidden({line.number: line for line in lines})
    return tuple(
        Helper(table.name(line, "Name"), table.names(table.name(line, "Inputs")), table.formula(line, "Formula"))
        for line in lines
    )


def read_devices(table: OwnTable) -> tuple[Device, ...]:
    """The rows of a Devices sheet; a blank cell stands for a setting left out."""
    keys = header_keys(table)
    headers = {k: table.others[c] for c, k in keys.items()}
    devices = []
    lines = list(table.lines())
    for line in lines:
        settings = {keys[c]: table.other(line, c) for c in sorted(keys)}
        device = Device(table.name(line, "Stream"), table.name(line, "Device"), settings, headers)
        devices.append(device)
    table.report_hidden({line.number: line for line in lines})
    return tuple(devices)


def read_scene(table: OwnTable) -> tuple[SceneRow, ...]:
    """The rows of a Scene sheet; their words are understood later."""
    lines = list(table.lines())
    table.report_hidden({line.number: line for line in lines})
    return tuple(
        SceneRow(
            table.duration(line, "Time (s)"), table.name(line, "Thing"), table.name(line, "Does"),
            table.prose(line, "Value"),
        )
        for line in lines
    )  # fmt: skip


def read_test(table: OwnTable) -> TestSheet:
    """The rows of a test sheet. Send and Expect are written like formulas (`zone="Head"`) or as plain texts."""
    lines = list(table.lines())
    table.report_hidden({line.number: line for line in lines})
    return TestSheet(table.sheet.name, tuple(_row(table, line) for line in lines))


def _row(table: OwnTable, line: FilledRow) -> TestRow:
    time, stream = table.duration(line, "Time (ms)"), table.name(line, "Stream")
    for cell, what in ((time, "time"), (stream, "stream")):
        if not cell:
            table.add("SHEET013", cell.address, what=what)
    return TestRow(time, stream, table.fields(line, "Send"), table.fields(line, "Expect"), table.notes(line))


def read_gestures(table: OwnTable) -> tuple[GestureRow, ...]:
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


def read_protocol(table: OwnTable, fields: dict[str, Cell], names: dict[str, str]) -> None:
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


def _value(table: OwnTable, line: FilledRow, columns: Mapping[str, int]) -> Cell:
    column = columns["Value"]
    raw = line.cells.get(column)
    if raw is not None and raw.kind is Kind.DATE:  # the date of an approval, say, is meant as a date
        return Cell(raw.text, table.address(line.number, column), raw.typed)
    return table.prose(line, "Value")
