"""Remembering faces."""

from __future__ import annotations

from rrp_sheets.model.exchange import Command, Happening
from rrp_sheets.model.values import Record
from rrp_sheets.sim.actuators.base import Base, as_number


class RememberFace(Base):
    """Remembers a new face."""

    def take(self, order: Command, us: int) -> None:
        """Remember the face of the record that arrives, else the new face in view."""
        value = order.value
        name = str(self.settings.get("name") or "")
        number = None
        if isinstance(value, str) and value.strip():
            name = value.strip()
        elif isinstance(value, Record):
            given = as_number(value.values.get("id"))
            number = int(given) if given is not None else None
        if not self.parts.faces.anyone:
            self.parts.faces.look(self.parts.body.camera())
        if not self.parts.faces.anyone:
            self.fail(order, "There is no face to remember in view.", "note")
            return
        remembered = self.parts.faces.remember(name, number)
        if remembered:
            self.parts.tell(Happening("note", f"The face is remembered as {remembered}.", order.stream, order.row))
        self.parts.arbiter.at_once(order, completed=bool(remembered))
