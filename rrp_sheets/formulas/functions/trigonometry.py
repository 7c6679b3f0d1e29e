"""Sines, tangents and their inverses. Angles are in radians; `radians(30)` and `degrees(0.5)` convert."""

from __future__ import annotations

import math

from rrp_sheets.formulas.functions.define import define, number
from rrp_sheets.formulas.problems import FormulaProblem
from rrp_sheets.model.values import Value
from rrp_sheets.texts import N_


def sin(angle: Value) -> float:
    """The sine of an angle in radians.

    >>> sin(0)
    0.0
    """
    return math.sin(number(angle))


def cos(angle: Value) -> float:
    """The cosine of an angle in radians.

    >>> cos(0)
    1.0
    """
    return math.cos(number(angle))


def tan(angle: Value) -> float:
    """The tangent of an angle in radians.

    >>> tan(0)
    0.0
    """
    return math.tan(number(angle))


def asin(value: Value) -> float:
    """The angle whose sine is a number from -1 to 1.

    >>> asin(0)
    0.0
    """
    return math.asin(_share(value))


def acos(value: Value) -> float:
    """The angle whose cosine is a number from -1 to 1.

    >>> acos(1)
    0.0
    """
    return math.acos(_share(value))


def atan(value: Value) -> float:
    """The angle whose tangent is a number.

    >>> atan(0)
    0.0
    """
    return math.atan(number(value))


def radians(degrees: Value) -> float:
    """An angle given in degrees, in radians.

    >>> round(radians(180), 4)
    3.1416
    """
    return math.radians(number(degrees))


def degrees(angle: Value) -> float:
    """An angle given in radians, in degrees.

    >>> degrees(math.pi)
    180.0
    """
    return math.degrees(number(angle))


def pi() -> float:
    """The number pi.

    >>> round(pi(), 2)
    3.14
    """
    return math.pi


def _share(value: Value) -> float:
    if not -1 <= number(value) <= 1:
        raise FormulaProblem("FORM107", what=N_("{number:g} is not between -1 and 1", number=number(value)))
    return float(number(value))


FUNCTIONS = (
    define(sin, bounds=(-1, 1)), define(cos, bounds=(-1, 1)), define(tan),
    define(asin, bounds=(-math.pi / 2, math.pi / 2)), define(acos, bounds=(0, math.pi)),
    define(atan, bounds=(-math.pi / 2, math.pi / 2)), define(radians), define(degrees), define(pi),
)  # fmt: skip
