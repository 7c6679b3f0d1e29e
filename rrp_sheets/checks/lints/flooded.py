"""LINT002: speech that is driven by streams with many values a second."""

from __future__ import annotations

from rrp_sheets.checks.facts import BLANK, CAMERA, CHANGE, TIMER
from rrp_sheets.checks.lints.conflicts import VOICE
from rrp_sheets.checks.lints.context import LintContext, RowWriter
from rrp_sheets.diagnostics.report import Fix, FixEdit
from rrp_sheets.graph import Step
from rrp_sheets.texts import N_

TOO_OFTEN_HZ = 1.0  # a short sentence takes longer than a second
PERIOD = "10 s"  # of the throttle that is proposed, in words and as a fix


def lint_flooded(context: LintContext) -> None:
    """Report rows that would make the robot speak without a pause."""
    counted: set[str] = set()
    for step in context.steps():
        if step.connector.name == "accumulate" or counted.intersection(step.inputs):
            counted.add(step.output)  # a total decides about it: how often that is so cannot be said
        device, fact = context.graph.streams[step.output].device, context.fact(step.ref)
        speaks = step.connector.is_sink and device is not None and VOICE in device.type.resources
        often = fact.rate.kind in (CAMERA, CHANGE, TIMER) and fact.rate.hz > TOO_OFTEN_HZ
        if speaks and often and fact.known.kind != BLANK and not counted.intersection(step.inputs):
            source, hz = context.name(step.inputs[0]), f"{fact.rate.hz:g}"
            fixes = _fixes(step, context)
            context.report.add("LINT002", step.row.connector.address, fixes=fixes, stream=source, hz=hz, period=PERIOD)


def _fixes(step: Step, context: LintContext) -> list[Fix]:
    row = step.row
    names = [c.text for c in row.inputs] or [context.graph.streams[i].name for i in step.inputs]
    formula = context.compiled.formulas.get(step.ref)
    if len(names) != 1 or (row.formula and (formula is None or formula.used)):  # after a row before it they are others
        return []
    shown = context.name(step.inputs[0])

    def before(connector: str, period: str) -> tuple[FixEdit, ...]:
        writer = RowWriter(step)
        writer.insert(names[0] if row.inputs else "", connector, period, "")
        writer.put("")  # its input is now the row above
        return tuple(writer.edits)

    once = N_("Let “{name}” speak once in {period} at most (throttle)", name=shown, period=PERIOD)
    changed = N_("Speak only when “{name}” has changed (changes)", name=shown)
    return [Fix("throttle", once, before("throttle", PERIOD)), Fix("changes", changed, before("changes", ""))]
