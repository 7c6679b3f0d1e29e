"""The record types that flow: what is known of a formula's result, and of what a connector passes on."""

from __future__ import annotations

import ast
from collections.abc import Mapping, Sequence

from rrp_sheets.connectors.combine_latest import together
from rrp_sheets.connectors.timestamp import TIMED
from rrp_sheets.formulas import Formula, HelperDef, Table
from rrp_sheets.graph import Graph, Step
from rrp_sheets.model.names import key
from rrp_sheets.model.values import Field, RecordType

_PASS = frozenset({"filter", "sample", "forgetAfter", "once", "timeout", "changes", "throttle", "delay"})
_ROW_OF = {"INDEX": 0, "PICK": 0, "XLOOKUP": 2}  # functions that give a row of the table which is that argument
Records = Mapping[str, RecordType | None]


def record_of(step: Step, graph: Graph, records: Records, formula: Formula | None) -> RecordType | None:
    """The record type of what a row gives, where it is known."""
    name = step.connector.name
    kinds = [records.get(i) for i in step.inputs]
    if name == "timestamp":
        value = Field("value", example=kinds[0].example() if kinds and kinds[0] else None)
        return RecordType(TIMED.name, (value, *TIMED.fields[1:]), TIMED.aliases, TIMED.positions)
    if name == "combineLatest" and formula is None and not step.row.formula:
        return together(tuple(graph.streams[i].name for i in step.inputs))
    if name in _PASS:
        return kinds[0] if kinds else None
    if name == "merge":
        return _same(kinds)
    if formula is None:
        return None
    inputs = formula.names[len(formula.names) - len(kinds) :]
    return result_record(formula.tree, dict(zip(inputs, kinds, strict=True)))


def _same(kinds: Sequence[RecordType | None]) -> RecordType | None:
    return kinds[0] if kinds and all(k == kinds[0] for k in kinds) else None


def result_record(tree: ast.AST, names: Records) -> RecordType | None:
    """The record type of a formula's value, from those of its names."""
    if isinstance(tree, ast.Name):
        return names.get(tree.id)
    if isinstance(tree, ast.IfExp):
        return _either(tree.body, tree.orelse, names)
    if isinstance(tree, ast.Attribute):
        outer = result_record(tree.value, names)
        wanted = outer.keys.get(key(tree.attr)) if outer else None
        example = next((f.example for f in outer.fields if key(f.name) == wanted), None) if outer else None
        return getattr(example, "type", None)
    if isinstance(tree, ast.Call):
        return _called(tree, names)
    return None


def _either(first: ast.AST, second: ast.AST, names: Records) -> RecordType | None:
    """Of two branches; a branch that is blank has no say."""
    kinds = [result_record(b, names) for b in (first, second) if not (isinstance(b, ast.Constant) and b.value is None)]
    return _same(kinds)


def _called(call: ast.Call, names: Records) -> RecordType | None:
    helper: HelperDef | None = getattr(call, "helper", None)
    if helper is not None:
        given = [result_record(a, names) for a in call.args]
        inner = {p.name: kind for p, kind in zip(helper.parameters, given, strict=True)}
        return result_record(helper.tree, inner) if helper.tree is not None else None
    place = _ROW_OF.get(call.func.id) if isinstance(call.func, ast.Name) else None
    if place is None or len(call.args) <= place:
        return None
    source = call.args[place]
    if not isinstance(source, ast.Constant) or not isinstance(source.value, Table):
        return None
    if len(call.args) == 4:  # XLOOKUP with what it gives when nothing is found
        return _either_row(source.value.type, call.args[3], names)
    return source.value.type


def _either_row(row: RecordType, other: ast.AST, names: Records) -> RecordType | None:
    blank = isinstance(other, ast.Constant) and other.value is None
    return row if blank or result_record(other, names) == row else None
