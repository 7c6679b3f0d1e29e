"""Puts simple formulas into words and quotes the others, so that no paraphrase is wrong; and contents of streams.

The contents are known as far as the rows show them: record fields, units, and the sensors behind them.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Mapping
from dataclasses import dataclass, field

from rrp_sheets.formulas import FormulaProblem, read_formula
from rrp_sheets.graph import Graph, Step, StreamKind
from rrp_sheets.model.exchange import DONE
from rrp_sheets.model.names import argument_name, key
from rrp_sheets.model.values import RecordType
from rrp_sheets.render.texts import Texts

_COMPARED: dict[type[ast.cmpop], str] = {
    ast.Lt: "under", ast.LtE: "at_most", ast.Gt: "over", ast.GtE: "at_least", ast.Eq: "equal", ast.NotEq: "unequal",
}  # fmt: skip
_TURNED: dict[type[ast.cmpop], type[ast.cmpop]] = {
    ast.Lt: ast.Gt, ast.LtE: ast.GtE, ast.Gt: ast.Lt, ast.GtE: ast.LtE, ast.Eq: ast.Eq, ast.NotEq: ast.NotEq,
}  # fmt: skip
FieldNames = Mapping[tuple[str, str], str]


@dataclass(frozen=True)
class Named:
    """An input as a formula sees it: its noun (“Distance”, or "it"), and what it carries."""

    noun: str
    content: Content
    pronoun: bool = False


class _NotSimple(Exception):
    """Raised for a formula that is better quoted than described."""


@dataclass(frozen=True)
class Wording:
    """Describes the formulas of one row: `names` are its inputs by key, `helpers` the helpers' names as spelt by key.

    `fields` has the fields' names in the language, by the record's name and the field's key.
    """

    texts: Texts
    names: Mapping[str, Named]
    helpers: Mapping[str, str]
    fields: FieldNames = field(default_factory=dict)

    def condition(self, formula: str) -> str:
        """Return a filter's formula in words: `“Distance” is under 0.5 m`."""
        if special := self._special(formula, "condition"):
            return special
        try:
            return self._condition(_parse(formula))
        except _NotSimple:
            return self.texts.get("condition.holds", formula=shown(formula))

    def work(self, formula: str) -> str:
        """Return a formula in words as an action: `take its distance`."""
        if special := self._special(formula, "value"):
            return special
        try:
            return self._work(_parse(formula))
        except _NotSimple:
            return self.texts.get("value.work", formula=self.texts.get("value.code", formula=shown(formula)))

    def _special(self, formula: str, role: str) -> str:
        """Return the words for a formula that is missing, or is only a helper's name; empty for any other."""
        k = key(shown(formula))
        if not shown(formula):
            return self.texts.get(f"{role}.missing")
        only_helper = k in self.helpers and k not in self.names
        return self.texts.get(f"{role}.helper", name=_spaced(self.helpers[k])) if only_helper else ""

    def says_words(self, formula: str) -> str:
        """Return the constant text that a formula is, in words; empty when it is something else."""
        try:
            tree = _parse(formula)
        except _NotSimple:
            return ""
        return self._value(tree) if isinstance(tree, ast.Constant) and isinstance(tree.value, str) else ""

    def _work(self, tree: ast.expr) -> str:
        called, args = _call(tree)
        if called and called in self.helpers:
            name = _spaced(self.helpers[called])
            inputs = self.texts.listed([self._subject(a)[0] for a in args])
            return self.texts.get("value.helper_of" if inputs else "value.helper", name=name, inputs=inputs)
        if isinstance(tree, (ast.Name, ast.Attribute)):
            return self.texts.get("value.take", what=self._subject(tree)[0])
        if isinstance(tree, ast.Constant) and isinstance(tree.value, str):
            return self.texts.get("value.prepare", what=self._value(tree))
        return self.texts.get("value.give", what=self._value(tree))

    def _value(self, tree: ast.expr) -> str:
        get = self.texts.get
        if isinstance(tree, ast.Constant):
            value = tree.value
            if isinstance(value, bool) or value is None:
                return get({True: "value.true", False: "value.false", None: "value.blank"}[value])
            if isinstance(value, str):
                return get("value.words", text=value) if value else get("value.empty")
            return get("value.number", n=_number(value, ""))
        if isinstance(tree, ast.UnaryOp) and isinstance(tree.op, ast.USub):
            return get("value.number", n=_number(_constant(tree), ""))
        if isinstance(tree, (ast.Tuple, ast.List)) and all(isinstance(e, ast.Constant) for e in tree.elts):
            return get("value.values", formula=ast.unparse(tree))
        if isinstance(tree, (ast.Name, ast.Attribute)):
            return self._subject(tree)[0]
        if isinstance(tree, ast.IfExp):
            return self._either(tree.test, tree.body, tree.orelse)
        called, args = _call(tree)
        if called == "if" and len(args) == 3:
            return self._either(*args)
        raise _NotSimple

    def _either(self, test: ast.expr, yes: ast.expr, no: ast.expr) -> str:
        if any(isinstance(part, ast.IfExp) or _call(part)[0] for part in (yes, no)):
            raise _NotSimple  # a nested choice reads worse than the formula
        words = {"yes": self._value(yes), "condition": self._condition(test), "no": self._value(no)}
        return self.texts.get("value.either", **words)

    def _condition(self, tree: ast.expr) -> str:
        called, args = _call(tree)
        if isinstance(tree, ast.Compare):
            return self._comparison(tree)
        if isinstance(tree, ast.BoolOp):
            return self._joined(tree.values, "all" if isinstance(tree.op, ast.And) else "any")
        if called in ("and", "or"):
            return self._joined(args, "all" if called == "and" else "any")
        if called == "not" and len(args) == 1:
            return self._truth(args[0], "not_")
        if isinstance(tree, ast.UnaryOp) and isinstance(tree.op, ast.Not):
            return self._truth(tree.operand, "not_")
        return self._truth(tree, "")

    def _truth(self, tree: ast.expr, negation: str) -> str:
        called, args = _call(tree)
        if called == "isblank" and len(args) == 1:
            return self.texts.get(f"condition.{negation}blank", what=self._subject(args[0])[0])
        if isinstance(tree, ast.Attribute) and isinstance(tree.value, ast.Name) and key(tree.attr) == "completed":
            named = self.names.get(key(tree.value.id))
            if named is not None and named.content.record is DONE:
                return self.texts.get(f"condition.{negation}completed", what=named.noun)
        what, _, kind = self._subject(tree)
        if kind != "truth":  # a number or a text is not simply true
            raise _NotSimple
        return self.texts.get(f"condition.{negation}true", what=what)

    def _joined(self, parts: list[ast.expr], joiner: str) -> str:
        between = self._between(parts) if joiner == "all" else ""
        if any(isinstance(p, ast.BoolOp) or _call(p)[0] in ("and", "or") for p in parts):
            raise _NotSimple  # brackets do not survive in a sentence
        return between or self.texts.listed([self._condition(p) for p in parts], joiner)

    def _between(self, parts: list[ast.expr]) -> str:
        """Return `x >= 0.5 and x < 2` in the words for `0.5 <= x < 2`; empty for other conditions."""
        if len(parts) != 2 or not all(isinstance(p, ast.Compare) and len(p.ops) == 1 for p in parts):
            return ""
        low, high = parts
        assert isinstance(low, ast.Compare) and isinstance(high, ast.Compare)
        if ast.dump(low.left) != ast.dump(high.left):
            return ""
        lower = {ast.GtE: ast.LtE(), ast.Gt: ast.Lt()}.get(type(low.ops[0]))
        if lower is None or not isinstance(high.ops[0], (ast.Lt, ast.LtE)):
            return ""
        return self._comparison(ast.Compare(low.comparators[0], [lower, high.ops[0]], [low.left, high.comparators[0]]))

    def _comparison(self, tree: ast.Compare) -> str:
        get = self.texts.get
        if len(tree.ops) == 2:
            what, unit, _ = self._subject(tree.comparators[0])
            low, high = _constant(tree.left), _constant(tree.comparators[1])
            if not all(isinstance(op, (ast.Lt, ast.LtE)) for op in tree.ops):
                raise _NotSimple
            name = "from_to" if all(isinstance(op, ast.LtE) for op in tree.ops) else "between"
            return get(f"condition.{name}", what=what, low=_number(low, ""), high=_number(high, unit))
        if len(tree.ops) != 1 or type(tree.ops[0]) not in _COMPARED:
            raise _NotSimple
        left, right, op = tree.left, tree.comparators[0], type(tree.ops[0])
        if isinstance(left, ast.Constant) and not isinstance(right, ast.Constant):
            left, right, op = right, left, _TURNED[op]
        what, unit, _ = self._subject(left)
        if isinstance(right, ast.Constant) and not isinstance(right.value, (int, float)):
            if op not in (ast.Eq, ast.NotEq):
                raise _NotSimple
            shown_value = get("value.text", text=right.value) if isinstance(right.value, str) else self._value(right)
        elif isinstance(right, ast.Constant) and isinstance(right.value, bool):
            shown_value = self._value(right)
        elif isinstance(right, (ast.Name, ast.Attribute)):
            shown_value = self._subject(right)[0]
        else:
            shown_value = _number(_constant(right), unit)
        return get(f"condition.{_COMPARED[op]}", what=what, n=shown_value)

    def _subject(self, tree: ast.expr) -> tuple[str, str, str]:
        """Return the noun of an input or of its field, its unit, and its kind."""
        if isinstance(tree, ast.Name) and key(tree.id) in self.names:
            named = self.names[key(tree.id)]
            return named.noun, named.content.unit, ""
        if isinstance(tree, ast.Attribute) and isinstance(tree.value, ast.Name) and key(tree.value.id) in self.names:
            named = self.names[key(tree.value.id)]
            record = named.content.record
            found = find_field(record, tree.attr)
            if record is None or found is None:
                raise _NotSimple
            spelt, unit, kind = found
            name = self.fields.get((record.name, key(spelt)), spelt.replace("_", " "))
            if kind == "truth":
                name = self.texts.get("name.quoted", name=name)
            entry = "name.its" if named.pronoun else "name.field"
            return self.texts.get(entry, field=name, input=named.noun), unit, kind
        raise _NotSimple


