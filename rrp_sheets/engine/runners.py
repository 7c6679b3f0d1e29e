"""Loops of a run: in frames, with the world in lockstep, or by events on the wall clock.

Frames are paced to real time or as fast as the machine can. In the event loop one thread evaluates the rows, and each
actuator has a thread of its own. Sensors only put values into the event queue. Starting goes in the order of the
thesis: sensors, connectors, actuators; a device that does not start is reported with its cell, and the run does not
begin. Stopping is orderly and bounded: sensors, timers, connectors, actuators to a safe rest; a device that hangs is
left behind and reported.
"""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable, Collection, Iterable, Sequence
from contextlib import ExitStack
from functools import partial
from queue import SimpleQueue

from rrp_sheets.engine.command_handler import CommandHandler
from rrp_sheets.engine.engine import Engine, EventEngine
from rrp_sheets.engine.plan import Plan
from rrp_sheets.engine.ports import Actuator, LiveWorld, Sensor, World
from rrp_sheets.engine.realtime import TICK_US, EventQueue, FramePacer, QueuedEvent, SnapshotThrottle
from rrp_sheets.engine.run_events import (
    CommandQueue,
    FrameEnd,
    KeepAliveEvent,
    NoticeEvent,
    PictureEvent,
    RunObserver,
    StateEvent,
)
from rrp_sheets.errors import RunBroken, SheetsError
from rrp_sheets.model.exchange import Arrivals, Command, Notice, SceneAction, WorldSnapshot
from rrp_sheets.texts import N_

STANDING = 0.25  # s between two looks while the run is paused: whether its watcher has gone
LONGEST_WAIT = 1.0  # s between two signs of life, however slow a run is


class _Runner:
    """Part that both runners have: what people want of clock and world, and what a display has seen of it."""

    _world: World | LiveWorld
    _pace: FramePacer | EventQueue

    def __init__(self, control: CommandQueue | None) -> None:
        self._control = control or CommandQueue()
        self._showing = SnapshotThrottle()
        self._things: Collection[str] | None = None  # what a display has last seen in the world

    def _tell(self, shown: WorldSnapshot, us: int, observer: RunObserver) -> None:
        self._things = shown.state.things
        observer.handle(StateEvent(us, shown.state))
        if shown.picture:
            observer.handle(PictureEvent(us, shown.picture))

    def _wake(self) -> None:
        """The clock has changed, by which the world may sleep."""

    def pause(self, us: int) -> bool:
        """Let the clock stand still, and with it timers and world; False when it does already."""
        if self._pace.paused:
            return False
        self._pace.pause()
        self._showing.again()
        self._wake()
        return True

    def resume(self, us: int) -> bool:
        """Let the clock go on; False when it does already."""
        if not self._pace.paused:
            return False
        self._pace.resume(us)
        self._wake()
        return True

    def step(self, us: int) -> None:
        """Let the clock go on for one frame or tick."""
        self._pace.step()
        self._showing.again()
        self._wake()

    def act(self, actions: Sequence[SceneAction]) -> None:
        """Let something happen in the world."""
        if self._pace.paused:
            self._showing.again()
        self._world.act(actions)

    def watch(self, *, wanted: bool | None = None, look: bool | None = None) -> None:
        """Set whether a display wants the world, and pictures; None changes nothing."""
        self._showing.want(wanted, look)


