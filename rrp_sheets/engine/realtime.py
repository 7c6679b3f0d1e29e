"""Real time: pacing of frames, the event loop's queue, and the adapter of a world in lockstep, moved on by a thread."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from queue import Empty, SimpleQueue
from typing import TypeVar

from rrp_sheets.engine.ports import Actuator, LiveWorld, Sensor, World
from rrp_sheets.errors import RunBroken
from rrp_sheets.model.exchange import Arrivals, Command, DeviceUse, Notice, SceneAction, WorldSnapshot
from rrp_sheets.model.values import Value
from rrp_sheets.texts import N_

LAST_STEP_WITHIN = 15.0  # s, for a step that has begun when the run stops
STANDING = 0.25  # s between two looks while the run is paused, if nobody wakes it
MOST_WAITING = 20_000  # events in the queue: minutes of work for any workbook, which it would not catch up with
STATE_EVERY = 1 / 12  # s of wall time, between two states for a display
TICK_US = 33_333  # how often an event loop writes the trace and tells the display; the length of a single step
PICTURE_EVERY = 1 / 8  # s, between two pictures
SHARE = 12.0  # a display may cost one part in so many of the time
Now = Callable[[], float]
_Item = TypeVar("_Item")


class RealtimeAdapter(LiveWorld, Sensor, Actuator):
    """The simulated robot for the event loop: a thread moves its world on, `rate` steps a second.

    It is each of its sensors, which deliver from that thread, and each of its actuators.
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
        """Return this adapter, which stands for every sensor."""
        return self

    def actuator(self, use: DeviceUse) -> Actuator:
        """Return this adapter, which stands for every actuator."""
        return self

    def start(self, queue: EventQueue | None = None) -> None:
        """Nothing to do: the world has been started."""

    def take(self, command: Command) -> None:
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

    def stop(self) -> None:
        """Take no further step."""
        self._over = True
        self._awake.set()

    def rest(self) -> None:
        """Nothing to do: the world comes to its rest as a whole."""

    def close(self) -> Sequence[Notice]:
        """Stop the world after its last step; returns notices. Raises RunBroken, perhaps not reported before."""
        self.stop()
        if self._thread is not None:
            self._thread.join(LAST_STEP_WITHIN)
        left = self._world.stop()
        if self._broken is not None:
            raise self._broken
        return left.notices if left else ()

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
        if actions := _all(self._actions):
            self._world.act(actions)
        showing = self._showing
        if showing is not None and (picture := showing.due()) is not None:
            began = time.monotonic()
            queue.show(self._world.show(picture))
            showing.cost(time.monotonic() - began)

    @staticmethod
    def _post(queue: EventQueue, arrivals: Arrivals) -> None:
        for stream, value in arrivals.events:
            queue.event(stream, value)
        for notice in arrivals.notices:
            queue.tell(notice)


def _all(queue: SimpleQueue[_Item]) -> list[_Item]:
    """Take out what a queue has now; one thread only takes from it."""
    return [queue.get_nowait() for _ in range(queue.qsize())]


@dataclass(frozen=True, slots=True)
class QueuedEvent:
    """A value of a stream, a notice, or the break of a device, with the time it was put in (µs of the run)."""

    us: int
    stream: str = ""
    value: Value = None
    notice: Notice | None = None
    broken: RunBroken | None = None


