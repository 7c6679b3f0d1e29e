"""Functions that take or give lists. Where a list is asked for, a table is the list of its rows."""

from __future__ import annotations

import math

from rrp_sheets.formulas.functions.define import bounded, define, flat, listing, number, too_many, whole
from rrp_sheets.formulas.limits import LONGEST_LIST, Charge, free, letters
from rrp_sheets.formulas.operations import same
from rrp_sheets.formulas.problems import FormulaProblem, wrong_kind
from rrp_sheets.model.values import Value
from rrp_sheets.texts import N_


def range_(first: Value, end: Value = None, step: Value = 1) -> list[int]:
    """Whole numbers from 0, or from the first number, up to but without the end.

    >>> range_(3), range_(1, 7, 2)
    ([0, 1, 2], [1, 3, 5])
    """
    start, stop = (0, whole(first)) if end is None else (whole(first), whole(end))
    if whole(step) == 0:
        raise FormulaProblem("FORM107", what=N_("A step of 0 never ends"))
    numbers = range(start, stop, whole(step))
    if not -LONGEST_LIST <= (stop - start) // whole(step) <= LONGEST_LIST or len(numbers) > LONGEST_LIST:
        raise too_many()
    return list(numbers)


def sequence(count: Value, start: Value = 1, step: Value = 1) -> list[int | float]:
    """So many numbers, from 1, or from the start in steps.

    >>> sequence(3), sequence(3, 0, 0.5)
    ([1, 2, 3], [0, 0.5, 1.0])
    """
    if not 0 <= whole(count) <= LONGEST_LIST:
        raise too_many()
    first, by = number(start), number(step)
    return [bounded(first + i * by) if i else first for i in range(whole(count))]


def sorted_(values: Value, *, charge: Charge = free) -> list[Value]:
    """A list in order: numbers by size, or texts by the alphabet.

    >>> sorted_([3, 1, 2])
    [1, 2, 3]
    """
    members = listing(values)
    if all(isinstance(v, str) for v in members):
        charge(letters(*members))
        return sorted(members, key=lambda v: (v.casefold(), v))
    return sorted(members, key=number)


def reverse(values: Value) -> list[Value]:
    """A list from its end to its beginning.

    >>> reverse([1, 2])
    [2, 1]
    """
    return list(reversed(listing(values)))


def unique(values: Value, *, charge: Charge = free) -> list[Value]:
    """A list with each value once.

    >>> unique(["red", "blue", "Red"])
    ['red', 'blue']
    """
    found: list[Value] = []
    for v in listing(values):
        charge(1 + len(found) // 4)
        if not any(same(v, other, charge) for other in found):
            found.append(v)
    return found


def first(values: Value) -> Value:
    """The first member of a list, or the first row of a table.

    >>> first([3, 1, 2])
    3
    """
    return _some(values)[0]


def last(values: Value) -> Value:
    """The last member of a list, or the last row of a table.

    >>> last([3, 1, 2])
    2
    """
    return _some(values)[-1]


def _some(values: Value) -> list[Value] | tuple[Value, ...]:
    members = listing(values)
    if not members:
        raise FormulaProblem("FORM107", what=N_("There is nothing in the list"))
    return members


def take(values: Value, count: Value) -> list[Value]:
    """The first members of a list; with a negative number, the last ones.

    >>> take([1, 2, 3], 2), take([1, 2, 3], -1)
    ([1, 2], [3])
    """
    members, n = listing(values), whole(count)
    return list(members[:n] if n >= 0 else members[n:])


def drop(values: Value, count: Value) -> list[Value]:
    """A list without its first members; with a negative number, without its last ones.

    >>> drop([1, 2, 3], 1), drop([1, 2, 3], -1)
    ([2, 3], [1, 2])
    """
    members, n = listing(values), whole(count)
    return list(members[n:] if n >= 0 else members[:n])


def list_(*values: Value) -> list[Value]:
    """A list of the values.

    >>> list_(1, "two"), list_([1], "two")
    ([1, 'two'], [[1], 'two'])
    """
    if len(values) == 1 and isinstance(values[0], (list, tuple)):
        return list(values[0])
    if len(values) == 1 and not isinstance(values[0], (int, float, str)):
        raise wrong_kind(N_("a value"), values[0])
    members = list(values)
    bounded(members)
    return members


def count(*values: Value) -> int:
    """Count the numbers among some values or in a list.

    >>> count([1, 2, "three"])
    2
    """
    return sum(1 for v in flat(values) if isinstance(v, (int, float)) and not isinstance(v, bool))


def counta(*values: Value) -> int:
    """Count the values that are not blank.

    >>> counta([1, None, "three"])
    2
    """
    return len(flat(values))


def countif(values: Value, what: Value, *, charge: Charge = free) -> int:
    """Count the members of a list that equal a value; to count by a condition, write SUM([x > 3 for x in list]).

    >>> countif(["red", "blue", "Red"], "red")
    2
    """
    if isinstance(what, str) and what[:1] in ("<", ">", "="):
        advice = N_("COUNTIF counts what is equal; for a condition write SUM([x > 3 for x in list])")
        raise FormulaProblem("FORM107", what=advice)
    return sum(1 for v in listing(values) if same(v, what, charge))


def all_(values: Value) -> bool:
    """TRUE when all members of a list hold.

    >>> all_([True, 1])
    True
    """
    return all(bool(number(v)) for v in listing(values))


def any_(values: Value) -> bool:
    """TRUE when at least one member of a list holds.

    >>> any_([False, 0, True])
    True
    """
    return any(bool(number(v)) for v in listing(values))


FUNCTIONS = (
    define(range_), define(sequence), define(sorted_, "SORT"), define(reverse), define(unique), define(first),
    define(last), define(take), define(drop), define(list_), define(count, bounds=(0, math.inf)), define(counta),
    define(countif), define(all_), define(any_),
)  # fmt: skip
