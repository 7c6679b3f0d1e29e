"""Routes of values from events through filters to rows, and the conditions that must hold together on them.

A route is one way from an origin (a sensor stream, a done stream, or the clock of a row that holds values back) to a
stream. Two rows act at one instant when they have routes from one origin whose conditions can hold together.
"""

from __future__ import annotations

import ast
import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

from rrp_sheets.checks.facts import ANY, NUMBER, UNKNOWN, AbstractValue, Fact, exactly, known_of
from rrp_sheets.formulas import Formula, HelperDef, Table
from rrp_sheets.formulas.operations import same
from rrp_sheets.formulas.parsing import Pick
from rrp_sheets.graph import Graph, Step, StreamKind
from rrp_sheets.model.values import Value

MOST_ROUTES = 16
MOST_FILTERS = 20  # of one route; the earlier ones are forgotten
MOST_NODES = 60  # of an expression that is followed through several rows
MOST_COMBINATIONS = 64
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
class Route:
    """One way in which a stream gets a value."""

    origin: str  # the id of a sensor or done stream, or `clock` and the ref of a row
    filters: tuple[str, ...] = ()  # refs of the filter rows on the way
    # what is known about values on this way alone: an accumulate gives 1, say, when a certain input arrives
    given: tuple[tuple[str, AbstractValue], ...] = ()
    # origins, with the filters after them, that have given nothing for a while (forgetAfter)
    silent: tuple[tuple[str, frozenset[str]], ...] = ()

    def waits_for(self, other: Route) -> bool:
        """Return whether this route has values only while the other one has none."""
        return any(other.origin == origin and filters <= set(other.filters) for origin, filters in self.silent)


