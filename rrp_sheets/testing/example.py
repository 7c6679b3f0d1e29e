"""A connector's example as a marble diagram: its rows of marbles are sent into a workbook of one row, and run."""

from __future__ import annotations

import re

from rrp_sheets.connectors import Connector
from rrp_sheets.connectors.wiring import ConnectorContext
from rrp_sheets.engine.clock import FrameClock
from rrp_sheets.engine.streams import LiveStream
from rrp_sheets.formulas import compile_formula, make_scope
from rrp_sheets.formulas.evaluator import GuardedInterpreter
from rrp_sheets.model.durations import parse_duration, show_duration
from rrp_sheets.model.values import Failure, Value
from rrp_sheets.render.marble_diagram import Bar, Group, Lane, Marble, MarbleDiagram
from rrp_sheets.render.marble_drawing import draw_marbles

MARK_US = 100_000
"""Time, in µs, that one place in a row of marbles represents."""
_MARBLES = re.compile(r"[-\w]*-[-\w]*")
_AFTER_US = 1_000_000
_NAMES = ("First", "Second", "Third", "Fourth")


def example_svg(connector: Connector) -> str:
    """The picture of a connector's example, for its help page.

    >>> from rrp_sheets.connectors import connectors
    >>> example_svg(connectors().get("filter")).startswith("<svg")
    True
    """
    return draw_marbles([example_score(connector)], strips=1, legend=False)[0].svg


def example_score(connector: Connector) -> MarbleDiagram:
    """Run a connector's example, and return what goes in and what comes out as a marble diagram."""
    rows = [text for text in connector.example if _MARBLES.fullmatch(text)]
    rest = [text for text in connector.example if not _MARBLES.fullmatch(text)]
    parameter = rest[0] if rest else ""
    names = ("Input",) if len(rows) == 1 else _NAMES[: len(rows)]
    sent = [[(at * MARK_US, _value(c)) for at, c in enumerate(row) if c != "-"] for row in rows]
    came, errors, last = _played(connector, names, sent, parameter)
    period = parse_duration(parameter) if connector.parameter.value == "period" else None
    shown = show_duration(period) if period else parameter
    groups = [
        Group((), Lane(name, name, "stream", tuple(Marble(us, value) for us, value in found)))
        for name, found in zip(names, sent, strict=True)
    ]
    ticks = tuple(range(period, last + 1, period)) if period and connector.name == "sample" else ()
    if period and connector.name in ("timeout", "delay"):
        ticks = tuple(us for us, _ in came)
    elif connector.name == "forgetAfter":
        ticks = tuple(us for us, value in came if value is None)
    bar = Bar(0, names, connector.name, connector.icon, shown, ticks)
    kind = "actuator" if connector.is_sink else "stream"
    marbles = [Marble(us, value) for us, value in came] + [Marble(us, None, "", words) for us, words in errors]
    groups.append(Group((bar,), Lane("Output", "Output", kind, tuple(sorted(marbles, key=lambda m: m.us)))))
    return MarbleDiagram(connector.name, tuple(groups), 0, last)


def _value(character: str) -> Value:
    return int(character) if character.isdigit() else character


def _played(
    connector: Connector, names: tuple[str, ...], sent: list[list[tuple[int, Value]]], parameter: str
) -> tuple[list[tuple[int, Value]], list[tuple[int, str]], int]:
    """Return what came out and at which times, the errors, and the end of the example's time (µs)."""
    clock = FrameClock()
    inputs = [LiveStream(name, clock) for name in names]
    came: list[tuple[int, Value]] = []
    errors: list[tuple[int, str]] = []

    def fail(failure: Failure, values: tuple[Value, ...]) -> None:
        errors.append((clock.us, failure.message))

    period = parse_duration(parameter) if connector.parameter.value == "period" else None
    formula = None
    if parameter and period is None:
        formula = compile_formula(parameter, make_scope([(n, None) for n in names], extra=connector.extra))
    wiring = ConnectorContext(
        inputs=inputs, clock=clock, rank=0, period_us=period or 0, fail=fail, names=names,
        evaluate=formula.prepare(GuardedInterpreter()) if formula else None,
    )  # fmt: skip
    connector.build(wiring).subscribe(lambda value: came.append((clock.us, value)))
    last = max((us for found in sent for us, _ in found), default=0)
    frame = 0
    while frame * MARK_US <= last + _AFTER_US:
        clock.begin(frame * MARK_US)
        for stream, found in zip(inputs, sent, strict=True):
            for us, value in found:
                if us == clock.us:
                    stream.on_next(value)
        clock.drain()
        frame += 1
    return came, errors, max([last, *(us for us, _ in came)])
