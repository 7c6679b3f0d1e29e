"""The event-loop engine: events one by one, in the order of their arrival.

Between two events nothing waits: each settles the whole graph, by (time, rank), exactly as a frame with this one event
does, so that a diamond is consistent here too. A timer acts at its own time, and a value of just that time is its
instant's. Its caller decides how time passes: `realtime_runner` by the wall clock, a test as it likes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

from rrp_sheets.engine.engine import Engine
from rrp_sheets.model.exchange import Command
from rrp_sheets.model.values import Value


class EventEngine(Engine):
    """Every event is an instant of its own, and so is every timer.

    Attributes:
        halted: whether the run is to stop: timers that are due are then left where they are.
    """

    halted: Callable[[], bool] = staticmethod(lambda: False)

    def settle(self, now_us: int, arrivals: Iterable[tuple[str, Value]]) -> list[Command]:
        """Let what is due by now act, then each value enter and settle; the commands of all of it, in order."""
        now_us = max(now_us, self.clock.us)  # what was stamped by another thread may come a moment late
        commands: list[Command] = []
        for arrival in arrivals:
            self._catch_up(now_us, commands)
            if self.ended_by:
                return commands
            commands += self._instant(now_us, (arrival,))
        self._catch_up(now_us + 1, commands)
        if self._sent or self._commands:  # what people sent, and what a behaviour that they switched off leaves
            commands += self._instant(now_us, ())
        self.clock.begin(now_us)
        return commands

    def _catch_up(self, before_us: int, commands: list[Command]) -> None:
        """Let the timers that are due before a time act, each at its own."""
        while not self.ended_by and not self.halted() and (due := self.clock.next_due) is not None and due < before_us:
            commands += self._instant(due, ())
