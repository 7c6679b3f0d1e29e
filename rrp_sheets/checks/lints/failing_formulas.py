"""LINT006, LINT010, LINT011: formulas that fail on examples, are no condition, or read merged values of two kinds."""

from __future__ import annotations

import ast

from rrp_sheets.checks.examples import alike
from rrp_sheets.checks.facts import LIST, RECORD, TEXT, known_of
from rrp_sheets.checks.lints.context import LintContext, row_key, row_of
from rrp_sheets.diagnostics import CODES
from rrp_sheets.formulas import Formula
from rrp_sheets.formulas.problems import KINDS, kind_of
from rrp_sheets.graph import Step
from rrp_sheets.model.names import key
from rrp_sheets.model.values import Failure, Record, Value, show
from rrp_sheets.texts import N_

_NO_CONDITION = (TEXT, LIST, RECORD)
MOST_STREAMS = 100  # that are followed from one merge
_ANY_VALUE = "any event"  # what an actuator takes that does not look at the value


def lint_failing_formulas(context: LintContext) -> None:
    """Report the problems of the rows' formulas that follow from the facts."""
    for step in context.steps():
        formula = context.compiled.formulas.get(step.ref)
        if formula is not None and not _no_condition(step, formula, context):
            _trouble(step, context)
        if step.connector.name == "merge":
            _mixed(step, context)


def _no_condition(step: Step, formula: Formula, context: LintContext) -> bool:
    """Report a filter whose formula gives a text, a list or a record, and return whether it does."""
    if step.connector.name != "filter":
        return False
    names = {n: context.fact(i).known for n, i in zip(formula.names, step.inputs, strict=True)}
    kind = known_of(formula.tree, names).kind
    if kind in _NO_CONDITION:
        example = f'{formula.text.strip()[:40]} = "…"' if kind == TEXT else "distance < 0.5"
        context.report.add("LINT011", step.row.formula.address, what=KINDS[kind], example=example)
    return kind in _NO_CONDITION


def _trouble(step: Step, context: LintContext) -> None:
    trouble = context.compiled.troubles.get(step.ref)
    if trouble is None:
        return
    failure = trouble.failure
    remedy = CODES[failure.code].constant_remedy or N_("Check what the inputs give.")
    formula = context.compiled.formulas[step.ref]
    values = ", ".join(text for name, value in trouble.values for text in _said(formula, name, value))
    span = (failure.column, failure.column + 1) if failure.column >= 0 else None
    address = step.row.formula.address
    context.report.add("LINT010", address, span=span, values=values, reason=failure.message, remedy=remedy)


def _said(formula: Formula, name: str, value: Value) -> list[str]:
    """Return an example in words; of a record, only the fields that the formula reads."""
    shown, found = name.strip() or "value", list[str]()
    if isinstance(value, Record):
        nodes = (n for n in ast.walk(formula.tree) if isinstance(n, ast.Attribute))
        read = dict.fromkeys(n.attr for n in nodes if isinstance(n.value, ast.Name) and n.value.id == name)
        fields = [(field, value.type.keys.get(key(field), "")) for field in read]
        found = [f"{shown}.{field} {show(value.values[k], 40)}" for field, k in fields if k in value.values]
    return found or [f"{shown} {show(value, 60)}"]


def _mixed(step: Step, context: LintContext) -> None:
    """Report a merge of values of different kinds, where a row or an actuator needs them to be alike."""
    first, *others = step.inputs
    fact = context.fact(first)
    if not fact.has_example or fact.example is None:
        return
    for other in others:
        second = context.fact(other)
        if not second.has_example or alike(fact.example, second.example):
            continue
        use = _use(step.output, [fact.example, second.example], context, step, set())
        if use is not None:
            context.report.add(
                "LINT006", step.row.inputs_cell.address, output=context.name(step.output), use=use,
                first=_kind(fact.example), one=context.name(first),
                second=_kind(second.example), two=context.name(other),
            )  # fmt: skip
            return


def _kind(value: Value) -> str:
    return N_("a record ({name})", name=value.type.name) if isinstance(value, Record) else kind_of(value)


def _use(stream: str, values: list[Value], context: LintContext, merge: Step, seen: set[str]) -> str | None:
    """Return in words how a stream's values are used so that their kind matters; None when it does not."""
    plain = not any(isinstance(v, Record) for v in values)
    seen.add(stream)
    for reader in context.readers.get(stream, []):
        if row_key(reader.row.output.address) in context.unclear:
            continue
        formula = context.compiled.formulas.get(reader.ref)
        if formula is not None:
            fails = [_fails(formula, reader, stream, v, context) for v in values]
            if any(fails) and not all(fails):
                return N_(", and the formula of {row} cannot work with both", row=row_of(reader, merge))
        connector = reader.connector
        if connector.name == "merge" or (connector.passes is not None and reader.inputs[0] == stream):
            if reader.output in seen or len(seen) >= MOST_STREAMS:
                continue
            found = _use(reader.output, values, context, merge, seen)
            if found is not None:
                return found
        elif connector.is_sink and formula is None and plain:
            device = context.graph.streams[reader.output].device
            if device is not None and not device.type.takes.startswith(_ANY_VALUE):
                return ""
    return None


def _fails(formula: Formula, reader: Step, stream: str, value: Value, context: LintContext) -> bool:
    values: list[Value] = [0 if name == "total" else value for name in reader.connector.extra]
    for i in reader.inputs:
        fact = context.fact(i)
        if i != stream and not fact.has_example:
            return False
        values.append(value if i == stream else None if reader.connector.name == "accumulate" else fact.example)
    result = context.compiled.examples.value(formula, values)
    return isinstance(result, Failure) and bool(result.code)
