"""The two engines and their base: the wired rows of a plan, their clock, behaviours that switch on and off.

An engine decides only at which instants values enter and the graph settles.
"""

from __future__ import annotations

import heapq
import sys
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Callable, Collection, Iterable
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from functools import partial
from typing import Any, TypeVar

from reactivex import Observable, never
from reactivex.abc import DisposableBase, ObserverBase, ScheduledAction, SchedulerBase
from reactivex.disposable import CompositeDisposable, Disposable, SingleAssignmentDisposable
from reactivex.scheduler.periodicscheduler import PeriodicScheduler
from reactivex.typing import AbsoluteTime, RelativeTime

from rrp_sheets.connectors.spec import ConnectorContext
from rrp_sheets.engine.builtin_devices import MIN_DELAY_US, BuiltinDevices
from rrp_sheets.engine.plan import Plan
from rrp_sheets.engine.ports import INSTANT, NO_ROW, RANK, SETTLING, Heartbeat
from rrp_sheets.engine.run_events import FormulaFailure, RunObserver, StreamEvent
from rrp_sheets.engine.scene import SceneTriggers
from rrp_sheets.errors import RunBroken
from rrp_sheets.formulas import Formula
from rrp_sheets.formulas.evaluator import GuardedInterpreter
from rrp_sheets.formulas.operations import Picker
from rrp_sheets.graph import Step
from rrp_sheets.model.exchange import Command, Notice
from rrp_sheets.model.values import Failure, Value
from rrp_sheets.scene.scene_words import choose_random_numbers
from rrp_sheets.texts import N_

_FRAMES_PER_ROW = 8  # Python frames that one row of a chain takes at most, so that 500 rows do not overflow
_VALUES_PER_ROW = 60  # that many in one instant, if all rows have so many, are not yet called too many
_EPOCH = datetime.fromtimestamp(0, UTC)
MOST_AT_ONCE = 30_000
"""Most values that all streams may have in one frame. Rows that double what they get, one after the other or in
a circle through a done stream, reach it within a few rows or frames; a workbook of many rows may have more."""
_LAST = 1 << 30  # the rank of actions that come from reactivex's own operators: after all rows
_State = TypeVar("_State")
Entry = tuple[int, int, int, Callable[[], None]]


class FrameClock(PeriodicScheduler):
    """The run's clock, a reactivex scheduler of virtual time in whole µs (`us`); `heartbeat` tells the row at work.

    Within a frame actions are ordered by (rank, due time, sequence): the graph settles in topological order, and a
    timer that is due acts at its connector's place, after the values of its own instant have reached it. From frame to
    frame timers keep their absolute due times and act in the first frame at or after them.
    """

    def __init__(self, heartbeat: Heartbeat | None = None) -> None:
        super().__init__()
        self.us = 0
        self.heartbeat: Heartbeat = heartbeat if heartbeat is not None else [0, 0, NO_ROW]
        self.came = 0  # values on streams since the frame began
        self.most = MOST_AT_ONCE  # how many those may be
        self._timers: list[Entry] = []  # (due, rank, sequence, action): after this frame
        self._frame: list[Entry] = []  # (rank, due, sequence, action): in this frame
        self._sequence = 0

    @property
    def now(self) -> datetime:
        """The time as reactivex's operators want it."""
        return _EPOCH + timedelta(microseconds=self.us)

    def push(self, due_us: int, rank: int, action: Callable[[], None]) -> None:
        """Do something in the first frame at or after `due_us`, at `rank` in its order."""
        self._sequence += 1
        if due_us <= self.us:
            heapq.heappush(self._frame, (rank, due_us, self._sequence, action))
        else:
            heapq.heappush(self._timers, (due_us, rank, self._sequence, action))

    def begin(self, us: int) -> None:
        """Go on to a later time; what is due by then waits for its turn in this frame."""
        self.us = us
        self.came = 0
        timers = self._timers
        while timers and timers[0][0] <= us:
            due, rank, sequence, action = heapq.heappop(timers)
            heapq.heappush(self._frame, (rank, due, sequence, action))

    def drain(self) -> None:
        """Do everything that belongs to this frame, in order."""
        frame, heartbeat = self._frame, self.heartbeat
        while frame:
            rank, _, _, action = heapq.heappop(frame)
            heartbeat[RANK] = rank
            action()
        heartbeat[RANK] = NO_ROW

    @property
    def next_due(self) -> int | None:
        """Time of the next action; None when nothing waits."""
        if self._frame:
            return self.us
        return self._timers[0][0] if self._timers else None

    def forget(self, ranks: Collection[int]) -> None:
        """Forget what rows have put on the agenda: their behaviour was switched off. Between frames only."""
        self._timers = [entry for entry in self._timers if entry[1] not in ranks]
        heapq.heapify(self._timers)

    def clear(self) -> None:
        """Forget the whole agenda: the run is over."""
        self._timers.clear()
        self._frame.clear()

    # ---- reactivex's scheduler interface, for connectors made of its operators
    def schedule(self, action: ScheduledAction[_State], state: _State | None = None) -> DisposableBase:
        """Do something in this frame."""
        return self._schedule(self.us, action, state)

    def schedule_relative(
        self, duetime: RelativeTime, action: ScheduledAction[_State], state: _State | None = None
    ) -> DisposableBase:
        """Do something after a time."""
        return self._schedule(self.us + round(self.to_seconds(duetime) * 1e6), action, state)

    def schedule_absolute(
        self, duetime: AbsoluteTime, action: ScheduledAction[_State], state: _State | None = None
    ) -> DisposableBase:
        """Do something at a time."""
        return self._schedule(round((self.to_datetime(duetime) - _EPOCH).total_seconds() * 1e6), action, state)

    def _schedule(self, due: int, action: ScheduledAction[Any], state: Any) -> DisposableBase:
        acting = SingleAssignmentDisposable()

        def act() -> None:
            if not acting.is_disposed:
                acting.disposable = action(self, state) or Disposable()

        self.push(due, _LAST, act)
        return acting


