"""Derives what is known about a formula's value from what is known about its inputs, without evaluating it."""

from __future__ import annotations

import ast
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import reduce

from rrp_sheets.checks.facts import (
    ANY,
    BLANK,
    LIST,
    NUMBER,
    TEXT,
    TRUTH,
    UNKNOWN,
    AbstractValue,
    either,
    exactly,
    number_within,
    one_of,
)
from rrp_sheets.formulas import HelperDef, Table
from rrp_sheets.formulas.nodes import IfError, Join, Pick, Switch
from rrp_sheets.model.values import Value

Names = Mapping[str, AbstractValue]
MOST_STEPS = 2_000
MOST_DEEP = 100
"""Nodes within nodes, those of helpers included: far fewer than Python's own limit, whoever calls."""


def known_of(tree: ast.AST, names: Names) -> AbstractValue:
    """Return what is known about the value of a resolved tree; `names` are its inputs.

    >>> from rrp_sheets.formulas import compile_formula, make_scope
    >>> tree = compile_formula("CLAMP(x * 2, 0, 1) + 1", make_scope([("X", None)])).tree
    >>> known = known_of(tree, {"x": UNKNOWN}); known.kind, known.low, known.high
    ('number', 1.0, 2.0)
    """
    return _of(tree, _Env(names, _Budget()))


@dataclass(slots=True)
class _Budget:
    """The nodes that may still be visited, and the current depth; both bound helpers that call helpers."""

    left: int = MOST_STEPS
    deep: int = 0


@dataclass(frozen=True, slots=True)
class _Env:
    """The names in scope, and the rest of the budget."""

    names: Names
    budget: _Budget


def _of(tree: ast.AST | None, env: _Env) -> AbstractValue:
    found, budget = _NODES.get(type(tree)), env.budget
    budget.left -= 1
    if found is None or budget.left < 0 or budget.deep >= MOST_DEEP:
        return UNKNOWN
    budget.deep += 1
    known: AbstractValue = found(tree, env)
    budget.deep -= 1
    return known


def _always(kind: str) -> Callable[[ast.AST, _Env], AbstractValue]:
    known = AbstractValue(kind)
    return lambda node, env: known


def _constant(node: ast.Constant, env: _Env) -> AbstractValue:
    return UNKNOWN if isinstance(node.value, Table) else exactly(node.value)


def _name(node: ast.Name, env: _Env) -> AbstractValue:
    return env.names.get(node.id, UNKNOWN)


def _attribute(node: ast.Attribute, env: _Env) -> AbstractValue:
    return _of(node.value, env).at(node.attr)


def _subscript(node: ast.Subscript, env: _Env) -> AbstractValue:
    owner = _of(node.value, env)
    place = node.slice.value if isinstance(node.slice, ast.Constant) else None
    if owner.record is not None and isinstance(place, str):
        return owner.at(place)
    if owner.record is not None and type(place) is int and -len(owner.record.positions) <= place:
        return owner.at(owner.record.positions[place]) if place < len(owner.record.positions) else UNKNOWN
    if owner.members and type(place) is int:
        return owner.members[place] if -len(owner.members) <= place < len(owner.members) else UNKNOWN
    return _member(owner.choices) if owner.kind == LIST else AbstractValue(TEXT) if owner.kind == TEXT else UNKNOWN


def _member(lists: tuple[Value, ...] | None) -> AbstractValue:
    """Return what is known about a member of one of these lists."""
    if lists is None:
        return UNKNOWN
    return one_of(m for members in lists if isinstance(members, (list, tuple)) for m in members)


def _ifexp(node: ast.IfExp, env: _Env) -> AbstractValue:
    held = _holds(node.test, env)
    if held is not None:
        return _of(node.body if held else node.orelse, env)
    return either(_of(node.body, env), _of(node.orelse, env))


def _holds(test: ast.AST, env: _Env) -> bool | None:
    """Return whether a condition is certain to hold: `ISBLANK(start)` of a known blank; None when it is uncertain."""
    if isinstance(test, ast.UnaryOp) and isinstance(test.op, ast.Not):
        held = _holds(test.operand, env)
        return None if held is None else not held
    if isinstance(test, ast.BoolOp):
        parts = [_holds(v, env) for v in test.values]
        wanted = isinstance(test.op, ast.Or)
        return wanted if wanted in parts else None if None in parts else not wanted
    if isinstance(test, ast.Call) and isinstance(test.func, ast.Name) and test.func.id == "ISBLANK":
        value = _of(test.args[0], env)
        return True if value.kind == BLANK else None if value.blank or value.kind == ANY else False
    return None


def _iferror(node: IfError, env: _Env) -> AbstractValue:
    if node.otherwise is None:
        return AbstractValue(TRUTH)  # ISERROR
    return either(_of(node.value, env), _of(node.otherwise, env))


def _switch(node: Switch, env: _Env) -> AbstractValue:
    return reduce(either, [_of(r, env) for r in (*node.results, node.otherwise) if r is not None])


def _list(node: ast.List | ast.Tuple, env: _Env) -> AbstractValue:
    members = tuple(_of(e, env) for e in node.elts)
    if all(m.choices is not None and len(m.choices) == 1 for m in members):
        return AbstractValue(LIST, choices=([m.choices[0] for m in members if m.choices],), members=members)
    return AbstractValue(LIST, members=members)


def _unary(node: ast.UnaryOp, env: _Env) -> AbstractValue:
    if isinstance(node.op, ast.Not):
        return AbstractValue(TRUTH)
    value = _of(node.operand, env)
    if isinstance(node.op, ast.UAdd):
        return number_within(value.low, value.high, value.unit)
    return number_within(-value.high, -value.low, value.unit)


