"""Devices sheets: streams, the devices behind them, and a column for every setting."""

from __future__ import annotations

from rrp_sheets.model.workbook import Device
from rrp_sheets.workbook.columns import Table, header_keys


def read_devices(table: Table) -> tuple[Device, ...]:
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