def shown(formula: str) -> str:
    """Return the formula on one line and without its leading `=`."""
    return " ".join(formula.split()).removeprefix("=").lstrip()


def _parse(formula: str) -> ast.expr:
    try:
        return read_formula(formula)
    except FormulaProblem:
        raise _NotSimple from None


def _call(tree: ast.expr) -> tuple[str, list[ast.expr]]:
    """Return the key of the function that is called, and its arguments; empty when it is no call."""
    if isinstance(tree, ast.Call) and isinstance(tree.func, ast.Name):
        return key(tree.func.id), tree.args
    return "", []


def _constant(tree: ast.expr) -> float:
    if isinstance(tree, ast.UnaryOp) and isinstance(tree.op, ast.USub):
        return -_constant(tree.operand)
    if isinstance(tree, ast.Constant) and isinstance(tree.value, (int, float)) and not isinstance(tree.value, bool):
        return tree.value
    raise _NotSimple


def _number(value: object, unit: str) -> str:
    if not isinstance(value, (int, float)):
        raise _NotSimple
    return f"{value:g}".replace("-", "−") + (f" {unit}" if unit else "")


def _spaced(name: str) -> str:
    """Separate the words of a name: `ballToDistance` → `ball to distance`."""
    return re.sub(r"(?<=[a-z])([A-Z])", lambda m: " " + m[1].lower(), name).replace("_", " ")


