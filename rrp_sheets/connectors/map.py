"""map: a new value worked out from each value of the first input."""

from __future__ import annotations

from rrp_sheets.connectors.spec import Connector, ConnectorContext, Parameter, ValueStream, evaluated
from rrp_sheets.model.values import Failure, Value


def build(wiring: ConnectorContext) -> ValueStream:
    """Return an observable of the formula's results for the first input's values and the latest of the others."""
    from reactivex import compose
    from reactivex import operators as ops

    evaluate, fail = wiring.evaluate, wiring.fail
    assert evaluate is not None
    if len(wiring.inputs) == 1:

        def work_out(value: Value) -> Value:
            result = evaluate(value)
            if type(result) is Failure:
                fail(result, (value,))
            return result

        return wiring.inputs[0].pipe(compose(ops.map(work_out), ops.filter(lambda result: type(result) is not Failure)))

    return evaluated(wiring)


MAP = Connector(
    name="map",
    max_inputs=None,
    parameter=Parameter.FORMULA,
    icon=('<path d="M1 6h6.5M5.2 3.4 7.8 6 5.2 8.6"/><rect x="9" y="4.2" width="2.6" height="3.6" class="f"/>'),
    words=("select", "withlatestfrom", "calculate", "compute", "計算"),
    help="Calculates a new value for each value of the first input, using the latest values of further inputs.",
    sentence="{Event}, set {output} to {value}.",
    variants={
        "next": "{Event}, send {value} to {rows}.",
        "code": "{Event}, calculate {output} with {value}.",
        "code_next": "{Event}, calculate {value} for {rows}.",
        "code_several": "{Event}, calculate {output} with {value} and the latest {others}.",
        "code_several_next": "{Event}, calculate {value} with the latest {others} for {rows}.",
    },
    legend="calculates a new value",
    build=build,
    example=("1-2--3", "value * 10"),
)
