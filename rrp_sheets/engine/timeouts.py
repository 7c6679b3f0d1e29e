"""Calls of devices that may hang: on threads of their own, waited for no longer than a bound."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterable
from queue import SimpleQueue

from rrp_sheets.engine.event_queue import EventQueue
from rrp_sheets.engine.ports import Actuator
from rrp_sheets.errors import RunBroken
from rrp_sheets.model.exchange import Command

_LOOK = 0.05  # s between two looks, each of which counts as no more


def run_with_timeout(seconds: float, calls: Iterable[tuple[str, Callable[[], None]]]) -> list[str]:
    """Make calls at the same time; the names of those that have not come back after the bound.

    Time that this process did not get on a busy machine does not count: a call may have waited for it too.

    Raises:
        RunBroken: the first that a call raised.
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
    if errors:
        raise errors[0]
    return [name for name, thread in running if thread.is_alive()]


class ActuatorThread:
    """An actuator on a thread of its own: the engine gives it commands and goes on at once.

    Attributes:
        resting: set when it is to rest; then no further command is carried out.
    """

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
