"""filter: lets a value of the first input pass when the formula holds."""

from __future__ import annotations

from collections.abc import Callable

from rrp_sheets.connectors.spec import Connector, ConnectorContext, Parameter, Passing, ValueStream, first_with_latest
from rrp_sheets.model.values import Failure, Value, show
from rrp_sheets.texts import N_


def build(wiring: ConnectorContext) -> ValueStream:
    """Return an observable of the first input's values for which the formula gives TRUE or a number other than 0."""
    from reactivex import operators as ops

    evaluate, fail = wiring.evaluate, wiring.fail
    assert evaluate is not None

    def holds(result: Value, values: tuple[Value, ...]) -> bool:
        if result is True or result is False:
            return result
        if result is None:
            return False
        if isinstance(result, (int, float)):
            return result != 0
        if type(result) is not Failure:
            words = N_("A filter needs TRUE or FALSE, but this gives {value}.", value=show(result))
            result = Failure("FORM108", words)
        fail(result, values)
        return False

    if len(wiring.inputs) == 1:

        def passes(value: Value) -> bool:
            result = evaluate(value)
            return result if result is True or result is False else holds(result, (value,))

        return wiring.inputs[0].pipe(ops.filter(passes))

    def use(values: tuple[Value, ...], emit: Callable[[Value], None]) -> None:
        if holds(evaluate(*values), values):
            emit(values[0])

    return first_with_latest(wiring, use)


FILTER = Connector(
    name="filter",
    max_inputs=None,
    parameter=Parameter.FORMULA,
    icon=('<path d="M1 1.5h10L7.2 6.2v4.3L4.8 9V6.2z"/>'),
    words=("where", "if", "condition", "only", "条件", "絞る"),
    help="Passes a value of the first input on when the formula is true, using the latest values of further inputs.",
    sentence="When {condition}, send {output}.",
    variants={
        "next": "When {condition}, continue with {rows}.",
        "event": "{Event}, if {condition}, send {output}.",
        "event_next": "{Event}, if {condition}, continue with {rows}.",
        "event_code_several": "{Event}, send {output} if {condition}, using the latest {others}.",
        "event_code_several_next": "{Event}, continue with {rows} if {condition}, using the latest {others}.",
        "while": "While {condition}, every {one} becomes {output}.",
        "while_next": "While {condition}, every {one} is passed on to {rows}.",
    },
    legend="only values that fit",
    build=build,
    passes=Passing(),
    example=("1-5--2-7", "value > 3"),
)
