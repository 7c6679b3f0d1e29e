"""Whether a value is what a test row expects."""

from __future__ import annotations

import math
import re
from collections.abc import Callable

from rrp_sheets.checks.expecting import Expectation
from rrp_sheets.diagnostics.phrase import Phrase
from rrp_sheets.formulas import Formula
from rrp_sheets.formulas.compare import same
from rrp_sheets.formulas.evaluator import GuardedInterpreter
from rrp_sheets.model.values import Failure, Record, Value, show
from rrp_sheets.testing.results import failure_words

_DECIMAL_COMMA = re.compile(r"[+-]?\d+,\d+")
RELATIVE = 1e-9
NEAR_ZERO = 1e-12
"""Numbers that differ by less are equal: 0.1 + 0.2 - 0.3 is 0 in the eyes of people."""

Holds = Callable[[Value], str]
"""From a value to what is wrong with it, in words; an empty text when it is as expected."""


def make_holds(expectation: Expectation, interpreter: GuardedInterpreter) -> Holds:
    """What tells whether a value is as expected."""
    if expectation.kind == "any":
        return lambda value: ""
    if expectation.kind == "about":
        return _about(expectation)
    if expectation.kind == "condition":
        return _condition(expectation, interpreter)
    if expectation.kind == "fields":
        return _fields(expectation, interpreter)
    wanted = expectation.value
    if isinstance(wanted, Formula):
        wanted = wanted.prepare(interpreter)()
        if type(wanted) is Failure:
            words = failure_words(wanted)
            return lambda value: words
    return lambda value: "" if equal(value, wanted, exact=expectation.quoted) else _kind_hint(value, wanted)


def equal(value: Value, wanted: Value, *, exact: bool = False) -> bool:
    """Whether two values are equal as in formulas (capitals do not matter), numbers to 1e-9 relative.

    Args:
        value: that came.
        wanted: that was expected.
        exact: whether spaces at the ends of a text count.

    >>> equal(0.1 + 0.2, 0.3), equal("hello ", "Hello"), equal("1", 1), equal([1.0, "a"], (1, "A"))
    (True, True, False, True)
    """
    if _number(value) and _number(wanted):
        return value == wanted or math.isclose(value, wanted, rel_tol=RELATIVE, abs_tol=NEAR_ZERO)
    if isinstance(value, str) and isinstance(wanted, str):
        return same(value, wanted) if exact else same(_bare(value), _bare(wanted))
    if isinstance(value, (list, tuple)) and isinstance(wanted, (list, tuple)):
        return len(value) == len(wanted) and all(equal(a, b, exact=exact) for a, b in zip(value, wanted, strict=True))
    if isinstance(value, Record) and isinstance(wanted, Record):
        keys = value.values.keys()
        return keys == wanted.values.keys() and all(equal(value.values[k], wanted.values[k]) for k in keys)
    return same(value, wanted)


def _number(value: Value) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _bare(text: str) -> str:
    return " ".join(text.split())


def _kind_hint(value: Value, wanted: Value) -> str:
    if isinstance(value, str) and not isinstance(wanted, str) and _bare(value) == show(wanted, 60):
        return f'It is a text; write "{value}" in quotes to expect it.'
    if isinstance(wanted, str) and _number(value) and wanted == show(value):
        return Phrase("It is a number; write {wanted} without quotes to expect it.", wanted=wanted)
    if isinstance(wanted, str) and _number(value) and _DECIMAL_COMMA.fullmatch(wanted):
        return Phrase("Numbers are written with a point: {value}.", value=wanted.replace(",", "."))
    if isinstance(value, Record):
        return "It is a record; write for example any, or field=value."
    return "different"


def _about(expectation: Expectation) -> Holds:
    wanted, within = expectation.value, expectation.within
    assert isinstance(wanted, float)

    def holds(value: Value) -> str:
        if not _number(value):
            return "It is no number."
        slack = abs(wanted) * RELATIVE + NEAR_ZERO
        return "" if abs(value - wanted) <= within + slack else "different"

    return holds


def _condition(expectation: Expectation, interpreter: GuardedInterpreter) -> Holds:
    assert expectation.condition is not None
    evaluate = expectation.condition.prepare(interpreter)

    def holds(value: Value) -> str:
        result = evaluate(value)
        if type(result) is Failure:
            return Phrase("The condition cannot be worked out for it: {reason}", reason=failure_words(result))
        return "" if (result is True or (_number(result) and result != 0)) else "different"

    return holds


def _fields(expectation: Expectation, interpreter: GuardedInterpreter) -> Holds:
    parts = [(name, make_holds(one, interpreter)) for name, one in expectation.fields]

    def holds(value: Value) -> str:
        if not isinstance(value, Record):
            return "" if isinstance(value, str) and equal(value, expectation.text) else "It is no record with fields."
        for name, one in parts:
            try:
                field = value.get(name)
            except KeyError:
                return Phrase("It has no field “{name}”.", name=name)
            wrong = one(field)
            if wrong:
                return Phrase("Its {name} is {value}.", name=name, value=show(field))
        return ""

    return holds


__all__ = ["Holds", "equal", "make_holds"]
