"""Looks of a new workbook: colours, fonts, the width, the prompt and the drop-down of every column."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from rrp_sheets.model.names import key

FONT = "Arial"  # on every machine, or with a replacement of the same widths
SIZE = 10
INK, PALE_INK, RULE = "1F2D3A", "5F6B76", "C9D3DB"
HEADERS = {  # fill of the header row, and of the tab
    "behaviour": "D5E5EF",
    "devices": "DDEBDD",
    "helpers": "E9E2F0",
    "scene": "F4E8D3",
    "gestures": "F4E8D3",
    "test": "F1DFDF",
    "protocol": "E3E6E9",
    "": "ECEFF1",
}
MARK, OFF_INK = "FFE9B8", "8A949C"
ROWS = 200


@dataclass(frozen=True, slots=True)
class ColumnStyle:
    """A column: width in characters, the drop-down's list, and the prompt shown in its cells."""

    width: float = 16
    offers: str = ""
    prompt: str = ""


_NOTES = ColumnStyle(32, "", "Anything you want to remember. The robot does not read it.")
_ANY = ColumnStyle()
COLUMNS: dict[str, dict[str, ColumnStyle]] = {
    "behaviour": {
        "Input streams": ColumnStyle(22, "Streams", "What this row listens to: a sensor, or the output of another row. "
                                     "Several are separated by commas. Blank: the output of the row above."),
        "Connector": ColumnStyle(15, "Connectors", "What this row does with the input: map calculates, filter lets "
                                 "pass, subscribe lets the robot act."),
        "Formula": ColumnStyle(36, "", "A calculation with the inputs, such as redBall.distance < 0.5. A space in a "
                               "stream's name is left out: Red ball is redBall. No = is needed."),
        "Output stream": ColumnStyle(20, "Streams", "A new name for the result; for subscribe the actuator that acts. "
                                     "Blank: the next row takes it."),
        "Notes": _NOTES,
        "On": ColumnStyle(8, "On or off", "FALSE switches this row off. Blank is on."),
        "Priority": ColumnStyle(9, "", "A number: the larger one wins when two rows want the same part of the robot. "
                                "Blank is 0."),
    },
    "devices": {
        "Stream": ColumnStyle(24, "", "The name you give this sensor or actuator; behaviours use it."),
        "Device": ColumnStyle(24, "All devices", "Which sensor or actuator of the robot it is."),
        "Text": ColumnStyle(38, "", "What the robot says."),
        "Notes": _NOTES,
    },
    "helpers": {
        "Name": ColumnStyle(24, "", "The helper's name; write it into the Formula of a row."),
        "Inputs": ColumnStyle(24, "", "Names for what the helper calculates with, separated by commas. Blank: a "
                              "constant."),
        "Formula": ColumnStyle(46, "", "The calculation, with the names of Inputs."),
        "Notes": _NOTES,
    },
    "scene": {
        "Time (s)": ColumnStyle(14, "", "Seconds after the start, the row above (+ 2) or an event: Ask done + 2"),
        "Thing": ColumnStyle(18, "Thing", "Who or what: Red ball, Blue cup, Table, Person or a name, Light, "
                             "Operator, …"),
        "Does": ColumnStyle(18, "Does", "What happens: appears, moves, says, touches, …"),
        "Value": ColumnStyle(34, "", "Where, what or how long. at 1, 0.2, 0.4 is in metres: forward, left, up."),
        "Notes": _NOTES,
    },
    "gestures": {
        "Name": ColumnStyle(20, "", "The gesture's name, the same in all its rows."),
        "Time (s)": ColumnStyle(10, "", "When the joints are there, in seconds from the gesture's beginning."),
        "Notes": _NOTES,
    },
    "test": {
        "Time (ms)": ColumnStyle(12, "", "Milliseconds after the start."),
        "Stream": ColumnStyle(24, "Streams", "The stream that gets the value, or that is looked at."),
        "Send": ColumnStyle(28, "", "What arrives: a value, or the fields of a sensor: distance=0.3; x=0"),
        "Expect": ColumnStyle(28, "", "What must come out: a value, any, or nothing."),
        "Notes": _NOTES,
    },
    "protocol": {
        "Field": ColumnStyle(24, "", "The name of a field; you may add your own."),
        "Value": ColumnStyle(90, "", ""),
    },
}  # fmt: skip


