"""sample: at each tick the latest value, if one has arrived since the last tick."""

from __future__ import annotations

from rrp_sheets.connectors.spec import Connector, ConnectorContext, Parameter, Passing, Taker, ValueStream, of_first
from rrp_sheets.model.values import Value


def build(wiring: ConnectorContext) -> ValueStream:
    """Return an observable of the latest value at each tick, if one has arrived since the last tick.

    Ticks have absolute due times (no drift); a value of the tick's own instant counts.
    """
    clock, rank = wiring.clock, wiring.rank

    def make(emit: Taker) -> Taker:
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
                emit(waiting.pop())

        def edited() -> None:
            if clock.us + wiring.period_us != due:
                arm(clock.us + wiring.period_us)

        def take(value: Value) -> None:
            waiting[:] = [value]

        arm(clock.us + wiring.period_us)  # a behaviour may be switched on in the middle of a run
        wiring.edited = edited
        return take

    return of_first(wiring, make)


SAMPLE = Connector(
    name="sample",
    parameter=Parameter.PERIOD,
    icon=('<path d="M.8 9.5h2.4v-7h2.8v7h2.8v-7h2.4"/>'),
    words=("buffer", "interval", "every", "regularly", "毎秒", "一定間隔"),
    help="Passes the latest value on at a fixed pace, if a new one has arrived.",
    sentence="{Pace}, the latest {one} becomes {output}, if there is a new one.",
    variants={"next": "{Pace}, the latest {one} is passed on to {rows}, if there is a new one."},
    legend="the latest, at a fixed pace",
    build=build,
    passes=Passing("ticks", later=True),
    example=("1-2-3---4", "200 ms"),
)
