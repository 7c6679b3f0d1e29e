"""Paths of things, which give the place at a time: standing, moving along a line, circling."""

from __future__ import annotations

import math
from dataclasses import dataclass

Point = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Still:
    """Path of a thing that stays at one place."""

    place: Point

    def at(self, us: int) -> Point:
        """Return the place at a time of the run."""
        return self.place


@dataclass(frozen=True, slots=True)
class LinePath:
    """Path from one place to another at constant speed.

    >>> LinePath((0, 0, 0), (1, 0, 2), 0, 1_000_000).at(500_000)
    (0.5, 0.0, 1.0)
    """

    start: Point
    end: Point
    from_us: int
    for_us: int

    def at(self, us: int) -> Point:
        """Return the place at a time of the run."""
        part = 1.0 if self.for_us <= 0 else min(max((us - self.from_us) / self.for_us, 0.0), 1.0)
        x, y, z = (a + part * (b - a) for a, b in zip(self.start, self.end, strict=True))
        return x, y, z


@dataclass(frozen=True, slots=True)
class Circle:
    """Path around a middle, upright (facing the robot) or flat, leaving from `start` without a jump."""

    start: Point
    middle: Point
    radius: float
    period_us: int
    from_us: int
    flat: bool = False

    def at(self, us: int) -> Point:
        """Return the place at a time of the run: in the first quarter of a round it swings onto the circle.

        >>> c = Circle((1.0, 0.0, 0.4), (0.0, 0.0, 0.4), 0.5, 4_000_000, 0, flat=True)
        >>> c.at(0), [round(x, 3) for x in c.at(1_000_000)]
        ((1.0, 0.0, 0.4), [0.0, 0.5, 0.4])
        """
        passed = max(us - self.from_us, 0)
        part = min(1.0, 4 * passed / self.period_us)
        mx, my, mz = self.middle
        dx, dy, dz = self.start[0] - mx, self.start[1] - my, self.start[2] - mz
        a, b, off = (dx, dy, dz) if self.flat else (dy, dz, dx)
        far = math.hypot(a, b)
        angle = (math.atan2(b, a) if far > 1e-9 else -math.pi / 2) + 2 * math.pi * passed / self.period_us
        radius = far + part * (self.radius - far)
        a, b, off = radius * math.cos(angle), radius * math.sin(angle), off * (1 - part)
        return (mx + a, my + b, mz + off) if self.flat else (mx + off, my + a, mz + b)
