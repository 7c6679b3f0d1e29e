"""timestamp: each value together with the time of its arrival."""

from __future__ import annotations

from rrp_sheets.connectors.spec import Connector, ConnectorContext, ValueStream
from rrp_sheets.model.values import Field, Record, RecordType

TIMED = RecordType(
    "Value with time",
    (Field("value", help="the value"), Field("timestamp", "number", "s", 1.0, "seconds since the run began")),
    aliases={"v": "value", "t": "timestamp"},
    positions=("timestamp", "value"),  # as in the original software: [0] is the time
)


def build(wiring: ConnectorContext) -> ValueStream:
    """Return an observable of records of `value` (`v`) and `timestamp` (`t`, in seconds on the run's one clock)."""
    from reactivex import operators as ops

    clock = wiring.clock
    return wiring.inputs[0].pipe(ops.map(lambda v: Record(TIMED, {"value": v, "timestamp": clock.us / 1_000_000})))


TIMESTAMP = Connector(
    name="timestamp",
    icon=('<circle cx="6" cy="6" r="4.8"/><path d="M6 3v3.2l2.2 1.3"/>'),
    words=("時刻",),
    help="Adds the time to each value: a record with the fields value (v) and timestamp (t, seconds).",
    sentence="Each {one} becomes {output}, together with its time.",
    variants={"next": "Each {one} is passed on to {rows}, together with its time."},
    legend="adds the time",
    build=build,
    example=("a-b--c",),
)
