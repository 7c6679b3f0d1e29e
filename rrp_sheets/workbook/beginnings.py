"""What a new sheet of each kind begins with: its columns, and of the Protocol its fields."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rrp_sheets.workbook.template import empty_sheets, template_sheets

TITLES = {
    "behaviour": "Behaviour", "devices": "Devices", "helpers": "Helpers", "scene": "Scene", "gestures": "Gestures",
    "test": "Test", "protocol": "Protocol", "table": "Table",
}  # fmt: skip
"""What each kind is called; the order is that of the sheets in a new workbook."""
SINGLE = frozenset(("devices", "helpers", "scene", "gestures", "protocol"))
"""Kinds of which a workbook has one."""
_JOINTS = (
    "HeadYaw", "HeadPitch", "RShoulderPitch", "RShoulderRoll", "RElbowYaw", "RElbowRoll", "RWristYaw", "RHand",
    "LShoulderPitch", "LShoulderRoll", "LElbowYaw", "LElbowRoll", "LWristYaw", "LHand",
)  # fmt: skip


def beginning(kind: str, robot: str = "nao") -> list[list[str]]:
    """The rows that a new sheet of a kind has.

    >>> beginning("test")
    [['Time (ms)', 'Stream', 'Send', 'Expect', 'Notes']]
    """
    if kind == "gestures":
        return [["Name", "Time (s)", *_JOINTS, "Notes"]]
    if kind == "table":
        return [["Name", "Value"]]
    sheets = {**template_sheets(robot), "Protocol": empty_sheets(robot)["Protocol"]}
    rows = sheets[{"behaviour": "Tracking", "test": "Check"}.get(kind, TITLES[kind])]
    if kind == "protocol":
        return [[field, "" if field == "Run" else value] for field, value in rows]
    return [list(rows[0])]


def place_of(kind: str, sheets: Mapping[str, str]) -> str:
    """The sheet that a new one of a kind stands before; empty: at the end.

    Args:
        kind: of the new sheet.
        sheets: all sheets in their order, with the kind of each; empty for the user's own.

    >>> place_of("behaviour", {"Read me": "", "Tracking": "behaviour", "Devices": "devices", "Lists": ""})
    'Devices'
    """
    order: Sequence[str] = list(TITLES)
    names = list(sheets)
    alike = [i for i, name in enumerate(names) if sheets[name] == kind]
    if alike:
        return names[alike[-1] + 1] if alike[-1] + 1 < len(names) else ""
    rank = order.index(kind)
    before = [i for i, name in enumerate(names) if sheets[name] and order.index(sheets[name]) < rank]
    after = [i for i, name in enumerate(names) if sheets[name] and order.index(sheets[name]) > rank]
    if before and kind != "table":
        return names[before[-1] + 1] if before[-1] + 1 < len(names) else ""
    return names[after[0]] if after and kind != "table" else ""
