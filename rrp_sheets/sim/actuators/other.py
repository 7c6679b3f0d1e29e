"""Actuators that move nothing."""

from __future__ import annotations

from rrp_sheets.model.exchange import Command, DeviceUse, Notice
from rrp_sheets.model.values import show
from rrp_sheets.sim.actuators.base import Base, Parts


class Print(Base):
    """Shows the value in the log."""

    def take(self, order: Command, us: int) -> None:
        """Show it."""
        value = order.value
        text = value if isinstance(value, str) else show(value)
        self.parts.tell(Notice("note", text, order.stream, order.row))
        self.parts.arbiter.at_once(order)

    def blank(self, order: Command, us: int) -> None:
        """A blank is shown like any other value."""
        self.parts.tell(Notice("note", show(None), order.stream, order.row))


class Later(Base):
    """What the simulated robot does not carry out yet: every command is over at once, not completed."""

    def __init__(self, spec: DeviceUse, parts: Parts) -> None:
        super().__init__(spec, parts)
        self._told = False

    def take(self, order: Command, us: int) -> None:
        """Say so, once."""
        if self._told:
            self.parts.arbiter.at_once(order, completed=False)
            return
        self._told = True
        self.fail(order, f"{self.spec.name}: the simulated robot does not carry out {self.spec.device} yet.", "note")