class FrameRunner(_Runner):
    """A run in frames, one after the other, and what people do between them.

    It starts the world and then wires the engine; a run that is paced waits, so that it is not faster than real time.
    """

    _world: World
    _pace: FramePacer

    def __init__(
        self, world: World, wire: Callable[[], Engine], *, paced: bool = False, control: CommandQueue | None = None
    ) -> None:
        super().__init__(control)
        self._world = world
        self._arrivals = world.start()
        self.engine = wire()
        self._paced = paced
        self._pace = FramePacer(0.0)

    def go(self, until_us: int, observer: RunObserver) -> tuple[int, str]:
        """Run frames until the time is over, a row ends the run or the user stops; the time (µs) and how it ended."""
        engine, world, control = self.engine, self._world, self._control
        arrivals = self._arrivals
        handler = CommandHandler(engine, self, observer, control)
        rate = engine.plan.checked.run.frame_rate
        frame = now = 0
        self._pace = FramePacer(1.0 if self._paced else 0.0)
        while True:
            commands = engine.settle(now, arrivals.events)
            if cued := engine.triggers.take():
                world.act(cued)
            for notice in (*arrivals.notices, *engine.take_notices()):
                observer.handle(NoticeEvent(now, notice))
            observer.handle(FrameEnd(now))
            if engine.ended_by:
                return now, "end run"
            if control.stopped or observer.stopped():
                return now, "stopped"
            if now >= until_us:
                return now, "time"
            frame += 1
            due = frame * 1_000_000 // rate
            if not self._wait(now, due, handler, observer):
                return now, "stopped"
            now = due
            arrivals = world.advance(now, commands)
            if control.stopped:  # meanwhile: the robot rests already, and the rows of this frame may take long
                for notice in arrivals.notices:
                    observer.handle(NoticeEvent(now, notice))
                return now, "stopped"

    def stop(self) -> list[Notice]:
        """Stop the world; returns what happened meanwhile."""
        self.engine.close()
        left = self._world.stop() or Arrivals()
        self.engine.finish(left.events)
        return list(left.notices)

    def _wait(self, now: int, due: int, handler: CommandHandler, observer: RunObserver) -> bool:
        """Do what people want until the next frame is due; False when the run is to stop."""
        control, pace = self._control, self._pace
        self._show(now, observer)
        while True:
            if handler.between(now):
                self._show(now, observer)
            if control.stopped:
                return False
            if not pace.stands and (left := pace.left(due)) <= 0:
                pace.went()
                return True
            control.wait(STANDING if pace.stands else min(left, LONGEST_WAIT))
            if pace.stands or left > LONGEST_WAIT:
                if observer.stopped():
                    return False
                observer.handle(KeepAliveEvent(now))
                if self._showing.wanted:
                    self._world.show(False)  # whether it is still there: nothing else asks it anything

    def _show(self, now: int, observer: RunObserver) -> None:
        picture = self._showing.due()
        if picture is not None:
            began = time.monotonic()
            self._tell(self._world.show(picture), now, observer)
            self._showing.cost(time.monotonic() - began)

    def speed(self, factor: float, us: int) -> None:
        """Be so fast from now on; 0 is as fast as the machine can."""
        self._pace.speed(factor, us)

    def things(self) -> Collection[str] | None:
        """Return the things in the world now."""
        if self._things is None or not self._showing.wanted:
            self._things = self._world.show(False).state.things
        return self._things


START_WITHIN = 20.0  # s, for one device
STOP_WITHIN = 2.0  # s, for all sensors
REST_WITHIN = 5.0  # s, for all actuators
WORLD_CLOSE_WITHIN = 300.0  # s, for the world and its files; the simulator's supervisor ends one that hangs before
BEHIND_US = 5_000_000  # a run whose rows cannot keep up with the clock ends so much later at most
SWITCH_SECONDS = 0.0005  # a tenth of Python's: halves the longest latencies beside a busy thread


