"""forgetAfter: passes values on, and a blank once nothing has arrived for a while."""

from __future__ import annotations

from rrp_sheets.connectors.spec import Connector, ConnectorContext, Parameter, Passing, Taker, ValueStream, of_first
from rrp_sheets.model.values import Value


def build(wiring: ConnectorContext) -> ValueStream:
    """Return an observable of every value at once, and of one blank when nothing has arrived for the period."""
    clock, rank = wiring.clock, wiring.rank

    def make(emit: Taker) -> Taker:
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
                emit(None)

        def take(value: Value) -> None:
            nonlocal due, waiting
            due = clock.us + wiring.period_us
            emit(value)
            if not waiting:
                waiting = True
                clock.push(due, rank, check)

        return take

    return of_first(wiring, make)


FORGET_AFTER = Connector(
    name="forgetAfter",
    parameter=Parameter.PERIOD,
    icon=('<path d="M2.5 1h7M2.5 11h7M3.3 1c0 3 2.7 3.6 2.7 5S3.3 8 3.3 11M8.7 1c0 3-2.7 3.6-2.7 5s2.7 2 2.7 5"/>'),
    words=("forget", "expire", "忘れる"),
    help="Passes values on at once. If none arrives for the period, an empty value (blank) follows.",
    sentence="Each {one} becomes {output} at once. If no new one arrives for {period}, an empty value (blank) follows.",
    variants={
        "next": "Each {one} is passed on to {rows} at once. If no new one arrives for {period}, an empty value (blank) "
        "follows."
    },
    legend="forgets what is old",
    build=build,
    passes=Passing(blanks=True),
    example=("1-2-------3", "300 ms"),
)