class EventQueue:
    """A queue with the run's clock. Any thread may put something in; one thread takes it out, in order of arrival."""

    def __init__(self) -> None:
        self.begun = threading.Event()  # set when the run's clock starts; what is put in before has the time 0
        self._queue: SimpleQueue[QueuedEvent] = SimpleQueue()
        self._shown: SimpleQueue[WorldSnapshot] = SimpleQueue()
        self._broken: RunBroken | None = None
        self._zero = 0
        self._most: int | None = None  # the run's time at which it stands still
        self.paused = False

    def begin(self) -> None:
        """Start the run's clock."""
        self._zero = time.monotonic_ns()
        self.begun.set()

    @property
    def now_us(self) -> int:
        """The run's time in whole microseconds; 0 before it has begun."""
        now, most = (time.monotonic_ns() - self._zero) // 1_000 if self._zero else 0, self._most
        return now if most is None else min(now, most)

    @property
    def stands(self) -> bool:
        """True while the clock stands still."""
        return self._most is not None and self.now_us >= self._most

    def pause(self) -> None:
        """Let the clock stand still where it is; what is put in meanwhile waits."""
        self._most, self.paused = self.now_us, True

    def resume(self, us: int) -> None:
        """Let the clock go on from where it stands; unlike a frame's clock it does not need the time `us`."""
        now = self.now_us
        self._zero = time.monotonic_ns() - now * 1_000
        self._most, self.paused = None, False

    def step(self) -> None:
        """Let the clock go on for one tick; while one goes on, it is made longer."""
        now = self.now_us
        self._zero = time.monotonic_ns() - now * 1_000
        self._most = now + TICK_US

    def event(self, stream: str, value: Value) -> None:
        """Put a value of a stream into the queue."""
        self._queue.put(QueuedEvent(self.now_us, stream, value))

    def tell(self, notice: Notice) -> None:
        """Put a notice into the queue."""
        self._queue.put(QueuedEvent(self.now_us, notice=notice))

    def broke(self, error: RunBroken) -> None:
        """Put the break of a device into the queue: the run cannot go on."""
        self._broken = error
        self._queue.put(QueuedEvent(self.now_us, broken=error))

    def show(self, shown: WorldSnapshot) -> None:
        """Keep a snapshot of the world for a display, apart from the events."""
        self._shown.put(shown)

    def seen(self) -> list[WorldSnapshot]:
        """Return the snapshots since the last call. Raises RunBroken of a device while the clock stands still."""
        if self._broken is not None and self.stands:
            raise self._broken
        return _all(self._shown)

    def take(self, until_us: int) -> QueuedEvent | None:
        """Return the next event, or None if there is none by a time of the run. Raises RunBroken when too many wait."""
        if self._queue.qsize() > MOST_WAITING:
            words = N_("Events arrive faster than the rows can handle them: more than {most:,} are waiting.")
            remedy = N_("Look for two rows that start one actuator after its own done stream, and keep only one. Or "
                        "pass fewer values on (throttle, changes, sample).")  # fmt: skip
            raise RunBroken(N_(words, most=MOST_WAITING), remedy)
        wait = (until_us - self.now_us) / 1_000_000
        try:
            return self._queue.get(timeout=wait) if wait > 0 else self._queue.get_nowait()
        except Empty:
            return None


class FramePacer:
    """Due times of frames: `factor` 1 is real time, 2 twice as fast, 0 as fast as the machine can.

    Time that was paused, and a speed that changes, are not caught up with.
    """

    def __init__(self, factor: float, now: Now = time.monotonic) -> None:
        self._now = now
        self._factor = factor
        self._steps = 0
        self._anchor = (now(), 0)  # a wall time, and the run's time (µs) of then
        self.paused = False

    @property
    def stands(self) -> bool:
        """True while the run stands still: paused, and no single step is wanted."""
        return self.paused and not self._steps

    def left(self, due_us: int) -> float:
        """Return the seconds that are left until the frame of `due_us`; not more than 0 when it is due."""
        if self._steps or not self._factor:
            return 0.0
        wall, us = self._anchor
        return wall + (due_us - us) / 1e6 / self._factor - self._now()

    def went(self) -> None:
        """A frame goes on."""
        if self.paused and self._steps:
            self._steps -= 1

    def pause(self) -> None:
        """Stand still."""
        self.paused, self._steps = True, 0

    def resume(self, us: int) -> None:
        """Go on from where the run stands (µs)."""
        self.paused, self._steps = False, 0
        self._anchor = (self._now(), us)

    def step(self) -> None:
        """Go on for one frame."""
        self._steps += 1

    def speed(self, factor: float, us: int) -> None:
        """Be so fast from where the run stands (µs)."""
        self._factor = factor
        self._anchor = (self._now(), us)


class SnapshotThrottle:
    """Due times of snapshots for a display: of the world's state, and of what the robot sees if they want to look."""

    def __init__(self, now: Now = time.monotonic) -> None:
        self._now = now
        self._state_at = self._picture_at = now()
        self.wanted = False
        self.look = False

    def want(self, wanted: bool | None, look: bool | None) -> None:
        """Say what is wanted from now on; None leaves it as it is."""
        self.wanted = self.wanted if wanted is None else wanted
        self.look = self.look if look is None else look
        self.again()

    def due(self) -> bool | None:
        """Return None when no snapshot is due, else whether it should have a picture."""
        now = self._now()
        if not self.wanted or now < self._state_at:
            return None
        picture = self.look and now >= self._picture_at
        self._state_at = max(self._state_at + STATE_EVERY, now)
        if picture:
            self._picture_at = max(self._picture_at + PICTURE_EVERY, now)
        return picture

    def cost(self, seconds: float) -> None:
        """Put off the next state by a share of what the last one cost: on a slow machine it comes less often."""
        self._state_at = max(self._state_at, self._now() + seconds * SHARE)

    def again(self) -> None:
        """Show it as soon as can be: something was changed by hand."""
        self._state_at = self._picture_at = self._now()
