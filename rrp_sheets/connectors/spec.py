"""The description of a connector for checks, drawings, help and engines, and what it is built with.

Engines implement :class:`Clock`. Everything that needs several inputs or time *settles*: it collects what arrives in
one instant and acts once, at its place in the topological order, after everything before it has settled. So a diamond
emits once and consistently, and a timer that is due sees the values of its own instant.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import TYPE_CHECKING, Literal, Protocol, TypeAlias

from rrp_sheets.model.values import Failure, Value
from rrp_sheets.texts import LazyMessage

if TYPE_CHECKING:
    from reactivex import Observable
    from reactivex.abc import DisposableBase, ObserverBase, SchedulerBase


class Parameter(Enum):
    """Content of a connector's Formula cell."""

    FORMULA = "formula"  # required
    OPTIONAL_FORMULA = "optional formula"
    PERIOD = "period"
    NONE = "none"


@dataclass(frozen=True)
class Passing:
    """The way in which a connector passes on the values of its first input, which stay as they are.

    Attributes:
        rate: as often as they come (`same`), at most once in a period (`limited`), at its ends (`ticks`), when they
            change (`changes`), or now and then (`events`).
        later: whether a value leaves at another moment than it came.
        blanks: whether a blank follows when nothing has come for the period.
    """

    rate: Literal["same", "limited", "ticks", "changes", "events"] = "same"
    later: bool = False
    blanks: bool = False


@dataclass(frozen=True)
class Connector:
    """Description of one kind of row for the checks, the engine and the help.

    Attributes:
        name: as shown, such as `combineLatest`; any spelling with the same key is accepted, and `synonyms` too.
        words: plain words, in all languages, and the names of other software, by which people look for it.
        max_inputs: the most, or None for any number.
        icon: SVG elements in a 12 × 12 box, stroke only; `class="f"` marks what is filled.
        help: one or two sentences for users.
        sentence: a whole sentence for the plain-language description. `{input}` is the first input's name, `{one}` the
            same after “each” or “the first”; `{inputs}` are all inputs (`{inputs_or}`: the last after “or”;
            `{each_or}`: after “each”), `{others}` all but the first after “each” or “the latest” (`{others_or}`: with
            “or”). `{output}` is the result's name, or the phrase “the input of row 5” for one without name. There are
            `{formula}`, `{period}`, `{pace}` and, from the formula, `{value}` and `{condition}`; `{event}` is the
            phrase for what triggers the row, `{does}` what an actuator does. `{Input}` begins a sentence.
        variants: its sentences for special rows, each named by what is special, in this order and joined by `_`: the
            formula stands in the way of words (`code`), `event` or `while` (`filter`), `formula`, `one` input or
            `several`, and an output without name that the `{rows}` take (`next`). The one that names most is taken.
        sentences: the sentence in other languages, by their codes; the program's own connectors have theirs in its
            catalogues.
        legend: a few words for the legend of diagrams; without them it leaves the connector out.
        build: wires the connector: from a :class:`ConnectorContext` to the observable of its output.
        is_sink: True for `subscribe`, the only connector with a side effect.
        any_input: True when one fed input is enough to be of use (`merge`); switched-off inputs are then silent.
        first_input: True when it is enough that the first input is fed (`timeout`); the others may be silent.
        passes: how it passes on the values of its first input; None when its values are others.
        extra: names that its formula sees before the inputs (accumulate: `total`, `value`).
        example: input rows of marbles (`1-2--3`) and the parameter, run to make the help's marble picture.
    """

    name: str
    icon: str
    help: str
    sentence: str
    build: Callable[[ConnectorContext], Observable[object]]
    min_inputs: int = 1
    max_inputs: int | None = 1
    parameter: Parameter = Parameter.NONE
    synonyms: tuple[str, ...] = ()
    words: tuple[str, ...] = ()
    advanced: bool = False
    is_sink: bool = False
    any_input: bool = False
    first_input: bool = False
    passes: Passing | None = None
    extra: tuple[str, ...] = ()
    example: Sequence[str] = ()
    variants: Mapping[str, str] = field(default_factory=dict, compare=False)
    sentences: Mapping[str, str] = field(default_factory=dict, compare=False)
    legend: str = ""

    def sentence_for(self, case: str = "") -> LazyMessage:
        """Return the sentence, or the variant for a case, as a message for the catalogues."""
        if case not in self.variants:
            return LazyMessage(self.sentence, msgctxt=f"row.{self.name}")
        return LazyMessage(self.variants[case], msgctxt=f"row.{self.name}_{case}")

    def help_message(self) -> LazyMessage:
        """Return the help as a message for the catalogues."""
        return LazyMessage(self.help, msgctxt=f"connector.{self.name}")

    def legend_message(self) -> LazyMessage:
        """Return the words of the legend as a message for the catalogues."""
        return LazyMessage(self.legend, msgctxt=f"legend.connector.{self.name}")


