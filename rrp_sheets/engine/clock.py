"""The run's clock, a reactivex scheduler of virtual time in whole µs, and the heartbeat that a watchdog reads.

Within a frame actions are ordered by (rank, due time, sequence): the graph settles in topological order, and a timer
that is due acts at its connector's place, after the values of its own instant have reached it. From frame to frame
timers keep their absolute due times and act in the first frame at or after them.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Collection
from datetime import UTC, datetime, timedelta
from typing import Any, Protocol, TypeVar

from reactivex.abc import DisposableBase, ScheduledAction
from reactivex.disposable import Disposable, SingleAssignmentDisposable
from reactivex.scheduler.periodicscheduler import PeriodicScheduler
from reactivex.typing import AbsoluteTime, RelativeTime

_EPOCH = datetime.fromtimestamp(0, UTC)
MOST_AT_ONCE = 30_000
"""Most values that all streams may have in one frame. Rows that double what they get, one after the other or in
a circle through a done stream, reach it within a few rows or frames; a workbook of many rows may have more."""
_LAST = 1 << 30  # the rank of actions that come from reactivex's own operators: after all rows
_State = TypeVar("_State")
Entry = tuple[int, int, int, Callable[[], None]]


class FrameClock(PeriodicScheduler):
    """Scheduler with the time in microseconds (`us`), its agenda, and the `cell` that tells which row is at work."""

    def __init__(self, cell: Heartbeat | None = None) -> None:
        super().__init__()
        self.us = 0
        self.cell = cell if cell is not None else new_cell()
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
        frame, cell = self._frame, self.cell
        while frame:
            rank, _, _, action = heapq.heappop(frame)
            cell[RANK] = rank
            action()
        cell[RANK] = NO_ROW

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
        cancelled = [False]
        inner = SingleAssignmentDisposable()

        def act() -> None:
            if not cancelled[0]:
                inner.disposable = action(self, state) or Disposable()

        def cancel() -> None:
            cancelled[0] = True
            inner.dispose()

        self.push(due, _LAST, act)
        return Disposable(cancel)


INSTANT, SETTLING, RANK = range(3)
"""Places: how many instants (frames) have begun; 1 while one settles, else 0; the rank of the row being worked out."""
PLACES = 3
NO_ROW = -1


class Heartbeat(Protocol):
    """Whole numbers by place: a list, or a memory view."""

    def __getitem__(self, place: int, /) -> int: ...

    def __setitem__(self, place: int, number: int, /) -> None: ...


def new_cell() -> Heartbeat:
    """A cell that nobody watches."""
    return [0, 0, NO_ROW]
