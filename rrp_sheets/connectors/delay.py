"""delay: each value, later."""

from __future__ import annotations

from rrp_sheets.connectors.spec import Connector, ConnectorContext, Parameter, Passing, Taker, ValueStream, of_first


def build(wiring: ConnectorContext) -> ValueStream:
    """Return an observable of every value after the period; their order and their distances are kept."""
    clock, rank = wiring.clock, wiring.rank

    def make(emit: Taker) -> Taker:
        return lambda value: clock.push(clock.us + wiring.period_us, rank, lambda: emit(value))

    return of_first(wiring, make)


DELAY = Connector(
    name="delay",
    parameter=Parameter.PERIOD,
    icon=(
        '<circle cx="2.2" cy="3" r="1.2"/><path d="M2.2 7.2h6M6.2 5.2l2 2-2 2"/>'
        '<circle cx="10.4" cy="7.2" r="1.2" class="f"/>'
    ),
    words=("wait", "later", "pause", "seconds", "待つ", "遅らせる", "後で"),
    help="Passes every value on after the period.",
    sentence="{Period} after each {one}, send {output}.",
    variants={"next": "{Period} after each {one}, continue with {rows}."},
    legend="the same, later",
    build=build,
    advanced=True,
    passes=Passing(later=True),
    example=("1-2--3-----", "200 ms"),
)
