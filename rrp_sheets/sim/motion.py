"""Smooth motion of one joint's set point: limited velocity and acceleration, no overshoot."""

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