class Engine(ABC):
    """The rows of a plan, wired. Subclasses say at which instants they settle.

    Attributes:
        streams: by id; each knows its latest value and how many it has had.
        interpreter: of the rows' formulas.
        errors: how often each row's formula has failed, by row ref.
        triggers: the rows of the scene that wait for an event.
        on: keys of the behaviours that are switched on now.
        ended_by: the row that has ended the run with the actuator End run, as Stop does; empty while it goes on.
        sent_by: who sent the value that is entering now by hand; None while others do.
    """

    def __init__(
        self, plan: Plan, observer: RunObserver | None = None, seed: int = 0, heartbeat: Heartbeat | None = None
    ) -> None:
        self.plan = plan
        self.seed = seed
        self.clock = FrameClock(heartbeat)
        self.clock.most = max(self.clock.most, _VALUES_PER_ROW * len(plan.steps))
        self.errors: Counter[str] = Counter()
        self.streams = {s.id: LiveStream(s.id, self.clock) for s in plan.streams}
        self.on: set[str] = set()
        self.ended_by = ""
        self.sent_by: str | None = None
        self._sent: list[tuple[str, Value, str]] = []  # by hand: enter in the next instant
        self._running: dict[str, LiveRow] = {}  # by the row's ref, while its behaviour is on
        self._edits: dict[str, tuple[Formula | None, int | None]] = {}  # of rows that were edited during the run
        self._observer = observer
        self.interpreter = GuardedInterpreter()
        self._commands: list[Command] = []
        self._notices: list[Notice] = []
        self._driven: dict[str, Command] = {}  # the last command of each actuator stream, to stop it
        self._wired: dict[str, CompositeDisposable] = {}
        if len(plan.steps) > 60:  # for the rest of the process: a lower limit would break an engine that still runs
            sys.setrecursionlimit(max(sys.getrecursionlimit(), 1_000 + _FRAMES_PER_ROW * len(plan.steps)))
        if observer is not None:
            self._watch(observer)
        self.triggers = SceneTriggers(choose_random_numbers(plan.checked.scene or (), seed)[0])
        for stream in sorted(self.triggers.streams & set(self.streams)):
            self._cue(stream)
        uses = [u for u in (*plan.sensors, *plan.actuators) if u.stream in plan.own]
        dones = {actuator: done for done, actuator in plan.dones.items()}
        records = {s.id: s.device.type.payload for s in plan.streams if s.device and s.device.type.payload}
        self._own = BuiltinDevices(self, uses, dones, records)
        for behaviour in plan.behaviours:
            if behaviour in plan.on:
                self._switch_on(behaviour)

    @property
    def row(self) -> str:
        """The row that is being worked out, or was when something went wrong; empty when it is none."""
        return self.plan.rows_by_rank().get(self.clock.heartbeat[RANK], "")

    @abstractmethod
    def settle(self, now_us: int, arrivals: Iterable[tuple[str, Value]]) -> list[Command]:
        """Go on to a time with the values that have arrived by then; the commands for the actuators of the world."""

    def take_notices(self) -> list[Notice]:
        """Return the notices since the last call: a behaviour was switched, a wait has no time."""
        found, self._notices = self._notices, []
        return found

    def close(self) -> None:
        """Take the rows apart; nothing happens any more."""
        for behaviour in list(self._wired):
            self._wired.pop(behaviour).dispose()
        self.clock.clear()

    def finish(self, events: Iterable[tuple[str, Value]] = ()) -> None:
        """Take the rows apart, end what still goes on; `events`: what the world's end has ended, for observers only."""
        self.close()
        self._own.end()
        for stream, value in events:
            self.feed(stream, value)

    # ---- what subclasses settle with
    def _instant(self, now_us: int, arrivals: Iterable[tuple[str, Value]]) -> list[Command]:
        """One instant: values enter, the graph settles, the engine's own devices act, the world's commands come out."""
        heartbeat = self.clock.heartbeat
        heartbeat[INSTANT] += 1
        heartbeat[SETTLING] = 1
        try:
            self.clock.begin(now_us)
            streams = self.streams
            for stream, value in arrivals:
                if stream in streams:
                    streams[stream].on_next(value)
            if self._sent:  # people's values enter after those of the world, as they are the newest
                sent, self._sent = self._sent, []
                for stream, value, self.sent_by in sent:
                    streams[stream].on_next(value)
                self.sent_by = None
            self.clock.drain()
            commands, self._commands = self._commands, []
            return self._carry_out(commands) if commands and self.plan.own else commands
        finally:
            heartbeat[SETTLING] = 0

    def _carry_out(self, commands: list[Command]) -> list[Command]:
        """The engine's own devices act, after the graph has settled; the commands that are left for the world."""
        own, left = self.plan.own, []
        while commands:
            for command in commands:
                if command.stream in own:
                    self._own.take(command)
                    if self.ended_by:
                        return []
                else:
                    left.append(command)
            commands, self._commands = self._commands, []  # a behaviour that was switched off stops its actuators
        return left

    # ---- the host of the engine's own devices
    def feed(self, stream: str, value: Value) -> None:
        """Let a value enter a stream, if some row reads it."""
        if stream in self.streams:
            self.streams[stream].on_next(value)

    def tell(self, notice: Notice) -> None:
        """Report a notice to the observers of the run."""
        self._notices.append(notice)

    def switch(self, behaviour: str, state: str) -> None:
        """Switch a behaviour (its key) `on`, `off`, or the other way (`toggle`); between instants only."""
        name = next((b.name for b in self.plan.checked.graph.behaviours if b.key == behaviour), "")
        if behaviour not in self.plan.behaviours:
            self.tell(Notice("error", N_("There is no such behaviour to switch.")))
            return
        wanted = (behaviour not in self.on) if state == "toggle" else state == "on"
        if self.turn(behaviour, wanted):
            self.tell(Notice("note", switch_text(name, wanted)))

    # ---- what people do, between instants only
    def turn(self, behaviour: str, on: bool) -> bool:
        """Switch a behaviour (its key) of the plan by hand; False when it is so already."""
        if on == (behaviour in self.on):
            return False
        if on:
            self._switch_on(behaviour)
        else:
            self._switch_off(behaviour)
        return True

    def stimulate(self, stream: str, value: Value, by: str) -> None:
        """Let a value of somebody's enter a sensor stream in the next instant."""
        self._sent.append((stream, value, by))

    def edit(self, ref: str, formula: Formula | None, period_us: int | None) -> None:
        """Let a row go on with another formula or period; what it remembers stays."""
        self._edits[ref] = formula, period_us
        if ref in self._running:
            self._running[ref].edit(formula, period_us)

    def _switch_on(self, behaviour: str) -> None:
        """Wire the rows of a behaviour anew: no total, no latest value and no timer of before is left."""
        self.on.add(behaviour)
        heartbeat = self.clock.heartbeat
        wired = self._wired[behaviour] = CompositeDisposable()
        for step in self.plan.behaviours[behaviour]:
            heartbeat[RANK] = step.rank
            self._connect(step, wired)
        heartbeat[RANK] = NO_ROW

    def _switch_off(self, behaviour: str) -> None:
        """Take the rows of a behaviour apart, and stop what it has its actuators do."""
        self.on.discard(behaviour)
        self._wired.pop(behaviour).dispose()
        steps = self.plan.behaviours[behaviour]
        self.clock.forget({s.rank for s in steps})
        for gone in steps:
            self._running.pop(gone.ref, None)
        mine = {s.ref: s for s in steps if s.connector.is_sink}
        for stream, last in list(self._driven.items()):
            step = mine.get(last.row)
            if step is None:
                continue
            if last.value is not None:
                self._sender(step, self.streams[stream])(None)
            if stream not in self.plan.own:
                self._commands.append(replace(last, value=None, release=True))

    # ---- wiring
    def _watch(self, observer: RunObserver) -> None:
        """Observe every stream but the actuators' (which tell each row's commands), before anything reads it."""
        clock = self.clock

        def watch(stream: str, row: str) -> None:
            self.streams[stream].subscribe(lambda value: observer.handle(StreamEvent(clock.us, stream, row, value)))

        for stream in (*(s.stream for s in self.plan.sensors), *self.plan.dones):
            watch(stream, "")
        for step in self.plan.steps:
            if not step.connector.is_sink:
                watch(step.output, step.ref)

    def _cue(self, stream: str) -> None:
        """Report the events of a stream to the scene's rows that wait for it; a blank is none."""
        triggers, clock = self.triggers, self.clock
        self.streams[stream].subscribe(lambda value: None if value is None else triggers.heard(stream, clock.us))

    def _connect(self, step: Step, wired: CompositeDisposable) -> None:
        row = self._running[step.ref] = LiveRow(step, self)
        unedited = self.plan.checked.formulas.get(step.ref), step.period_us
        formula, period_us = self._edits.get(step.ref, unedited)
        output = self.streams[step.output]
        sink = self._sender(step, output) if step.connector.is_sink else output.on_next
        wired.add(row.wire(formula, period_us).subscribe(sink))

    def _sender(self, step: Step, output: LiveStream) -> Callable[[Value], None]:
        sensors = self.plan.descent[step.ref]
        observer, clock = self._observer, self.clock
        row, stream, priority = step.ref, output.id, step.row.priority
        robot, device = self.plan.checked.robot, self.plan.checked.graph.streams[step.output].device

        def send(value: Value) -> None:
            value = robot.standard(device.type.name, value) if device else value  # so that recordings compare
            output.on_next(value)
            command = self._driven[stream] = Command(stream, value, row, sensors, priority)
            self._commands.append(command)
            if observer is not None:
                observer.handle(StreamEvent(clock.us, stream, row, value))

        return send

    def fail(self, ref: str, failure: Failure, values: tuple[Value, ...]) -> None:
        """Count and report that a row's formula has failed for some values."""
        self.errors[ref] += 1
        if self._observer is not None:
            self._observer.handle(FormulaFailure(self.clock.us, ref, failure, values))