class Paths:
    """The routes of all streams of a workbook, with the conditions of the filters on them."""

    def __init__(self, graph: Graph, formulas: Mapping[str, Formula], facts: Mapping[str, Fact]) -> None:
        self._formulas = formulas
        self._facts = facts
        self._terms: dict[str, ast.expr] = {}
        self._cases: dict[str, list[Case]] = {}
        self._steps: dict[str, Step] = {}
        self.of: dict[str, tuple[Route, ...] | None] = {}
        """By stream id (of an actuator: by the ref of the row that drives it); None when there are too many."""
        self.dead: dict[str, Step] = {}
        """Filter rows that no value can pass, by ref."""
        for stream in graph.streams.values():
            if stream.kind in (StreamKind.SENSOR, StreamKind.DONE):
                self.of[stream.id] = (Route(stream.id),)
        filters = any(s.connector.name == "filter" for b in graph.behaviours for s in b.steps)
        for behaviour in graph.behaviours:
            for step in sorted(behaviour.steps, key=lambda s: s.rank):
                if step.active and step.inputs:
                    self._steps[step.ref] = step
                    if filters and not step.connector.is_sink:
                        self._follow(step)
                    self.of[step.ref if step.connector.is_sink else step.output] = self._through(step)

    # ---- routes
    def _through(self, step: Step) -> tuple[Route, ...] | None:
        name, passes = step.connector.name, step.connector.passes
        first = self.of.get(step.inputs[0], ())
        if name == "accumulate":
            return self._accumulated(step)
        if name in ("combineLatest", "merge") or (step.connector.is_sink and not step.row.formula):
            found = [self.of.get(i, ()) for i in step.inputs]
            return None if None in found else _few(r for routes in found for r in routes or ())
        if first is None:
            return None
        if passes is not None and passes.later:
            return _few(replace(r, origin=f"clock {step.ref}") for r in first)
        if passes is not None and passes.blanks:
            return self._forgetting(step, first)
        return self._filtered(step, first) if name == "filter" and step.ref in self._formulas else first

    def _filtered(self, step: Step, first: tuple[Route, ...]) -> tuple[Route, ...]:
        passed = [replace(r, filters=(*r.filters, step.ref)[-MOST_FILTERS:]) for r in first]
        kept = [r for r in passed if self.possible(r)]
        if passed and not kept:
            self.dead[step.ref] = step
        return tuple(kept)

    def _forgetting(self, step: Step, first: tuple[Route, ...]) -> tuple[Route, ...] | None:
        """Return the routes of the input's values, and one from the clock for the blank that follows them."""
        about, known = _symbol(step.output), self._facts.get(step.inputs[0], Fact()).known
        passed = [replace(r, given=(*r.given, (about, known))) for r in first]
        silent = tuple((r.origin, frozenset(r.filters)) for r in first)
        return _few([*passed, Route(f"clock {step.ref}", (), ((about, exactly(None)),), silent)])

    def _accumulated(self, step: Step) -> tuple[Route, ...] | None:
        formula = self._formulas.get(step.ref)
        about = _symbol(step.output)
        found: list[Route] = []
        for place, stream in enumerate(step.inputs):
            routes = self.of.get(stream, ())
            if routes is None:
                return None
            known = UNKNOWN
            if formula is not None:
                extra = len(step.connector.extra)
                names = {n: exactly(None) for n in formula.names[extra:]}
                names[formula.names[extra + place]] = self._facts.get(stream, Fact()).known
                known = known_of(formula.tree, {**names, "total": AbstractValue(NUMBER)})
            found += [replace(r, given=(*r.given, (about, known))) if known != UNKNOWN else r for r in routes]
        return _few(found)

    # ---- conditions
    def possible(self, *routes: Route) -> bool:
        """Return whether the conditions of these routes can hold together; True too when there are too many."""
        refs = dict.fromkeys(ref for r in routes for ref in r.filters)
        each = [self._case(ref) for ref in refs]
        if math.prod(map(len, each)) > MOST_COMBINATIONS:
            return True
        given = [g for r in routes for g in r.given]
        given += [(about, known) for ref in refs for about, known in self._known_by(ref)]
        return any(can_hold(itertools.chain.from_iterable(c), given) for c in itertools.product(*each))

    def together(self, first: Sequence[Route], second: Sequence[Route], *, same_origin: bool) -> bool:
        """Return whether a value of one of the first and a value of one of the second routes can come at one time."""
        pairs = ((a, b) for a in first for b in second if not same_origin or a.origin == b.origin)
        return any(not a.waits_for(b) and not b.waits_for(a) and self.possible(a, b) for a, b in pairs)

    def _case(self, ref: str) -> list[Case]:
        if ref not in self._cases:
            formula = self._formulas[ref]
            tree = self._substituted(formula.tree, self._steps[ref], formula)
            self._cases[ref] = [()] if tree is None else cases(tree)
        return self._cases[ref]

    def _known_by(self, ref: str) -> list[tuple[str, AbstractValue]]:
        """Return what is known of what a filter compares, by its text: bounds of a joint, texts that a word can be."""
        step, formula = self._steps[ref], self._formulas[ref]
        known = {n: self._facts.get(i, Fact()).known for n, i in zip(formula.names, step.inputs, strict=True)}
        own = {about for case in cases(formula.tree) for about in (lit.about for lit in case)}
        found = []
        for node in ast.walk(formula.tree):
            if isinstance(node, (ast.Name, ast.Attribute)) and text_of(node) in own:
                what = known_of(node, known)
                if what.choices is not None or what.kind != ANY:
                    inlined = self._substituted(node, step, formula)
                    if inlined is not None:
                        found.append((text_of(inlined), what))
        return found

    # ---- expressions followed through rows
    def _term(self, stream: str) -> ast.expr:
        return self._terms.get(stream) or ast.Name(_symbol(stream))

    def _follow(self, step: Step) -> None:
        name, formula, passes = step.connector.name, self._formulas.get(step.ref), step.connector.passes
        if passes is not None and not passes.blanks:
            self._terms[step.output] = self._term(step.inputs[0])
        elif name in ("map", "combineLatest") and formula is not None:
            term = self._substituted(formula.tree, step, formula)
            self._terms[step.output] = ast.Name(_symbol(step.output)) if term is None else term

    def _substituted(self, tree: ast.expr, step: Step, formula: Formula) -> ast.expr | None:
        names = {n: self._term(i) for n, i in zip(formula.names, step.inputs, strict=True)}
        return _substitute(tree, names, [MOST_NODES])


def _symbol(stream: str) -> str:
    return f"«{stream}»"


def field_text(stream: str, name: str) -> str:
    """Return the text by which the conditions of routes name a field of a sensor's value."""
    return text_of(ast.Attribute(ast.Name(_symbol(stream)), name, ast.Load()))


def _few(routes: Iterable[Route]) -> tuple[Route, ...] | None:
    found: list[Route] = []
    for route in routes:
        if route not in found:
            found.append(route)
        if len(found) > MOST_ROUTES:
            return None
    return tuple(found)


