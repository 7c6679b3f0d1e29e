"""Puts simple formulas into words and quotes the others, so that no paraphrase is wrong; and contents of streams.

The contents are known as far as the rows show them: record fields, units, and the sensors behind them.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import Enum
from typing import NamedTuple

from rrp_sheets.formulas import FormulaProblem, read_formula
from rrp_sheets.formulas.parsing import Join
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
_NOUNS = {
    (True, True): "name.its", (True, False): "name.field",
    (False, True): "name.its_value", (False, False): "name.value_of",
}  # fmt: skip
"""Entries for a field, by whether its name says enough and whether its noun is "it"."""
_QUOTES = re.compile("[“”「」『』]")
_MOST_PARTS = 6  # of a text that is joined together: a longer one reads worse than its formula
_SIGNS: dict[type[ast.operator], str] = {ast.Add: "+", ast.Sub: "−", ast.Mult: "×", ast.Div: "÷"}


@dataclass(frozen=True)
class Named:
    """An input as a formula sees it.

    Attributes:
        noun: “Distance”, or "it".
        content: what it carries.
        pronoun: whether the noun is "it".
        name: its name, also when the noun is "it".
        actuator: the name of the actuator whose end it tells; empty for other streams.
    """

    noun: str
    content: Content
    pronoun: bool = False
    name: str = ""
    actuator: str = ""


class Form(Enum):
    """Form of a formula in words."""

    FIXED = "fixed"  # a text or a number
    WORDS = "words"  # a noun phrase
    CODE = "code"  # something to calculate: a helper, or the formula in quotes


@dataclass(frozen=True)
class Phrase:
    """A formula in words as a noun phrase; of a fixed text or number also the value alone."""

    text: str
    form: Form
    fixed: str = ""


class TotalChange(NamedTuple):
    """Change of a total by a value: `keep` it, `add` a number to it, `set` it, or raise it to `least` if it is less."""

    does: str
    value: str = ""


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

    def condition(self, formula: str) -> Phrase:
        """Return a filter's formula in words: `“Distance” is under 0.5 m`."""
        if special := self._special(formula, "condition"):
            return Phrase(special, Form.WORDS)
        try:
            return Phrase(self._condition(_parse(formula)), Form.WORDS)
        except _NotSimple:
            return Phrase(self.texts.get("condition.holds", formula=shown(formula)), Form.CODE)

    def value(self, formula: str) -> Phrase:
        """Return a formula in words as a noun phrase: `its distance`."""
        if special := self._special(formula, "value"):
            return Phrase(special, Form.CODE if shown(formula) else Form.WORDS)
        try:
            return self._phrase(_parse(formula))
        except _NotSimple:
            return Phrase(self.texts.get("value.code", formula=shown(formula)), Form.CODE)

    def _special(self, formula: str, role: str) -> str:
        """Return the words for a formula that is missing, or is only a helper's name; empty for any other."""
        k = key(shown(formula))
        if not shown(formula):
            return self.texts.get(f"{role}.missing")
        only_helper = k in self.helpers and k not in self.names
        return self.texts.get(f"{role}.helper", name=_spaced(self.helpers[k])) if only_helper else ""

    def _phrase(self, tree: ast.expr) -> Phrase:
        called, args = _call(tree)
        if called and called in self.helpers:
            name = _spaced(self.helpers[called])
            inputs = self.texts.listed([self._subject(a)[0] for a in args])
            entry = "value.helper_of" if inputs else "value.helper"
            return Phrase(self.texts.get(entry, name=name, inputs=inputs), Form.CODE)
        if isinstance(tree, ast.Constant) and isinstance(tree.value, str) and tree.value:
            return Phrase(self.texts.get("value.words", text=tree.value), Form.FIXED, tree.value)
        if (number := _number_of(tree)) is not None:
            return Phrase(self.texts.get("value.number", n=_number(number, "")), Form.FIXED, _number(number, ""))
        return Phrase(self._value(tree), Form.WORDS)

    def _value(self, tree: ast.expr) -> str:
        """Return a formula, or one of the values that it chooses from, as a noun phrase."""
        get = self.texts.get
        if isinstance(tree, ast.Constant):
            value = tree.value
            if isinstance(value, bool) or value is None:
                return get({True: "value.true", False: "value.false", None: "value.blank"}[value])
            if isinstance(value, str):
                return get("value.text", text=value) if value else get("value.empty")
        if (number := _number_of(tree)) is not None:
            return _number(number, "")
        if isinstance(tree, (ast.Tuple, ast.List)) and all(isinstance(e, ast.Constant) for e in tree.elts):
            return get("value.values", formula=ast.unparse(tree))
        if isinstance(tree, (Join, ast.JoinedStr)):
            return get("value.words", text=self._joined_text(tree.values))
        if isinstance(tree, ast.BinOp) and type(tree.op) in _SIGNS:
            return self._operand(tree)
        if isinstance(tree, ast.IfExp):
            return self._either(tree.test, tree.body, tree.orelse)
        called, args = _call(tree)
        if called == "if" and len(args) == 3:
            return self._either(*args)
        return self._subject(tree)[0]

    def _joined_text(self, parts: Sequence[ast.expr]) -> str:
        """Return a text that is joined together, with what a run fills in between ‹ and ›."""
        if len(parts) > _MOST_PARTS:
            raise _NotSimple
        said = []
        for part in parts:
            tree = part.value if isinstance(part, ast.FormattedValue) else part
            if isinstance(tree, ast.Constant) and isinstance(tree.value, str):
                said.append(tree.value)
            else:
                said.append(f"‹{self._gap(tree)}›")
        return "".join(said)

    def _gap(self, tree: ast.expr) -> str:
        """Return the short name of what stands in a text: `colour of Target`."""
        field = self._field(tree)
        if field is not None:
            named, name, _, _ = field
            return _QUOTES.sub("", self.texts.get("value.gap", field=name, input=named.name or named.noun))
        if isinstance(tree, ast.Name) and key(tree.id) in self.names:
            named = self.names[key(tree.id)]
            return _QUOTES.sub("", named.name or named.noun)
        called, args = _call(tree)
        if called in self.helpers and args:
            inputs = self.texts.in_a_row([self._gap(arg) for arg in args])
            return f"{_spaced(self.helpers[called])}({inputs})"
        return _QUOTES.sub("", self._subject(tree)[0])

    def _operand(self, tree: ast.expr) -> str:
        """Return a number in words, also one that is worked out from two others: `“Trials” + 1`."""
        if isinstance(tree, ast.BinOp) and type(tree.op) in _SIGNS:
            parts = [tree.left, tree.right]
            if any(isinstance(part, ast.BinOp) for part in parts):
                raise _NotSimple  # brackets do not survive in a sentence
            left, right = map(self._operand, parts)
            if isinstance(tree.op, ast.Add) and _number_of(tree.right) == 1:
                return self.texts.get("value.one_more", n=left)
            return self.texts.get("value.sum", left=left, sign=_SIGNS[type(tree.op)], right=right)
        if (number := _number_of(tree)) is not None:
            return _number(number, "")
        if isinstance(tree, ast.Name) and key(tree.id) in self.names and self.names[key(tree.id)].pronoun:
            return self.names[key(tree.id)].name or self.names[key(tree.id)].noun
        return self._subject(tree)[0]

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
            if named is not None and named.actuator:
                return self.texts.get(f"condition.{negation}completed", what=self._quoted(named.actuator))
            if named is not None and named.content.record is DONE:
                return self.texts.get(f"condition.{negation}completed_action", what=named.noun)
        if isinstance(tree, ast.Attribute) and (found := self._field(tree)) and found[0].pronoun:
            record = found[0].content.record
            entry = f"condition.{key(record.name)}.{negation}{key(tree.attr)}" if record else ""
            if self.texts.has(entry):
                return self.texts.get(entry)
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
        bounds = (low.comparators[0], high.comparators[0])
        if lower is None or not isinstance(high.ops[0], (ast.Lt, ast.LtE)) or None in map(_number_of, bounds):
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
        if isinstance(right, ast.Constant) and (isinstance(right.value, (bool, str)) or right.value is None):
            if op not in (ast.Eq, ast.NotEq):
                raise _NotSimple
            shown_value = self._value(right)
        elif (number := _number_of(right)) is not None:
            shown_value = _number(number, unit)
        else:
            shown_value = self._operand(right)
        return get(f"condition.{_COMPARED[op]}", what=what, n=shown_value)

    def _subject(self, tree: ast.expr) -> tuple[str, str, str]:
        """Return the noun of an input, of its field or of what tables have, its unit, and its kind."""
        if isinstance(tree, ast.Name) and key(tree.id) in self.names:
            named = self.names[key(tree.id)]
            return named.noun, named.content.unit, ""
        if isinstance(tree, ast.Name) and key(tree.id) in self.helpers:
            return self._quoted(_spaced(self.helpers[key(tree.id)])), "", ""
        if (found := self._field(tree)) is not None:
            named, name, unit, kind = found
            known = named.content.record is not None and kind != "truth"
            name = name if known else self._quoted(name)
            entry = _NOUNS[known or not (named.pronoun or kind == "truth"), named.pronoun]
            return self.texts.get(entry, field=name, input=named.noun), unit, kind
        return self._of_table(tree), "", ""

    def _field(self, tree: ast.expr) -> tuple[Named, str, str, str] | None:
        """Return an input, its field's name in the language, unit and kind; None for others."""
        if not (isinstance(tree, ast.Attribute) and isinstance(tree.value, ast.Name)):
            return None
        named = self.names.get(key(tree.value.id))
        if named is None:
            return None
        record = named.content.record
        if record is None:
            return named, tree.attr.replace("_", " "), "", ""
        found = find_field(record, tree.attr)
        if found is None:
            raise _NotSimple
        spelt, unit, kind = found
        return named, self.fields.get((record.name, key(spelt)), spelt.replace("_", " ")), unit, kind

    def _of_table(self, tree: ast.expr) -> str:
        """Return the words for what is looked up in a table or picked from a list."""
        get = self.texts.get
        called, args = _call(tree)
        if called == "pick" and len(args) == 1:
            return get("table.pick", table=self._table(args[0])[0])
        if called == "rows" and len(args) == 1:
            return get("table.rows", table=self._table(args[0])[0])
        if called == "index" and len(args) == 2:
            table, column = self._table(args[0])
            entry = "table.cell" if column else "table.row"
            if isinstance(args[1], ast.Name) and key(args[1].id) in self.names and self.names[key(args[1].id)].pronoun:
                return get(f"{entry}_of_it", table=table, column=column)
            return get(entry, table=table, column=column, n=self._operand(args[1]))
        if called == "xlookup" and len(args) == 3:
            (table, where), (other, column) = self._table(args[1]), self._table(args[2])
            # not “its zone”: “its” could be that of the row looked for
            named = {name: replace(one, noun=one.name or one.noun, pronoun=False) for name, one in self.names.items()}
            what = replace(self, names=named)._subject(args[0])[0]
            if where and table == other:
                entry = "table.found_cell" if column else "table.found_row"
                return get(entry, table=table, where=where, what=what, column=column)
        raise _NotSimple

    def _table(self, tree: ast.expr) -> tuple[str, str]:
        """Return the names of a table or a list and of its column, in quotes; no column for the whole table."""
        if isinstance(tree, ast.Name) and key(tree.id) not in self.names:
            return self._quoted(_spaced(self.helpers.get(key(tree.id), tree.id))), ""
        if isinstance(tree, ast.Subscript) and isinstance(tree.slice, ast.Name) and isinstance(tree.value, ast.Name):
            return self._table(tree.value)[0], self._quoted(tree.slice.id)
        raise _NotSimple

    def _quoted(self, name: str) -> str:
        return self.texts.get("name.quoted", name=name)

    # ---- totals

    def total(self, formula: str, inputs: Sequence[str]) -> tuple[TotalChange, ...]:
        """Return what each of the inputs (by key) does to a total; nothing when the formula is no choice by input."""
        try:
            tree = _parse(formula)
            return tuple(self._step(self._chosen(tree, k)) for k in inputs)
        except _NotSimple:
            return ()

    def _chosen(self, tree: ast.expr, arrived: str) -> ast.expr:
        """Return the part of a formula that is used when the value of one input arrives: the others are blank."""
        called, args = _call(tree)
        if isinstance(tree, ast.IfExp):
            called, args = "if", [tree.test, tree.body, tree.orelse]
        if called != "if":
            return tree
        if len(args) != 3:
            raise _NotSimple
        return self._chosen(args[1] if self._arrival(args[0], arrived) else args[2], arrived)

    def _arrival(self, test: ast.expr, arrived: str) -> bool:
        """Return whether a test of an input for blank is true when the value of another or the same one arrives."""
        called, args = _call(test)
        if called == "not" and len(args) == 1:
            return not self._arrival(args[0], arrived)
        if isinstance(test, ast.UnaryOp) and isinstance(test.op, ast.Not):
            return not self._arrival(test.operand, arrived)
        if called != "isblank" or len(args) != 1 or not isinstance(args[0], ast.Name):
            raise _NotSimple
        name = key(args[0].id)
        content = self.names[name].content if name in self.names else None
        if content is None or (name == arrived and content.may_be_blank and not content.blank):
            raise _NotSimple
        return name != arrived or content.blank

    def _step(self, tree: ast.expr) -> TotalChange:
        called, args = _call(tree)
        if called == "max" and len(args) == 2 and isinstance(args[0], ast.Name) and key(args[0].id) == "total":
            return TotalChange("least", self._operand(args[1]))
        if isinstance(tree, ast.Name) and key(tree.id) == "total":
            return TotalChange("keep")
        if isinstance(tree, ast.BinOp) and isinstance(tree.op, ast.Add):
            added = _number_of(tree.right)
            if isinstance(tree.left, ast.Name) and key(tree.left.id) == "total" and added is not None:
                return TotalChange("add", _number(added, ""))
        return TotalChange("set", self._operand(tree))


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


def names_in(formula: str) -> set[str]:
    """Return the keys of the names in a formula; empty when it cannot be read."""
    try:
        return {key(node.id) for node in ast.walk(_parse(formula)) if isinstance(node, ast.Name)}
    except _NotSimple:
        return set()


def has_blank(formula: str) -> bool:
    """Return whether a formula names a blank."""
    try:
        return any(isinstance(node, ast.Constant) and node.value is None for node in ast.walk(_parse(formula)))
    except _NotSimple:
        return False


def _number_of(tree: ast.expr) -> float | None:
    """Return the number that a formula is; None when it is something else."""
    try:
        return _constant(tree)
    except _NotSimple:
        return None


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
    first = inputs[0] if inputs else Content()
    sources = inputs if passes is None else [first]
    blank = any(c.may_be_blank for c in sources) or (passes is not None and passes.blanks)
    if passes is not None or name == "merge":
        alike = all((c.record, c.unit) == (first.record, first.unit) for c in inputs) or name != "merge"
        record, unit = (first.record, first.unit) if alike else (None, "")
        return Content(record, unit, sensors, blank, all(c.blank for c in sources))
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
