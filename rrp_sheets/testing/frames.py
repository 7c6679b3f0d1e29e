"""Frames and times: a test's times are in microseconds, its tolerance is one frame."""

from __future__ import annotations

from dataclasses import dataclass

TOLERANCE = 1
"""Frames by which something may come earlier or later than a row says."""


@dataclass(frozen=True)
class Frames:
    """The frames of a run at a rate (frames a second).

    >>> frames = Frames(30)
    >>> frames.at(100_000), frames.at(100_001), frames.time(3)
    (3, 4, 100000)
    """

    rate: int

    def at(self, us: int) -> int:
        """The first frame at or after a time."""
        return -(-us * self.rate // 1_000_000)

    def time(self, frame: int) -> int:
        """Return the time of a frame, in microseconds."""
        return frame * 1_000_000 // self.rate
