"""timeout: the first input's value when nothing else has come in time."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rrp_sheets.connectors.spec import Connector, ConnectorContext, Parameter, Passing, Taker, ValueStream
from rrp_sheets.model.values import Value

if TYPE_CHECKING:
    from reactivex.abc import DisposableBase, ObserverBase, SchedulerBase


def build(wiring: ConnectorContext) -> ValueStream:
    """Return an observable of the first input's last value after the period, unless another input cancels it.

    A newer value restarts the period. In one instant the order is: cancel, start, emit; so a value that comes at the
    last moment is in time.
    """
    from reactivex import Observable
    from reactivex.disposable import CompositeDisposable

    clock, rank = wiring.clock, wiring.rank

    def subscribe(observer: ObserverBase[Value], scheduler: SchedulerBase | None = None) -> DisposableBase:
        arrived: list[tuple[int, Value]] = []
        armed: list[Value] = []  # the value that waits for its time, if any
        due = 0
        waiting = False  # whether a check is on the agenda: one at a time, however often the clock is armed

        def settle() -> None:
            nonlocal due, waiting
            if any(number for number, _ in arrived):
                armed.clear()
            for number, value in arrived:
                if number == 0:
                    armed[:] = [value]
                    due = clock.us + wiring.period_us
            arrived.clear()
            if armed and due <= clock.us:
                observer.on_next(armed.pop())
            if armed and not waiting:
                waiting = True
                clock.push(due, rank, check)

        def check() -> None:
            nonlocal waiting
            waiting = False
            settle()

        def taker(number: int) -> Taker:
            def take(value: Value) -> None:
                if not arrived:
                    clock.push(clock.us, rank, settle)
                arrived.append((number, value))

            return take

        return CompositeDisposable([s.subscribe(taker(i)) for i, s in enumerate(wiring.inputs)])

    return Observable(subscribe)


TIMEOUT = Connector(
    name="timeout",
    max_inputs=None,
    parameter=Parameter.PERIOD,
    icon=('<circle cx="6" cy="6.8" r="4.3"/><path d="M6 4.2v2.8M4.6 1h2.8M6 1v1.4"/><circle cx="6" cy="8.8" r=".5"/>'),
    words=("debounce", "silence", "wait", "seconds", "no answer", "待つ", "時間切れ", "返事がない"),
    help="Passes the first input's value on when the period is over, unless another input has a value first. A newer "
    "value restarts the period.",
    sentence="{Period} after the last {one}, send {output}.",
    variants={
        "next": "{Period} after the last {one}, continue with {rows}.",
        "several": "{Period} after the last {one}, send {output}, unless {others_or} arrives first.",
        "several_next": "{Period} after the last {one}, continue with {rows}, unless {others_or} arrives first.",
    },
    legend="when time has passed",
    build=build,
    advanced=True,
    first_input=True,
    passes=Passing("events", later=True),
    example=("1---2------", "--a--------", "300 ms"),
)