class RealtimeRunner(_Runner):
    """A run in an event loop; `wire` makes the engine, once the sensors have started.

    Raises RunBroken when a device does not start; then everything that was started has been stopped.
    """

    _world: LiveWorld

    def __init__(
        self, plan: Plan, world: LiveWorld, wire: Callable[[], EventEngine], control: CommandQueue | None = None
    ) -> None:
        super().__init__(control)
        self._plan = plan
        self._world = world
        self._queue = self._pace = EventQueue()
        self._sensors: list[tuple[str, Sensor]] = []
        self._hands: dict[str, ActuatorThread] = {}
        self._engine: EventEngine | None = None
        with ExitStack() as unless_started:
            unless_started.callback(self.stop)  # also after Ctrl-C: no sensor or actuator stays running
            self._start(wire)
            unless_started.pop_all()

    @property
    def engine(self) -> EventEngine:
        """Rows of the run, which must have begun."""
        assert self._engine is not None
        return self._engine

    def _start(self, wire: Callable[[], EventEngine]) -> None:
        places = {s.id: f" ({s.address})" if s.address else "" for s in self._plan.streams}
        self._world.open(self._queue)
        for use in self._plan.outer_sensors:
            sensor = self._world.sensor(use)
            words = N_("The sensor stream “{name}”{where}", name=use.name, where=places[use.stream])
            _start_one(words, partial(sensor.start, self._queue))
            self._sensors.append((use.name, sensor))
        self._engine = wire()
        for use in self._plan.outer_actuators:
            hand = ActuatorThread(use.name, self._world.actuator(use), self._queue)
            words = N_("The actuator stream “{name}”{where}", name=use.name, where=places[use.stream])
            _start_one(words, hand.start)
            self._hands[use.stream] = hand

    def go(self, until_us: int, observer: RunObserver) -> tuple[int, str]:
        """Run until the time is over, a row ends the run or the user stops; the time (µs) and how it ended."""
        interval = sys.getswitchinterval()
        sys.setswitchinterval(SWITCH_SECONDS)
        try:
            self._queue.begin()
            return self._loop(until_us, observer)
        finally:
            sys.setswitchinterval(interval)

    def _loop(self, until_us: int, observer: RunObserver) -> tuple[int, str]:
        engine, queue = self.engine, self._queue
        handler = CommandHandler(engine, self, observer, self._control)
        engine.halted = lambda: self._control.stopped
        queued: QueuedEvent | None = None
        ticked = 0
        while True:
            if not self._between(handler, observer):
                return engine.clock.us, "stopped"
            due = engine.clock.next_due
            tick = ticked + TICK_US
            if queued is None:
                queued = queue.take(min(until_us, tick) if due is None else min(until_us, tick, due))
            now = queue.now_us if queued is None else queued.us
            if due is not None and due < tick < now:  # timers come first, and no more than a tick of them at a time
                now = tick
                self._settle(min(now, until_us), [])
            else:
                self._settle(min(now, until_us), self._open(queued, observer) if queued and now < until_us else [])
                queued = None
            for told in engine.take_notices():
                observer.handle(NoticeEvent(engine.clock.us, told))
            if now >= tick or now >= until_us or engine.ended_by:
                ticked = now
                observer.handle(FrameEnd(engine.clock.us))
                if observer.stopped():
                    return engine.clock.us, "stopped"
            if engine.ended_by:
                return engine.clock.us, "end run"
            if now >= until_us or queue.now_us > until_us + BEHIND_US:
                return min(now, until_us), "time"

    def _between(self, handler: CommandHandler, observer: RunObserver) -> bool:
        """Carry out commands, and as long as the clock stands still nothing else; False when the run is to stop."""
        clock, control = self.engine.clock, self._control
        while True:
            if handler.between(clock.us):
                self._settle(clock.us, [])
            if control.stopped:
                return False
            for shown in self._queue.seen():
                self._tell(shown, clock.us, observer)
            if not self._queue.stands:
                return True
            observer.handle(KeepAliveEvent(clock.us))
            if observer.stopped():
                return False
            control.wait(STANDING / 5)  # what the world shows comes soon

    def _open(self, queued: QueuedEvent, observer: RunObserver) -> list[tuple[str, object]]:
        if queued.broken is not None:
            raise queued.broken
        if queued.notice is None:
            return [(queued.stream, queued.value)]
        observer.handle(NoticeEvent(self.engine.clock.us, queued.notice))
        return []

    def _wake(self) -> None:
        self._world.wake()

    def speed(self, factor: float, us: int) -> None:
        """Not here: the event loop goes by the wall clock. Raises SheetsError."""
        if factor != 1:
            words = N_("This workbook uses the engine “event loop”, which runs in real time and has no speed setting.")
            raise SheetsError(words, N_("Write frame in the field Engine of its Protocol, then run again."))

    def things(self) -> Collection[str] | None:
        """Return the things in the world as a display has last seen them."""
        return self._things

    def watch(self, *, wanted: bool | None = None, look: bool | None = None) -> None:
        """Set whether a display wants the world, and pictures; None changes nothing."""
        self._showing.want(wanted, look)
        self._world.show(self._showing)

    def _settle(self, now_us: int, arrivals: list[tuple[str, object]]) -> None:
        for command in self.engine.settle(now_us, arrivals):
            if command.stream in self._hands:
                self._hands[command.stream].give(command)
        if cued := self.engine.triggers.take():
            self._world.act(cued)

    def stop(self) -> list[Notice]:
        """Stop in order, in bounded time; returns what happened and what hung. Raises the first RunBroken."""
        hung: list[str] = []
        errors: list[RunBroken] = []

        def bounded(seconds: float, calls: list[tuple[str, Callable[[], None]]]) -> None:
            late, broken = run_with_timeout(seconds, calls)
            hung.extend(late)
            errors.extend(broken)

        sensors, self._sensors = self._sensors, []
        hands, self._hands = list(self._hands.values()), {}
        bounded(STOP_WITHIN, [(name, sensor.stop) for name, sensor in sensors])
        if self._engine is not None:
            self._engine.finish()
        bounded(REST_WITHIN, [(hand.name, hand.rest) for hand in hands])
        left: list[Notice] = []
        bounded(WORLD_CLOSE_WITHIN, [(N_("the robot"), lambda: left.extend(self._world.close() or ()))])
        if errors:
            raise errors[0]
        texts = [N_("{name} did not stop in time.", name=name) for name in hung]
        return [*left, *(Notice("error", text) for text in texts)]


