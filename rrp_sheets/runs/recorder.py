"""What happens in a run, told to its trace and to whoever watches."""

from __future__ import annotations

import time

from rrp_sheets.engine.command_handler import switched
from rrp_sheets.engine.command_queue import CommandQueue
from rrp_sheets.engine.engine import Engine
from rrp_sheets.engine.observer import RunObserver
from rrp_sheets.engine.trace import TraceWriter
from rrp_sheets.model.exchange import Notice, OperatorAction, WorldSnapshot
from rrp_sheets.model.values import Failure, Value
from rrp_sheets.runs.view import RunView

_ROBOT = "the robot itself"  # where an error is counted that is no row's: it has fallen


class Recorder(RunObserver):
    """The observer of an engine and of its loop: tells the trace and the view. The trace comes when the run begins."""

    def __init__(self, view: RunView, control: CommandQueue) -> None:
        self.view = view
        self.control = control
        self.trace: TraceWriter | None = None
        self.engine: Engine | None = None
        self.unusable: dict[str, int] = {}  # how often an actuator could not use a row's value
        self._began = time.monotonic()
        self._on: set[str] = set()  # the behaviours that the view knows to be on

    def begin(self, trace: TraceWriter, engine: Engine) -> None:
        """The run's clock starts."""
        self.trace, self.engine, self._began = trace, engine, time.monotonic()
        self._on = set(engine.on)

    @property
    def wall(self) -> float:
        """Seconds of the wall clock since the beginning."""
        return time.monotonic() - self._began

    def event(self, us: int, stream: str, row: str, value: Value) -> None:
        """A value on a stream (its id)."""
        if self.trace is not None:
            by = self.engine.sent_by if self.engine is not None and not row else None
            self.trace.event(us, stream, row, value, by)
        self.view.event(us, stream, row, value)

    def error(self, us: int, row: str, failure: Failure, values: tuple[Value, ...]) -> None:
        """A formula failed."""
        if self.trace is not None:
            self.trace.error(us, row, failure, values)
        self.view.error(us, row, failure, values)

    def happening(self, us: int, happening: Notice) -> None:
        """Something besides the events."""
        if self.trace is not None:
            self.trace.happening(us, happening)
        if happening.kind == "error":  # an actuator cannot use its value: an error of that row like any other
            place = happening.row or happening.stream or _ROBOT
            self.unusable[place] = self.unusable.get(place, 0) + 1
        self.view.happening(us, happening)

    def frame(self, us: int) -> None:
        """A frame is over."""
        if self.trace is not None:
            self.trace.flush()
        if self.engine is not None and self.engine.on != self._on:
            self._tell_switched(us, self.engine)
        self.view.frame(us)

    def _tell_switched(self, us: int, engine: Engine) -> None:
        """A row has switched behaviours; in the trace that is a note of the row's."""
        for behaviour in engine.plan.checked.graph.behaviours:
            on = behaviour.key in engine.on
            if on != (behaviour.key in self._on):
                self.view.acted(us, switched(behaviour.name, on))
        self._on = set(engine.on)

    def acted(self, us: int, act: OperatorAction) -> None:
        """Somebody did something."""
        if self.trace is not None:
            self.trace.act(us, act, self.wall)
            self.trace.flush()
        if self.engine is not None:
            self._on = set(self.engine.on)
        self.view.acted(us, act)

    def refused(self, kind: str, message: str, remedy: str) -> None:
        """What somebody wanted cannot be done."""
        self.view.refused(kind, message, remedy)

    def paused(self, us: int, is_paused: bool) -> None:
        """The run stands still, or goes on."""
        self.view.paused(us, is_paused)

    def standing(self, us: int) -> None:
        """Nothing goes on."""
        self.view.standing(us)

    def shown(self, us: int, shown: WorldSnapshot) -> None:
        """The world, for a display."""
        self.view.shown(us, shown)

    def stopped(self) -> bool:
        """Whether the run should stop now."""
        return self.view.stopped()
