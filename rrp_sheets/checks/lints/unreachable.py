"""LINT005, LINT007, LINT015: filters that nothing passes or nothing stops, and done streams that never have a value."""

from __future__ import annotations

import ast

from rrp_sheets.checks.facts import NUMBER, known_of
from rrp_sheets.checks.lints.context import LintContext, row_of
from rrp_sheets.checks.lints.unmatched import NEVER_PASSES
from rrp_sheets.formulas import Formula
from rrp_sheets.formulas.parsing import Pick
from rrp_sheets.graph import Step, StreamKind
from rrp_sheets.model.values import show
from rrp_sheets.texts import N_, listed

_MOST_CHOICES = 5  # values that are named


def lint_unreachable(context: LintContext) -> None:
    """Report filters that pass nothing or everything."""
    for step in context.steps():
        if step.connector.name == "filter":
            _filter(step, context)


def lint_undriven(context: LintContext) -> None:
    """Report done streams that never have a value, as no row drives their actuator."""
    driven = {s.output for s in context.steps() if s.connector.is_sink}
    told: set[str] = set()
    for step in context.steps():
        for stream in step.inputs:
            found = context.graph.streams[stream]
            if found.kind is StreamKind.DONE and found.done_of not in driven and stream not in told:
                told.add(stream)
                actuator = found.name.removesuffix(" done")
                context.report.add("LINT007", step.row.inputs_cell.address, name=found.name, actuator=actuator)


def _filter(step: Step, context: LintContext) -> None:
    formula = context.compiled.formulas.get(step.ref)
    if formula is None:
        return
    address = step.row.formula.address
    if step.ref in context.routes.dead:
        routes = context.routes.of.get(step.inputs[0]) or ()
        steps = {s.ref: s for s in context.steps()} if routes else {}
        before = [steps[ref] for ref in dict.fromkeys(ref for r in routes for ref in r.filters)][:3]
        why = N_("its condition is never true for the values that its input can have")
        remedy = N_("Compare it with the values that its input can have.")
        first = step.inputs[0]
        can = context.fact(first).known.choices
        if before:
            rows = listed([row_of(s, step) for s in before], "and")
            why = N_("its condition contradicts {rows}, or the values that its input can have", rows=rows)
            remedy = N_("Compare it with the condition of {rows}.", rows=rows)
        elif can is not None and 0 < len(can) <= _MOST_CHOICES:
            values = listed([N_("“{text}”", text=v) if isinstance(v, str) else show(v) for v in can], "or")
            why = N_("“{name}” can only be {values}, so this never matches", name=context.name(first), values=values)
        if not any(d.code == "LINT005" and d.address == address for d in context.report):  # of a text in it
            context.report.add("LINT005", address, what=NEVER_PASSES, why=why, remedy=remedy)
    elif not formula.used:
        _without_input(step, formula, context)
    else:
        names = {n: context.fact(i).known for n, i in zip(formula.names, step.inputs, strict=True)}
        known = known_of(formula.tree, names)
        if known.kind == NUMBER and not known.blank and (known.low > 0 or known.high < 0):
            why = N_("a number passes unless it is 0, and this number never is 0")
            context.report.add("LINT015", address, why=why, example=f"{formula.text.strip()[:40]} > 1")


def _without_input(step: Step, formula: Formula, context: LintContext) -> None:
    """Report a filter whose formula does not use what arrives: all of it passes, or nothing."""
    if any(isinstance(n, Pick) for n in ast.walk(formula.tree)):
        return  # it is drawn anew each time
    value = context.compiled.examples.value(formula, [None] * len(formula.names))
    if not (value is None or isinstance(value, (bool, int, float))):
        return
    address, why = step.row.formula.address, N_("the formula is always blank, whatever arrives")
    if value is not None:
        why = N_("the formula is always {value}, whatever arrives", value=show(value))
    if value:
        example = f"{formula.names[0]} > 1" if formula.names else "distance < 0.5"
        context.report.add("LINT015", address, why=why, example=example)
    else:
        remedy = N_("Use the input in the condition.")
        context.report.add("LINT005", address, what=NEVER_PASSES, why=why, remedy=remedy)
