"""Reads the Send cell of a test row: a value, a formula for one, or fields of the example."""

from __future__ import annotations

from dataclasses import dataclass

from rrp_sheets.checks.parts import TooLarge, compiled, fields, literal, without_equals
from rrp_sheets.diagnostics import Report
from rrp_sheets.diagnostics.phrase import Phrase, sentences, small
from rrp_sheets.diagnostics.proposals import meant
from rrp_sheets.formulas import Formula, FormulaProblem, Scope
from rrp_sheets.model.cells import Cell
from rrp_sheets.model.names import key, nearest
from rrp_sheets.model.values import RecordType, Value

Given = Formula | Value
"""Source of a value: a formula without inputs, evaluated when it is sent, or the value itself."""


@dataclass(frozen=True)
class Sending:
    """The meaning of a test row's Send cell.

    Attributes:
        text: as the cell says it.
        value: when the whole cell is one value or formula.
        fields: values of fields, by the field's name; the others have their example values.
        whole: True when `value` counts, False when it is the example with `fields` changed.
    """

    text: str
    value: Given = None
    fields: tuple[tuple[str, Given], ...] = ()
    whole: bool = False


def read_send(cell: Cell, record: RecordType | None, scope: Scope, report: Report) -> Sending | None:
    """Return the meaning of a Send cell; None when it is refused, which is reported.

    Args:
        cell: of the sheet; not blank.
        record: of the stream, where it is known.
        scope: of a formula without inputs.
        report: where findings go.
    """
    text = without_equals(cell.text)
    try:
        found, value = literal(text)
        if found:
            if record is not None and value is not None:
                every = ", ".join(f.name for f in record.fields)
                report.add("TEST015", cell.address, text=cell.text, record=record.name, fields=every,
                           example=record.fields[0].name)  # fmt: skip
            return Sending(cell.text, value, whole=True)
        parts = fields(text)
        if parts is not None:
            return _fields(cell, parts, record, scope, report)
    except TooLarge as error:
        report.add("TEST014", cell.address, text=str(error))
        return None
    formula = compiled(text, scope)
    if isinstance(formula, FormulaProblem):
        tell_formula(report, "TEST007", cell, formula)
        return None
    return Sending(cell.text, formula, whole=True)


def _fields(
    cell: Cell, parts: list[tuple[str, str]], record: RecordType | None, scope: Scope, report: Report
) -> Sending | None:
    if not known_fields(cell, [name for name, _ in parts], record, report):
        return None
    given: list[tuple[str, Given]] = []
    for name, text in parts:
        found, value = literal(text)
        if not found:
            formula = compiled(text, scope)
            if isinstance(formula, Formula):
                value = formula
            elif _is_text(name, record):
                value = text  # zone=Left hand
            else:
                tell_formula(report, "TEST007", cell, formula)
                return None
        given.append((name, value))
    return Sending(cell.text, fields=tuple(given))


def known_fields(cell: Cell, names: list[str], record: RecordType | None, report: Report) -> bool:
    """Return whether a record has all these fields, each named once; problems are reported."""
    seen: set[str] = set()
    for name in names:
        k = record.keys.get(key(name)) if record else key(name)
        if k is None and record is not None:
            guess = nearest(name, [f.name for f in record.fields])
            every = ", ".join(f.name for f in record.fields)
            otherwise = Phrase("Its fields are: {every}.", every=every)
            report.add("TEST008", cell.address, record=record.name, field=name, **meant(guess, otherwise))
            return False
        if k in seen:
            report.add("TEST013", cell.address, field=name)
            return False
        seen.add(k or "")
    return True


def _is_text(name: str, record: RecordType | None) -> bool:
    if record is None:
        return True
    k = record.keys[key(name)]
    return any(key(f.name) == k and f.kind in ("text", "any") for f in record.fields)


def tell_formula(report: Report, code: str, cell: Cell, problem: FormulaProblem) -> None:
    """Report a formula's problem at a test's cell."""
    why, remedy = small(problem.message), problem.remedy
    if code == "TEST007" and problem.code == "FORM004":
        name = problem.details.get("name", "")
        why = Phrase("“{name}” is no number, no text in quotes, no helper and no table.", name=name)
        remedy = Phrase(
            'Put a text between quotes: "{name}". Fields of a record are written as field=value.', name=name
        )
    elif code == "TEST007" and problem.code == "FORM001" and "quotes" not in problem.details:
        remedy = sentences(remedy, 'A text to send stands in quotes: "Hello".')
    report.add(code, cell.address, text=cell.text, why=why, remedy=remedy)
