"""Sums, means and extremes, of some numbers or of lists; blanks are left out, as spreadsheets count."""

from __future__ import annotations

import math
from collections.abc import Sequence

from rrp_sheets.formulas.functions.define import bounded, define, flat, number
from rrp_sheets.formulas.functions.maths import Number
from rrp_sheets.formulas.problems import FormulaProblem
from rrp_sheets.model.values import Value
from rrp_sheets.texts import N_


def _numbers(values: tuple[Value, ...]) -> list[Number]:
    found = [number(v) for v in flat(values)]
    if not found:
        raise FormulaProblem("FORM107", what=N_("An empty list has no number"))
    return found


def _total(numbers: Sequence[Number]) -> Number:
    """Their sum. With fractions it is rounded once, at the end: Python's own `sum` does it otherwise from 3.12 on."""
    if any(isinstance(n, float) for n in numbers):
        try:
            return math.fsum(numbers)
        except (OverflowError, ValueError):  # too large on the way, or without end: no Python rounds that
            pass
    return sum(numbers)


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
    return _total([number(v) for v in flat(values)])


def average(*values: Value) -> float:
    """The mean of some numbers or of a list.

    >>> average([1, 2, 3])
    2.0
    """
    found = _numbers(values)
    return _total(found) / len(found)


def median(*values: Value) -> Number:
    """The middle one of some numbers or of a list.

    >>> median(1, 100, 2)
    2
    """
    found = sorted(_numbers(values))
    half = len(found) // 2
    return found[half] if len(found) % 2 else (found[half - 1] + found[half]) / 2


def stdev(*values: Value) -> float:
    """The standard deviation of some numbers or of a list, as of a sample.

    >>> stdev(1, 3)
    1.4142135623730951
    """
    found = _numbers(values)
    if len(found) < 2:
        raise FormulaProblem("FORM107", what=N_("A deviation needs at least two numbers"))
    mean = _total(found) / len(found)
    return math.sqrt(_total([(n - mean) ** 2 for n in found]) / (len(found) - 1))


def product(*values: Value) -> Number:
    """The product of some numbers or of a list.

    >>> product(2, 3, [4])
    24
    """
    result: Number = 1
    for v in flat(values):
        result = bounded(result * number(v))
    return result


FUNCTIONS = (
    define(min_), define(max_), define(sum_), define(product), define(average, "MEAN", "AVG"), define(median),
    define(stdev),
)  # fmt: skip
