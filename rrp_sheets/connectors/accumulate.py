"""accumulate: a total that every event changes."""

from __future__ import annotations

from collections.abc import Callable

from rrp_sheets.connectors.spec import Connector, ConnectorContext, Parameter, ValueStream, batch_per_instant, by_input
from rrp_sheets.model.values import Failure, Value


def build(wiring: ConnectorContext) -> ValueStream:
    """Return an observable of the total, which each event changes, by input order and then by arrival.

    The formula's result becomes the total. It sees `total`, `value` (the event's) and the inputs: the event's own has
    its value, the others are blank. Without formula every event counts one. An error keeps the total.
    """
    evaluate, fail = wiring.evaluate, wiring.fail
    count = len(wiring.inputs)
    total: Value = 0

    def flush(batch: list[tuple[int, Value]], emit: Callable[[Value], None]) -> None:
        nonlocal total
        for number, value in by_input(batch):
            if evaluate is None:
                total += 1
            else:
                inputs = [value if i == number else None for i in range(count)]
                result = evaluate(total, value, *inputs)
                if type(result) is Failure:
                    fail(result, (total, value, *inputs))
                    continue
                total = result
            emit(total)

    return batch_per_instant(wiring, flush)


ACCUMULATE = Connector(
    name="accumulate",
    max_inputs=None,
    parameter=Parameter.OPTIONAL_FORMULA,
    icon=('<path d="M9.6 2.8V1.3H2.2L6.4 6l-4.2 4.7h7.4V9.2"/>'),
    words=(
        "scan",
        "reduce",
        "count",
        "sum",
        "total",
        "add",
        "score",
        "many",
        "times",
        "数える",
        "合計",
        "回数",
        "点数",
    ),
    help="Updates a total with each value of its inputs. Without a formula it counts them.",
    sentence="Each {each_or} adds 1 to {output}.",
    variants={
        "next": "Each {each_or} adds 1 to a total, which is passed on to {rows}.",
        "formula": "Each {each_or} updates {output} to {formula}.",
        "formula_next": "Each {each_or} updates a total to {formula}, which is passed on to {rows}.",
    },
    legend="counts or adds up",
    build=build,
    advanced=True,
    any_input=True,
    extra=("total", "value"),
    example=("1-1-1----1-", "------0----", "IF(ISBLANK(second), total + 1, 0)"),
)