def _substitute(tree: ast.expr, names: Mapping[str, ast.expr], left: list[int]) -> ast.expr | None:
    """Return a tree with names replaced and helpers inlined; None when it is too large, or has a PICK or a loop."""

    def visit(node: ast.AST, names: Mapping[str, ast.expr]) -> ast.AST:
        left[0] -= 1
        if left[0] < 0 or isinstance(node, (ast.ListComp, Pick)):
            raise _TooLarge
        if isinstance(node, ast.Name):
            found = names.get(node.id, node)
            left[0] -= sum(1 for _ in ast.walk(found)) - 1
            return found
        helper: HelperDef | None = getattr(node, "helper", None)
        if helper is not None and helper.tree is not None and isinstance(node, ast.Call):
            given = {p.name: visit(a, names) for p, a in zip(helper.parameters, node.args, strict=True)}
            return visit(helper.tree, given)  # type: ignore[arg-type]
        if not node._fields:
            return node
        new = node.__class__.__new__(node.__class__)
        new.__dict__.update(node.__dict__)
        for name in node._fields:
            value = getattr(node, name, None)
            if name == "func":
                continue
            if isinstance(value, ast.AST):
                setattr(new, name, visit(value, names))
            elif type(value) is list and not isinstance(node, ast.Constant):
                setattr(new, name, [visit(v, names) if isinstance(v, ast.AST) else v for v in value])
        return new

    try:
        return visit(tree, names)  # type: ignore[return-value]
    except _TooLarge:
        return None


class _TooLarge(Exception):
    """Raised for an expression that cannot be followed: it has too many nodes, a PICK or a loop."""


@dataclass(frozen=True, slots=True)
class Literal:
    """One condition on one expression."""

    about: str  # the expression, as a text that is the same for equal ones
    op: type | None  # a comparison, or None: whether it is true (`value` says)
    value: Value = None
    between: bool = False  # it compares two expressions: `about` holds both, and `value` is None


Case = tuple[Literal, ...]


def text_of(tree: ast.AST) -> str:
    """Return an expression as a text that is equal for equal expressions."""
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
    """Return the cases in which a condition holds (or does not); each is a list of conditions that all hold.

    >>> len(cases(ast.parse("x > 1 and (y or z)", mode="eval").body))
    2
    """
    if isinstance(tree, ast.UnaryOp) and isinstance(tree.op, ast.Not):
        return cases(tree.operand, not wanted)
    if isinstance(tree, ast.BoolOp):
        return _joined([cases(v, wanted) for v in tree.values], isinstance(tree.op, ast.And) is wanted)
    if isinstance(tree, ast.Compare):
        triples = zip([tree.left, *tree.comparators], tree.ops, tree.comparators, strict=False)
        return _joined([_compared(a, type(op), b, wanted) for a, op, b in triples], wanted)
    if isinstance(tree, ast.Constant) and type(tree.value) in (bool, int, float):
        return [()] if bool(tree.value) is wanted else []
    if isinstance(tree, ast.Call) and isinstance(tree.func, ast.Name) and tree.func.id == "ISBLANK":
        return [(Literal(text_of(tree.args[0]), ast.Eq if wanted else ast.NotEq, None),)]
    if isinstance(tree, ast.Call) and isinstance(tree.func, ast.Name) and tree.func.id == "BETWEEN":
        value, low, high = tree.args
        return _joined([_compared(value, ast.GtE, low, wanted), _compared(value, ast.LtE, high, wanted)], wanted)
    return [(Literal(text_of(tree), None, wanted),)]


def _joined(parts: Sequence[list[Case]], every: bool) -> list[Case]:
    """Return the cases in which every part holds, or any."""
    if (math.prod(map(len, parts)) if every else sum(map(len, parts))) > MOST_CASES:
        return [()]  # too many to follow: it may hold
    if every:
        return [tuple(itertools.chain.from_iterable(c)) for c in itertools.product(*parts)]
    return list(itertools.chain.from_iterable(parts))


def constant(tree: ast.AST) -> tuple[bool, Value]:
    """Return whether an expression always has the same value, and that value."""
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
            return _joined([each], every=False) if op is ast.In else [tuple(itertools.chain.from_iterable(each))]
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
    """Requirements of a case on one expression."""

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
    """Return whether conditions can hold together, given what is known about their expressions."""
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
        op, value, thing.number = literal.op, float(literal.value), True
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
    if thing.equal and not _suits(thing.equal[0], thing):
        return False
    return all(_allows(known, thing) for known in given)


def _allows(known: AbstractValue, thing: _Thing) -> bool:
    """Return whether a value that is possible by what is known can meet the requirements."""
    if known.choices:
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
    """Return whether a value meets the requirements."""
    if any(not same(value, e) for e in thing.equal) or any(same(value, u) for u in thing.unequal):
        return False
    if value is None:
        return not thing.number and True not in thing.truths
    if not isinstance(value, (int, float)):
        return True
    if value < thing.low or (value == thing.low and thing.open_low):
        return False
    if value > thing.high or (value == thing.high and thing.open_high):
        return False
    return not thing.truths or bool(value) in thing.truths
