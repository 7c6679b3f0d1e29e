"""Source of the pack's parts: the checked workbook in a language, and the texts that its rows can say."""

from __future__ import annotations

import ast
import itertools
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property

from rrp_sheets.checks import Checked
from rrp_sheets.checks.dataflow import Paths
from rrp_sheets.checks.facts import BLANK, UNKNOWN, known_of
from rrp_sheets.checks.protocol import channel
from rrp_sheets.diagnostics import Diagnostic
from rrp_sheets.diagnostics.catalogue import Severity
from rrp_sheets.formulas import HelperDef
from rrp_sheets.formulas.parsing import IfError, Join, Pick, Switch
from rrp_sheets.graph import Graph, Step, Stream, StreamKind
from rrp_sheets.model.names import key
from rrp_sheets.model.values import Record, Value, show
from rrp_sheets.model.workbook import Cell
from rrp_sheets.render.pack.model import Ref
from rrp_sheets.render.sentences import Rows
from rrp_sheets.render.style import clean
from rrp_sheets.render.texts import Texts
from rrp_sheets.robots import DeviceType
from rrp_sheets.workbook import Reading

BUTTON = "OperatorButton"


@dataclass(frozen=True)
class Driver:
    """An active row that drives an actuator stream."""

    behaviour: str
    step: Step
    stream: Stream
    stops: bool


@dataclass(frozen=True)
class Source:
    """Workbook to be printed, with the words of the language for that."""

    reading: Reading
    checked: Checked
    words: Texts
    rows: Rows = field(repr=False)

    def get(self, entry: str, /, **values: object) -> str:
        """Return a text of the pack."""
        return self.words.get(f"pack.{entry}", **values)

    def count(self, entry: str, n: int, **values: object) -> str:
        """Return a text that has a form of its own for one: the entry with `_one`."""
        return self.get(f"{entry}_one" if n == 1 else entry, n=f"{n:,}", **values)

    def protocol(self, name: str) -> str:
        """Return a field of the Protocol sheet, on several lines if it has them."""
        return self.checked.workbook.protocol.text(name)

    @cached_property
    def speech(self) -> SpeechTexts:
        """Finder of the texts that rows can say."""
        return SpeechTexts(self.checked)

    @cached_property
    def findings(self) -> list[Diagnostic]:
        """Errors and warnings of the check, in the order of their flags."""
        return [d for d in self.checked.report if d.severity is not Severity.INFO]

    def flags(self, behaviour: str) -> dict[int, list[int]]:
        """Return the numbers of the findings in a behaviour (by key), by row."""
        found: dict[int, list[int]] = {}
        for number, d in enumerate(self.findings, 1):
            if d.address and key(d.address.sheet) == behaviour:
                found.setdefault(d.address.row, []).append(number)
        return found

    @cached_property
    def active(self) -> list[tuple[str, Step]]:
        """Active rows, with their behaviour's name."""
        return [(clean(b.name), s) for b in self.checked.graph.behaviours for s in b.steps if s.active]

    @cached_property
    def drivers(self) -> list[Driver]:
        """Active rows that drive actuators."""
        facts, streams = self.checked.facts, self.checked.graph.streams
        return [
            Driver(name, s, streams[s.output], s.ref in facts and facts[s.ref].known.kind == BLANK)
            for name, s in self.active
            if s.connector.is_sink and s.output in streams
        ]

    @cached_property
    def sensors(self) -> dict[str, tuple[Ref, ...]]:
        """Sensor streams that rows take in, each with those rows."""
        found: dict[str, list[tuple[str, Step]]] = {}
        for name, step in self.active:
            for stream in dict.fromkeys(step.inputs):
                if self.checked.graph.streams[stream].kind is StreamKind.SENSOR:
                    found.setdefault(stream, []).append((name, step))
        return {stream: refs(rows) for stream, rows in found.items()}

    def shows(self, stream: str, thing: str) -> bool:
        """Return whether a sensor shows something (`person`), by its entry in the catalogue file."""
        device = self.checked.graph.streams[stream].device
        name = device.type.name if device else ""
        return any(thing in s.get("shows", ()) for s in self.checked.robot.data["sensor"] if s["name"] == name)

    def channel(self, stream: Stream) -> str:
        """Return the channel of a sensor: `camera`, `touch`, `microphone` or another entry of `pack.channel`."""
        return channel(self.checked.robot, stream.device.type if stream.device else None)

    def is_button(self, stream: str) -> bool:
        """Return whether a sensor stream is a button of the operator."""
        device = self.checked.graph.streams[stream].device
        return device is not None and device.type.name == BUTTON

    @cached_property
    def buttons(self) -> list[str]:
        """Ids of the operator's button streams that rows take in."""
        return [s for s in self.sensors if self.is_button(s)]

    @cached_property
    def _paths(self) -> Paths:
        """Routes from sensors to rows, with the conditions on the way."""
        return Paths(self.checked.graph, self.checked.formulas, self.checked.facts)

    @cached_property
    def _rows(self) -> dict[str, Step]:
        return {step.ref: step for _, step in self.active}

    def follows(self, place: str, sensor: str) -> bool:
        """Return whether a stream, or a row by its ref, can get a value of a sensor without the end of an action.

        Where there are too many routes it counts as one that can.
        """
        routes = self._paths.of.get(place, ())
        if routes is None or any(route.origin == sensor for route in routes):
            return True
        waiting = [self._rows[r.origin.removeprefix("clock ")] for r in routes if r.origin.startswith("clock ")]
        return any(self.follows(step.inputs[0], sensor) for step in waiting)

    def label(self, stream: str) -> str:
        """Return the label of a button, by default the name of its stream."""
        found = self.checked.graph.streams[stream]
        return clean(str(found.settings.get("label") or found.name))

    def quoted(self, names: Iterable[str], joiner: str = "and") -> str:
        """Return `“a”, “b” and “c”`."""
        return self.words.listed([self.words.get("name.quoted", name=n) for n in names], joiner)

    def presses(self) -> str:
        """Return `the operator presses “a” or “b”`, with the buttons that rows take in."""
        return self.get("summary.presses", list=self.quoted((self.label(s) for s in self.buttons), "or"))

    def listed_cells(self, cells: Iterable[Cell]) -> str:
        """Return the names in a cell, as they are typed: `a, b`."""
        return self.words.in_a_row([clean(c.text) for c in cells])

    def fields(self, kind: DeviceType) -> list[str]:
        """Return the fields of a sensor's value with their units."""
        names = kind.words(self.words.language).fields
        said = [(names[key(f.name)][0], f.unit) for f in kind.payload.fields] if kind.payload else []
        return [self.get("sensed.field", name=name, unit=unit) if unit else name for name, unit in said]


