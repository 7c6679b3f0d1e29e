"""Actuators that move nothing: printing, remembering faces, and devices that are not simulated yet."""

from __future__ import annotations

from rrp_sheets.errors import SheetsError
from rrp_sheets.model.exchange import Command, DeviceUse, Notice
from rrp_sheets.model.values import Record, show
from rrp_sheets.sim.actuators.base import Base, Parts, as_number


class PrintActuator(Base):
    """Shows the value in the log."""

    def take(self, order: Command, us: int) -> None:
        """Report the value as a note."""
        value = order.value
        text = value if isinstance(value, str) else show(value)
        self.parts.tell(Notice("note", text, order.stream, order.row))
        self.parts.arbiter.at_once(order)

    def blank(self, order: Command, us: int) -> None:
        """Report a blank like any other value."""
        self.parts.tell(Notice("note", show(None), order.stream, order.row))


class Later(Base):
    """Stand-in for a device that is not simulated yet: every command is over at once, not completed."""

    def __init__(self, spec: DeviceUse, parts: Parts) -> None:
        super().__init__(spec, parts)
        self._told = False

    def take(self, order: Command, us: int) -> None:
        """Report once that the device is not simulated, and end the command."""
        if self._told:
            self.parts.arbiter.at_once(order, completed=False)
            return
        self._told = True
        self.fail(order, f"{self.spec.name}: the simulated robot does not carry out {self.spec.device} yet.", "note")


class RememberFace(Base):
    """Remembers a new face."""

    def take(self, order: Command, us: int) -> None:
        """Remember the face of the record that arrives, else the new face that is longest in view."""
        value = order.value
        name = str(self.settings.get("name") or "")
        number = None
        if isinstance(value, str) and value.strip():
            name = value.strip()
        elif isinstance(value, Record):
            given = as_number(value.values.get("id"))
            number = int(given) if given is not None else None
        remembered, why = self.parts.faces.remember(name, number)
        if not remembered:
            self.fail(order, why, "note")
            return
        self.parts.tell(Notice("note", f"The face is remembered as {remembered}.", order.stream, order.row))
        try:
            self.parts.faces.keep()
        except SheetsError as error:
            self.parts.tell(Notice("note", str(error), order.stream, order.row))
        self.parts.arbiter.at_once(order)
