"""LINT017: rows that wait for the end of a command which only they themselves can cause.

A row can act once every input that it needs can have a value. A done stream can have one once a row that drives its
actuator can act. Whatever is not reached in this way from the sensors never acts.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rrp_sheets.checks.lints.context import LintContext
from rrp_sheets.graph import Step, Stream, StreamKind

_ALL = frozenset({"map", "filter", "combineLatest", "timestamp"})
"""Connectors that give nothing before each input has had a value; `subscribe` with a formula is another."""
_MOST_ACTUATORS = 100  # that are looked behind: the check of a long sheet must stay quick


def lint_deadlock(context: LintContext) -> None:
    """Report rows that need a done stream of an actuator which only they can start."""
    streams = context.graph.streams
    steps = [s for b in context.graph.behaviours for s in b.steps if s.active and s.inputs]
    makers: dict[str, list[Step]] = {}
    for step in steps:
        makers.setdefault(step.output, []).append(step)
    dead = _never_acting(steps, makers, streams)
    behind: dict[str, set[str]] = {}
    told: list[str] = []
    for step in context.steps():
        for stream in (streams[i] for i in _needs(step)) if step.ref in dead else ():
            actuator = stream.done_of
            if stream.kind is not StreamKind.DONE or actuator not in makers:
                continue
            if actuator not in behind:
                if len(behind) == _MOST_ACTUATORS:
                    return
                behind[actuator] = _behind(actuator, dead, makers, streams)
            if step.ref in behind[actuator]:
                if not any(ref in behind[actuator] for ref in told):
                    told.append(step.ref)
                    name = streams[makers[actuator][0].output].name
                    context.report.add("LINT017", step.row.inputs_cell.address, done=stream.name, actuator=name)
                break


def _needs(step: Step) -> tuple[str, ...]:
    """Return the inputs without which a row does nothing; for a row that takes any input, all of them."""
    return step.inputs[:1] if step.connector.passes and step.connector.name not in _ALL else step.inputs


def _source(stream: Stream) -> str:
    """Return the id of the stream whose rows give a stream its values: for a done stream, its actuator's."""
    return stream.done_of if stream.kind is StreamKind.DONE else stream.id


def _never_acting(
    steps: Sequence[Step], makers: Mapping[str, list[Step]], streams: Mapping[str, Stream]
) -> dict[str, Step]:
    left = {step.ref: step for step in steps}
    readers: dict[str, list[Step]] = {}
    for step in steps:
        for stream in _needs(step):
            readers.setdefault(_source(streams[stream]), []).append(step)
    given: set[str] = set()  # outputs of rows that can act
    waiting = list(steps)
    while waiting:
        step = waiting.pop()
        sources = [_source(streams[i]) for i in _needs(step)]
        ready = [s not in makers or s in given for s in sources]  # a sensor, or an end that nothing here causes
        connector = step.connector
        every = connector.name in _ALL or connector.passes is not None or (connector.is_sink and step.row.formula)
        if step.ref in left and (all(ready) if every else any(ready)):
            del left[step.ref]
            if step.output not in given:
                given.add(step.output)
                waiting += readers.get(step.output, ())
    return left


def _behind(
    actuator: str, dead: Mapping[str, Step], makers: Mapping[str, list[Step]], streams: Mapping[str, Stream]
) -> set[str]:
    """Return the refs of the rows that never act and for which an actuator waits."""
    found: set[str] = set()
    seen = {actuator}
    waiting = [actuator]
    while waiting:
        for row in makers.get(waiting.pop(), ()):
            if row.ref not in dead:
                continue
            found.add(row.ref)
            fresh = {_source(streams[i]) for i in _needs(row)} - seen
            seen |= fresh
            waiting += fresh
    return found
