"""Contents of the streams as far as the rows show them: record fields, units, and the sensors behind them."""

from __future__ import annotations

import ast
from collections.abc import Mapping
from dataclasses import dataclass, field

from rrp_sheets.graph import Graph, Step, Stream, StreamKind
from rrp_sheets.model.names import argument_name, key
from rrp_sheets.model.values import RecordType

_BLANK = {"blank", "none", "blank()"}
_PASSES = {"filter", "sample", "merge", "forgetafter", "delay", "throttle", "changes", "once", "timeout"}


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
    found = {stream.id: _of_sensor(stream) for stream in graph.streams.values() if stream.kind in given}
    steps = sorted((s for b in graph.behaviours for s in b.steps), key=lambda s: s.rank)
    for step in steps:
        stream = graph.streams.get(step.output)
        if stream is None or stream.kind in (StreamKind.ACTUATOR, *given):
            continue
        found[step.output] = _of_step(step, found, graph)
    return found


def _of_sensor(stream: Stream) -> Content:
    kind = stream.device.type if stream.device else None
    sensors = {stream.id: None} if stream.kind is StreamKind.SENSOR else {}
    return Content(kind.payload if kind else None, kind.unit if kind else "", sensors)


def _of_step(step: Step, found: Mapping[str, Content], graph: Graph) -> Content:
    inputs = [found.get(i, Content()) for i in step.inputs]
    sensors = {s: None for content in inputs for s in content.sensors}
    blank = any(c.may_be_blank for c in inputs) or key(step.connector.name) == "forgetafter"
    first = inputs[0] if inputs else Content()
    name = key(step.connector.name)
    if name in _PASSES:
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
        tree = ast.parse(formula.strip().lstrip("=").strip(), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return None, ""
    if isinstance(tree, ast.Name) and key(tree.id) in names:
        content = names[key(tree.id)]
        return content.record, content.unit
    if isinstance(tree, ast.Attribute) and isinstance(tree.value, ast.Name) and key(tree.value.id) in names:
        record = names[key(tree.value.id)].record
        found = find_field(record, tree.attr)
        return None, found[1] if found else ""
    return None, ""


def find_field(record: RecordType | None, name: str) -> tuple[str, str, str] | None:
    """Return the shown name, unit and kind of a record's field, or None."""
    wanted = record.keys.get(key(name)) if record else None
    return next(((f.name, f.unit, f.kind) for f in record.fields if key(f.name) == wanted), None) if record else None
