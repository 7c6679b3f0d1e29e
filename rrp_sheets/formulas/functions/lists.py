"""Lists."""

from __future__ import annotations

from rrp_sheets.formulas.functions.define import bounded, define, listing, number, whole
from rrp_sheets.formulas.limits import LONGEST_LIST
from rrp_sheets.formulas.problems import FormulaProblem, wrong_kind
from rrp_sheets.model.values import Value


def range_(first: Value, end: Value = None, step: Value = 1) -> list[int]:
    """Whole numbers from 0, or from the first number, up to but without the end.

    >>> range_(3), range_(1, 7, 2)
    ([0, 1, 2], [1, 3, 5])
    """
    start, stop = (0, whole(first)) if end is None else (whole(first), whole(end))
    if whole(step) == 0:
        raise FormulaProblem("FORM107", what="A step of 0 never ends")
    numbers = range(start, stop, whole(step))
    if len(numbers) > LONGEST_LIST:
        raise FormulaProblem("FORM105", reason=f"lists have at most {LONGEST_LIST} places")
    return list(numbers)


def sorted_(values: Value) -> list[Value]:
    """A list in order: numbers by size, or texts by the alphabet.

    >>> sorted_([3, 1, 2])
    [1, 2, 3]
    """
    members = listing(values)
    if all(isinstance(v, str) for v in members):
        return sorted(members, key=lambda v: (v.casefold(), v))
    return sorted(members, key=number)


def reverse(values: Value) -> list[Value]:
    """A list from its end to its beginning.

    >>> reverse([1, 2])
    [2, 1]
    """
    return list(reversed(listing(values)))


def list_(*values: Value) -> Value:
    """A list of the values.

    >>> list_(1, "two")
    [1, 'two']
    """
    if len(values) == 1 and isinstance(values[0], (list, tuple)):
        return list(values[0])
    if len(values) == 1 and not isinstance(values[0], (int, float, str)):
        raise wrong_kind("a value", values[0])
    return bounded(list(values))


FUNCTIONS = (define(range_), define(sorted_), define(reverse), define(list_))
