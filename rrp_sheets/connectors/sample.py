"""sample: at each tick the latest value, if one has arrived since the last tick."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rrp_sheets.connectors.spec import Connector, ConnectorContext, Parameter
from rrp_sheets.model.values import Value

if TYPE_CHECKING:
    from reactivex import Observable
    from reactivex.abc import DisposableBase, ObserverBase, SchedulerBase


def build(wiring: ConnectorContext) -> Observable[Value]:
    """Return an observable of the latest value at each tick, if one has arrived since the last tick.

    Ticks have absolute due times (no drift); a value of the tick's own instant counts.
    """
    from reactivex import Observable
    from reactivex.disposable import SingleAssignmentDisposable

    clock, rank = wiring.clock, wiring.rank

    def subscribe(observer: ObserverBase[Value], scheduler: SchedulerBase | None = None) -> DisposableBase:
        waiting: list[Value] = []
        due = 0

        def arm(at: int) -> None:
            nonlocal due
            due = at
            clock.push(due, rank, lambda: tick(at))

        def tick(at: int) -> None:
            if at != due:  # the period was edited meanwhile
                return
            period = wiring.period_us
            arm(due + max(1, (clock.us - due) // period + 1) * period)
            if waiting:
                observer.on_next(waiting.pop())

        def edited() -> None:
            if clock.us + wiring.period_us != due:
                arm(clock.us + wiring.period_us)

        def take(value: Value) -> None:
            waiting[:] = [value]

        source = SingleAssignmentDisposable()
        source.disposable = wiring.inputs[0].subscribe(take)
        arm(clock.us + wiring.period_us)  # a behaviour may be switched on in the middle of a run
        wiring.edited = edited
        return source

    return Observable(subscribe)


SAMPLE = Connector(
    name="sample",
    min_inputs=1,
    max_inputs=1,
    parameter=Parameter.PERIOD,
    icon=('<path d="M.8 9.5h2.4v-7h2.8v7h2.8v-7h2.4"/>'),
    help="At a fixed pace, the latest value, if one has arrived since the last time.",
    sentence="Every {period}, the latest {input} goes on.",
    build=build,
    example=("1-2-3---4", "200 ms"),
)
