"""What balls and persons look like. They have no mass: they are only seen."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from rrp_sheets.sim.body import Vector
from rrp_sheets.sim.colours import BALL_COLOURS, COLOURS, RGB, parse_colour

CLOTHES: tuple[RGB, ...] = ((0.42, 0.60, 0.62), (0.76, 0.64, 0.46), (0.60, 0.52, 0.68), (0.50, 0.62, 0.46))
SKIN: RGB = (0.93, 0.78, 0.68)
HAIR: tuple[RGB, ...] = ((0.34, 0.25, 0.20), (0.62, 0.50, 0.36), (0.20, 0.18, 0.18), (0.50, 0.34, 0.26))
"""Clothes, skin and hair are too pale to be taken for a ball."""
DARK: RGB = (0.18, 0.15, 0.15)
LIPS: RGB = (0.72, 0.45, 0.43)
HEAD = 0.095  # m, radius
AROUND = 20  # faces around a turned shape


class Figure:
    """Shapes that move together: each a body of the physics without mass, at an offset."""

    def __init__(self, bullet: Any) -> None:
        self._b = bullet
        self._parts: list[tuple[int, Vector]] = []

    def add(self, shape: int, offset: Sequence[float]) -> None:
        """Add a part; `offset` in the figure's frame, m."""
        self._parts.append((self._b.createMultiBody(0, -1, shape, [0, 0, -5]), np.array(offset, dtype=np.float64)))

    def place(self, position: Sequence[float], yaw: float = 0.0) -> None:
        """Put the figure somewhere, turned by `yaw`."""
        c, s = math.cos(yaw), math.sin(yaw)
        turned = self._b.getQuaternionFromEuler([0, 0, yaw])
        for body, (x, y, z) in self._parts:
            at = [position[0] + c * x - s * y, position[1] + s * x + c * y, position[2] + z]
            self._b.resetBasePositionAndOrientation(body, at, turned)

    def remove(self) -> None:
        """Take the figure out of the world."""
        for body, _ in self._parts:
            self._b.removeBody(body)
        self._parts.clear()


def ball(bullet: Any, colour: str, radius: float) -> Figure:
    """A ball of a colour, by name or as `#rrggbb`."""
    rgb = BALL_COLOURS.get(colour) or parse_colour(colour) or COLOURS["grey"]
    figure = Figure(bullet)
    figure.add(_ellipsoid(bullet, (radius, radius, radius), rgb, fine=1.6), (0, 0, 0))
    return figure


def person(bullet: Any, number: int, height: float) -> Figure:
    """A simple person who looks along the figure's x.

    Args:
        bullet: the physics.
        number: chooses clothes and hair.
        height: of the middle of the face above the floor, m.
    """
    clothes, hair = CLOTHES[number % len(CLOTHES)], HAIR[number % len(HAIR)]
    figure = Figure(bullet)
    neck = height - 0.7 * HEAD
    wide = min(0.17, 0.09 + 0.09 * height)  # m, radius at the floor
    outline = [
        (0.0, 0.0), (wide, 0.0), (wide * 1.02, 0.03), (wide * 0.86, neck * 0.35), (wide * 0.66, neck * 0.68),
        (wide * 0.56, neck * 0.86), (wide * 0.36, neck * 0.97), (0.03, neck + 0.01), (0.0, neck + 0.01),
    ]  # fmt: skip
    figure.add(_turned(bullet, outline, clothes), (0, 0, 0))
    for side in (1, -1):  # arms, hanging
        figure.add(_ellipsoid(bullet, (0.033, 0.033, neck * 0.19), clothes), (0.02, side * wide * 0.80, neck * 0.70))
        figure.add(_ellipsoid(bullet, (0.03, 0.026, 0.034), SKIN), (0.03, side * wide * 0.86, neck * 0.51))
    figure.add(_ellipsoid(bullet, (HEAD * 0.94, HEAD * 0.90, HEAD), SKIN), (0, 0, height))
    figure.add(_ellipsoid(bullet, (HEAD * 0.98, HEAD * 0.98, HEAD * 0.92), hair), (-0.020, 0, height + 0.024))
    for side in (1, -1):
        figure.add(_ellipsoid(bullet, (0.008, 0.010, 0.014), DARK), (HEAD * 0.88, side * 0.032, height + 0.012))
        figure.add(_ellipsoid(bullet, (0.012, 0.010, 0.02), SKIN), (0, side * HEAD * 0.93, height))
    figure.add(_ellipsoid(bullet, (0.014, 0.010, 0.013), (0.88, 0.70, 0.60)), (HEAD * 0.93, 0, height - 0.012))
    figure.add(_ellipsoid(bullet, (0.007, 0.026, 0.007), LIPS), (HEAD * 0.84, 0, height - 0.044))
    return figure


def _ellipsoid(bullet: Any, radii: Sequence[float], colour: RGB, fine: float = 1.0) -> int:
    rings = round(10 * fine)
    outline = [(math.sin(math.pi * i / rings), -radii[2] * math.cos(math.pi * i / rings)) for i in range(rings + 1)]
    return _turned(bullet, outline, colour, (radii[0], radii[1]), around=round(18 * fine))


def _turned(
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
    shape: int = bullet.createVisualShape(
        bullet.GEOM_MESH, vertices=points, indices=faces, normals=normals, rgbaColor=[*colour, 1],
        specularColor=[0, 0, 0],
    )  # fmt: skip
    return shape
