"""Arithmetic and statistics."""

from __future__ import annotations

import math
from decimal import ROUND_HALF_UP, Decimal, localcontext

from rrp_sheets.formulas.functions.define import define, flat, listing, number, whole
from rrp_sheets.formulas.problems import FormulaProblem
from rrp_sheets.model.values import Value

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
        raise FormulaProblem("FORM107", what="There is no square root of a negative number")
    return math.sqrt(n)


def exp(value: Value) -> float:
    """The number e to the power of a number.

    >>> exp(0)
    1.0
    """
    if number(value) > 35:
        raise FormulaProblem("FORM105", reason="numbers go up to 1e15")
    return math.exp(number(value))


def ln(value: Value) -> float:
    """The natural logarithm.

    >>> ln(1)
    0.0
    """
    if number(value) <= 0:
        raise FormulaProblem("FORM107", what="There is no logarithm of zero or of a negative number")
    return math.log(number(value))


def log10(value: Value) -> float:
    """The logarithm to base 10.

    >>> log10(1000)
    3.0
    """
    if number(value) <= 0:
        raise FormulaProblem("FORM107", what="There is no logarithm of zero or of a negative number")
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
        raise FormulaProblem("FORM105", reason="numbers go up to 1e15") from None
    if isinstance(rough, complex):
        raise FormulaProblem("FORM107", what="There is no such root of a negative number")
    if abs(rough) > 1e15:
        raise FormulaProblem("FORM105", reason="numbers go up to 1e15")
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
    n, p = number(value), max(-15, min(15, whole(places)))
    with localcontext(prec=60):  # 15 digits before the point and 15 behind it, with room
        rounded = Decimal(repr(float(n))).quantize(Decimal(1).scaleb(-p), rounding=ROUND_HALF_UP)
    return int(rounded) if p <= 0 else float(rounded)


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


def ceil(value: Value) -> int:
    """The whole number at or above a number.

    >>> ceil(2.1)
    3
    """
    return math.ceil(number(value))


def mod(value: Value, divisor: Value) -> Number:
    """The remainder of a division.

    >>> mod(7, 3)
    1
    """
    if number(divisor) == 0:
        raise FormulaProblem("FORM101")
    return number(value) % number(divisor)


def sign(value: Value) -> int:
    """1, 0 or -1: the sign of a number.

    >>> sign(-2.5)
    -1
    """
    n = number(value)
    return (n > 0) - (n < 0)


def _numbers(values: tuple[Value, ...]) -> list[Number]:
    found = [number(v) for v in flat(values)]
    if not found:
        raise FormulaProblem("FORM107", what="There is no number in an empty list")
    return found


def min_(*values: Value) -> Number:
    """The smallest of some numbers or of a list.

    >>> min_(3, [1, 2])
    1
    """
    return min(_numbers(values))


def max_(*values: Value) -> Number:
    """The largest of some numbers or of a list.

    >>> max_(3, [1, 2])
    3
    """
    return max(_numbers(values))


def sum_(*values: Value) -> Number:
    """The sum of some numbers or of a list.

    >>> sum_(1, 2, [3, 4])
    10
    """
    return sum(number(v) for v in flat(values))


def average(*values: Value) -> float:
    """The mean of some numbers or of a list.

    >>> average([1, 2, 3])
    2.0
    """
    found = _numbers(values)
    return sum(found) / len(found)


def median(*values: Value) -> Number:
    """The middle one of some numbers or of a list.

    >>> median(1, 100, 2)
    2
    """
    found = sorted(_numbers(values))
    half = len(found) // 2
    return found[half] if len(found) % 2 else (found[half - 1] + found[half]) / 2


def count(*values: Value) -> int:
    """How many numbers there are among some values or in a list.

    >>> count([1, 2, "three"])
    2
    """
    return sum(1 for v in flat(values) if isinstance(v, (int, float)) and not isinstance(v, bool))


def all_(values: Value) -> bool:
    """Whether all members of a list hold.

    >>> all_([True, 1])
    True
    """
    return all(bool(number(v)) for v in listing(values))


def any_(values: Value) -> bool:
    """Whether at least one member of a list holds.

    >>> any_([False, 0, True])
    True
    """
    return any(bool(number(v)) for v in listing(values))


FUNCTIONS = (
    define(abs_), define(sqrt), define(exp), define(ln), define(log10), define(power, "POW"), define(round_),
    define(int_, "FLOOR"), define(trunc), define(ceil, "CEILING"), define(mod), define(sign), define(min_),
    define(max_), define(sum_), define(average, "MEAN", "AVG"), define(median), define(count), define(all_),
    define(any_),
)  # fmt: skip
