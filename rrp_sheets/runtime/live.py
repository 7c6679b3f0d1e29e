"""The event loop: one thread that evaluates, on the wall clock; sensors only put values into the mail.

Starting goes in the order of the thesis: sensors, connectors, actuators; a device that does not start is told with its
cell, and the run does not begin. Stopping is orderly and bounded: sensors, timers, connectors, actuators to a safe
rest; a device that hangs is left behind and told.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import partial

from rrp_sheets.errors import RunBroken
from rrp_sheets.model.exchange import Command, Happening
from rrp_sheets.runtime.bounded import Hand, within
from rrp_sheets.runtime.events import EventEngine
from rrp_sheets.runtime.loop import Hooks
from rrp_sheets.runtime.mail import Mail
from rrp_sheets.runtime.plan import Plan
from rrp_sheets.runtime.ports import LiveWorld, Sensor

START_WITHIN = 20.0  # s, for one device
STOP_WITHIN = 2.0  # s, for all sensors
REST_WITHIN = 5.0  # s, for all actuators
CLOSE_WITHIN = 45.0  # s, for the world, with what it writes
TICK_US = 33_333  # how often the trace is written and the display is told
SWITCH_SECONDS = 0.0005  # a tenth of Python's: halves the longest latencies beside a busy thread


class LiveCourse:
    """A run in an event loop.

    Args:
        plan: what runs.
        world: its devices.
        wire: makes the engine, with its connectors wired.

    Raises:
        RunBroken: when a device does not start; then everything that was started has been stopped.
    """

    def __init__(self, plan: Plan, world: LiveWorld, wire: Callable[[], EventEngine]) -> None:
        self._plan = plan
        self._world = world
        self._mail = Mail()
        self._sensors: list[tuple[str, Sensor]] = []
        self._hands: dict[str, Hand] = {}
        self._engine: EventEngine | None = None
        try:
            self._start(wire)
        except BaseException:  # Ctrl-C too: nothing is left running
            self.stop()
            raise

    @property
    def engine(self) -> EventEngine:
        """The engine."""
        assert self._engine is not None
        return self._engine

    def _start(self, wire: Callable[[], EventEngine]) -> None:
        places = {s.id: f" ({s.address})" if s.address else "" for s in self._plan.streams}
        self._world.open(self._mail)
        for use in self._plan.outer_sensors:
            sensor = self._world.sensor(use)
            _start_one(f"The sensor stream “{use.name}”{places[use.stream]}", partial(sensor.start, self._mail))
            self._sensors.append((use.name, sensor))
        self._engine = wire()
        for use in self._plan.outer_actuators:
            hand = Hand(use.name, self._world.actuator(use), self._mail)
            _start_one(f"The actuator stream “{use.name}”{places[use.stream]}", hand.start)
            self._hands[use.stream] = hand

    def go(self, until_us: int, hooks: Hooks) -> tuple[int, str]:
        """Run until the time is over, a row ends the run, or the user stops; the time (µs) and how it ended.

        Raises:
            RunBroken: when a device has broken.
        """
        interval = sys.getswitchinterval()
        sys.setswitchinterval(SWITCH_SECONDS)
        try:
            self._mail.begin()
            return self._loop(until_us, hooks)
        finally:
            sys.setswitchinterval(interval)

    def _loop(self, until_us: int, hooks: Hooks) -> tuple[int, str]:
        engine, mail = self.engine, self._mail
        ticked = 0
        while True:
            due = engine.clock.next_due
            tick = ticked + TICK_US
            letter = mail.take(min(until_us, tick) if due is None else min(until_us, tick, due))
            now = mail.now_us if letter is None else letter.us
            if now < until_us:
                happening = letter.happening if letter else None
                if letter is not None and letter.broken is not None:
                    raise letter.broken
                if happening is not None:
                    hooks.happening(engine.clock.us, happening)
                self._settle(now, [(letter.stream, letter.value)] if letter and not happening else [])
            else:
                self._settle(until_us, [])
            for told in engine.take_happenings():
                hooks.happening(engine.clock.us, told)
            if now >= tick or now >= until_us or engine.ended_by:
                ticked = now
                hooks.frame(engine.clock.us)
                if hooks.stopped():
                    return engine.clock.us, "stopped"
            if engine.ended_by:
                return engine.clock.us, "end run"
            if now >= until_us:
                return until_us, "time"

    def _settle(self, now_us: int, arrivals: list[tuple[str, object]]) -> None:
        command: Command
        for command in self.engine.settle(now_us, arrivals):
            if command.stream in self._hands:
                self._hands[command.stream].give(command)

    def stop(self) -> list[Happening]:
        """Stop in order; what hung is told. Always comes back in bounded time.

        Raises:
            RunBroken: the first thing that broke while stopping.
        """
        hung: list[str] = []
        errors: list[RunBroken] = []

        def bounded(seconds: float, calls: list[tuple[str, Callable[[], None]]]) -> None:
            try:
                hung.extend(within(seconds, calls))
            except RunBroken as error:
                errors.append(error)

        sensors, self._sensors = self._sensors, []
        hands, self._hands = list(self._hands.values()), {}
        bounded(STOP_WITHIN, [(name, sensor.stop) for name, sensor in sensors])
        if self._engine is not None:
            self._engine.finish()
        bounded(REST_WITHIN, [(hand.name, hand.rest) for hand in hands])
        bounded(CLOSE_WITHIN, [("the robot", self._world.close)])
        if errors:
            raise errors[0]
        return [Happening("error", f"{name} did not stop in time and was left behind.") for name in hung]


def _start_one(what: str, call: Callable[[], None]) -> None:
    """Start a device; what goes wrong is told with the device and its cell."""
    try:
        late = within(START_WITHIN, [(what, call)])
    except RunBroken as error:
        raise RunBroken(f"{what} did not start: {error.message}", error.remedy) from None
    if late:
        raise RunBroken(f"{what} did not start within {START_WITHIN:g} s.", "Check the device, and run again.")
