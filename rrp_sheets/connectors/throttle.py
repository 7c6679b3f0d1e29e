"""throttle: the first value of each period."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rrp_sheets.connectors.spec import Connector, ConnectorContext, Parameter
from rrp_sheets.model.values import Value

if TYPE_CHECKING:
    from reactivex import Observable
    from reactivex.abc import DisposableBase, ObserverBase, SchedulerBase


def build(wiring: ConnectorContext) -> Observable[Value]:
    """Return an observable that drops values within the period after one that passes; one at its end passes."""
    from reactivex import Observable

    clock = wiring.clock

    def subscribe(observer: ObserverBase[Value], scheduler: SchedulerBase | None = None) -> DisposableBase:
        free = 0  # from when on a value passes

        def take(value: Value) -> None:
            nonlocal free
            if clock.us >= free:
                free = clock.us + wiring.period_us
                observer.on_next(value)

        return wiring.inputs[0].subscribe(take)

    return Observable(subscribe)


THROTTLE = Connector(
    name="throttle",
    min_inputs=1,
    max_inputs=1,
    parameter=Parameter.PERIOD,
    icon=('<path d="M1 1.5v9M11 1.5v9M1 6h3"/><circle cx="5" cy="6" r="1" class="f"/><path d="M7.6 6h.2M9.2 6h.2"/>'),
    help="Lets one value pass and drops those that come within the period after it.",
    sentence="Of {input}, at most one in {period} goes on; the others are dropped.",
    build=build,
    advanced=True,
    example=("1-2-3-4-5-6", "300 ms"),
)
