"""forgetAfter: passes values on, and a blank once nothing has arrived for a while."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rrp_sheets.connectors.spec import Connector, ConnectorContext, Parameter
from rrp_sheets.model.values import Value

if TYPE_CHECKING:
    from reactivex import Observable
    from reactivex.abc import DisposableBase, ObserverBase, SchedulerBase


def build(wiring: ConnectorContext) -> Observable[Value]:
    """Return an observable of every value at once, and of one blank when nothing has arrived for the period."""
    from reactivex import Observable

    clock, rank = wiring.clock, wiring.rank

    def subscribe(observer: ObserverBase[Value], scheduler: SchedulerBase | None = None) -> DisposableBase:
        due = 0  # when the value now held is forgotten; 0: nothing to forget
        waiting = False  # whether a check is on the agenda: one at a time, however many values arrive

        def check() -> None:
            nonlocal due, waiting
            waiting = False
            if due > clock.us:
                waiting = True
                clock.push(due, rank, check)
            elif due:
                due = 0
                observer.on_next(None)

        def take(value: Value) -> None:
            nonlocal due, waiting
            due = clock.us + wiring.period_us
            observer.on_next(value)
            if not waiting:
                waiting = True
                clock.push(due, rank, check)

        return wiring.inputs[0].subscribe(take)

    return Observable(subscribe)


FORGET_AFTER = Connector(
    name="forgetAfter",
    min_inputs=1,
    max_inputs=1,
    parameter=Parameter.PERIOD,
    icon=('<path d="M2.5 1h7M2.5 11h7M3.3 1c0 3 2.7 3.6 2.7 5S3.3 8 3.3 11M8.7 1c0 3-2.7 3.6-2.7 5s2.7 2 2.7 5"/>'),
    help="Passes values on at once, and a blank once when nothing has arrived for the period.",
    sentence="{Input} is forgotten when nothing new has come for {period}.",
    build=build,
    example=("1-2-------3", "300 ms"),
)
