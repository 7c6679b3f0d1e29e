"""The names that a new workbook offers in its drop-downs. Who makes one passes them in."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field


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
