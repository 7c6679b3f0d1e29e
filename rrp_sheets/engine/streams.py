"""A stream of a run: a reactivex observable and observer without locks, since one thread runs the whole graph."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from reactivex import Observable
from reactivex.abc import DisposableBase, ObserverBase, SchedulerBase
from reactivex.disposable import Disposable

from rrp_sheets.engine.clock import RANK, FrameClock
from rrp_sheets.errors import RunBroken
from rrp_sheets.model.values import Value
from rrp_sheets.texts import N_


class LiveStream(Observable[Value]):
    """Passes values on in the order of subscription, and keeps the latest one and its time for the display.

    Attributes:
        latest: the last value.
        at_us: when it came; -1 before the first.
        arrived: how many have come.
    """

    def __init__(self, stream_id: str, clock: FrameClock) -> None:
        super().__init__()
        self.id = stream_id
        self.latest: Value = None
        self.at_us = -1
        self.arrived = 0
        self._clock = clock
        self._cell = clock.cell
        self._sinks: tuple[tuple[int, Callable[[Value], Any]], ...] = ()  # each with the rank of its row

    def on_next(self, value: Value) -> None:
        """A new value.

        Raises:
            RunBroken: when too many values have come in one instant.
        """
        clock = self._clock
        clock.came += 1
        if clock.came > clock.most:
            raise RunBroken(
                N_("Rows multiply what they get: more than {most:,} values came in one moment.", most=clock.most),
                N_(
                    "Look for two rows that send the same values on to one stream (merge), or command one actuator "
                    "after its own done stream, and let one of them do so."
                ),
            )
        self.latest = value
        self.at_us = clock.us
        self.arrived += 1
        cell = self._cell
        for rank, sink in self._sinks:
            cell[RANK] = rank
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
        mine = (self._cell[RANK], sink)  # the row that is being wired, or worked out
        self._sinks = (*self._sinks, mine)

        def leave() -> None:
            self._sinks = tuple(s for s in self._sinks if s is not mine)

        return Disposable(leave)
