"""The names that a new workbook offers in its drop-downs. Who makes one passes them in."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from rrp_sheets.model.names import key

_LISTS = re.compile(r"Lists(?: for drop-downs(?: \d+)?)?")
"""What the sheet with the drop-downs' entries is called."""


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
