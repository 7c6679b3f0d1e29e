"""Visible shapes of balls and persons. They have no mass: they are only seen."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from rrp_sheets.sim.body import Vector
from rrp_sheets.sim.colours import BALL_COLOURS, COLOURS, RGB, parse_colour

CLOTHES: tuple[RGB, ...] = ((0.42, 0.60, 0.62), (0.76, 0.64, 0.46), (0.60, 0.52, 0.68), (0.50, 0.62, 0.46))
"""Too pale to be taken for a ball."""
AROUND = 20  # faces around a shape that is turned on a lathe


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
    bullet: Any,
    outline: Sequence[tuple[float, float]],
    colour: RGB,
    stretch: tuple[float, float] = (1.0, 1.0),
    around: int = AROUND,
) -> int:
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
