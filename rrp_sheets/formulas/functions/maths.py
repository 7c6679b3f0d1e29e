"""Arithmetic."""

from __future__ import annotations

import math
from collections.abc import Callable
from decimal import ROUND_DOWN, ROUND_HALF_UP, ROUND_UP, Decimal, localcontext

from rrp_sheets.formulas.functions.define import bounded, define, number, whole
from rrp_sheets.formulas.limits import LARGEST_NUMBER
from rrp_sheets.formulas.problems import FormulaProblem
from rrp_sheets.model.values import Value
from rrp_sheets.texts import N_

Number = int | float


def abs_(value: Value) -> Number:
    """A number without its sign.

    >>> abs_(-3)
    3
    """
    return abs(number(value))


def sqrt(value: Value) -> float:
    """The square root.

    >>> sqrt(16)
    4.0
    """
    n = number(value)
    if n < 0:
        raise FormulaProblem("FORM107", what=N_("There is no square root of a negative number"))
    return math.sqrt(n)


def exp(value: Value) -> float:
    """The number e to the power of a number.

    >>> exp(0)
    1.0
    """
    if number(value) > 35:
        raise FormulaProblem("FORM105", reason=N_("numbers go up to 1e15"))
    return math.exp(number(value))


def ln(value: Value) -> float:
    """The natural logarithm.

    >>> ln(1)
    0.0
    """
    if number(value) <= 0:
        raise FormulaProblem("FORM107", what=N_("There is no logarithm of zero or of a negative number"))
    return math.log(number(value))


def log10(value: Value) -> float:
    """The logarithm to base 10.

    >>> log10(1000)
    3.0
    """
    if number(value) <= 0:
        raise FormulaProblem("FORM107", what=N_("There is no logarithm of zero or of a negative number"))
    return math.log10(number(value))


def power(base: Value, exponent: Value) -> Number:
    """A number to the power of another, within the bounds of formulas.

    >>> power(2, 10), power(4, 0.5)
    (1024, 2.0)
    """
    a, b = number(base), number(exponent)
    try:
        rough: float | complex = float(a) ** float(b)
    except ZeroDivisionError:
        raise FormulaProblem("FORM101") from None
    except OverflowError:
        raise FormulaProblem("FORM105", reason=N_("numbers go up to 1e15")) from None
    if isinstance(rough, complex):
        raise FormulaProblem("FORM107", what=N_("There is no such root of a negative number"))
    if abs(rough) > 1e15:
        raise FormulaProblem("FORM105", reason=N_("numbers go up to 1e15"))
    # the rough value is within bounds, so the exact whole-number power is small too
    if isinstance(a, int) and isinstance(b, int) and b >= 0:
        exact: int = a**b
        return exact
    return rough


def round_(value: Value, places: Value = 0) -> Number:
    """A number rounded, halves away from zero, as spreadsheets do.

    >>> round_(2.5), round_(-2.5), round_(1.005, 2), round_(1234, -2)
    (3, -3, 1.01, 1200)
    """
    return _cut(value, places, ROUND_HALF_UP)


def _cut(value: Value, places: Value, how: str) -> Number:
    n, p = number(value), max(-15, min(15, whole(places)))
    with localcontext(prec=60):  # 15 digits before the point and 15 behind it, with room
        rounded = Decimal(repr(float(n))).quantize(Decimal(1).scaleb(-p), rounding=how)
    return int(rounded) if p <= 0 else float(rounded)


def roundup(value: Value, places: Value = 0) -> Number:
    """A number rounded away from zero.

    >>> roundup(2.1), roundup(-2.1), roundup(1.231, 2)
    (3, -3, 1.24)
    """
    return _cut(value, places, ROUND_UP)


def rounddown(value: Value, places: Value = 0) -> Number:
    """A number rounded towards zero.

    >>> rounddown(2.9), rounddown(-2.9), rounddown(1.239, 2)
    (2, -2, 1.23)
    """
    return _cut(value, places, ROUND_DOWN)


def int_(value: Value) -> int:
    """The whole number at or below a number.

    >>> int_(3.9), int_(-3.5)
    (3, -4)
    """
    return math.floor(number(value))


def trunc(value: Value) -> int:
    """A number without what stands after its decimal point.

    >>> trunc(-3.9)
    -3
    """
    return math.trunc(number(value))


def floor(value: Value, step: Value = 1) -> Number:
    """The whole number at or below a number, or the multiple of a step.

    >>> floor(2.7), floor(-2.1), floor(0.37, 0.25)
    (2, -3, 0.25)
    """
    return _step(value, step, math.floor)


def ceil(value: Value, step: Value = 1) -> Number:
    """The whole number at or above a number, or the multiple of a step.

    >>> ceil(2.1), ceil(-2.7), ceil(0.3, 0.25)
    (3, -2, 0.5)
    """
    return _step(value, step, math.ceil)


def mround(value: Value, step: Value) -> Number:
    """The nearest multiple of a step.

    >>> mround(17, 5), mround(0.3, 0.25)
    (15, 0.25)
    """
    return _step(value, step, lambda n: int(_cut(n, 0, ROUND_HALF_UP)))


def _step(value: Value, step: Value, how: Callable[[float], int]) -> Number:
    n, by = number(value), number(step)
    if by == 1:
        return how(n)
    if by <= 0:
        raise FormulaProblem("FORM107", what=N_("The step must be more than 0"))
    times = n / by
    if abs(times) > LARGEST_NUMBER:
        raise FormulaProblem("FORM105", reason=N_("numbers go up to 1e15"))
    # 0.3 / 0.1 is a little less than 3 to a computer
    near = round(times)
    return (near if abs(times - near) < 1e-9 else how(times)) * by


def mod(value: Value, divisor: Value) -> Number:
    """The remainder of a division.

    >>> mod(7, 3)
    1
    """
    if number(divisor) == 0:
        raise FormulaProblem("FORM101")
    return number(value) % number(divisor)


def quotient(value: Value, divisor: Value) -> int:
    """The whole number of times that a number goes into another, without the rest.

    >>> quotient(7, 3), quotient(-7, 3)
    (2, -2)
    """
    if number(divisor) == 0:
        raise FormulaProblem("FORM101")
    times: Number = bounded(number(value) / number(divisor))
    return math.trunc(times)


def iseven(value: Value) -> bool:
    """TRUE when a whole number is even.

    >>> iseven(4), iseven(3)
    (True, False)
    """
    return math.trunc(number(value)) % 2 == 0


def isodd(value: Value) -> bool:
    """TRUE when a whole number is odd.

    >>> isodd(3), isodd(4)
    (True, False)
    """
    return math.trunc(number(value)) % 2 == 1


def sign(value: Value) -> int:
    """1, 0 or -1: the sign of a number.

    >>> sign(-2.5)
    -1
    """
    n = number(value)
    return (n > 0) - (n < 0)


FUNCTIONS = (
    define(abs_, bounds=(0, math.inf)), define(sqrt, bounds=(0, math.inf)), define(exp, bounds=(0, math.inf)),
    define(ln), define(log10), define(power, "POW"), define(round_), define(roundup), define(rounddown),
    define(mround), define(int_), define(floor), define(trunc), define(ceil, "CEILING"), define(mod),
    define(quotient), define(sign, bounds=(-1, 1)), define(iseven), define(isodd),
)  # fmt: skip