def refs(rows: Iterable[tuple[str, Step]]) -> tuple[Ref, ...]:
    """Group rows by their behaviour."""
    found: dict[str, list[int]] = {}
    for name, step in rows:
        found.setdefault(name, []).append(step.number)
    return tuple(Ref(name, tuple(dict.fromkeys(numbers))) for name, numbers in found.items())


def driver_refs(drivers: Iterable[Driver]) -> tuple[Ref, ...]:
    """Group the rows of drivers by their behaviour."""
    return refs((d.behaviour, d.step) for d in drivers)


MOST = 24  # texts of one formula
_DEEP = 40
_FORMS: Mapping[str, Callable[[str], str]] = {
    "LOWER": str.lower, "UPPER": str.upper, "PROPER": str.title, "TRIM": str.strip,
}  # fmt: skip
_MADE = frozenset({"map", "combineLatest", "accumulate"})
SpokenTexts = dict[str, None]
"""Texts in their order, each once."""


@dataclass(frozen=True)
class _Env:
    """Meanings of the names in a formula: streams, and a helper's parameters."""

    streams: Mapping[str, str]
    given: Mapping[str, tuple[ast.expr, _Env]]


class SpeechTexts:
    """Finder of the texts that a checked workbook's rows can say."""

    def __init__(self, checked: Checked) -> None:
        self._checked = checked
        self._graph: Graph = checked.graph
        self._makers: dict[str, list[Step]] = {}
        for behaviour in self._graph.behaviours:
            for step in behaviour.steps:
                if step.active and not step.connector.is_sink:
                    self._makers.setdefault(step.output, []).append(step)
        self._found: dict[str, SpokenTexts] = {}

    def texts_of(self, step: Step) -> list[str]:
        """Return the texts that a row can send to its actuator; none when it only sends blanks."""
        found: SpokenTexts = {}
        if step.row.formula.text:
            found = self._of_formula(step, 0)
        else:
            for stream in dict.fromkeys(step.inputs):
                found |= self._of_stream(stream, 0)
        return [text for text in found if text]

    def _of_stream(self, stream: str, deep: int) -> SpokenTexts:
        if stream not in self._found:
            self._found[stream] = self._looked_up(stream, deep)
        return self._found[stream]

    def _looked_up(self, stream: str, deep: int) -> SpokenTexts:
        fact = self._checked.facts.get(stream)
        if fact is not None and fact.known.choices is not None:
            return _shown(fact.known.choices)
        makers = self._makers.get(stream, [])
        if (self._graph.streams[stream].kind is not StreamKind.ORDINARY and not makers) or deep > _DEEP:
            return _open(self._graph.streams[stream].name)
        found: SpokenTexts = {}
        for step in makers:
            if step.connector.name in _MADE:
                found |= self._of_formula(step, deep + 1)
                continue
            inputs = step.inputs if step.connector.name == "merge" else step.inputs[:1]
            for one in inputs:
                found |= self._of_stream(one, deep + 1)
        return found

    def _of_formula(self, step: Step, deep: int) -> SpokenTexts:
        formula = self._checked.formulas.get(step.ref)
        if formula is None:
            return _open(step.row.formula.text)
        names = formula.names[len(formula.names) - len(step.inputs) :] if step.inputs else ()
        env = _Env(dict(zip(names, step.inputs, strict=False)), {})
        return self._of(formula.tree, env, deep)

    def _of(self, tree: ast.AST | None, env: _Env, deep: int) -> SpokenTexts:
        if tree is None or deep > _DEEP:
            return _open("…")
        match tree:
            case ast.Constant():
                return _shown([tree.value])
            case ast.JoinedStr():
                return self._joined([self._of(part, env, deep + 1) for part in tree.values])
            case ast.FormattedValue():
                return self._of(tree.value, env, deep + 1)
            case Join():
                return self._joined([self._of(part, env, deep + 1) for part in tree.values])
            case ast.IfExp():
                return self._of(tree.body, env, deep + 1) | self._of(tree.orelse, env, deep + 1)
            case Switch():
                return self._union([*tree.results, tree.otherwise], env, deep)
            case IfError():
                return self._union([tree.value, tree.otherwise], env, deep)
            case Pick():
                return self._members(tree.members, env, deep)
            case ast.Name() if tree.id in env.given:
                return self._of(*env.given[tree.id], deep + 1)
            case ast.Name() if tree.id in env.streams:
                return self._of_stream(env.streams[tree.id], deep + 1)
        return self._other(tree, env, deep)

    def _other(self, tree: ast.AST, env: _Env, deep: int) -> SpokenTexts:
        helper: HelperDef | None = getattr(tree, "helper", None)
        if isinstance(tree, ast.Call) and helper is not None:
            given = {p.name: (a, env) for p, a in zip(helper.parameters, tree.args, strict=False)}
            return self._of(helper.tree, _Env({}, given), deep + 1)
        facts = self._checked.facts
        names = {name: facts[s].known if s in facts else UNKNOWN for name, s in env.streams.items()}
        known = known_of(tree, names | dict.fromkeys(env.given, UNKNOWN))
        if known.choices is not None:
            return _shown(known.choices)
        called = tree.func.id if isinstance(tree, ast.Call) and isinstance(tree.func, ast.Name) else ""
        if called in _FORMS and isinstance(tree, ast.Call) and len(tree.args) == 1:
            inner = self._of(tree.args[0], env, deep + 1)
            return {text if "‹" in text else _FORMS[called](text): None for text in inner}
        return _open(self._source(tree, env))

    def _members(self, members: Iterable[ast.expr], env: _Env, deep: int) -> SpokenTexts:
        found: SpokenTexts = {}
        for member in members:
            tree: ast.AST | None = member
            helper: HelperDef | None = getattr(member, "helper", None)
            if helper is not None and helper.tree is not None:
                tree = helper.tree
            if isinstance(tree, (ast.List, ast.Tuple)):
                found |= self._union(tree.elts, env, deep)
            elif isinstance(tree, ast.Constant) and isinstance(tree.value, (list, tuple)):
                found |= _shown(tree.value)
            else:
                found |= self._of(tree, env, deep + 1)
        return found

    def _union(self, trees: Iterable[ast.AST | None], env: _Env, deep: int) -> SpokenTexts:
        found: SpokenTexts = {}
        for tree in trees:
            found |= {} if tree is None else self._of(tree, env, deep + 1)
        return found

    @staticmethod
    def _joined(parts: list[SpokenTexts]) -> SpokenTexts:
        """Return all combinations of the parts; where they are too many, the largest part becomes `‹a | b›`."""
        lists = [list(part) or [""] for part in parts]
        while math.prod(map(len, lists)) > MOST:
            longest = max(lists, key=len)
            lists[lists.index(longest)] = ["‹" + " | ".join(longest) + "›"]
        return {"".join(way): None for way in itertools.product(*lists)}

    def _source(self, tree: ast.AST, env: _Env) -> str:
        """Return a short name for what is not known: a field, an input, or dots."""
        if isinstance(tree, ast.Attribute):
            inner = self._source(tree.value, env)
            return f"{inner}.{tree.attr}" if inner != "…" else tree.attr
        if isinstance(tree, ast.Name):
            given = env.given.get(tree.id)
            return self._source(*given) if given is not None else tree.id
        return "…"


def _open(name: str) -> SpokenTexts:
    return {f"‹{name}›": None}


def _shown(values: Iterable[Value]) -> SpokenTexts:
    """Return the values as spoken, without blanks and records; an empty text stays, as it may be joined to others."""
    return {
        value if isinstance(value, str) else show(value): None
        for value in values
        if value is not None and not isinstance(value, Record)
    }
