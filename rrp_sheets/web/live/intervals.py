"""Which row has which part of the robot, and from when to when."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass

_KEPT = 400
_GAP_US = 700_000  # a row that drives again so soon has never stopped, for a reader: eyes set twice a second


@dataclass(slots=True, eq=False)
class Interval:
    """A row has a resource from one time to another, or still."""

    resource: str
    row: str
    began: int
    ended: int | None = None

    def plain(self) -> list[object]:
        """As it is told, in seconds."""
        return [self.resource, self.row, self.began / 1e6, None if self.ended is None else self.ended / 1e6]


class Drives:
    """Stretches of driving, the newest kept."""

    def __init__(self) -> None:
        self._kept: deque[Interval] = deque(maxlen=_KEPT)
        self._last: dict[str, Interval] = {}
        self._new: list[Interval] = []

    def take(self, us: int, driving: Mapping[str, str]) -> None:
        """What drives at a moment."""
        for resource, last in self._last.items():
            if last.ended is None and driving.get(resource) != last.row:
                last.ended = us
                self._tell(last)
        for resource, row in driving.items():
            before = self._last.get(resource)
            if before is not None and before.row == row and (before.ended is None or us - before.ended <= _GAP_US):
                if before.ended is not None:
                    before.ended = None
                    self._tell(before)
                continue
            fresh = self._last[resource] = Interval(resource, row, us)
            self._kept.append(fresh)
            self._tell(fresh)

    def _tell(self, stretch: Interval) -> None:
        if stretch not in self._new:
            self._new.append(stretch)

    def news(self) -> list[list[object]]:
        """The stretches that began or ended since the last time."""
        told = [s.plain() for s in self._new]
        self._new = []
        return told

    def all(self) -> list[list[object]]:
        """The stretches that are kept."""
        return [s.plain() for s in self._kept]
