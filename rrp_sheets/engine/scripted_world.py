"""A world without a robot: values are injected into sensor streams at given times; commands are only collected."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from rrp_sheets.engine.ports import Arrivals
from rrp_sheets.model.exchange import Command, State, WorldSnapshot
from rrp_sheets.model.scene import SceneAction
from rrp_sheets.model.values import Value


class ScriptedWorld:
    """For tests and for checking behaviours in virtual time.

    Attributes:
        received: the commands that came, with the time of the frame they were given in.
        acted: what people did to the world.
    """

    def __init__(self, events: Iterable[tuple[int, str, Value]]) -> None:
        self._events = sorted(events, key=lambda e: e[0])
        self._next = 0
        self._last_us = 0
        self.received: list[tuple[int, Command]] = []
        self.acted: list[SceneAction] = []

    def start(self) -> Arrivals:
        """The values of time 0."""
        return Arrivals(self._until(0))

    def advance(self, now_us: int, commands: Sequence[Command]) -> Arrivals:
        """The values since the frame before."""
        self.received.extend((self._last_us, c) for c in commands)
        self._last_us = now_us
        return Arrivals(self._until(now_us))

    def act(self, actions: Sequence[SceneAction]) -> None:
        """Nothing is there that could be moved: it is only collected."""
        self.acted.extend(actions)

    def show(self, picture: bool) -> WorldSnapshot:
        """There is nothing to see."""
        return WorldSnapshot(State({}, (), (), "", {}))

    def stop(self) -> None:
        """Nothing to let go of."""

    def _until(self, us: int) -> list[tuple[str, Value]]:
        first = self._next
        while self._next < len(self._events) and self._events[self._next][0] <= us:
            self._next += 1
        return [(stream, value) for _, stream, value in self._events[first : self._next]]
