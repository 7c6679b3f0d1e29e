"""Solid shapes of things, with the distance of a point from one and the places where rays hit one.

Plain geometry beside the physics: things never push the robot, and moving one costs nothing until a distance is needed.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rrp_sheets.sim.body import Vector

Point = Sequence[float] | Vector


@dataclass(frozen=True)
class Solid(ABC):
    """A shape in the world. Lengths in m.

    Attributes:
        name: of the thing it belongs to.
        middle: of the shape.
    """

    name: str
    middle: tuple[float, float, float]

    @abstractmethod
    def distance(self, point: Point) -> float:
        """Return how far a point is from the shape; 0 inside."""

    @abstractmethod
    def hits(self, origin: Point, rays: Vector) -> Vector:
        """Return how far each ray (rows of unit vectors) goes from `origin` to the shape; infinite where it misses."""


@dataclass(frozen=True)
class Sphere(Solid):
    """A round shape: a ball, a head.

    >>> Sphere("Ball", (1, 0, 0), 0.1).distance((0, 0, 0))
    0.9
    """

    radius: float

    def distance(self, point: Point) -> float:
        """Return how far a point is from the sphere; 0 inside."""
        return max(math.dist(self.middle, point) - self.radius, 0.0)

    def hits(self, origin: Point, rays: Vector) -> Vector:
        """Return how far each ray goes until it hits the sphere."""
        off = np.subtract(self.middle, origin)
        along = rays @ off
        inside = self.radius**2 - (float(off @ off) - along**2)
        with np.errstate(invalid="ignore"):
            near = along - np.sqrt(inside)
        return np.where((inside >= 0) & (along >= 0), np.maximum(near, 0.0), np.inf)


@dataclass(frozen=True)
class Cylinder(Solid):
    """An upright cylinder: a cup, a body.

    >>> Cylinder("Cup", (1, 0, 0.5), 0.1, 1.0).distance((0, 0, 0.9))
    0.9
    """

    radius: float
    height: float

    def distance(self, point: Point) -> float:
        """Return how far a point is from the cylinder; 0 inside."""
        x, y, z = (p - m for p, m in zip(point, self.middle, strict=True))
        return math.hypot(max(math.hypot(x, y) - self.radius, 0.0), max(abs(z) - self.height / 2, 0.0))

    def hits(self, origin: Point, rays: Vector) -> Vector:
        """Return how far each ray goes until it hits the cylinder."""
        x, y, z = (float(o - m) for o, m in zip(origin, self.middle, strict=True))
        a = rays[:, 0] ** 2 + rays[:, 1] ** 2
        b = rays[:, 0] * x + rays[:, 1] * y
        c = x * x + y * y - self.radius**2
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            root = np.sqrt(b * b - a * c)
            upright = a < 1e-12
            enters = np.where(upright, np.where(c <= 0, -np.inf, np.nan), (-b - root) / a)
            leaves = np.where(upright, np.where(c <= 0, np.inf, np.nan), (-b + root) / a)
        return _first(np.stack([enters, _slab(z, rays[:, 2], self.height)[0]]),
                      np.stack([leaves, _slab(z, rays[:, 2], self.height)[1]]))  # fmt: skip


@dataclass(frozen=True)
class SolidBox(Solid):
    """A box that stands upright.

    Attributes:
        size: along its own x, y and z.
        turned: to the left, rad.

    >>> SolidBox("Wall", (2, 0, 0.5), (0.1, 3, 1), 0.0).distance((0, 0, 0.5))
    1.95
    """

    size: tuple[float, float, float]
    turned: float = 0.0

    def distance(self, point: Point) -> float:
        """Return how far a point is from the box; 0 inside."""
        own = self._own(np.subtract(point, self.middle)[None, :])[0]
        return math.hypot(*(max(abs(float(o)) - s / 2, 0.0) for o, s in zip(own, self.size, strict=True)))

    def hits(self, origin: Point, rays: Vector) -> Vector:
        """Return how far each ray goes until it hits the box."""
        start = self._own(np.subtract(origin, self.middle)[None, :])[0]
        turned = self._own(rays)
        slabs = [_slab(float(start[i]), turned[:, i], self.size[i]) for i in range(3)]
        return _first(np.stack([s[0] for s in slabs]), np.stack([s[1] for s in slabs]))

    def _own(self, vectors: Vector) -> Vector:
        """Return vectors in the box's own frame."""
        c, s = math.cos(self.turned), math.sin(self.turned)
        own: Vector = vectors @ np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        return own


def _slab(start: float, way: Vector, size: float) -> tuple[Vector, Vector]:
    """Return how far rays go until they enter and leave the space between two parallel planes around 0."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        one, two = (-size / 2 - start) / way, (size / 2 - start) / way
    inside = abs(start) <= size / 2
    still = np.abs(way) < 1e-12
    enters = np.where(still, -np.inf if inside else np.inf, np.minimum(one, two))
    leaves = np.where(still, np.inf if inside else -np.inf, np.maximum(one, two))
    return enters, leaves


def _first(enters: Vector, leaves: Vector) -> Vector:
    """Return how far rays go until they are within all of several spaces."""
    enter, leave = enters.max(axis=0), leaves.min(axis=0)
    return np.where((enter <= leave) & (leave >= 0), np.maximum(enter, 0.0), np.inf)