def _binop(node: ast.BinOp, env: _Env) -> AbstractValue:
    left, right = _of(node.left, env), _of(node.right, env)
    if isinstance(node.op, (ast.Add, ast.Mult)) and {left.kind, right.kind} & {TEXT, LIST}:
        return AbstractValue(left.kind if left.kind in (TEXT, LIST) else right.kind)
    if isinstance(node.op, ast.Add) and NUMBER not in (left.kind, right.kind):
        return UNKNOWN  # two texts, as far as is known
    low, high = _bounds(node.op, left, right)
    unit = (left.unit or right.unit) if isinstance(node.op, (ast.Add, ast.Sub)) else ""
    return number_within(low, high, unit)


def _bounds(op: ast.operator, left: AbstractValue, right: AbstractValue) -> tuple[float, float]:
    if isinstance(op, ast.Add):
        return left.low + right.low, left.high + right.high
    if isinstance(op, ast.Sub):
        return left.low - right.high, left.high - right.low
    if isinstance(op, (ast.Mult, ast.Div)) and left.bounded and right.bounded:
        if isinstance(op, ast.Div) and right.low <= 0 <= right.high:
            return -math.inf, math.inf
        pairs = [(a, b) for a in (left.low, left.high) for b in (right.low, right.high)]
        ends = [a * b if isinstance(op, ast.Mult) else a / b for a, b in pairs]
        return min(ends), max(ends)
    return -math.inf, math.inf


def _pick(node: Pick, env: _Env) -> AbstractValue:
    if len(node.members) == 1:
        return _among(node.members[0], env)
    return reduce(either, [_of(m, env) for m in node.members])


def _among(node: ast.AST, env: _Env) -> AbstractValue:
    """Return what is known about a member of a list, or about a row of a table."""
    if isinstance(node, ast.Constant) and isinstance(node.value, Table):
        rows = one_of(node.value.rows[:1])  # all rows are alike, and there may be many
        return replace(rows, choices=node.value.rows) if node.value.rows else UNKNOWN
    return _member(_of(node, env).choices)


def _call(node: ast.Call, env: _Env) -> AbstractValue:
    helper: HelperDef | None = getattr(node, "helper", None)
    if helper is not None:
        given = {p.name: _of(a, env) for p, a in zip(helper.parameters, node.args, strict=True)}
        return _of(helper.tree, _Env(given, env.budget)) if helper.tree else UNKNOWN
    name = node.func.id if isinstance(node.func, ast.Name) else ""
    if name in _SPECIAL:
        return _SPECIAL[name](node, env)
    gives: str | tuple[float, float] = getattr(node, "gives", "any")
    return AbstractValue(gives) if isinstance(gives, str) else number_within(*gives)


def _index(node: ast.Call, env: _Env) -> AbstractValue:
    return _among(node.args[0], env)


def _xlookup(node: ast.Call, env: _Env) -> AbstractValue:
    found = _among(node.args[2], env)
    return either(found, _of(node.args[3], env)) if len(node.args) > 3 else found


def _clamp(node: ast.Call, env: _Env) -> AbstractValue:
    value, low, high = (_of(a, env) for a in node.args)
    return number_within(min(max(value.low, low.low), high.low), min(max(value.high, low.high), high.high), value.unit)


def _extreme(node: ast.Call, env: _Env) -> AbstractValue:
    found = [_of(a, env) for a in node.args]
    if len(found) < 2 or any(f.kind != NUMBER or f.blank for f in found):
        return AbstractValue(NUMBER) if len(found) > 1 else _member(found[0].choices)
    best = min if isinstance(node.func, ast.Name) and node.func.id == "MIN" else max
    return number_within(best(f.low for f in found), best(f.high for f in found), found[0].unit)


def _length(node: ast.Call, env: _Env) -> AbstractValue:
    """Return what is known about ROWS: a constant for a table or list that is known."""
    source = node.args[0]
    if isinstance(source, ast.Constant) and isinstance(source.value, (Table, list, tuple)):
        return exactly(len(source.value))
    return number_within(0, 1_000)


def _radians(node: ast.Call, env: _Env) -> AbstractValue:
    value = _of(node.args[0], env)
    scale = math.radians if isinstance(node.func, ast.Name) and node.func.id == "RADIANS" else math.degrees
    return number_within(scale(value.low), scale(value.high))


_SPECIAL: dict[str, Callable[[ast.Call, _Env], AbstractValue]] = {
    "INDEX": _index, "XLOOKUP": _xlookup, "CLAMP": _clamp, "MIN": _extreme, "MAX": _extreme, "ROWS": _length,
    "RADIANS": _radians, "DEGREES": _radians, "FIRST": _index, "LAST": _index,
}  # fmt: skip
_NODES: dict[type, Callable[..., AbstractValue]] = {
    ast.Constant: _constant, ast.Name: _name, ast.Attribute: _attribute, ast.Subscript: _subscript, ast.IfExp: _ifexp,
    IfError: _iferror, Switch: _switch, ast.List: _list, ast.Tuple: _list, ast.UnaryOp: _unary, ast.BinOp: _binop,
    ast.Call: _call, Pick: _pick, ast.Compare: _always(TRUTH), ast.BoolOp: _always(TRUTH), ast.JoinedStr: _always(TEXT),
    Join: _always(TEXT), ast.ListComp: _always(LIST),
}  # fmt: skip