FIELDS: dict[str, tuple[tuple[str, ...], str]] = {
    "engine": (("frame", "event loop"), "frame: every frame takes all that has come. event loop: each value at once."),
    "facememory": (("ends with the run", "kept"), "How long the robot remembers faces."),
    "camerapictures": (("kept", "not kept"), "Whether pictures of the robot's camera are kept with a run's record."),
    "language": (("English", "日本語"), "In which the workbook is explained, drawn and printed. Blank: English."),
}
"""Fields of the Protocol sheet, by key, that say one of a few things: these, and a prompt."""


def column(kind: str, header: str, choices: frozenset[str] = frozenset()) -> ColumnStyle:
    """The look of a column; columns of the user's own, and settings, have a plain one.

    Args:
        kind: of the sheet; empty for the user's own.
        header: the standard header, or as spelt.
        choices: titles of lists that may be offered for a setting.
    """
    known = COLUMNS.get(kind, {}).get(header)
    if known:
        return known
    if kind == "gestures":
        return ColumnStyle(
            15, "", f"{header} at that time: rad, or degrees as 30°; a hand from 0 to 1. Blank: on its way."
        )
    if kind == "devices":
        return ColumnStyle(18, header if header in choices else "", f"The setting {header}; blank is the usual one.")
    return _ANY


_LISTS = re.compile(r"Lists(?: for drop-downs(?: \d+)?)?")
"""Name of the sheet with the entries of the drop-downs."""


@dataclass(frozen=True, slots=True)
class Offers:
    """Names for drop-downs and for the marks of unknown names.

    Attributes:
        connectors: the everyday ones first, then the advanced ones.
        sensors: devices that can be an input stream.
        actuators: devices that can be an output stream.
        choices: further choices by column header (`Mode`, `Joint`, `Thing`, `Does`).
    """

    connectors: tuple[str, ...] = ()
    sensors: tuple[str, ...] = ()
    actuators: tuple[str, ...] = ()
    choices: Mapping[str, tuple[str, ...]] = field(default_factory=dict)

    def lists(self) -> dict[str, tuple[str, ...]]:
        """The columns of the Lists sheet by their title; empty ones are left out."""
        lists = {
            "Connectors": self.connectors,
            "Sensors": self.sensors,
            "Actuators": self.actuators,
            "All devices": tuple(dict.fromkeys(self.sensors + self.actuators)),
            "On or off": ("TRUE", "FALSE"),
            **{title: tuple(names) for title, names in self.choices.items()},
        }
        return {title: names for title, names in lists.items() if names}

    def made(self, name: str, rows: Sequence[Sequence[str]]) -> bool:
        """Return whether a sheet is a Lists sheet that the program has made: it can be made again without loss.

        A sheet with another name, column or entry is the user's own.

        >>> offers = Offers(("map", "filter"))
        >>> offers.made("Lists", [["Connectors", "On or off"], ["map", "TRUE"]])
        True
        >>> offers.made("Lists", [["Connectors", "On or off"], ["mine", "TRUE"]])
        False
        """
        lists = self.lists()
        titles = [text.strip() for text in rows[0]] if rows else []
        if not _LISTS.fullmatch(name) or "On or off" not in titles or not lists.keys() >= set(titles):
            return False
        known = [{key(entry) for entry in lists[title]} for title in titles]
        return all(
            not text.strip() or (column < len(known) and key(text) in known[column])
            for row in rows[1:]
            for column, text in enumerate(row)
        )
