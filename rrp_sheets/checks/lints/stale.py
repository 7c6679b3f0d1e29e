"""The stale combination: combineLatest joins a value that has ended long ago with new ones (thesis, 4.4.8)."""

from __future__ import annotations

import ast
from collections.abc import Sequence
from dataclasses import dataclass, replace

from rrp_sheets.checks.facts import EVENT
from rrp_sheets.checks.lints.material import Material, row_of
from rrp_sheets.checks.lints.stale_fixes import remedies
from rrp_sheets.diagnostics.phrase import Phrase
from rrp_sheets.formulas import Formula
from rrp_sheets.graph import Step
from rrp_sheets.model.names import key

_RARE = frozenset({"once", "timeout"})
_TIMES = frozenset({"t", "timestamp"})


@dataclass(frozen=True, slots=True)
class Pace:
    """How a stream's values come.

    Attributes:
        filters: refs of the filter rows that hold some of them back.
        rare: whether they come only when something happens.
        steady: whether they come again and again.
        timed: whether they carry the time at which they came.
    """

    filters: frozenset[str] = frozenset()
    rare: bool = False
    steady: bool = False
    timed: bool = False


def lint_stale(material: Material) -> None:
    """Report every combineLatest that joins old values with new ones."""
    paces: dict[str, Pace] = {}
    steps = {s.ref: s for s in material.steps()}
    for step in steps.values():
        inputs = [_pace(i, material, paces) for i in step.inputs]
        if not step.connector.is_sink:
            paces[step.output] = _after(step, inputs)
        if step.connector.name != "combineLatest":
            continue
        found = _stale_pair(step, inputs, material)
        if found is None:
            continue
        rare, steady = found
        filters = sorted(inputs[rare].filters - inputs[steady].filters, key=lambda ref: steps[ref].number)
        why = (
            Phrase("{row} lets only some values pass", row=row_of(steps[filters[0]], step))
            if filters
            else "when something happens"
        )
        material.report.add(
            "LINT001",
            step.row.connector.address,
            fixes=remedies(step, step.inputs[rare], material),
            rare=material.name(step.inputs[rare]),
            steady=material.name(step.inputs[steady]),
            why=why,
            row=step.number,
        )


def _pace(stream: str, material: Material, paces: dict[str, Pace]) -> Pace:
    if stream in paces:
        return paces[stream]
    rate = material.fact(stream).rate
    return Pace(rare=rate.kind == EVENT, steady=rate.hz > 0)


def _after(step: Step, inputs: Sequence[Pace]) -> Pace:
    """The pace of what a row gives."""
    name, first = step.connector.name, inputs[0]
    if name == "filter":
        return replace(first, filters=first.filters | {step.ref})
    if name == "timestamp":
        return replace(first, timed=True)
    if name in _RARE:
        return replace(first, rare=True, steady=False)
    if name == "accumulate":
        return Pace()  # a total stays true until the next one
    if name == "changes":
        return replace(first, rare=False, steady=False)  # what has not changed is still so
    if name in ("combineLatest", "merge"):
        filters = frozenset.intersection(*(p.filters for p in inputs))
        return Pace(filters, all(p.rare for p in inputs), any(p.steady for p in inputs), all(p.timed for p in inputs))
    return replace(first, timed=False) if name == "map" else first


def _stale_pair(step: Step, inputs: Sequence[Pace], material: Material) -> tuple[int, int] | None:
    """The places of an input that may be old and of one that goes on, when nothing bounds the age."""
    formula = material.compiled.formulas.get(step.ref)
    if formula is None and step.row.formula:
        return None  # the formula is wrong, which is told there
    for old, slow in enumerate(inputs):
        for new, quick in enumerate(inputs):
            held_back = slow.filters - quick.filters and not quick.filters - slow.filters
            waits = slow.rare and not quick.rare
            if old == new or not quick.steady or not (held_back or waits):
                continue
            forgets = material.fact(step.inputs[old]).may_be_blank and _asks(formula, old)
            if forgets or (slow.timed and quick.timed and _compares_times(formula, old, new)):
                continue
            return old, new
    return None


def _asks(formula: Formula | None, place: int) -> bool:
    """Whether a formula looks at an input, so that a blank one makes a difference."""
    return formula is None or formula.names[place] in formula.used


def _compares_times(formula: Formula | None, old: int, new: int) -> bool:
    """Whether a formula uses the times of both inputs, or passes them on whole."""
    return formula is None or (_uses_time(formula, old) and _uses_time(formula, new))


def _uses_time(formula: Formula, place: int) -> bool:
    name = formula.names[place]
    for node in ast.walk(formula.tree):
        if isinstance(node, ast.Call) and any(isinstance(a, ast.Name) and a.id == name for a in node.args):
            return True  # a helper looks at it
        owner = getattr(node, "value", None)
        if not (isinstance(owner, ast.Name) and owner.id == name):
            continue
        if isinstance(node, ast.Attribute) and key(node.attr) in _TIMES:
            return True
        if isinstance(node, ast.Subscript) and isinstance(node.slice, ast.Constant):
            return node.slice.value == 0 or key(str(node.slice.value)) in _TIMES
    return False
