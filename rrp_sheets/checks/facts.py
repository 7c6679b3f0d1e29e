"""Facts about values before the run: of sensors and other streams, and of formulas without evaluating them."""

from __future__ import annotations

import ast
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import reduce

from rrp_sheets.formulas import HelperDef, Table
from rrp_sheets.formulas.parsing import IfError, Join, Pick, Switch
from rrp_sheets.formulas.problems import kind_of_value
from rrp_sheets.graph import Stream, StreamKind
from rrp_sheets.model.exchange import DONE
from rrp_sheets.model.names import key
from rrp_sheets.model.values import Field, Record, RecordType, Value
from rrp_sheets.robots import Robot

MOST_CHOICES = 100
NUMBER, TEXT, TRUTH, LIST, RECORD, BLANK, ANY = "number", "text", "truth", "list", "record", "blank", "any"


@dataclass(frozen=True, slots=True)
class AbstractValue:
    """Knowledge about a value before the run."""

    kind: str = ANY  # one of `NUMBER`, `TEXT`, `TRUTH`, `LIST`, `RECORD` and `BLANK`; `ANY` when it is not known
    record: RecordType | None = None
    # what is known about a record's fields, by key, where it is more than their type says
    fields: Mapping[str, AbstractValue] = field(default_factory=dict)
    low: float = -math.inf  # bounds of a number, in its `unit`; infinite when not known
    high: float = math.inf
    # all the values that it can have; None when there are too many, or when they are not known
    choices: tuple[Value, ...] | None = None
    unit: str = ""
    blank: bool = False  # it may be blank besides
    members: tuple[AbstractValue, ...] = ()  # of a list that is written out: what is known about each place

    @property
    def bounded(self) -> bool:
        """True for a number that has bounds on both sides."""
        return self.kind == NUMBER and math.isfinite(self.low) and math.isfinite(self.high)

    def at(self, name: str) -> AbstractValue:
        """Return what is known about a field."""
        if self.record is None:
            return UNKNOWN
        k = self.record.keys.get(key(name), "")
        if k in self.fields:
            return self.fields[k]
        if self.choices is not None:
            return one_of(c.values.get(k) for c in self.choices if isinstance(c, Record))
        found = self.record.field(name)
        return UNKNOWN if found is None else of_field(found)


UNKNOWN = AbstractValue()


def of_field(f: Field) -> AbstractValue:
    """Return what a record type says about one of its fields."""
    if isinstance(f.example, Record):
        return AbstractValue(RECORD, f.example.type)
    if f.choices:
        return one_of(f.choices)
    if f.kind == NUMBER:
        return AbstractValue(NUMBER, low=f.lower, high=f.upper, unit=f.unit)
    return AbstractValue(f.kind, unit=f.unit) if f.kind in (TEXT, TRUTH) else UNKNOWN


def exactly(value: Value) -> AbstractValue:
    """Return the abstract value of a single known value.

    >>> exactly(3).low, exactly("red").choices
    (3.0, ('red',))
    """
    known = kind_of_value(value)
    if known == NUMBER:
        return AbstractValue(known, low=float(value), high=float(value), choices=(value,))
    record = value.type if isinstance(value, Record) else None
    return AbstractValue(known, record, choices=(value,), blank=value is None)


def number_within(low: float, high: float, unit: str = "") -> AbstractValue:
    """Return an abstract number within bounds; a bound that is NaN (∞ - ∞) counts as none.

    >>> number_within(0, 1).bounded, number_within(2, 2).choices, number_within(float("nan"), 1).low
    (True, (2,), -inf)
    """
    low = -math.inf if math.isnan(low) else low
    high = math.inf if math.isnan(high) else high
    choices = (low,) if low == high and math.isfinite(low) else None
    return AbstractValue(NUMBER, low=low, high=high, choices=choices, unit=unit)


def one_of(values: Iterable[Value]) -> AbstractValue:
    """Return the abstract value that covers all of these values."""
    known = [exactly(value) for value in values]
    return reduce(either, known) if known else UNKNOWN


def either(first: AbstractValue, second: AbstractValue) -> AbstractValue:
    """Return the abstract value that covers both.

    >>> either(exactly(1), exactly(3)).high, either(exactly(1), exactly("a")).kind
    (3.0, 'any')
    """
    choices = None
    if first.choices is not None and second.choices is not None:
        more = [c for c in second.choices if not any(type(c) is type(o) and c == o for o in first.choices)]
        choices = (*first.choices, *more) if len(first.choices) + len(more) <= MOST_CHOICES else None
    if BLANK in (first.kind, second.kind):
        other = second if first.kind == BLANK else first
        return replace(other, choices=choices, blank=True)
    blank = first.blank or second.blank
    if first.kind != second.kind:
        return AbstractValue(choices=choices, blank=blank)
    unit = first.unit if first.unit == second.unit else first.unit or second.unit
    record = _common(first.record, second.record)
    fields = {k: either(v, second.fields[k]) for k, v in first.fields.items() if k in second.fields} if record else {}
    low, high = min(first.low, second.low), max(first.high, second.high)
    members: tuple[AbstractValue, ...] = ()
    if len(first.members) == len(second.members):
        members = tuple(either(a, b) for a, b in zip(first.members, second.members, strict=True))
    return AbstractValue(first.kind, record, fields, low, high, choices, unit, blank, members)


