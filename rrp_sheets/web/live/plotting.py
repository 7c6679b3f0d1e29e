"""Numbers over time for the small plots, thinned so that a display can follow and memory stays small."""

from __future__ import annotations

from collections import deque

from rrp_sheets.model.values import Record, Value

MOST_KEYS = 80
KEPT_US = 60_000_000  # of the run's clock
_KEPT = 900  # points of a key
_PER_TELLING = 4  # points of a key that are told at once: the first, the last, and the extremes between them
Point = tuple[int, float]


class Plots:
    """The numbers of streams, by the stream's name or `name.field`."""

    def __init__(self) -> None:
        self._kept: dict[str, deque[Point]] = {}
        self._new: dict[str, list[Point]] = {}

    def take(self, us: int, name: str, value: Value, *, fields: bool) -> None:
        """A value; of a record its numbers when `fields`."""
        if isinstance(value, Record):
            if fields:
                for field, part in value.as_dict().items():
                    self._put(us, f"{name}.{field}", part)
        else:
            self._put(us, name, value)

    def _put(self, us: int, key: str, value: Value) -> None:
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            return
        if key not in self._kept:
            if len(self._kept) >= MOST_KEYS:
                return
            self._kept[key] = deque(maxlen=_KEPT)
        self._new.setdefault(key, []).append((us, float(value)))

    def news(self) -> list[list[object]]:
        """The points since the last time, thinned."""
        told = []
        for key, points in self._new.items():
            thin = _thinned(points)
            self._kept[key].extend(thin)
            told.append(_plain(key, thin))
        self._new = {}
        return told

    def all(self, us: int) -> list[list[object]]:
        """The points that were told so far, those of the last minute."""
        kept = ((k, [p for p in points if p[0] >= us - KEPT_US]) for k, points in self._kept.items())
        return [_plain(k, points) for k, points in kept if points]


def _plain(key: str, points: list[Point]) -> list[object]:
    return [key, [[us / 1e6, float(f"{v:.4g}")] for us, v in points]]


def _thinned(points: list[Point]) -> list[Point]:
    """At most four of the points: the first, the smallest, the largest and the last.

    >>> _thinned([(1, 5.0), (2, 9.0), (3, 1.0), (4, 2.0), (5, 3.0)])
    [(1, 5.0), (2, 9.0), (3, 1.0), (5, 3.0)]
    """
    if len(points) <= _PER_TELLING:
        return points
    inner = points[1:-1]
    extremes = {min(inner, key=lambda p: p[1]), max(inner, key=lambda p: p[1])}
    return [points[0], *sorted(extremes), points[-1]]
