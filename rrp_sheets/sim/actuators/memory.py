"""Remembering faces."""

from __future__ import annotations

from rrp_sheets.errors import SheetsError
from rrp_sheets.model.exchange import Command, Notice
from rrp_sheets.model.values import Record
from rrp_sheets.sim.actuators.base import Base, as_number


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