ValueStream: TypeAlias = "Observable[Value]"
Taker = Callable[[Value], None]


class Clock(Protocol):
    """The run's one clock, in whole microseconds from the start, and its schedule of actions."""

    us: int

    def push(self, due_us: int, rank: int, action: Callable[[], None]) -> None:
        """Schedule an action, ordered by (time, rank, sequence); the first frame at or after the time runs it."""
        ...


@dataclass
class ConnectorContext:
    """Everything that a connector needs to build the observable of one row.

    Attributes:
        inputs: the observables of its input streams, in order.
        rank: the row's place in the topological order.
        evaluate: the row's formula over what the connector adds to the names in scope (`Connector.extra`) and its
            inputs' values, in order; gives a Failure on an error. None without formula.
        period_us: of a connector with a period. It may be edited while the run goes on: read it when a period begins.
        fail: reports an error with the values that it came from; the event is dropped.
        edited: called when the period was edited; set by connectors that have already scheduled their next action.
    """

    inputs: Sequence[Observable[Value]]
    clock: Clock
    rank: int
    evaluate: Callable[..., Value] | None = None
    period_us: int = 0
    fail: Callable[[Failure, tuple[Value, ...]], None] = lambda failure, values: None
    names: tuple[str, ...] = ()
    edited: Callable[[], None] = lambda: None


def batch_per_instant(
    wiring: ConnectorContext, flush: Callable[[list[tuple[int, Value]], Callable[[Value], None]], None]
) -> ValueStream:
    """Return an observable that collects the inputs' values and calls `flush` once per instant, at the row's rank.

    `flush` gets the arrivals as (input number, value), in the order of their arrival, and a function to emit with.
    """
    from reactivex import Observable
    from reactivex.disposable import CompositeDisposable

    def subscribe(observer: ObserverBase[Value], scheduler: SchedulerBase | None = None) -> DisposableBase:
        arrived: list[tuple[int, Value]] = []
        clock, rank, emit = wiring.clock, wiring.rank, observer.on_next

        def run() -> None:
            batch = arrived[:]
            arrived.clear()
            flush(batch, emit)

        def taker(number: int) -> Taker:
            def take(value: Value) -> None:
                if not arrived:
                    clock.push(clock.us, rank, run)
                arrived.append((number, value))

            return take

        return CompositeDisposable([s.subscribe(taker(i)) for i, s in enumerate(wiring.inputs)])

    return Observable(subscribe)


def of_first(wiring: ConnectorContext, make: Callable[[Taker], Taker]) -> ValueStream:
    """Return an observable that subscribes `make(emit)` to the first input."""
    from reactivex import Observable

    def subscribe(observer: ObserverBase[Value], scheduler: SchedulerBase | None = None) -> DisposableBase:
        return wiring.inputs[0].subscribe(make(observer.on_next))

    return Observable(subscribe)


def by_input(batch: list[tuple[int, Value]]) -> list[tuple[int, Value]]:
    """Return the arrivals of one instant by input order, then by arrival."""
    return sorted(batch, key=lambda item: item[0])


def merged(wiring: ConnectorContext) -> ValueStream:
    """Return an observable of every value of every input; those of one instant in the order of the inputs."""

    def flush(batch: list[tuple[int, Value]], emit: Callable[[Value], None]) -> None:
        for _, value in by_input(batch):
            emit(value)

    return batch_per_instant(wiring, flush)


def first_with_latest(
    wiring: ConnectorContext, use: Callable[[tuple[Value, ...], Callable[[Value], None]], None]
) -> ValueStream:
    """Return an observable that calls `use` with each value of the first input and the others' latest values.

    Values of this instant count as latest. Nothing passes before each further input has had a value.
    """
    count = len(wiring.inputs)
    latest: list[Value] = [None] * count
    seen = [False] * count
    seen[0] = True

    def flush(batch: list[tuple[int, Value]], emit: Callable[[Value], None]) -> None:
        for number, value in batch:
            if number:
                latest[number], seen[number] = value, True
        if not all(seen):
            return
        for number, value in batch:
            if number == 0:
                use((value, *latest[1:]), emit)

    return batch_per_instant(wiring, flush)


def evaluated(wiring: ConnectorContext) -> ValueStream:
    """Return the observable of the formula's results for the first input's values, at the row's place in the order."""
    evaluate, fail = wiring.evaluate, wiring.fail
    assert evaluate is not None

    def use(values: tuple[Value, ...], emit: Callable[[Value], None]) -> None:
        result = evaluate(*values)
        if type(result) is Failure:
            fail(result, values)
        else:
            emit(result)

    return first_with_latest(wiring, use)
