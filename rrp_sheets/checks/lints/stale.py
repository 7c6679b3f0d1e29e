"""LINT001: combineLatest that joins a value which has ended long ago with new ones, and fixes for it."""

from __future__ import annotations

import ast
import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from rrp_sheets.checks.facts import EVENT
from rrp_sheets.checks.lints.context import LintContext, RowWriter, row_of
from rrp_sheets.diagnostics.report import Fix
from rrp_sheets.formulas import Formula, replace_names
from rrp_sheets.graph import Step
from rrp_sheets.model.names import argument_name, key
from rrp_sheets.texts import N_

_TIMES = frozenset({"t", "timestamp"})


@dataclass(frozen=True, slots=True)
class Pace:
    """The way in which a stream's values come: `filters` (refs of rows) hold some of them back.

    `rare` ones come only when something happens, `steady` ones again and again; `timed` ones carry their time.
    """

    filters: frozenset[str] = frozenset()
    rare: bool = False
    steady: bool = False
    timed: bool = False


def lint_stale(context: LintContext) -> None:
    """Report every combineLatest that joins old values with new ones."""
    paces: dict[str, Pace] = {}
    steps = {s.ref: s for s in context.steps()}
    for step in steps.values():
        inputs = [_pace(i, context, paces) for i in step.inputs]
        if not step.connector.is_sink:
            paces[step.output] = _after(step, inputs)
        if step.connector.name != "combineLatest":
            continue
        found = _stale_pair(step, inputs, context)
        if found is None:
            continue
        rare, steady = found
        filters = [steps[ref] for ref in inputs[rare].filters - inputs[steady].filters]
        why = N_("when something happens")
        if filters:
            why = N_("{row} passes only some values on", row=row_of(min(filters, key=lambda s: s.number), step))
        context.report.add(
            "LINT001", step.row.connector.address, fixes=remedies(step, step.inputs[rare], context),
            rare=context.name(step.inputs[rare]), steady=context.name(step.inputs[steady]), why=why, row=step.number,
        )  # fmt: skip


def _pace(stream: str, context: LintContext, paces: dict[str, Pace]) -> Pace:
    rate = context.fact(stream).rate
    return paces.get(stream) or Pace(rare=rate.kind == EVENT, steady=rate.hz > 0)


def _after(step: Step, inputs: Sequence[Pace]) -> Pace:
    name, passes, first = step.connector.name, step.connector.passes, inputs[0]
    if name == "filter":
        return replace(first, filters=first.filters | {step.ref})
    if name == "timestamp":
        return replace(first, timed=True)
    if passes is not None and passes.rate == "events":
        return replace(first, rare=True, steady=False)
    if name == "accumulate":
        return Pace()  # a total stays true until the next one
    if passes is not None and passes.rate == "changes":
        return replace(first, rare=False, steady=False)  # what has not changed is still so
    if name in ("combineLatest", "merge"):
        filters = frozenset.intersection(*(p.filters for p in inputs))
        return Pace(filters, all(p.rare for p in inputs), any(p.steady for p in inputs), all(p.timed for p in inputs))
    return replace(first, timed=False) if name == "map" else first


def _stale_pair(step: Step, inputs: Sequence[Pace], context: LintContext) -> tuple[int, int] | None:
    """Return the places of an input that may be old and of one that goes on, or None when the age is bounded."""
    formula = context.compiled.formulas.get(step.ref)
    if formula is None and step.row.formula:
        return None  # the formula is wrong, which is told there
    for old, slow in enumerate(inputs):
        for new, quick in enumerate(inputs):
            held_back = slow.filters > quick.filters
            waits = slow.rare and not quick.rare
            if old == new or not quick.steady or not (held_back or waits):
                continue
            # a row without formula passes its inputs on whole, blanks and times included
            forgets = formula is None or formula.names[old] in formula.used
            if forgets and context.fact(step.inputs[old]).known.blank:
                continue
            if not (slow.timed and quick.timed):
                return old, new
            if formula is not None and not (_uses_time(formula, old) and _uses_time(formula, new)):
                return old, new
    return None


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


