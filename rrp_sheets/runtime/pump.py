"""A world in lockstep, as one that goes by itself: a thread moves it on with the wall clock."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from queue import Empty, SimpleQueue

from rrp_sheets.errors import RunBroken
from rrp_sheets.model.exchange import Command, DeviceUse
from rrp_sheets.runtime.mail import Mail
from rrp_sheets.runtime.ports import Actuator, Arrivals, LiveWorld, Sensor, World

LAST_STEP_WITHIN = 15.0  # s, for a step that has begun when the run stops


class PumpedWorld(LiveWorld):
    """The simulated robot for the event loop.

    Args:
        world: started here, moved on by a thread, and stopped here.
        rate: how often it is moved on, in steps a second.
    """

    def __init__(self, world: World, rate: int) -> None:
        self._world = world
        self._rate = rate
        self._commands: SimpleQueue[Command] = SimpleQueue()
        self._over = threading.Event()
        self._thread: threading.Thread | None = None

    def open(self, mail: Mail) -> None:
        """Start the world; its first values are in the mail."""
        self._post(mail, self._world.start())
        self._thread = threading.Thread(target=self._pump, args=(mail,), name="world", daemon=True)
        self._thread.start()

    def sensor(self, use: DeviceUse) -> Sensor:
        """All sensors are the world's: they deliver from its thread."""
        return _Part(self)

    def actuator(self, use: DeviceUse) -> Actuator:
        """All actuators are the world's: it carries their commands out in its next step."""
        return _Part(self)

    def give(self, command: Command) -> None:
        """Let a command be carried out in the next step."""
        self._commands.put(command)

    def halt(self) -> None:
        """Take no further step."""
        self._over.set()

    def close(self) -> None:
        """Stop the world, when its last step is done."""
        self.halt()
        if self._thread is not None:
            self._thread.join(LAST_STEP_WITHIN)
        self._world.stop()

    def _pump(self, mail: Mail) -> None:
        while not mail.begun.wait(0.1):
            if self._over.is_set():
                return
        step = 0
        while True:
            step += 1
            due = step * 1_000_000 // self._rate
            if self._over.wait(max(0.0, (due - mail.now_us) / 1_000_000)):
                return
            try:
                self._post(mail, self._world.advance(due, self._waiting()))
            except RunBroken as error:
                mail.broke(error)
                return

    def _waiting(self) -> Sequence[Command]:
        found: list[Command] = []
        while True:
            try:
                found.append(self._commands.get_nowait())
            except Empty:
                return found

    @staticmethod
    def _post(mail: Mail, arrivals: Arrivals) -> None:
        for stream, value in arrivals.events:
            mail.event(stream, value)
        for happening in arrivals.happenings:
            mail.tell(happening)


class _Part(Sensor, Actuator):
    """A sensor or an actuator of a pumped world."""

    def __init__(self, world: PumpedWorld) -> None:
        self._world = world

    def start(self, mail: Mail | None = None) -> None:
        """Nothing to do: the world has been started."""

    def stop(self) -> None:
        """No further step is taken."""
        self._world.halt()

    def take(self, command: Command) -> None:
        """In the world's next step."""
        self._world.give(command)

    def rest(self) -> None:
        """The world comes to its rest as a whole."""
