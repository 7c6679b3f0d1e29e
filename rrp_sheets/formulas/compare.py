"""Comparison of two values: texts without regard to capitals, blank equal only to blank."""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable
from typing import Any

from rrp_sheets.diagnostics.phrase import Phrase, capital
from rrp_sheets.formulas.limits import Charge, free, letters, searching
from rrp_sheets.formulas.problems import FormulaProblem, kind_of, wrong_kind
from rrp_sheets.model.values import Record, Value

ORDER: dict[type, Callable[[Any, Any], bool]] = {
    ast.Lt: operator.lt, ast.LtE: operator.le, ast.Gt: operator.gt, ast.GtE: operator.ge,
}  # fmt: skip
NUMBERS = frozenset((int, float, bool))


def same(left: Value, right: Value, charge: Charge = free) -> bool:
    """Return whether two values are equal; texts are compared without regard to capitals.

    Args:
        left: a value.
        right: another.
        charge: called with the work that it took, in steps.

    >>> same("Red", "red"), same([1, "A"], [1, "a"]), same(None, 0)
    (True, True, False)
    """
    if isinstance(left, str) and isinstance(right, str):
        charge(letters(left, right))
        return left.casefold() == right.casefold()
    if isinstance(left, (list, tuple)) and isinstance(right, (list, tuple)):
        charge(len(left))
        return len(left) == len(right) and all(same(a, b, charge) for a, b in zip(left, right, strict=True))
    if isinstance(left, Record) and isinstance(right, Record):
        return left is right or _identical(left, right, charge)
    if left is None or right is None or isinstance(left, str) or isinstance(right, str):
        return left is right
    return bool(left == right)


def _identical(left: Value, right: Value, charge: Charge) -> bool:
    """Return the result of Python's `==` on what records hold, and charge for what it reads."""
    if type(left) is Record and type(right) is Record:
        charge(1 + len(left.values) // 4)
        mine, other = left.values, right.values
        return mine.keys() == other.keys() and all(_identical(v, other[k], charge) for k, v in mine.items())
    if type(left) is type(right) and isinstance(left, (list, tuple)):
        charge(len(left))
        return len(left) == len(right) and all(_identical(a, b, charge) for a, b in zip(left, right, strict=True))
    if isinstance(left, str) and isinstance(right, str):
        charge(letters(left, right))
    return bool(left == right)


def compare(op: ast.cmpop, left: Value, right: Value, charge: Charge = free) -> bool:
    """Return the result of one comparison; raises FormulaProblem when the values cannot be compared."""
    if isinstance(op, (ast.Eq, ast.Is)):
        return same(left, right, charge)
    if isinstance(op, (ast.NotEq, ast.IsNot)):
        return not same(left, right, charge)
    if isinstance(op, (ast.In, ast.NotIn)):
        if isinstance(right, (list, tuple)):
            charge(len(right))
            held = any(same(left, r, charge) for r in right)
        elif isinstance(left, str) and isinstance(right, str):
            what, text = left.casefold(), right.casefold()
            charge(searching(what, text))
            held = what in text
        else:
            raise wrong_kind("a list", right)
        return held is isinstance(op, ast.In)
    if isinstance(left, str) and isinstance(right, str):
        charge(letters(left, right))
        return ORDER[type(op)](left.casefold(), right.casefold())
    if type(left) in NUMBERS and type(right) in NUMBERS:
        return ORDER[type(op)](left, right)
    if left is None or right is None:
        raise FormulaProblem("FORM102", needed="a value to compare")
    raise FormulaProblem(
        "FORM103",
        what=Phrase("{what} cannot be compared with {kind}", what=capital(kind_of(left)), kind=kind_of(right)),
    )
