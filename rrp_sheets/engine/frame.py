"""The frame engine: deterministic and free of glitches."""

from __future__ import annotations

from collections.abc import Iterable

from rrp_sheets.engine.engine import Engine, Observer
from rrp_sheets.model.exchange import Command
from rrp_sheets.model.values import Value

__all__ = ["FrameEngine", "Observer"]


class FrameEngine(Engine):
    """Every frame: the sensors' values enter at one instant, the graph settles, commands come out."""

    def settle(self, now_us: int, arrivals: Iterable[tuple[str, Value]]) -> list[Command]:
        """One frame: let the values enter, settle the graph, and return the commands for the actuators."""
        return self._instant(now_us, arrivals)
