"""Cups, boxes, tables and walls: what they look like, and where rays and hands meet them.

A thing stands where the middle of its underside is. It has no mass: it is seen and measured, and pushes nothing.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from rrp_sheets.sim import figures
from rrp_sheets.sim.colours import BALL_COLOURS, RGB, parse_colour
from rrp_sheets.sim.paths import Circle, Line, Point, Still
from rrp_sheets.sim.solids import Box, Cylinder, Solid

Size = tuple[float, float, float]
WALL_THICK = 0.05  # m
TOP_THICK = 0.025  # m, of a table's top
LEG = 0.035  # m
WOOD: RGB = (0.80, 0.68, 0.52)
PLASTER: RGB = (0.80, 0.82, 0.80)
CARDBOARD: RGB = (0.72, 0.58, 0.42)
CUP_WIDE = 0.8  # of its height


@dataclass
class Prop:
    """A cup, a box, a table or a wall in the world.

    Attributes:
        size: along its own x (deep), y (wide) and z (high), m.
        turned: to the left, rad.
        colour: a name, or empty.
    """

    name: str
    kind: str
    figure: figures.Figure
    path: Still | Line | Circle
    size: Size
    turned: float = 0.0
    colour: str = ""

    def solids(self, us: int) -> list[Solid]:
        """Its shapes where they are at a time."""
        x, y, z = self.path.at(us)
        deep, wide, high = self.size
        if self.kind == "cup":
            return [Cylinder(self.name, (x, y, z + high / 2), wide / 2, high)]
        if self.kind != "table":
            return [Box(self.name, (x, y, z + high / 2), self.size, self.turned)]
        c, s = math.cos(self.turned), math.sin(self.turned)
        parts: list[Solid] = [Box(self.name, (x, y, z + high - TOP_THICK / 2), (deep, wide, TOP_THICK), self.turned)]
        for ox, oy in _corners(deep, wide):
            spot = (x + c * ox - s * oy, y + s * ox + c * oy, z + high / 2)
            parts.append(Box(self.name, spot, (LEG, LEG, high), self.turned))
        return parts

    def top(self, us: int) -> float:
        """How high its upper side is, m."""
        return self.path.at(us)[2] + self.size[2]


def make_prop(bullet: Any, name: str, kind: str, values: Any, at: Point) -> Prop:
    """A thing as its row says."""
    colour = str(values.get("colour") or "")
    size = _size(kind, values.get("size"))
    figure = figures.Figure(bullet)
    _DRAWN[kind](bullet, figure, size, colour)
    return Prop(name, kind, figure, Still(at), size, float(values.get("turned") or 0.0), colour)


def _size(kind: str, said: Any) -> Size:
    if kind == "cup":
        return CUP_WIDE * float(said), CUP_WIDE * float(said), float(said)
    if kind == "wall":
        wide, high = (float(s) for s in said)
        return WALL_THICK, wide, high
    wide, deep, high = (float(s) for s in said)
    return deep, wide, high


def _corners(deep: float, wide: float) -> list[tuple[float, float]]:
    x, y = deep / 2 - LEG, wide / 2 - LEG
    return [(side * x, other * y) for side in (1, -1) for other in (1, -1)]


def _cup(bullet: Any, figure: figures.Figure, size: Size, colour: str) -> None:
    """Open at the top, wider there than below, with a handle's worth of nothing: a beaker."""
    radius, high = size[1] / 2, size[2]
    outline = [
        (0.0, 0.0), (radius * 0.72, 0.0), (radius * 0.76, high * 0.04), (radius, high), (radius * 0.93, high),
        (radius * 0.68, high * 0.08), (0.0, high * 0.08),
    ]  # fmt: skip
    figure.add(figures.turned(bullet, outline, _rgb(colour, (0.95, 0.95, 0.93))), (0, 0, 0))


def _box(bullet: Any, figure: figures.Figure, size: Size, colour: str) -> None:
    figure.add(block(bullet, size, _rgb(colour, CARDBOARD)), (0, 0, size[2] / 2))


def _table(bullet: Any, figure: figures.Figure, size: Size, colour: str) -> None:
    deep, wide, high = size
    figure.add(block(bullet, (deep, wide, TOP_THICK), WOOD), (0, 0, high - TOP_THICK / 2))
    under = high - TOP_THICK
    for x, y in _corners(deep, wide):
        figure.add(block(bullet, (LEG, LEG, under), _darker(WOOD)), (x, y, under / 2))


def _wall(bullet: Any, figure: figures.Figure, size: Size, colour: str) -> None:
    figure.add(block(bullet, size, PLASTER), (0, 0, size[2] / 2))


_DRAWN = {"cup": _cup, "box": _box, "table": _table, "wall": _wall}


def block(bullet: Any, size: Sequence[float], colour: RGB) -> int:
    """A block around its middle, each side with light of its own."""
    points: list[list[float]] = []
    normals: list[list[float]] = []
    faces: list[int] = []
    for axis in range(3):
        for side in (1.0, -1.0):
            normal = [0.0, 0.0, 0.0]
            normal[axis] = side
            first = len(points)
            u, v = (axis + 1) % 3, (axis + 2) % 3
            for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
                point = [0.0, 0.0, 0.0]
                point[axis], point[u], point[v] = side * size[axis] / 2, a * size[u] / 2, b * size[v] / 2
                points.append(point)
                normals.append(normal)
            order = (0, 1, 2, 0, 2, 3) if side > 0 else (0, 2, 1, 0, 3, 2)
            faces += [first + i for i in order]
    return figures.mesh(bullet, points, faces, normals, colour)


def _rgb(colour: str, otherwise: RGB) -> RGB:
    return BALL_COLOURS.get(colour) or parse_colour(colour) or otherwise if colour else otherwise


def _darker(colour: RGB) -> RGB:
    r, g, b = (0.8 * c for c in colour)
    return r, g, b
