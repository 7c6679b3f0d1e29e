"""Actuators of the eyes' colour and brightness."""

from __future__ import annotations

from rrp_sheets.model.exchange import Command
from rrp_sheets.sim.actuators.base import Base, as_number
from rrp_sheets.sim.colours import EXAMPLE, parse_colour


class EyeLedColor(Base):
    """Sets the eyes to the colour that arrives."""

    def take(self, order: Command, us: int) -> None:
        """Set the eyes' colour."""
        colour = parse_colour(order.value)
        if colour is None:
            self.wrong(order, f"a colour, for example {EXAMPLE}")
            return
        self.parts.eyes.colour = colour
        self.parts.eyes.show()
        self.parts.arbiter.at_once(order)


class EyeColor(Base):
    """Sets the eyes to the colour of its setting."""

    def take(self, order: Command, us: int) -> None:
        """Set the eyes' colour."""
        colour = parse_colour(self.settings.get("colour"))
        if colour is None:
            self.fail(order, f"{self.spec.name}: its setting Colour needs a colour, for example {EXAMPLE}.")
            return
        self.parts.eyes.colour = colour
        self.parts.eyes.show()
        self.parts.arbiter.at_once(order)


class EyeBrightness(Base):
    """Sets the eyes' brightness to the number that arrives."""

    def take(self, order: Command, us: int) -> None:
        """Dim or brighten the eyes."""
        number = as_number(order.value)
        if number is None:
            self.wrong(order, "a number from 0 to 1")
            return
        colour = parse_colour(self.settings.get("colour"))
        if colour is not None:
            self.parts.eyes.colour = colour
        self.parts.eyes.brightness = self.clamp(order, "Brightness", number, (0.0, 1.0))
        self.parts.eyes.show()
        self.parts.arbiter.at_once(order)
