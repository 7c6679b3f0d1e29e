"""Whether conditions can hold together: `distance < 0.5` and `distance >= 0.5` cannot.

Only what is certain counts: what is not understood may hold together with anything.
"""

from __future__ import annotations

import ast
import itertools
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from rrp_sheets.checks.abstract_values import ANY, NUMBER, AbstractValue
from rrp_sheets.checks.reasoning import known_of
from rrp_sheets.formulas import Table
from rrp_sheets.model.values import Value

MOST_CASES = 12
_OPPOSITE: dict[type, type] = {
    ast.Lt: ast.GtE, ast.GtE: ast.Lt, ast.Gt: ast.LtE, ast.LtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.In: ast.NotIn, ast.NotIn: ast.In,
}  # fmt: skip
_PLAIN: dict[type, type] = {ast.Is: ast.Eq, ast.IsNot: ast.NotEq}
_MIRRORED: dict[type, type] = {ast.Lt: ast.Gt, ast.Gt: ast.Lt, ast.LtE: ast.GtE, ast.GtE: ast.LtE}
_ORDERS: dict[type, frozenset[str]] = {
    ast.Lt: frozenset("<"), ast.LtE: frozenset("<="), ast.Gt: frozenset(">"), ast.GtE: frozenset(">="),
    ast.Eq: frozenset("="), ast.NotEq: frozenset("<>"),
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Literal:
    """One condition on one thing.

    Attributes:
        about: what it is about, as a text that is the same for the same expression.
        op: a comparison, or None: whether it is true (`value` says).
        value: what it is compared with; of a comparison of two expressions it is part of `about`, and this is None.
    """

    about: str
    op: type | None
    value: Value = None
    between: bool = False


Case = tuple[Literal, ...]


def text_of(tree: ast.AST) -> str:
    """An expression as a text: equal for expressions that mean the same."""
    if isinstance(tree, ast.Constant):
        return tree.value.name if isinstance(tree.value, Table) else repr(tree.value)[:200]
    if isinstance(tree, ast.Name):
        return tree.id
    parts = [type(tree).__name__]
    for name in tree._fields:
        value = getattr(tree, name, None)
        if isinstance(value, list):
            parts.append("[" + " ".join(text_of(v) if isinstance(v, ast.AST) else repr(v) for v in value) + "]")
        elif isinstance(value, ast.AST):
            parts.append(text_of(value) if value._fields else type(value).__name__)
        elif value is not None:
            parts.append(str(value))
    return f"({' '.join(parts)})"


def cases(tree: ast.AST, wanted: bool = True) -> list[Case]:
    """In which cases a condition holds (or does not); each case is a list of conditions that all hold.

    >>> len(cases(ast.parse("x > 1 and (y or z)", mode="eval").body))
    2
    """
    if isinstance(tree, ast.UnaryOp) and isinstance(tree.op, ast.Not):
        return cases(tree.operand, not wanted)
    if isinstance(tree, ast.BoolOp):
        parts = [cases(v, wanted) for v in tree.values]
        if isinstance(tree.op, ast.And) is wanted:
            return _together(parts)
        return _limited([c for part in parts for c in part])
    if isinstance(tree, ast.Compare):
        lefts = [tree.left, *tree.comparators]
        triples = list(zip(lefts, tree.ops, tree.comparators, strict=False))
        parts = [_compared(a, type(op), b, wanted) for a, op, b in triples]
        return _together(parts) if wanted else _limited([c for part in parts for c in part])
    if isinstance(tree, ast.Constant) and type(tree.value) in (bool, int, float):
        return [()] if bool(tree.value) is wanted else []
    if isinstance(tree, ast.Call) and isinstance(tree.func, ast.Name) and tree.func.id == "ISBLANK":
        return [(Literal(text_of(tree.args[0]), ast.Eq if wanted else ast.NotEq, None),)]
    if isinstance(tree, ast.Call) and isinstance(tree.func, ast.Name) and tree.func.id == "BETWEEN":
        value, low, high = tree.args
        parts = [_compared(value, ast.GtE, low, wanted), _compared(value, ast.LtE, high, wanted)]
        return _together(parts) if wanted else _limited([c for part in parts for c in part])
    return [(Literal(text_of(tree), None, wanted),)]


def _together(parts: Sequence[list[Case]]) -> list[Case]:
    count = math.prod(len(p) for p in parts)
    if count > MOST_CASES:
        return [()]  # too many to follow: it may hold
    return [tuple(itertools.chain.from_iterable(c)) for c in itertools.product(*parts)]


def _limited(found: list[Case]) -> list[Case]:
    return found if len(found) <= MOST_CASES else [()]


def constant(tree: ast.AST) -> tuple[bool, Value]:
    """Whether an expression is always the same, and its value."""
    if isinstance(tree, ast.Constant):
        return not isinstance(tree.value, Table), tree.value
    known = known_of(tree, {})
    if known.choices is not None and len(known.choices) == 1:
        return True, known.choices[0]
    return False, None


def _compared(left: ast.AST, op: type, right: ast.AST, wanted: bool) -> list[Case]:
    op = op if wanted else _OPPOSITE[op]
    op = _PLAIN.get(op, op)
    fixed_left, a = constant(left)
    fixed_right, b = constant(right)
    if fixed_left and fixed_right:
        return [()]  # nothing depends on it here; what never holds is found by evaluating it
    if op in (ast.In, ast.NotIn):
        if fixed_right and isinstance(b, (list, tuple)) and not fixed_left:
            each: list[Case] = [(Literal(text_of(left), ast.Eq if op is ast.In else ast.NotEq, m),) for m in b]
            return _limited(each) if op is ast.In else [tuple(itertools.chain.from_iterable(each))]
        return [()]
    if fixed_right:
        return [_one(text_of(left), op, b)]
    if fixed_left:
        return [_one(text_of(right), _MIRRORED.get(op, op), a)]
    first, second = text_of(left), text_of(right)
    if first > second:
        first, second, op = second, first, _MIRRORED.get(op, op)
    return [(Literal(f"{first} ? {second}", op, between=True),)]


def _one(about: str, op: type, value: Value) -> Case:
    if isinstance(value, bool) and op in (ast.Eq, ast.NotEq):
        return (Literal(about, None, value is (op is ast.Eq)),)
    return (Literal(about, op, value),)


@dataclass(slots=True)
class _Thing:
    """What a case says about one thing."""

    low: float = -math.inf
    high: float = math.inf
    open_low: bool = False
    open_high: bool = False
    equal: list[Value] = field(default_factory=list)
    unequal: list[Value] = field(default_factory=list)
    truths: set[bool] = field(default_factory=set)
    orders: frozenset[str] = frozenset("<=>")
    number: bool = False  # compared by < or >, so a number or a text, and never blank


def can_hold(case: Iterable[Literal], given: Iterable[tuple[str, AbstractValue]] = ()) -> bool:
    """Whether conditions can hold together, when so much is known about things."""
    things: dict[str, _Thing] = {}
    for literal in case:
        _take(things.setdefault(literal.about, _Thing()), literal)
    known: dict[str, list[AbstractValue]] = {}
    for about, what in given:
        known.setdefault(about, []).append(what)
    return all(_possible(t, known.get(about, ())) for about, t in things.items())


def _take(thing: _Thing, literal: Literal) -> None:
    if literal.between:
        thing.orders &= _ORDERS.get(literal.op or ast.Eq, frozenset("<=>"))
    elif literal.op is None:
        thing.truths.add(bool(literal.value))
    elif literal.op is ast.Eq:
        thing.equal.append(literal.value)
    elif literal.op is ast.NotEq:
        thing.unequal.append(literal.value)
    elif isinstance(literal.value, (int, float)):
        _bound(thing, literal.op, float(literal.value))


def _bound(thing: _Thing, op: type, value: float) -> None:
    thing.number = True
    if op in (ast.Gt, ast.GtE) and (value > thing.low or (value == thing.low and op is ast.Gt)):
        thing.low, thing.open_low = value, op is ast.Gt
    if op in (ast.Lt, ast.LtE) and (value < thing.high or (value == thing.high and op is ast.Lt)):
        thing.high, thing.open_high = value, op is ast.Lt


def _possible(thing: _Thing, given: Sequence[AbstractValue]) -> bool:
    if len(thing.truths) > 1 or not thing.orders:
        return False
    low, high = thing.low, thing.high
    if low > high or (low == high and (thing.open_low or thing.open_high)):
        return False
    first = thing.equal[0] if thing.equal else None
    if thing.equal:
        if any(not _same(first, e) for e in thing.equal) or any(_same(first, u) for u in thing.unequal):
            return False
        if not _fits(thing, first):
            return False
    return all(_allows(known, thing) for known in given)


def _fits(thing: _Thing, value: Value) -> bool:
    """Whether a value is within the bounds, and as true as it should be."""
    if value is None:
        return not thing.number and True not in thing.truths
    if isinstance(value, (int, float)):
        if value < thing.low or (value == thing.low and thing.open_low):
            return False
        if value > thing.high or (value == thing.high and thing.open_high):
            return False
        return bool(value) in thing.truths if thing.truths else True
    return True


def _allows(known: AbstractValue, thing: _Thing) -> bool:
    """Whether one of the values that something can have is as it should be."""
    if known.choices is not None and known.choices:
        return any(_suits(c, thing) for c in known.choices)
    if known.kind != NUMBER or known.blank:
        never_blank = not known.blank and known.kind != ANY
        return not (never_blank and thing.equal and thing.equal[0] is None)
    if thing.equal and isinstance(thing.equal[0], (int, float)):
        return known.low <= thing.equal[0] <= known.high
    low, high = max(known.low, thing.low), min(known.high, thing.high)
    only_end = (thing.open_low and low == thing.low) or (thing.open_high and high == thing.high)
    return low < high or (low == high and not only_end)


def _suits(value: Value, thing: _Thing) -> bool:
    if any(not _same(value, e) for e in thing.equal) or any(_same(value, u) for u in thing.unequal):
        return False
    return _fits(thing, value)


def _same(a: Value, b: Value) -> bool:
    if isinstance(a, str) and isinstance(b, str):
        return a.casefold() == b.casefold()
    if isinstance(a, str) or isinstance(b, str) or a is None or b is None:
        return a is b
    return bool(a == b)