LONGEST_SECONDS = 1
LONGEST_AGE = f"{LONGEST_SECONDS} s"


def remedies(step: Step, rare: str, context: LintContext) -> list[Fix]:
    """Return fixes that forget the old value or compare timestamps; none for rows that they cannot rewrite."""
    formula = step.row.formula.text
    named = [context.graph.streams[i].name for i in step.inputs]
    if not formula or not all(named) or not step.row.inputs:
        return []
    made = [_forgetting(step, rare, context), _timing(step, context)]
    return [fix for fix in made if fix is not None]


def _forgetting(step: Step, rare: str, context: LintContext) -> Fix | None:
    old = context.graph.streams[rare].name
    recent = _free(f"Recent {old}", step, context)
    text = _opened(step, context)
    inner = replace_names(text, {key(argument_name(old)): argument_name(recent)})
    if inner is None:
        return None
    inputs = ", ".join(recent if key(c.text) == key(old) else c.text for c in step.row.inputs)
    formula = f"IF(ISBLANK({argument_name(recent)}); BLANK; {inner})"
    row = RowWriter(step)
    row.insert(old, "forgetAfter", LONGEST_AGE, recent)
    if all(r.connector.is_sink and not r.row.formula for r in context.readers.get(step.output, [])):
        # only actuators read it, and the blank stops them
        row.put(inputs, None, formula, step.row.output.text)
    else:
        either = _free(f"{step.row.output.text or 'Joined'} or blank", step, context)
        row.put(inputs, None, formula, either)
        row.insert(either, "filter", f"NOT(ISBLANK({argument_name(either)}))", step.row.output.text, after=True)
    title = N_("Forget “{name}” {age} after its last value (forgetAfter)", name=old, age=LONGEST_AGE)
    return Fix("forget-old-value", title, tuple(row.edits))


def _timing(step: Step, context: LintContext) -> Fix | None:
    names = [context.graph.streams[i].name for i in step.inputs]
    timed = {n: _free(f"{n} with time", step, context) for n in names}
    text = _opened(step, context)
    inner = replace_names(text, {key(argument_name(n)): f"{argument_name(t)}.v" for n, t in timed.items()})
    if inner is None:
        return None
    times = "; ".join(f"{argument_name(t)}.t" for t in timed.values())
    output = step.row.output.text or _free("Joined", step, context)
    pair, fresh = _free(f"{output} and age", step, context), _free(f"Fresh {output}", step, context)
    row = RowWriter(step)
    for name, new in timed.items():
        row.insert(name, "timestamp", "", new)
    row.put(", ".join(timed.values()), None, f"({inner}, MAX({times}) - MIN({times}))", pair)
    row.insert(pair, "filter", f"{argument_name(pair)}[1] < {LONGEST_SECONDS}", fresh, after=True)
    row.insert(fresh, "map", f"{argument_name(fresh)}[0]", step.row.output.text, after=True)
    title = N_("Join only values that came within {age} of each other (timestamp)", age=LONGEST_AGE)
    return Fix("join-close-in-time", title, tuple(row.edits))


def _opened(step: Step, context: LintContext) -> str:
    """Return the row's formula; a helper's name alone becomes a call of it."""
    text = step.row.formula.text
    helper = context.compiled.helpers.by_key.get(key(text))
    if helper is None or not helper.parameters:
        return text.removeprefix("=")
    names = ", ".join(argument_name(context.graph.streams[i].name) for i in step.inputs)
    return f"{argument_name(helper.shown)}({names})"


def _free(name: str, step: Step, context: LintContext) -> str:
    sheet = key(step.row.output.address.sheet)
    streams: Mapping[str, object] = context.graph.streams
    names = itertools.chain([name], (f"{name} {n}" for n in itertools.count(2)))
    return next(n for n in names if key(n) not in streams and f"{sheet}!{key(n)}" not in streams)
