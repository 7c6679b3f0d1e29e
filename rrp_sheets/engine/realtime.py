"""Adapter of a world in lockstep to the event loop: a thread moves the world on with the wall clock."""

from __future__ import annotations

import threading
import time
from collections.abc import Sequence
from queue import Empty, SimpleQueue
from typing import TypeVar

from rrp_sheets.engine.event_queue import EventQueue
from rrp_sheets.engine.pacing import SnapshotThrottle
from rrp_sheets.engine.ports import Actuator, Arrivals, LiveWorld, Sensor, World
from rrp_sheets.errors import RunBroken
from rrp_sheets.model.exchange import Command, DeviceUse, Notice
from rrp_sheets.model.scene_actions import SceneAction

LAST_STEP_WITHIN = 15.0  # s, for a step that has begun when the run stops
STANDING = 0.25  # s between two looks while the run is paused, if nobody wakes it
_Item = TypeVar("_Item")


class RealtimeAdapter(LiveWorld):
    """The simulated robot for the event loop.

    Args:
        world: started here, moved on by a thread, and stopped here.
        rate: how often it is moved on, in steps a second.
    """

    def __init__(self, world: World, rate: int) -> None:
        self._world = world
        self._rate = rate
        self._commands: SimpleQueue[Command] = SimpleQueue()
        self._actions: SimpleQueue[SceneAction] = SimpleQueue()
        self._awake = threading.Event()
        self._over = False
        self._thread: threading.Thread | None = None
        self._broken: RunBroken | None = None
        self._showing: SnapshotThrottle | None = None

    def open(self, queue: EventQueue) -> None:
        """Start the world; its first values are in the event queue."""
        self._post(queue, self._world.start())
        self._thread = threading.Thread(target=self._pump, args=(queue,), name="world", daemon=True)
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

    def act(self, actions: Sequence[SceneAction]) -> None:
        """Let something happen in the world, at once."""
        for action in actions:
            self._actions.put(action)
        self._awake.set()

    def show(self, showing: SnapshotThrottle) -> None:
        """Put the world into the event queue for a display, as often as it wants."""
        self._showing = showing
        self._awake.set()

    def wake(self) -> None:
        """The clock goes on, or the run is over: do not sleep longer."""
        self._awake.set()

    def halt(self) -> None:
        """Take no further step."""
        self._over = True
        self._awake.set()

    def close(self) -> Sequence[Notice]:
        """Stop the world, when its last step is done; returns what happened meanwhile.

        Raises:
            RunBroken: when the world has broken; it may not have been reported, as the run was over.
        """
        self.halt()
        if self._thread is not None:
            self._thread.join(LAST_STEP_WITHIN)
        left = self._world.stop()
        if self._broken is not None:
            raise self._broken
        return left.happenings if left else ()

    def _pump(self, queue: EventQueue) -> None:
        while not queue.begun.wait(0.1):
            if self._over:
                return
        step = 0
        try:
            while not self._over:
                step += 1
                due = step * 1_000_000 // self._rate
                self._sleep(queue, due)
                if not self._over:
                    self._post(queue, self._world.advance(due, _all(self._commands)))
                    self._serve(queue)
        except RunBroken as error:
            self._broken = error
            queue.broke(error)

    def _sleep(self, queue: EventQueue, due: int) -> None:
        """Sleep until a step is due; operators' actions are done meanwhile, also while the clock stands still."""
        while not self._over and (left := (due - queue.now_us) / 1_000_000) > 0:
            if self._awake.wait(STANDING if queue.stands else left):
                self._awake.clear()
                self._serve(queue)
            elif self._showing is not None and queue.stands:
                self._world.show(False)  # whether it is still there: nothing else asks it anything

    def _serve(self, queue: EventQueue) -> None:
        actions, showing = _all(self._actions), self._showing
        if actions:
            self._world.act(actions)
        picture = showing.due() if showing is not None else None
        if showing is not None and picture is not None:
            began = time.monotonic()
            queue.show(self._world.show(picture))
            showing.cost(time.monotonic() - began)

    @staticmethod
    def _post(queue: EventQueue, arrivals: Arrivals) -> None:
        for stream, value in arrivals.events:
            queue.event(stream, value)
        for happening in arrivals.happenings:
            queue.tell(happening)


def _all(queue: SimpleQueue[_Item]) -> list[_Item]:
    found: list[_Item] = []
    while True:
        try:
            found.append(queue.get_nowait())
        except Empty:
            return found


class _Part(Sensor, Actuator):
    """A sensor or an actuator of a pumped world."""

    def __init__(self, world: RealtimeAdapter) -> None:
        self._world = world

    def start(self, queue: EventQueue | None = None) -> None:
        """Nothing to do: the world has been started."""

    def stop(self) -> None:
        """No further step is taken."""
        self._world.halt()

    def take(self, command: Command) -> None:
        """Let the command be carried out in the world's next step."""
        self._world.give(command)

    def rest(self) -> None:
        """The world comes to its rest as a whole."""
