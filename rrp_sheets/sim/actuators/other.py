"""Actuators that move nothing: eyes, printing, remembering faces, and devices that are not simulated yet."""

from __future__ import annotations

from rrp_sheets.errors import SheetsError
from rrp_sheets.model.exchange import Command, Notice
from rrp_sheets.model.values import Record, show
from rrp_sheets.perception.face_memory import FACE_REMEMBERED
from rrp_sheets.sim.actuators.base import SimActuator, as_number
from rrp_sheets.sim.appearance import EXAMPLE, parse_colour
from rrp_sheets.texts import N_, sentences


class PrintActuator(SimActuator, device="Print"):
    """Shows the value in the log."""

    def take(self, command: Command, us: int) -> None:
        """Report the value as a note."""
        text = command.value if isinstance(command.value, str) else show(command.value)
        self.parts.tell(Notice("note", text, command.stream, command.row))
        self.parts.arbiter.at_once(command)

    def blank(self, command: Command, us: int) -> None:
        """Report a blank like any other value."""
        self.parts.tell(Notice("note", show(None), command.stream, command.row))


class Later(SimActuator):
    """Stand-in for a device that is not simulated yet: every command is over at once, not completed."""

    _told = False

    def take(self, command: Command, us: int) -> None:
        """Report once that the device is not simulated, and end the command."""
        if self._told:
            self.parts.arbiter.at_once(command, completed=False)
            return
        self._told = True
        text = N_("{name}: the simulated robot does not carry out {device} yet.", name=self.spec.name,
                  device=self.spec.device)  # fmt: skip
        self.fail(command, text, "note")


class RememberFace(SimActuator, device="RememberFace"):
    """Remembers a new face."""

    def take(self, command: Command, us: int) -> None:
        """Remember the face of the record that arrives, else the new face that is longest in view."""
        value = command.value
        name = (value.strip() if isinstance(value, str) else "") or str(self.settings.get("name") or "")
        given = as_number(value.values.get("id")) if isinstance(value, Record) else None
        remembered, why = self.parts.faces.remember(name, None if given is None else int(given))
        if not remembered:
            self.fail(command, why, "note")
            return
        self.parts.tell(Notice("note", N_(FACE_REMEMBERED, name=remembered), command.stream, command.row))
        try:
            self.parts.faces.keep()
        except SheetsError as error:
            self.parts.tell(Notice("note", sentences(error.message, error.remedy), command.stream, command.row))
        self.parts.arbiter.at_once(command)


class EyeLedColor(SimActuator, device="EyeLedColor"):
    """Sets the eyes to the colour that arrives."""

    def take(self, command: Command, us: int) -> None:
        """Set the eyes' colour."""
        colour = parse_colour(command.value)
        if colour is None:
            self.wrong(command, N_("a colour, for example {example}", example=EXAMPLE))
            return
        self.parts.eyes.show(colour)
        self.parts.arbiter.at_once(command)


class EyeColor(SimActuator, device="EyeColor"):
    """Sets the eyes to the colour of its setting."""

    def take(self, command: Command, us: int) -> None:
        """Set the eyes' colour."""
        colour = parse_colour(self.settings.get("colour"))
        if colour is None:
            text = N_("{name}: its setting Colour needs a colour, for example {example}.", name=self.spec.name,
                      example=EXAMPLE)  # fmt: skip
            self.fail(command, text)
            return
        self.parts.eyes.show(colour)
        self.parts.arbiter.at_once(command)


class EyeBrightness(SimActuator, device="EyeBrightness"):
    """Sets the eyes' brightness to the number that arrives."""

    def take(self, command: Command, us: int) -> None:
        """Dim or brighten the eyes."""
        number = as_number(command.value)
        if number is None:
            self.wrong(command, N_("a number from 0 to 1"))
            return
        self.parts.eyes.brightness = self.clamp(command, N_("Brightness"), number, (0.0, 1.0))
        self.parts.eyes.show(parse_colour(self.settings.get("colour")))
        self.parts.arbiter.at_once(command)
