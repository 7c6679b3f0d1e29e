"""throttle: the first value of each period."""

from __future__ import annotations

from rrp_sheets.connectors.spec import Connector, ConnectorContext, Parameter, Passing, Taker, ValueStream, of_first
from rrp_sheets.model.values import Value


def build(wiring: ConnectorContext) -> ValueStream:
    """Return an observable that drops values within the period after one that passes; one at its end passes."""
    clock = wiring.clock

    def make(emit: Taker) -> Taker:
        free = 0  # from when on a value passes

        def take(value: Value) -> None:
            nonlocal free
            if clock.us >= free:
                free = clock.us + wiring.period_us
                emit(value)

        return take

    return of_first(wiring, make)


THROTTLE = Connector(
    name="throttle",
    parameter=Parameter.PERIOD,
    icon=('<path d="M1 1.5v9M11 1.5v9M1 6h3"/><circle cx="5" cy="6" r="1" class="f"/><path d="M7.6 6h.2M9.2 6h.2"/>'),
    words=("throttlefirst", "seldom", "limit", "間引く"),
    help="Passes a value on, then ignores new ones for the period.",
    sentence="{Event}, send {output}, then ignore new ones for {period}.",
    variants={"next": "{Event}, continue with {rows}, then ignore new ones for {period}."},
    legend="at most one per period",
    build=build,
    advanced=True,
    passes=Passing("limited"),
    example=("1-2-3-4-5-6", "300 ms"),
)
