"""combineLatest: one result whenever an input changes, with the latest of the others."""

from __future__ import annotations

from collections.abc import Callable

from rrp_sheets.connectors.spec import Connector, ConnectorContext, Parameter, ValueStream, batch_per_instant
from rrp_sheets.model.names import key
from rrp_sheets.model.values import Failure, Field, Record, RecordType, Value

COMBINATION = "Combination"
"""Name of the record types that a blank formula gives."""


def together(names: tuple[str, ...]) -> RecordType:
    """Return the record type that a blank formula gives: its fields are the inputs' names, or their places."""
    fields = tuple(Field(n or f"input {i}") for i, n in enumerate(names, 1))
    return RecordType(COMBINATION, fields, positions=tuple(key(f.name) for f in fields))


def build(wiring: ConnectorContext) -> ValueStream:
    """Return an observable of one result per instant in which an input changed, once each has had a value."""
    count = len(wiring.inputs)
    latest: list[Value] = [None] * count
    missing = set(range(count))
    evaluate, fail = wiring.evaluate, wiring.fail
    kind = together(wiring.names)
    fields = kind.positions

    def flush(batch: list[tuple[int, Value]], emit: Callable[[Value], None]) -> None:
        for number, value in batch:
            latest[number] = value
            missing.discard(number)
        if missing:
            return
        if evaluate is None:
            emit(Record(kind, dict(zip(fields, latest, strict=True))))
            return
        result = evaluate(*latest)
        if type(result) is Failure:
            fail(result, tuple(latest))
        else:
            emit(result)

    return batch_per_instant(wiring, flush)


COMBINE_LATEST = Connector(
    name="combineLatest",
    min_inputs=2,
    max_inputs=None,
    parameter=Parameter.OPTIONAL_FORMULA,
    icon=('<path d="M1 2.2h2.6l3 3M1 9.8h2.6l3-3M8.5 6H12"/><circle cx="7.2" cy="6" r="1.9" class="f"/>'),
    words=("zip", "combine", "both", "together", "組み合わせる", "両方"),
    help="Joins the latest values of its inputs. It waits until each has arrived, then repeats with each new one.",
    sentence="Once {inputs} have arrived, each new value of any of them updates {output} with the latest of each.",
    variants={
        "next": "Once {inputs} have arrived, each new value of any of them sends {rows} the latest of each.",
        "formula": "Once {inputs} have arrived, each new value of any of them updates {output} to {value}.",
        "formula_next": "Once {inputs} have arrived, each new value of any of them sends {rows} {value}.",
    },
    legend="joins the latest of each",
    build=build,
    example=("1---2----3", "--a----b--", "first & second"),
)