def switch_text(behaviour: str, on: bool) -> str:
    """Return the sentence that a behaviour is switched on or off."""
    if on:
        return N_("The behaviour {behaviour} is switched on.", behaviour=behaviour)
    return N_("The behaviour {behaviour} is switched off.", behaviour=behaviour)


_SILENT: Observable[Value] = never()  # an input whose rows are switched off: it keeps its place, and gives nothing


class LiveRow:
    """A row of a run."""

    def __init__(self, step: Step, engine: Engine) -> None:
        self._build = step.connector.build
        self._interpreter = engine.interpreter
        self._picker = Picker(engine.seed, step.ref)
        self._evaluate: Callable[..., Value] | None = None
        shown = engine.plan.checked.graph.streams
        self._wiring = ConnectorContext(
            inputs=[engine.streams.get(i, _SILENT) for i in step.inputs], clock=engine.clock, rank=step.rank,
            fail=partial(engine.fail, step.ref), names=tuple(shown[i].name for i in step.inputs),
        )  # fmt: skip

    def wire(self, formula: Formula | None, period_us: int | None) -> Observable[Value]:
        """Return the observable of what the row gives."""
        if formula is not None:
            self._wiring.evaluate = self._work_out
        self._use(formula, period_us)
        return self._build(self._wiring)

    def edit(self, formula: Formula | None, period_us: int | None) -> None:
        """Go on with another formula or period; what the connector remembers stays."""
        self._use(formula, period_us)
        if period_us:
            self._wiring.edited()

    def _use(self, formula: Formula | None, period_us: int | None) -> None:
        self._evaluate = formula.prepare(self._interpreter, self._picker) if formula is not None else None
        self._wiring.period_us = max(period_us, MIN_DELAY_US) if period_us else 0

    def _work_out(self, *values: Value) -> Value:
        """Evaluate the row's present formula; connectors keep this function while the formula may change."""
        assert self._evaluate is not None
        return self._evaluate(*values)


