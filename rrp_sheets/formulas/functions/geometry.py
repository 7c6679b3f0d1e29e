"""Geometry and scaling, for robots."""

from __future__ import annotations

import math

from rrp_sheets.formulas.functions.define import define, number
from rrp_sheets.formulas.problems import FormulaProblem
from rrp_sheets.model.values import Value
from rrp_sheets.texts import N_


def distance(x1: Value, y1: Value, x2: Value, y2: Value) -> float:
    """The distance between two points.

    >>> distance(0, 0, 3, 4)
    5.0
    """
    return math.hypot(number(x2) - number(x1), number(y2) - number(y1))


def hypot(x: Value, y: Value) -> float:
    """The distance of a point from the origin.

    >>> hypot(3, 4)
    5.0
    """
    return math.hypot(number(x), number(y))


def angle(x: Value, y: Value) -> float:
    """The direction of a point seen from the origin: radians, 0 is ahead (x), positive is left (y).

    >>> angle(1, 0)
    0.0
    """
    return math.atan2(number(y), number(x))


def clamp(value: Value, low: Value, high: Value) -> int | float:
    """A number, or the limit it goes beyond.

    >>> clamp(7, 0, 5), clamp(-1, 0, 5), clamp(3, 0, 5)
    (5, 0, 3)
    """
    if number(low) > number(high):
        raise FormulaProblem("FORM107", what=N_("The low limit is above the high limit"))
    return max(number(low), min(number(high), number(value)))


def scale(value: Value, from_low: Value, from_high: Value, to_low: Value, to_high: Value) -> float:
    """A number stretched from one range onto another.

    >>> scale(5, 0, 10, 0, 1)
    0.5
    """
    span = number(from_high) - number(from_low)
    if span == 0:
        raise FormulaProblem("FORM101")
    return number(to_low) + (number(value) - number(from_low)) * (number(to_high) - number(to_low)) / span


def between(value: Value, low: Value, high: Value) -> bool:
    """TRUE when a number lies between two others, or is one of them.

    >>> between(3, 1, 5), between(6, 1, 5)
    (True, False)
    """
    return number(low) <= number(value) <= number(high)


def anglediff(first: Value, second: Value) -> float:
    """The turn from the first direction to the second, the short way round, in radians.

    >>> round(anglediff(0.1, 0.4), 2), round(anglediff(3, -3), 2)
    (0.3, 0.28)
    """
    turn = (number(second) - number(first) + math.pi) % (2 * math.pi) - math.pi
    return turn + 2 * math.pi if turn < -math.pi else turn


FUNCTIONS = (
    define(distance, bounds=(0, math.inf)), define(hypot, bounds=(0, math.inf)),
    define(angle, bounds=(-math.pi, math.pi)), define(anglediff), define(clamp), define(scale), define(between),
)  # fmt: skip
