"""subscribe: drives an actuator; the only connector with a side effect."""

from __future__ import annotations

from rrp_sheets.connectors.spec import Connector, ConnectorContext, Parameter, ValueStream, evaluated, merged


def build(wiring: ConnectorContext) -> ValueStream:
    """Return an observable of the values for the actuator: those of every input or, with a formula, its results.

    A formula works as in `map`. Values come at the row's own place in the order, so the later of two rows prevails.
    """
    return merged(wiring) if wiring.evaluate is None else evaluated(wiring)


SUBSCRIBE = Connector(
    name="subscribe",
    max_inputs=None,
    parameter=Parameter.OPTIONAL_FORMULA,
    icon=('<path d="M.8 6h5.6M4.2 3.6 6.6 6 4.2 8.4"/><path d="M9.4 1.5v9" stroke-width="2.4"/>'),
    words=("do", "act", "command", "動かす", "実行"),
    help="Controls the actuator stream named as output. A blank value stops what it is doing.",
    sentence="{Event}, {does}.",
    variants={"code_several": "{Event}, {does}, using the latest {others}.", "used": "{Event}, {does}, using {value}."},
    legend="controls an actuator",
    build=build,
    is_sink=True,
    example=("1-2--3",),
)