class FrameEngine(Engine):
    """Every frame: the sensors' values enter at one instant, the graph settles, commands come out."""

    def settle(self, now_us: int, arrivals: Iterable[tuple[str, Value]]) -> list[Command]:
        """One frame: let the values enter, settle the graph, and return the commands for the actuators."""
        return self._instant(now_us, arrivals)


class EventEngine(Engine):
    """Every event is an instant of its own, and so is every timer; once `halted`, due timers are left as they are."""

    halted: Callable[[], bool] = staticmethod(lambda: False)

    def settle(self, now_us: int, arrivals: Iterable[tuple[str, Value]]) -> list[Command]:
        """Let what is due by now act, then each value enter and settle; the commands of all of it, in order."""
        now_us = max(now_us, self.clock.us)  # what was stamped by another thread may come a moment late
        commands: list[Command] = []
        for arrival in arrivals:
            self._catch_up(now_us, commands)
            if self.ended_by:
                return commands
            commands += self._instant(now_us, (arrival,))
        self._catch_up(now_us + 1, commands)
        if self._sent or self._commands:  # what people sent, and what a behaviour that they switched off leaves
            commands += self._instant(now_us, ())
        self.clock.begin(now_us)
        return commands

    def _catch_up(self, before_us: int, commands: list[Command]) -> None:
        """Let the timers that are due before a time act, each at its own."""
        while not self.ended_by and not self.halted() and (due := self.clock.next_due) is not None and due < before_us:
            commands += self._instant(due, ())


