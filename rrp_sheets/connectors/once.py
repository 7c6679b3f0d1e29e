"""once: every kind of value only the first time, until a value of another input lets it pass again."""

from __future__ import annotations

from collections.abc import Callable, Hashable

from rrp_sheets.connectors.spec import Connector, ConnectorContext, Parameter, Passing, ValueStream, batch_per_instant
from rrp_sheets.model.values import Failure, Value, identity

MOST_KEYS = 100_000
"""Of more, the oldest are forgotten: a run of hours must not fill the memory."""


def build(wiring: ConnectorContext) -> ValueStream:
    """Return an observable of the first input's values whose key has not passed since another input had a value.

    In one instant the other inputs come first, as with `map` and `filter`: `Right, Part | once` takes a right answer
    that comes together with a new part as the new part's. Without formula all values have one key.
    """
    evaluate, fail = wiring.evaluate, wiring.fail
    latest: list[Value] = [None] * len(wiring.inputs)
    passed: dict[Hashable, None] = {}

    def flush(batch: list[tuple[int, Value]], emit: Callable[[Value], None]) -> None:
        for number, value in batch:
            if number:
                latest[number] = value
                passed.clear()
        for number, value in batch:
            if number:
                continue
            result: Value = True
            if evaluate is not None:
                values = (value, *latest[1:])
                result = evaluate(*values)
                if type(result) is Failure:
                    fail(result, values)
                    continue
            key = identity(result)
            if key in passed:
                continue
            if len(passed) >= MOST_KEYS:
                del passed[next(iter(passed))]
            passed[key] = None
            emit(value)

    return batch_per_instant(wiring, flush)


ONCE = Connector(
    name="once",
    max_inputs=None,
    parameter=Parameter.OPTIONAL_FORMULA,
    icon=('<circle cx="6" cy="6" r="4.8"/><path d="M4.6 4.4 6.2 3v6M4.6 9h3.2"/>'),
    words=("distinct", "first", "take", "最初", "一度", "1回"),
    help="Passes only the first value of the first input on, or the first for each result of the formula. A value of "
    "another input starts over.",
    sentence="Only the first {one} becomes {output}.",
    variants={
        "next": "Only the first {one} is passed on to {rows}.",
        "formula": "The first {one} with a new value of {formula} becomes {output}. Later ones with the same "
        "value do nothing.",
        "formula_next": "The first {one} with a new value of {formula} is passed on to {rows}. Later ones with the "
        "same value do nothing.",
        "several": "Only the first {one} becomes {output}, and again the first one after each {others}.",
        "several_next": "Only the first {one} is passed on to {rows}, and again the first one after each {others}.",
        "formula_several": "The first {one} with a new value of {formula} becomes {output}. Later ones with the same "
        "value do nothing, until {others} arrives.",
        "formula_several_next": "The first {one} with a new value of {formula} is passed on to {rows}. Later ones with "
        "the same value do nothing, until {others} arrives.",
    },
    legend="only the first time",
    build=build,
    advanced=True,
    first_input=True,
    passes=Passing("events"),
    example=("a-b-a--b-a", "-----1----", "first"),
)
