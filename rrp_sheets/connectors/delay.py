"""delay: each value, later."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rrp_sheets.connectors.spec import Connector, ConnectorContext, Parameter
from rrp_sheets.model.values import Value

if TYPE_CHECKING:
    from reactivex import Observable
    from reactivex.abc import DisposableBase, ObserverBase, SchedulerBase


def build(wiring: ConnectorContext) -> Observable[Value]:
    """Return an observable of every value after the period; their order and their distances are kept."""
    from reactivex import Observable

    clock, rank = wiring.clock, wiring.rank

    def subscribe(observer: ObserverBase[Value], scheduler: SchedulerBase | None = None) -> DisposableBase:
        def take(value: Value) -> None:
            clock.push(clock.us + wiring.period_us, rank, lambda: observer.on_next(value))

        return wiring.inputs[0].subscribe(take)

    return Observable(subscribe)


DELAY = Connector(
    name="delay",
    min_inputs=1,
    max_inputs=1,
    parameter=Parameter.PERIOD,
    icon=(
        '<circle cx="2.2" cy="3" r="1.2"/><path d="M2.2 7.2h6M6.2 5.2l2 2-2 2"/>'
        '<circle cx="10.4" cy="7.2" r="1.2" class="f"/>'
    ),
    help="Passes every value on later, after the period.",
    sentence="{Input} goes on {period} later.",
    build=build,
    advanced=True,
    example=("1-2--3-----", "200 ms"),
)
