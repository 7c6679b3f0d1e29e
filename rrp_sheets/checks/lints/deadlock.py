"""Rows that wait for the end of a command which only they themselves can cause.

A row can act once every input that it needs can have a value. A done stream can have one once a row that drives its
actuator can act. Whatever is not reached in this way from the sensors never acts.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from rrp_sheets.checks.lints.material import Material
from rrp_sheets.graph import Step, Stream, StreamKind

_ALL = frozenset({"map", "filter", "combineLatest"})
"""Connectors that give nothing before each input has had a value; `subscribe` with a formula is another."""
_FIRST = frozenset({"timestamp", "sample", "forgetAfter", "once", "changes", "timeout", "delay", "throttle"})
"""Connectors that give nothing before the first input has had a value; the others may take any input."""


def lint_deadlock(material: Material) -> None:
    """Report rows that need a done stream of an actuator which only they can start."""
    steps = [s for b in material.graph.behaviours for s in b.steps if s.active and s.inputs]
    makers: dict[str, list[Step]] = {}
    for step in steps:
        makers.setdefault(step.output, []).append(step)
    dead = _never_acting(steps, makers, material.graph.streams)
    told: list[Step] = []
    reported = {step.ref for step in material.steps()}
    for step in steps:
        if step.ref not in dead or step.ref not in reported:
            continue
        for stream in (material.graph.streams[i] for i in _needs(step)):
            behind = _behind(makers.get(stream.done_of, ()), dead, makers, material.graph.streams)
            if stream.kind is not StreamKind.DONE or step.ref not in behind:
                continue
            if not any(other.ref in behind for other in told):
                told.append(step)
                name = makers[stream.done_of][0].output
                actuator = material.graph.streams[name].name
                material.report.add("LINT017", step.row.inputs_cell.address, done=stream.name, actuator=actuator)
            break


def _needs(step: Step) -> tuple[str, ...]:
    """The inputs without which a row does nothing; of those that take any input, all."""
    return step.inputs[:1] if step.connector.name in _FIRST else step.inputs


def _needs_all(step: Step) -> bool:
    formula = step.connector.drives and bool(step.row.formula)
    return step.connector.name in _ALL or step.connector.name in _FIRST or formula


def _never_acting(
    steps: Iterable[Step], makers: Mapping[str, list[Step]], streams: Mapping[str, Stream]
) -> dict[str, Step]:
    """The rows that can never act, by ref."""
    left = {step.ref: step for step in steps}
    acting: set[str] = set()

    def comes(stream: Stream) -> bool:
        source = stream.done_of if stream.kind is StreamKind.DONE else stream.id
        rows = makers.get(source)
        return not rows or any(row.ref in acting for row in rows)  # a sensor, or an end that nothing here causes

    grown = True
    while grown:
        grown = False
        for step in list(left.values()):
            ready = [comes(streams[i]) for i in _needs(step)]
            if all(ready) if _needs_all(step) else any(ready):
                acting.add(step.ref)
                del left[step.ref]
                grown = True
    return left


def _behind(
    rows: Iterable[Step], dead: Mapping[str, Step], makers: Mapping[str, list[Step]], streams: Mapping[str, Stream]
) -> set[str]:
    """The rows that never act and on which these rows wait, themselves included."""
    found: set[str] = set()
    waiting = [row for row in rows if row.ref in dead]
    while waiting:
        row = waiting.pop()
        if row.ref in found:
            continue
        found.add(row.ref)
        for stream in (streams[i] for i in _needs(row)):
            source = stream.done_of if stream.kind is StreamKind.DONE else stream.id
            waiting += [maker for maker in makers.get(source, ()) if maker.ref in dead]
    return found