class LiveStream(Observable[Value]):
    """Passes values on in the order of subscription; without locks, since one thread runs the whole graph."""

    def __init__(self, stream_id: str, clock: FrameClock) -> None:
        super().__init__()
        self.id = stream_id
        self.latest: Value = None
        self.at_us = -1  # when the latest value came; -1 before the first
        self.arrived = 0  # how many have come
        self._clock = clock
        self._heartbeat = clock.heartbeat
        self._sinks: tuple[tuple[int, Callable[[Value], Any]], ...] = ()  # each with the rank of its row

    def on_next(self, value: Value) -> None:
        """Pass a value on. Raises RunBroken when too many have come in one instant."""
        clock = self._clock
        clock.came += 1
        if clock.came > clock.most:
            remedy = N_("Look for two rows that pass the same values to one stream (merge), or that start one "
                        "actuator after its own done stream. Keep only one of them.")  # fmt: skip
            words = N_(
                "The rows multiply their values: more than {most:,} values came at the same moment.", most=clock.most
            )
            raise RunBroken(words, remedy)
        self.latest = value
        self.at_us = clock.us
        self.arrived += 1
        heartbeat = self._heartbeat
        for rank, sink in self._sinks:
            heartbeat[RANK] = rank
            sink(value)

    def subscribe(
        self,
        on_next: ObserverBase[Value] | Callable[[Value], None] | None = None,
        on_error: Callable[[Exception], None] | None = None,
        on_completed: Callable[[], None] | None = None,
        *,
        scheduler: SchedulerBase | None = None,
    ) -> DisposableBase:
        """Pass values on to an observer or a function. Streams of a run neither fail nor complete."""
        sink = on_next.on_next if isinstance(on_next, ObserverBase) else on_next
        if sink is None:
            return Disposable()
        mine = (self._heartbeat[RANK], sink)  # the row that is being wired, or worked out
        self._sinks = (*self._sinks, mine)

        def leave() -> None:
            self._sinks = tuple(s for s in self._sinks if s is not mine)

        return Disposable(leave)
