"""Texts that rows can say: those of their formulas, of tables and of the rows before them, as far as they are known."""

from __future__ import annotations

import ast
import itertools
import math
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

from rrp_sheets.checks.facts import UNKNOWN, Fact, known_of
from rrp_sheets.formulas import Formula, HelperDef
from rrp_sheets.formulas.parsing import IfError, Join, Pick, Switch
from rrp_sheets.graph import Graph, Step, StreamKind
from rrp_sheets.model.values import Record, Value, show
from rrp_sheets.model.workbook import Address

MOST = 24  # texts of one formula
MOST_NODES = 5_000  # that one row is followed through: helpers may call each other again and again
MOST_STREAMS = 100  # before a row in which its text is looked for
_DEEP = 40
_FORMS: Mapping[str, Callable[[str], str]] = {
    "LOWER": str.lower, "UPPER": str.upper, "PROPER": str.title, "TRIM": str.strip,
}  # fmt: skip
_MADE = frozenset({"map", "combineLatest", "accumulate"})
OPEN = re.compile("‹[^‹›|]*›")
"""In a text: what only the run decides."""
SpokenTexts = dict[str, None]
"""Texts in their order, each once."""


@dataclass(frozen=True)
class _Env:
    """Meanings of the names in a formula: streams, and a helper's parameters."""

    streams: Mapping[str, str]
    given: Mapping[str, tuple[ast.expr, _Env]]


class SpeechTexts:
    """Finder of the texts that a checked workbook's rows can say."""

    def __init__(self, graph: Graph, formulas: Mapping[str, Formula], facts: Mapping[str, Fact]) -> None:
        self._graph, self._formulas, self._facts = graph, formulas, facts
        self._left = 0  # nodes of formulas that are still looked at for this row
        self._makers: dict[str, list[Step]] = {}
        for behaviour in self._graph.behaviours:
            for step in behaviour.steps:
                if step.active and not step.connector.is_sink:
                    self._makers.setdefault(step.output, []).append(step)
        self._found: dict[str, SpokenTexts] = {}

    def texts_of(self, step: Step) -> list[str]:
        """Return the texts that a row can send to its actuator; none when it only sends blanks."""
        found: SpokenTexts = {}
        self._left = MOST_NODES
        if step.row.formula.text:
            found = self._of_formula(step, 0)
        else:
            for stream in dict.fromkeys(step.inputs):
                found |= self._of_stream(stream, 0)
        if self._left < 0:
            self._found.clear()  # what was cut short for this row may be whole for the next
        return [text for text in found if text]

    def cell_of(self, step: Step, text: str) -> Address:
        """Return the cell of the formula that gives one of a row's texts; that of the row's output when none does."""
        if step.row.formula:
            return step.row.formula.address
        streams = list(step.inputs)
        for stream in streams:
            for maker in self._makers.get(stream, ()):
                if maker.connector.name in _MADE and maker.row.formula and text in self.texts_of(maker):
                    return maker.row.formula.address
                streams += [one for one in maker.inputs if len(streams) < MOST_STREAMS and one not in streams]
        return step.row.output.address

    def _of_stream(self, stream: str, deep: int) -> SpokenTexts:
        if stream not in self._found:
            self._found[stream] = self._looked_up(stream, deep)
        return self._found[stream]

    def _looked_up(self, stream: str, deep: int) -> SpokenTexts:
        fact = self._facts.get(stream)
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
        formula = self._formulas.get(step.ref)
        if formula is None:
            return _open(step.row.formula.text)
        names = formula.names[len(formula.names) - len(step.inputs) :] if step.inputs else ()
        env = _Env(dict(zip(names, step.inputs, strict=False)), {})
        return self._of(formula.tree, env, deep)

    def _of(self, tree: ast.AST | None, env: _Env, deep: int) -> SpokenTexts:
        self._left -= 1
        if tree is None or deep > _DEEP or self._left < 0:
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
        facts = self._facts
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
