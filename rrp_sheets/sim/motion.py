"""Motion of things along paths, and smooth motion of a joint's set point without overshoot."""

from __future__ import annotations

import math
from dataclasses import dataclass

ARRIVED = 1e-5  # rad; nearer than this the set point is put on its target


@dataclass(slots=True)
class Glide:
    """A set point that moves to its target.

    >>> g = Glide(0.0); g.go(1.0, velocity=1.0, acceleration=4.0)
    >>> steps = 0
    >>> while g.moving: g.step(1 / 240); steps += 1
    >>> g.position, 1.2 < steps / 240 < 1.3
    (1.0, True)

    Attributes:
        position: of the set point, rad.
        speed: rad/s, signed.
        target: where it is going.
        velocity: the largest speed on the way, rad/s.
        acceleration: the largest, rad/s².
    """

    position: float
    speed: float = 0.0
    target: float = math.nan
    velocity: float = 1.0
    acceleration: float = 10.0

    def __post_init__(self) -> None:
        if math.isnan(self.target):
            self.target = self.position

    @property
    def moving(self) -> bool:
        """True while the target is not reached."""
        return self.position != self.target or self.speed != 0.0

    def go(self, target: float, velocity: float, acceleration: float) -> None:
        """Head for a new target, from the present position and speed."""
        self.target, self.velocity, self.acceleration = target, velocity, acceleration

    def halt(self) -> None:
        """Stop as fast as the acceleration allows."""
        brake = self.speed * abs(self.speed) / (2 * self.acceleration)
        self.target = self.position + brake

    def step(self, dt: float) -> None:
        """Let `dt` seconds pass."""
        left = self.target - self.position
        change = self.acceleration * dt
        if abs(left) < max(ARRIVED, change * dt) and abs(self.speed) <= 2 * change:
            self.position, self.speed = self.target, 0.0
            return
        # The speed from which it can still brake in the remaining way, less half a step's worth against overshoot.
        room = max(0.0, math.sqrt(2 * self.acceleration * abs(left)) - change / 2)
        wanted = math.copysign(min(self.velocity, room), left)
        self.speed += max(-change, min(change, wanted - self.speed))
        self.position += self.speed * dt


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