def _common(first: RecordType | None, second: RecordType | None) -> RecordType | None:
    """Return a record type for both, or None; types with the same fields are joined (a red and a green ball)."""
    if first is None or second is None or first == second:
        return first if first == second else None
    if first.fields != second.fields or first.positions != second.positions:
        return None
    return replace(first, name=f"{first.name} or {second.name}")


def not_blank(known: AbstractValue) -> AbstractValue:
    """Return the abstract value without a possible blank; one that is always blank stays as it is."""
    if known.kind == BLANK or not known.blank:
        return known
    kept = None if known.choices is None else tuple(c for c in known.choices if c is not None)
    return replace(known, choices=kept, blank=False)


CAMERA, CHANGE, EVENT, TIMER = "camera", "change", "event", "timer"
_ON_CHANGE = ("joint", "inertia")  # kinds of perception that tell only what is new
_JOINT_EXAMPLE = 0.1  # rad; not 0, by which one cannot divide


@dataclass(frozen=True, slots=True)
class Rate:
    """Frequency of a stream's values: at most `hz` a second, 0 when nothing can be said.

    The kind is `camera` (again and again, as pictures are looked at), `change` (when something is new), `event` (when
    somebody does something), `timer`; or empty when it is not known.
    """

    kind: str = ""
    hz: float = 0.0


@dataclass(frozen=True, slots=True)
class Fact:
    """Knowledge about a stream before the run; its example may be blank."""

    known: AbstractValue = UNKNOWN
    has_example: bool = False
    example: Value = None
    # False when the example went through a filter that does not let it pass: it shows the kind of value only
    sure: bool = True
    holes: bool = False  # whether the example is a record of which some fields are not known
    others: tuple[Value, ...] = ()  # examples of another type that the stream has besides (of a merge)
    rate: Rate = field(default_factory=Rate)


def sensor_fact(stream: Stream, robot: Robot) -> Fact:
    """Return the fact about a sensor's stream, or about the done stream of an actuator."""
    if stream.kind is StreamKind.DONE:
        return Fact(AbstractValue(RECORD, DONE), True, DONE.example(), holes=True, rate=Rate(EVENT))
    assert stream.device is not None
    kind = stream.device.type
    rate = _rate(stream, robot)
    if kind.payload is None:
        joint = robot.joints.get(key(str(stream.settings.get("joint"))))
        if joint is None:
            return Fact(AbstractValue(NUMBER, unit=kind.unit), True, _JOINT_EXAMPLE, rate=rate)
        example = min(max(_JOINT_EXAMPLE, joint.lower), joint.upper)
        return Fact(AbstractValue(NUMBER, low=joint.lower, high=joint.upper, unit=joint.unit), True, example, rate=rate)
    settings = stream.settings
    # the fields with choices, then those that the settings decide
    said = {key(f.name): of_field(f) for f in kind.payload.fields if f.choices}
    if settings.get("label"):
        said["label"] = exactly(settings["label"])
    if "zone" in settings:
        said["zone"] = exactly(settings["zone"]) if settings["zone"] else one_of(robot.touch_zones)
    words = settings.get("words")
    if isinstance(words, (list, tuple)) and words:
        said["word"] = one_of(words)
    fields = {k: known for k, known in said.items() if k in kind.payload.keys.values()}
    values = dict(kind.payload.example().values)
    for k, known in fields.items():
        if known.choices and values.get(k) not in known.choices:
            values[k] = known.choices[0]
    return Fact(AbstractValue(RECORD, kind.payload, fields), True, Record(kind.payload, values), rate=rate)


def _rate(stream: Stream, robot: Robot) -> Rate:
    assert stream.device is not None
    every, rate = stream.settings.get("every"), stream.settings.get("rate")
    if isinstance(every, (int, float)) and every > 0:
        return Rate(TIMER, 1_000_000 / every)
    if not isinstance(rate, (int, float)):
        return Rate(EVENT)
    name = stream.device.type.name
    entry: Mapping[str, object] = next((s for s in robot.data["sensor"] if s["name"] == name), {})
    return Rate(CHANGE if entry.get("perception") in _ON_CHANGE else CAMERA, float(rate))


def fastest(rates: list[Rate]) -> Rate:
    """Return the rate of a row that takes the values of several streams: the highest of theirs."""
    return max(rates, key=lambda r: r.hz, default=Rate())


def slower(rate: Rate, period_us: int | None) -> Rate:
    """Return the rate behind a sample or throttle with this period."""
    limit = 1_000_000 / period_us if period_us else 0.0
    hz = min(rate.hz, limit) if rate.hz and limit else rate.hz or limit
    return replace(rate, hz=hz)


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
    return _of(tree, _Env(names))


