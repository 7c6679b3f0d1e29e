"""Shapes of things and persons: solids, with the distance of a point and the places where rays hit, and what is seen.

Plain geometry beside the physics: things never push the robot, and moving one costs nothing until a distance is needed.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from rrp_sheets.perception.pinhole import Vector
from rrp_sheets.sim.appearance import BALL_COLOURS, COLOURS, RGB, parse_colour

Point = Sequence[float] | Vector
CLOTHES: tuple[RGB, ...] = ((0.42, 0.60, 0.62), (0.76, 0.64, 0.46), (0.60, 0.52, 0.68), (0.50, 0.62, 0.46))
"""Too pale to be taken for a ball."""
AROUND = 20  # faces around a shape that is turned on a lathe


@dataclass(frozen=True)
class Solid(ABC):
    """A shape in the world, with the name of the thing that it belongs to. Lengths in m."""

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
        above, below = _slab(z, rays[:, 2], self.height)
        return _first(np.stack([enters, above]), np.stack([leaves, below]))


@dataclass(frozen=True)
class SolidBox(Solid):
    """A box that stands upright.

    >>> SolidBox("Wall", (2, 0, 0.5), (0.1, 3, 1), 0.0).distance((0, 0, 0.5))
    1.95
    """

    size: tuple[float, float, float]  # along its own x, y and z
    turned: float = 0.0  # to the left, rad

    def distance(self, point: Point) -> float:
        """Return how far a point is from the box; 0 inside."""
        own = self._own(np.subtract(point, self.middle)[None, :])[0]
        return math.hypot(*(max(abs(float(o)) - s / 2, 0.0) for o, s in zip(own, self.size, strict=True)))

    def hits(self, origin: Point, rays: Vector) -> Vector:
        """Return how far each ray goes until it hits the box."""
        start = self._own(np.subtract(origin, self.middle)[None, :])[0]
        turned = self._own(rays)
        enters, leaves = zip(*(_slab(float(start[i]), turned[:, i], self.size[i]) for i in range(3)), strict=True)
        return _first(np.stack(enters), np.stack(leaves))

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


class CompoundShape:
    """Shapes that move together: each a body of the physics without mass, at an offset."""

    def __init__(self, bullet: Any) -> None:
        self._b = bullet
        self._parts: list[tuple[int, Vector, Sequence[float]]] = []

    def add(self, shape: int, offset: Sequence[float], tilt: Sequence[float] = (0.0, 0.0, 0.0, 1.0)) -> int:
        """Add a part, at `offset` (m) and `tilt` (a quaternion) in the figure's frame; return its number."""
        body: int = self._b.createMultiBody(0, -1, shape, [0, 0, -5])
        self._parts.append((body, np.array(offset, dtype=np.float64), tilt))
        return body

    def place(self, position: Sequence[float], yaw: float = 0.0) -> None:
        """Put the figure somewhere, turned by `yaw`."""
        c, s = math.cos(yaw), math.sin(yaw)
        facing = self._b.getQuaternionFromEuler([0, 0, yaw])
        for body, (x, y, z), tilt in self._parts:
            at = [position[0] + c * x - s * y, position[1] + s * x + c * y, position[2] + z]
            way = facing if tilt[3] == 1.0 else self._b.multiplyTransforms([0, 0, 0], facing, [0, 0, 0], tilt)[1]
            self._b.resetBasePositionAndOrientation(body, at, way)

    def remove(self) -> None:
        """Take the figure out of the world."""
        for body, *_ in self._parts:
            self._b.removeBody(body)
        self._parts.clear()


def ball(bullet: Any, colour: str, radius: float) -> CompoundShape:
    """A ball of a colour, by name or as `#rrggbb`."""
    rgb = BALL_COLOURS.get(colour) or parse_colour(colour) or COLOURS["grey"]
    figure = CompoundShape(bullet)
    figure.add(ellipsoid(bullet, (radius, radius, radius), rgb, fine=1.6), (0, 0, 0))
    return figure


def ellipsoid(bullet: Any, radii: Sequence[float], colour: RGB, fine: float = 1.0) -> int:
    """An ellipsoid around its middle; `fine` draws it with more or fewer faces."""
    rings = round(10 * fine)
    outline = [(math.sin(math.pi * i / rings), -radii[2] * math.cos(math.pi * i / rings)) for i in range(rings + 1)]
    return turned(bullet, outline, colour, (radii[0], radii[1]), around=round(18 * fine))


def turned(
    bullet: Any, outline: Sequence[tuple[float, float]], colour: RGB, stretch: tuple[float, float] = (1.0, 1.0),
    around: int = AROUND,
) -> int:  # fmt: skip
    """A shape turned on a lathe: `outline` lists (radius, height) from below to the top; `stretch` along x and y."""
    points, normals, faces = [], [], []
    for i, (radius, z) in enumerate(outline):
        below, above = outline[max(i - 1, 0)], outline[min(i + 1, len(outline) - 1)]
        slope = (above[1] - below[1], (below[0] - above[0]) * (stretch[0] + stretch[1]) / 2)
        length = math.hypot(*slope) or 1.0
        for j in range(around):
            u = 2 * math.pi * j / around
            points.append([radius * math.cos(u) * stretch[0], radius * math.sin(u) * stretch[1], z])
            normals.append([slope[0] / length * math.cos(u), slope[0] / length * math.sin(u), slope[1] / length])
    for i in range(len(outline) - 1):
        for j in range(around):
            a, b = i * around + j, i * around + (j + 1) % around
            faces += [a, b, b + around, a, b + around, a + around]
    return mesh(bullet, points, faces, normals, colour)


def mesh(bullet: Any, points: list[list[float]], faces: list[int], normals: list[list[float]], colour: RGB) -> int:
    """Create a dull shape of triangles and return its number."""
    shape: int = bullet.createVisualShape(
        bullet.GEOM_MESH, vertices=points, indices=faces, normals=normals, rgbaColor=[*colour, 1],
        specularColor=[0, 0, 0],
    )  # fmt: skip
    return shape