_BLANK = {"blank", "none", "blank()"}


@dataclass(frozen=True)
class Content:
    """Type, unit and origin of the values of a stream.

    Attributes:
        record: the record's type, when it is one.
        unit: of a number.
        sensors: the ids of the sensor streams that it descends from, in the order of the rows.
        may_be_blank: a connector before it sends blanks when values grow old.
        blank: it carries nothing but blanks, which stop what an actuator does.
    """

    record: RecordType | None = None
    unit: str = ""
    sensors: Mapping[str, None] = field(default_factory=dict)
    may_be_blank: bool = False
    blank: bool = False


def contents(graph: Graph) -> dict[str, Content]:
    """Return the content of every stream by its id."""
    given = (StreamKind.SENSOR, StreamKind.DONE)
    found: dict[str, Content] = {}
    for stream in graph.streams.values():
        if stream.kind in given:
            kind = stream.device.type if stream.device else None
            sensors = {stream.id: None} if stream.kind is StreamKind.SENSOR else {}
            found[stream.id] = Content(kind.payload if kind else None, kind.unit if kind else "", sensors)
    steps = sorted((s for b in graph.behaviours for s in b.steps), key=lambda s: s.rank)
    for step in steps:
        output = graph.streams.get(step.output)
        if output is not None and output.kind not in (StreamKind.ACTUATOR, *given):
            found[step.output] = _of_step(step, found, graph)
    return found


def _of_step(step: Step, found: Mapping[str, Content], graph: Graph) -> Content:
    inputs = [found.get(i, Content()) for i in step.inputs]
    sensors = {s: None for content in inputs for s in content.sensors}
    name, passes = step.connector.name, step.connector.passes
    blank = any(c.may_be_blank for c in inputs) or (passes is not None and passes.blanks)
    first = inputs[0] if inputs else Content()
    if passes is not None or name == "merge":
        alike = all((c.record, c.unit) == (first.record, first.unit) for c in inputs) or name != "merge"
        record, unit = (first.record, first.unit) if alike else (None, "")
        return Content(record, unit, sensors, blank, all(c.blank for c in inputs))
    if name == "map" and is_blank(step.row.formula.text):
        return Content(None, "", sensors, blank, True)
    if name == "map" and inputs:
        names = {key(argument_name(graph.streams[i].name)): c for i, c in zip(step.inputs, inputs, strict=True)}
        if len(inputs) == 1:
            names["value"] = first
        return Content(*_of_formula(step.row.formula.text, names), sensors, blank)
    return Content(None, "", sensors, blank)


def is_blank(formula: str) -> bool:
    """Return whether a formula is nothing but a blank."""
    return key(formula.strip().lstrip("=")) in _BLANK


def _of_formula(formula: str, names: Mapping[str, Content]) -> tuple[RecordType | None, str]:
    """Return record type and unit of a formula that is only a name or a field."""
    try:
        tree = _parse(formula)
    except _NotSimple:
        return None, ""
    if isinstance(tree, ast.Name) and (content := names.get(key(tree.id))) is not None:
        return content.record, content.unit
    if isinstance(tree, ast.Attribute) and isinstance(tree.value, ast.Name) and key(tree.value.id) in names:
        found = find_field(names[key(tree.value.id)].record, tree.attr)
        return None, found[1] if found else ""
    return None, ""


def find_field(record: RecordType | None, name: str) -> tuple[str, str, str] | None:
    """Return the shown name, unit and kind of a record's field, or None."""
    if record is None:
        return None
    wanted = record.keys.get(key(name))
    return next(((f.name, f.unit, f.kind) for f in record.fields if key(f.name) == wanted), None)