@dataclass(slots=True)
class _Env:
    """The names in scope; the nodes that may still be visited, and the depth, which bound helpers that call helpers."""

    names: Names
    left: int = MOST_STEPS
    deep: int = 0


def _of(tree: ast.AST | None, env: _Env) -> AbstractValue:
    found = _NODES.get(type(tree))
    env.left -= 1
    if found is None or env.left < 0 or env.deep >= MOST_DEEP:
        return UNKNOWN
    env.deep += 1
    known: AbstractValue = found(tree, env)
    env.deep -= 1
    return known


def _always(kind: str) -> Callable[[ast.AST, _Env], AbstractValue]:
    known = AbstractValue(kind)
    return lambda node, env: known


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
    return one_of(m for members in lists or () if isinstance(members, (list, tuple)) for m in members)


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


def _list(node: ast.List | ast.Tuple, env: _Env) -> AbstractValue:
    members = tuple(_of(e, env) for e in node.elts)
    if all(m.choices is not None and len(m.choices) == 1 for m in members):
        return AbstractValue(LIST, choices=([m.choices[0] for m in members if m.choices],), members=members)
    return AbstractValue(LIST, members=members)


def _unary(node: ast.UnaryOp, env: _Env) -> AbstractValue:
    if isinstance(node.op, ast.Not):
        return AbstractValue(TRUTH)
    value = _of(node.operand, env)
    low, high = (value.low, value.high) if isinstance(node.op, ast.UAdd) else (-value.high, -value.low)
    return number_within(low, high, value.unit)


def _binop(node: ast.BinOp, env: _Env) -> AbstractValue:
    left, right = _of(node.left, env), _of(node.right, env)
    if isinstance(node.op, (ast.Add, ast.Mult)) and {left.kind, right.kind} & {TEXT, LIST}:
        return AbstractValue(left.kind if left.kind in (TEXT, LIST) else right.kind)
    if isinstance(node.op, ast.Add) and NUMBER not in (left.kind, right.kind):
        return UNKNOWN  # two texts, as far as is known
    unit = (left.unit or right.unit) if isinstance(node.op, (ast.Add, ast.Sub)) else ""
    return number_within(*_bounds(node.op, left, right), unit)


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
    """Derive what is known about a member of a list, or about a row of a table."""
    if isinstance(node, ast.Constant) and isinstance(node.value, Table):
        rows = one_of(node.value.rows[:1])  # all rows are alike, and there may be many
        return replace(rows, choices=node.value.rows) if node.value.rows else UNKNOWN
    return _member(_of(node, env).choices)


def _call(node: ast.Call, env: _Env) -> AbstractValue:
    helper: HelperDef | None = getattr(node, "helper", None)
    if helper is not None:
        given = {p.name: _of(a, env) for p, a in zip(helper.parameters, node.args, strict=True)}
        outer, env.names = env.names, given
        known = _of(helper.tree, env) if helper.tree else UNKNOWN
        env.names = outer
        return known
    name = node.func.id if isinstance(node.func, ast.Name) else ""
    if name in _SPECIAL:
        return _SPECIAL[name](node, env)
    gives: str | tuple[float, float] = getattr(node, "gives", "any")
    return AbstractValue(gives) if isinstance(gives, str) else number_within(*gives)


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
    source = node.args[0]
    if isinstance(source, ast.Constant) and isinstance(source.value, (Table, list, tuple)):
        return exactly(len(source.value))
    return number_within(0, 1_000)


def _radians(node: ast.Call, env: _Env) -> AbstractValue:
    value = _of(node.args[0], env)
    scale = math.radians if isinstance(node.func, ast.Name) and node.func.id == "RADIANS" else math.degrees
    return number_within(scale(value.low), scale(value.high))


_SPECIAL: dict[str, Callable[[ast.Call, _Env], AbstractValue]] = {
    "XLOOKUP": _xlookup, "CLAMP": _clamp, "MIN": _extreme, "MAX": _extreme, "ROWS": _length,
    "RADIANS": _radians, "DEGREES": _radians,
    **dict.fromkeys(("INDEX", "FIRST", "LAST"), lambda node, env: _among(node.args[0], env)),
}  # fmt: skip
_NODES: dict[type, Callable[..., AbstractValue]] = {
    ast.Constant: lambda node, env: UNKNOWN if isinstance(node.value, Table) else exactly(node.value),
    ast.Name: lambda node, env: env.names.get(node.id, UNKNOWN),
    ast.Attribute: lambda node, env: _of(node.value, env).at(node.attr),
    ast.Subscript: _subscript, ast.IfExp: _ifexp, IfError: _iferror, ast.List: _list, ast.Tuple: _list,
    Switch: lambda node, env: reduce(either, [_of(r, env) for r in (*node.results, node.otherwise) if r is not None]),
    ast.UnaryOp: _unary, ast.BinOp: _binop, ast.Call: _call, Pick: _pick, ast.Compare: _always(TRUTH),
    ast.BoolOp: _always(TRUTH), ast.JoinedStr: _always(TEXT), Join: _always(TEXT), ast.ListComp: _always(LIST),
}  # fmt: skip
