"""Queue of the events for an event loop: the only object of a run that its other threads use."""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass
from queue import Empty, SimpleQueue

from rrp_sheets.errors import RunBroken
from rrp_sheets.model.exchange import Notice, WorldSnapshot
from rrp_sheets.model.values import Value

MOST_WAITING = 20_000  # events: minutes of work for any workbook, so that it will not be caught up with


@dataclass(frozen=True, slots=True)
class QueuedEvent:
    """A value of a stream, a happening, or the break of a device, with the time it was put in (µs of the run)."""

    us: int
    stream: str = ""
    value: Value = None
    happening: Notice | None = None
    broken: RunBroken | None = None


class EventQueue:
    """A queue with the run's clock. Any thread may put something in; one thread takes it out, in order of arrival.

    Attributes:
        begun: set when the run's clock starts; what is put in before has the time 0.
    """

    def __init__(self) -> None:
        self.begun = threading.Event()
        self._queue: SimpleQueue[QueuedEvent] = SimpleQueue()
        self._shown: SimpleQueue[WorldSnapshot] = SimpleQueue()
        self._broken: RunBroken | None = None
        self._zero = 0
        self._most: int | None = None  # the run's time at which it stands still

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
        self._most = self.now_us

    def resume(self, for_us: int | None = None) -> None:
        """Let the clock go on from where it stands, for some time only if that is given."""
        now = self.now_us
        self._zero = time.monotonic_ns() - now * 1_000
        self._most = None if for_us is None else now + for_us

    def event(self, stream: str, value: Value) -> None:
        """Put a value of a stream into the queue."""
        self._queue.put(QueuedEvent(self.now_us, stream, value))

    def tell(self, happening: Notice) -> None:
        """Put a notice into the queue."""
        self._queue.put(QueuedEvent(self.now_us, happening=happening))

    def broke(self, error: RunBroken) -> None:
        """Put the break of a device into the queue: the run cannot go on."""
        self._broken = error
        self._queue.put(QueuedEvent(self.now_us, broken=error))

    def show(self, shown: WorldSnapshot) -> None:
        """Keep a snapshot of the world for a display, apart from the events."""
        self._shown.put(shown)

    def seen(self) -> list[WorldSnapshot]:
        """Return the snapshots for a display since the last call; they do not wait behind events.

        Raises:
            RunBroken: when a device has broken while the clock stood still.
        """
        if self._broken is not None and self.stands:
            raise self._broken
        found: list[WorldSnapshot] = []
        while not self._shown.empty():
            found.append(self._shown.get_nowait())
        return found

    def take(self, until_us: int) -> QueuedEvent | None:
        """The next event, waiting until a time of the run for it; None when there is none by then.

        Raises:
            RunBroken: when so much waits that it grows faster than it is worked out.
        """
        if self._queue.qsize() > MOST_WAITING:
            raise RunBroken(
                f"Events come faster than the rows work them out: more than {MOST_WAITING:,} are waiting.",
                "Look for two rows that command one actuator after its own done stream, and let one of them do so; "
                "or let fewer values through (throttle, changes, sample).",
            )
        wait = (until_us - self.now_us) / 1_000_000
        try:
            return self._queue.get(timeout=wait) if wait > 0 else self._queue.get_nowait()
        except Empty:
            return None
