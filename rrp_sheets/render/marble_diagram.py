"""Model of marble diagrams from any source, and the diagrams as plain text for terminals."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

from rrp_sheets.errors import SheetsError
from rrp_sheets.graph import BehaviourGraph, Graph, Step, Stream, StreamKind
from rrp_sheets.model.durations import show_duration
from rrp_sheets.model.names import key, nearest
from rrp_sheets.model.values import Record, Value, show
from rrp_sheets.render.style import clean, columns, shortened
from rrp_sheets.render.texts import Texts, texts
from rrp_sheets.texts import N_, listed, translate

_MOST_TICKS = 400


@dataclass(frozen=True, slots=True)
class Marble:
    """A value at a time (µs), or why a formula failed; `row` is the one that gave it (`Tracking!4`), if any did."""

    us: int
    value: Value = None
    row: str = ""
    error: str = ""


@dataclass(frozen=True)
class Lane:
    """Line of one stream, with its marbles by time.

    Attributes:
        label: the stream's name; empty for an anonymous one.
        kind: `sensor`, `stream`, `anonymous`, `actuator`, `done`.
    """

    id: str
    label: str
    kind: str
    marbles: tuple[Marble, ...] = ()


@dataclass(frozen=True)
class Bar:
    """A connector: a row between its inputs and its output.

    Attributes:
        row: its number in the sheet; 0 for none.
        inputs: names of the input streams; `sources` their ids.
        icon: SVG elements in a 12 × 12 box.
        formula: as typed; of a period the duration.
        ticks: when its clock acts, in microseconds.
    """

    row: int
    inputs: tuple[str, ...]
    connector: str
    icon: str = ""
    formula: str = ""
    ticks: tuple[int, ...] = ()
    off: bool = False
    sources: tuple[str, ...] = ()


@dataclass(frozen=True)
class Group:
    """A stream with the rows that give it; a sensor has no such rows."""

    bars: tuple[Bar, ...]
    lane: Lane


@dataclass(frozen=True)
class MarbleDiagram:
    """A marble diagram, not yet drawn.

    Attributes:
        groups: from the sensors down to the actuators.
        marks: times with a short text each that are pointed at.
        foot: where it comes from, a line below it; empty for none.
        about: names and texts for the file's metadata.
    """

    title: str
    groups: tuple[Group, ...]
    first_us: int
    last_us: int
    marks: tuple[tuple[int, str], ...] = field(default=())
    foot: str = ""
    about: tuple[tuple[str, str], ...] = ()
    language: str = "en"

    @property
    def lanes(self) -> list[Lane]:
        """Lanes of all streams in order."""
        return [g.lane for g in self.groups]

    def between(self, first_us: int, last_us: int) -> MarbleDiagram:
        """Return the part of the diagram within a time window."""
        groups = []
        for group in self.groups:
            bars = [replace(b, ticks=tuple(t for t in b.ticks if first_us <= t <= last_us)) for b in group.bars]
            marbles = tuple(m for m in group.lane.marbles if first_us <= m.us <= last_us)
            groups.append(Group(tuple(bars), replace(group.lane, marbles=marbles)))
        return replace(self, groups=tuple(groups), first_us=first_us, last_us=last_us)

    def only(self, ids: Collection[str]) -> MarbleDiagram:
        """Return the diagram with only the streams of these ids."""
        return replace(self, groups=tuple(g for g in self.groups if g.lane.id in ids))


def make_score(
    graph: Graph, behaviour: BehaviourGraph, events: Iterable[tuple[int, str, str, Value]],
    errors: Iterable[tuple[int, str, str]] = (), last_us: int = 0, language: str = "en",
) -> MarbleDiagram:  # fmt: skip
    """Return the marble diagram of a behaviour: sensors, then streams by the rows that give them, then actuators.

    `events` have time (µs), stream id, row and value, in order; `errors` have time, row and message. The diagram
    goes on at least until `last_us`.
    """
    steps = sorted((s for s in behaviour.steps if s.active), key=lambda s: s.number)
    refs = {s.ref: s for s in steps}
    ids = dict.fromkeys(i for s in steps for i in (*s.inputs, s.output) if i in graph.streams)
    marbles: dict[str, list[Marble]] = {i: [] for i in ids}
    words = texts(language)
    for us, stream_id, row, value in events:
        last_us = max(last_us, us)
        if stream_id in ids and (graph.streams[stream_id].kind is not StreamKind.ACTUATOR or row in refs):
            marbles[stream_id].append(Marble(us, value, row))
    for us, row, message in errors:
        last_us = max(last_us, us)
        if row in refs:
            marbles[refs[row].output].append(Marble(us, None, row, translate(message, language)))
    streams = [graph.streams[i] for i in ids]
    first_row = {s.output: s.number for s in reversed(steps)}

    def rank(stream: Stream) -> tuple[int, int]:
        if stream.kind in (StreamKind.SENSOR, StreamKind.DONE):
            return 0, 0
        return (2, 0) if stream.kind is StreamKind.ACTUATOR else (1, first_row.get(stream.id, 0))

    groups = []
    for stream in sorted(streams, key=rank):
        bars = tuple(_bar(s, graph, marbles, last_us, words) for s in steps if s.output == stream.id)
        lane = Lane(stream.id, stream.name, stream.kind.value, tuple(sorted(marbles[stream.id], key=lambda m: m.us)))
        groups.append(Group(bars, lane))
    return MarbleDiagram(behaviour.name, tuple(groups), 0, last_us, language=language)


def _bar(step: Step, graph: Graph, marbles: Mapping[str, list[Marble]], last_us: int, words: Texts) -> Bar:
    formula = show_duration(step.period_us) if step.period_us else step.row.formula.text
    sources = tuple(i for i in step.inputs if i in graph.streams)
    streams, connector = [graph.streams[i] for i in sources], step.connector
    names = tuple(s.name or words.get("behaviour.row", n=s.address.row) for s in streams)
    clock = _ticks(step, marbles, last_us)
    return Bar(step.number, names, connector.name, connector.icon, formula, clock, not step.row.on, sources)


def _ticks(step: Step, marbles: Mapping[str, list[Marble]], last_us: int) -> tuple[int, ...]:
    """Return the times (µs) at which the clock of a connector with a period acts."""
    period, passes = step.period_us or 0, step.connector.passes
    if period <= 0 or passes is None:
        return ()
    if passes.rate == "ticks":
        return tuple(range(period, last_us + 1, period)) if last_us / period <= _MOST_TICKS else ()
    if passes.blanks:
        return tuple(m.us for m in marbles[step.output] if m.value is None)
    if passes.later and passes.rate == "same":
        return tuple(m.us + period for m in marbles.get(step.inputs[0], ()) if m.us + period <= last_us)
    return tuple(m.us for m in marbles[step.output]) if passes.later else ()


def upstream(graph: BehaviourGraph, streams: Iterable[str], most: int) -> list[str]:
    """Return these streams and those that they come from, the nearest first, at most `most`."""
    found = list(dict.fromkeys(streams))
    for current in found:  # it grows on the way
        for step in graph.steps:
            if step.output == current and step.active:
                found += [source for source in dict.fromkeys(step.inputs) if source not in found]
    return found[:most]


def chosen(
    scores: Sequence[MarbleDiagram], behaviour: str, window: tuple[int | None, int | None], streams: Sequence[str]
) -> list[MarbleDiagram]:
    """Return the diagrams of one behaviour, some streams, some time; raise SheetsError when nothing is left."""
    found = [s for s in scores if not behaviour or key(s.title.rpartition(": ")[2]) == key(behaviour)]
    if behaviour and not found:
        names = [s.title.rpartition(": ")[2] for s in scores]
        raise SheetsError(N_("Nothing came in a behaviour “{name}”.", name=behaviour), _proposed(behaviour, names))
    if streams:
        names = [lane.label for s in found for lane in s.lanes if lane.label]
        missing = [n for n in streams if key(n) not in {key(k) for k in names}]
        if missing:
            raise SheetsError(N_("There is no stream “{name}” here.", name=missing[0]), _proposed(missing[0], names))
        keys = {key(n) for n in streams}
        found = [s.only({lane.id for lane in s.lanes if key(lane.label) in keys}) for s in found]
    first, last = window
    cut = []
    for score in found:
        begin, end = first or 0, score.last_us if last is None else min(last, score.last_us)
        if begin >= end and (first or last is not None):
            raise SheetsError(
                N_("Nothing happened between {begin:g} s and {end:g} s.", begin=begin / 1e6, end=end / 1e6),
                N_("The time goes from 0 s to {end:g} s.", end=score.last_us / 1e6),
            )
        cut.append(score.between(begin, end))
    return [s for s in cut if s.groups]


def _proposed(name: str, names: Sequence[str]) -> str:
    if guess := nearest(name, names):
        return N_("Did you mean {guess}?", guess=guess)
    return N_("There are: {names}.", names=listed(list(dict.fromkeys(names))))


_FEW = 4
_LONGEST = 120  # letters; more stand on no marble


def labels(value: Value) -> Iterator[str]:
    """Yield a value in words, from the longest form to the shortest that is still useful.

    >>> list(labels(0.98632)), list(labels(None)), list(labels(True))
    (['0.986', '0.99', '1'], ['blank', '–'], ['TRUE'])
    """
    if value is None:
        yield from ("blank", "–")
    elif isinstance(value, bool):
        yield show(value)
    elif isinstance(value, (int, float)):
        whole = isinstance(value, float) and 1_000 <= abs(value) < 1_000_000
        yield from dict.fromkeys((f"{value:.0f}",) if whole else (show(value), f"{value:.2g}", f"{value:.1g}"))
    elif isinstance(value, Record):
        yield from _fields(value)
    elif isinstance(value, str):
        yield clean(value[:_LONGEST])
    else:
        yield clean(show(value, _LONGEST))


def _fields(record: Record) -> Iterator[str]:
    """Yield the fields of a record that are filled: all of them, then fewer."""
    if record.type.name == "Done":
        done = short(record.values.get("value")) if record.values.get("value") is not None else "done"
        yield done if record.values.get("completed") is not False else f"stopped: {done}"
        return
    told = [(n, v) for n, v in record.as_dict().items() if v not in (None, "")]
    if len(told) <= _FEW:  # of few fields the texts say most: the zone of a touch, a word
        told.sort(key=lambda item: not isinstance(item[1], str))
    parts = [short(v) if isinstance(v, str) else f"{clean(n)} {short(v)}" for n, v in told]
    for count in range(len(parts), 0, -1):
        yield ", ".join(parts[:count])[:_LONGEST]


def short(value: Value) -> str:
    r"""Return a value as it stands on a marble that has room.

    >>> short(0.123456), short(None), short("Hello\n you"), short(True)
    ('0.123', 'blank', 'Hello you', 'TRUE')
    """
    return next(labels(value), "")


def fitting(value: Value, room: float, measure: Callable[[str], float] = columns, least: float = 4) -> str:
    """Return the value as far as it fits into `room`; a text may be cut; empty when nothing useful would be left.

    >>> fitting("Can you touch my hand?", 9), fitting(0.98632, 4), fitting("Hello", 2)
    ('Can you…', '0.99', '')
    """
    for words in labels(value):
        if measure(words) <= room:
            return words
    if isinstance(value, Record):
        value = next((v for v in value.values.values() if isinstance(v, str) and v), None)
    if not isinstance(value, (str, list, tuple)) or room < least:
        return ""
    return shortened(short(value), room, measure)


_SIGNS = {"sensor": "□", "stream": "○", "anonymous": "·", "actuator": "▣", "done": "◇"}
_LABEL = 20
_MOST_LABEL = 30


def marble_text(score: MarbleDiagram, width: int = 100) -> list[str]:
    """Return the lines of a marble diagram, at most `width` columns: a time axis, a line for each stream, the marks."""
    if not score.groups:
        return []
    longest = max((columns(_label(lane)) for lane in score.lanes), default=0)
    label = min(max(_LABEL, longest + 1), _MOST_LABEL)
    room = max(20, width - label - 1)
    scale = _Scale(score.first_us, max(score.last_us, score.first_us + 1), room)
    axis = [" "] * (room + 8)
    for us, text in ticks(scale.first, scale.last, room // 12):
        at = scale.at(us)
        axis[at : at + len(text)] = text
    lines = [" " * label + "".join(axis)]
    for lane in score.lanes:
        name = shortened(_label(lane), label - 1)
        lines.append(name + " " * (label - columns(name)) + _line(lane, scale))
    lines += [" " * label + line for line in _marks(score.marks, scale)]
    return [line.rstrip() for line in lines]


@dataclass(frozen=True)
class _Scale:
    """Conversion of times to columns."""

    first: int
    last: int
    room: int

    def at(self, us: int) -> int:
        return min(self.room - 1, round((us - self.first) * (self.room - 1) / (self.last - self.first)))


def _label(lane: Lane) -> str:
    return f"{_SIGNS.get(lane.kind, '○')} {clean(lane.label or lane.id.partition('!')[2])}"


def nice_step(span: float, most: int) -> float:
    """Return a round distance between the labels of an axis that needs at most `most` of them.

    >>> nice_step(10, 6), nice_step(1.3, 10)
    (2.0, 0.2)
    """
    step = 1e-3
    while True:
        for factor in (1, 2, 5):
            if span / (step * factor) <= most:
                return round(step * factor, 9)
        step *= 10


def seconds_label(seconds: float) -> str:
    """Return the label of a time: `0 s`, `2.5 s`."""
    return f"{round(seconds, 3):g} s"


def ticks(first_us: int, last_us: int, most: int) -> Iterator[tuple[int, str]]:
    """Yield the times (µs) at which an axis has labels, at most `most` (or two) of them, with the labels."""
    step = nice_step((last_us - first_us) / 1e6, max(2, most))
    number = -(-first_us // round(step * 1e6))
    while number * step * 1e6 <= last_us:
        yield round(number * step * 1e6), seconds_label(number * step)
        number += 1


def _line(lane: Lane, scale: _Scale) -> str:
    """Return a stream's line with as much of each value as fits before the next; several in one place: `●2`."""
    places: dict[int, list[Marble]] = {}
    for marble in lane.marbles:
        places.setdefault(scale.at(marble.us), []).append(marble)
    starts = sorted(places)
    line, column = "", 0
    for at, following in zip(starts, [*starts[1:], scale.room + 6], strict=False):
        line += "─" * (at - column)
        shown = _mark(places[at], following - at - 1)
        line += shown
        column = max(at, column) + columns(shown)
    return line + "─" * (scale.room - column)


def _mark(marbles: Sequence[Marble], room: int) -> str:
    if any(m.error for m in marbles):
        return "✗"
    if len(marbles) == 1:
        return fitting(marbles[0].value, room) or "●"
    text = f"({' '.join(short(m.value) for m in marbles)})"
    if columns(text) <= room:
        return text
    return "●" + (str(len(marbles)) if len(marbles) < 10 else "+") if room >= 2 else "●"


def _marks(marks: Sequence[tuple[int, str]], scale: _Scale) -> list[str]:
    """Return the pointers below the lines: `▲ row 9`."""
    rows: list[str] = []
    for us, words in sorted(marks):
        if not scale.first <= us <= scale.last:
            continue
        at, text = scale.at(us), f"▲ {clean(words)}"
        free = next((i for i, row in enumerate(rows) if columns(row) < at), None)
        if free is None:
            rows.append(" " * at + text)
        else:
            rows[free] += " " * (at - columns(rows[free])) + text
    return rows[:5]