def _start_one(what: str, call: Callable[[], None]) -> None:
    """Start a device; an error is raised with the device and its cell."""
    late, errors = run_with_timeout(START_WITHIN, [(what, call)])
    if errors:
        raise RunBroken(N_("{what} did not start: {message}", what=what, message=errors[0].message), errors[0].remedy)
    if late:
        words = N_("{what} did not start within {seconds:g} s.", what=what, seconds=START_WITHIN)
        raise RunBroken(words, N_("Check the device, then run again."))


_LOOK = 0.05  # s between two looks, each of which counts as no more


def run_with_timeout(
    seconds: float, calls: Iterable[tuple[str, Callable[[], None]]]
) -> tuple[list[str], list[RunBroken]]:
    """Make calls, each on a thread of its own; returns the names of those not back in time, and what others raised.

    Time that this process did not get on a busy machine does not count: a call may have waited for it too.
    """
    errors: list[RunBroken] = []

    def guarded(call: Callable[[], None]) -> None:
        try:
            call()
        except RunBroken as error:
            errors.append(error)

    running = [(name, threading.Thread(target=guarded, args=(call,), name=name, daemon=True)) for name, call in calls]
    for _, thread in running:
        thread.start()
    left = seconds
    for _, thread in running:
        while thread.is_alive() and left > 0:
            began = time.monotonic()
            thread.join(min(_LOOK, left))
            left -= min(time.monotonic() - began, _LOOK)
    return [name for name, thread in running if thread.is_alive()], errors


class ActuatorThread:
    """An actuator on a thread of its own: the engine gives it commands and goes on at once."""

    def __init__(self, name: str, actuator: Actuator, queue: EventQueue) -> None:
        self.name = name
        self._actuator = actuator
        self._queue = queue
        self._commands: SimpleQueue[Command | None] = SimpleQueue()
        self.resting = threading.Event()
        self._thread = threading.Thread(target=self._work, name=name, daemon=True)

    def start(self) -> None:
        """Make the actuator ready. Raises RunBroken when it cannot be."""
        self._actuator.start()
        self._thread.start()

    def give(self, command: Command) -> None:
        """Let it carry out a command, when it has done those before."""
        self._commands.put(command)

    def rest(self) -> None:
        """Bring it to its rest; what still waits is dropped. Comes back when it rests."""
        self.resting.set()
        self._commands.put(None)
        self._thread.join()

    def _work(self) -> None:
        try:
            while (command := self._commands.get()) is not None:
                if not self.resting.is_set():
                    self._actuator.take(command)
        except RunBroken as error:
            self._queue.broke(error)
        self._actuator.rest()
