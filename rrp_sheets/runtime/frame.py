"""The frame engine: deterministic and free of glitches (design: 4-streams, Engines)."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable
from typing import Protocol

from rrp_sheets.connectors.wiring import Wiring
from rrp_sheets.formulas.evaluator import GuardedInterpreter
from rrp_sheets.graph import Step
from rrp_sheets.model.exchange import Command
from rrp_sheets.model.values import Failure, Value
from rrp_sheets.runtime.clock import FrameClock
from rrp_sheets.runtime.plan import Plan
from rrp_sheets.runtime.streams import LiveStream

_FRAMES_PER_ROW = 8  # Python frames that one row of a chain takes at most, so that 500 rows do not overflow


class Observer(Protocol):
    """Who is told of everything that happens in the graph, in order: the trace, a display, a test."""

    def event(self, us: int, stream: str, row: str, value: Value) -> None:
        """A value on a stream; `row` is the row that gave it, empty for sensor streams."""
        ...

    def error(self, us: int, row: str, failure: Failure, values: tuple[Value, ...]) -> None:
        """A formula failed; the event was dropped."""
        ...


class FrameEngine:
    """The rows of a plan, wired. Every frame: the sensors' values enter, the graph settles, commands come out.

    Attributes:
        clock: the run's clock.
        streams: by id; each knows its latest value and how many it has had.
        errors: how often each row's formula has failed, by row ref.
    """

    def __init__(self, plan: Plan, observer: Observer | None = None) -> None:
        self.plan = plan
        self.clock = FrameClock()
        self.errors: dict[str, int] = {}
        self.streams = {s.id: LiveStream(s.id, self.clock) for s in plan.streams}
        self._observer = observer
        self._interpreter = GuardedInterpreter()
        self._commands: list[Command] = []
        if len(plan.steps) > 60:  # for the rest of the process: a lower limit would break an engine that still runs
            sys.setrecursionlimit(max(sys.getrecursionlimit(), 1_000 + _FRAMES_PER_ROW * len(plan.steps)))
        if observer is not None:
            for stream in (*(s.stream for s in plan.sensors), *plan.dones):
                self._watch(self.streams[stream], "", observer)
        for step in plan.steps:
            self._connect(step)

    def settle(self, now_us: int, arrivals: Iterable[tuple[str, Value]]) -> list[Command]:
        """One frame: let the values enter, settle the graph, and return the commands for the actuators."""
        self.clock.begin(now_us)
        streams = self.streams
        for stream, value in arrivals:
            if stream in streams:
                streams[stream].on_next(value)
        self.clock.drain()
        commands, self._commands = self._commands, []
        return commands

    def _watch(self, stream: LiveStream, row: str, observer: Observer) -> None:
        clock, stream_id = self.clock, stream.id
        stream.subscribe(lambda value: observer.event(clock.us, stream_id, row, value))

    def _connect(self, step: Step) -> None:
        inputs = [i for i in step.inputs if i in self.streams]
        formula = self.plan.checked.formulas.get(step.ref)
        wiring = Wiring(
            inputs=[self.streams[i] for i in inputs],
            clock=self.clock,
            rank=step.rank,
            evaluate=formula.prepare(self._interpreter) if formula else None,
            period_us=step.period_us or 0,
            fail=self._failer(step),
            names=tuple(self.plan.checked.graph.streams[i].name for i in inputs),
        )
        output = self.streams[step.output]
        if step.connector.drives:
            step.connector.build(wiring).subscribe(self._sender(step, output))
            return
        if self._observer is not None:
            self._watch(output, step.ref, self._observer)
        step.connector.build(wiring).subscribe(output.on_next)

    def _sender(self, step: Step, output: LiveStream) -> Callable[[Value], None]:
        sensors = self.plan.descent[step.ref]
        observer, clock = self._observer, self.clock
        row, stream, priority = step.ref, output.id, step.row.priority

        def send(value: Value) -> None:
            output.on_next(value)
            self._commands.append(Command(stream, value, row, sensors, priority))
            if observer is not None:
                observer.event(clock.us, stream, row, value)

        return send

    def _failer(self, step: Step) -> Callable[[Failure, tuple[Value, ...]], None]:
        def fail(failure: Failure, values: tuple[Value, ...]) -> None:
            self.errors[step.ref] = self.errors.get(step.ref, 0) + 1
            if self._observer is not None:
                self._observer.error(self.clock.us, step.ref, failure, values)

        return fail
