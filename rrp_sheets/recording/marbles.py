"""Marble diagrams of recorded runs, from a run's folder or from a trace alone; of all or of some rows and times."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

from rrp_sheets.connectors import connectors
from rrp_sheets.diagnostics import Report
from rrp_sheets.engine.trace import stream_label
from rrp_sheets.errors import UnreadableFile
from rrp_sheets.graph import Graph, StreamKind
from rrp_sheets.graph.build import build_graph
from rrp_sheets.model.names import key
from rrp_sheets.model.run_files import TRACE, WORKBOOK, RecordedAction, RecordedEvent, RecordedValue, Stamp
from rrp_sheets.model.values import Field, Record, RecordType, Value
from rrp_sheets.recording.messages import as_message
from rrp_sheets.recording.metadata import kept_while_unchanged, stamp_of
from rrp_sheets.recording.trace_reader import TraceHeader, TraceReader
from rrp_sheets.render.marble_diagram import Group, Lane, Marble, MarbleDiagram, make_score
from rrp_sheets.render.marble_drawing import draw_marbles
from rrp_sheets.render.output import write_marbles
from rrp_sheets.render.texts import texts
from rrp_sheets.robots import load_robot, robot_names
from rrp_sheets.texts import N_, known_language, translate

_ACTS = ("mark", "switch", "press", "scene", "edit")  # of what people do: what changes a run, and their marks
_DRAG_US = 1_000_000  # between two places of one drag
MOST_PAGES = 12  # of marbles in one answer


def is_trace(path: Path) -> bool:
    """Return whether a path is a run's folder or a trace, and no workbook."""
    return path.suffix.casefold() == ".jsonl" or (path.is_dir() and (path / TRACE).is_file())


def trace_scores(path: Path, language: str = "") -> list[MarbleDiagram]:
    """Return the marble diagrams of a recorded run, one for each behaviour; one in all without the workbook beside it.

    They are in the language of the run unless another one is given. It raises UnreadableFile when it is no trace.
    """
    reader = TraceReader(path, is_named=True)
    events = list(reader)
    graph = _graph(reader.path.with_name(WORKBOOK))
    language = language or known_language(reader.header.fields.get("language"))
    people = _people(events, language)
    if graph is None:
        return [replace(score, language=language) for score in _alone(reader.header, events, people)]
    ids = {stream_label(s): s.id for s in graph.streams.values()}
    sent = [e for e in events if isinstance(e, RecordedValue) and e.stream in ids]
    values = [(e.us, ids[e.stream], e.row, value_from_json(e.stream, e.value)) for e in sent]
    failed = [e for e in events if not isinstance(e, RecordedValue) and e.kind == "error" and e.row]
    errors = [(e.us, e.row, translate(as_message(e.text), language)) for e in failed]
    last = max((e.us for e in events), default=0)
    scores = [make_score(graph, b, values, errors, last, language) for b in graph.behaviours]
    shown = [score for score in scores if any(lane.marbles for lane in score.lanes)]
    return [replace(score, groups=(*people, *score.groups), language=language) for score in shown]


def stamped_scores(path: Path) -> list[MarbleDiagram]:
    """Return the diagrams of `trace_scores`, with the run's stamp if the trace has its usual name."""
    file = path / TRACE if path.is_dir() else path
    found = trace_scores(path)
    return stamped(found, stamp_of(file.parent)) if file.name == TRACE else found


def stamped(scores: Iterable[MarbleDiagram], stamp: Stamp) -> list[MarbleDiagram]:
    """Return the diagrams with a stamp of their origin at the foot and in the metadata."""
    return [replace(score, foot=stamp.line(), about=tuple(stamp.pairs()), language=stamp.language) for score in scores]


def _graph(workbook: Path) -> Graph | None:
    """Return the graph of the workbook's copy beside a trace, None if it cannot be read; evaluate no formula."""
    from rrp_sheets.workbook import read

    try:
        reading = read(workbook)
    except UnreadableFile:
        return None
    robot = load_robot(reading.workbook.protocol.robot) if reading.workbook.protocol.robot in robot_names() else None
    return build_graph(reading.workbook, robot or load_robot(), connectors(), Report())


def _people(events: Iterable[RecordedEvent], language: str) -> tuple[Group, ...]:
    """Return a lane of what operators did meanwhile; none when they did nothing."""
    marbles: list[Marble] = []
    dragged: dict[str, int] = {}  # a thing that is dragged is put to many places: where it comes to lie is shown
    for event in events:
        if isinstance(event, RecordedValue) and event.by is not None:
            marbles.append(Marble(event.us, translate(N_("sent: {stream}", stream=event.stream), language)))
        elif isinstance(event, RecordedAction) and event.kind in _ACTS:
            marble = Marble(event.us, translate(_done(event), language))
            thing = str(event.detail.get("thing")) if "put" in event.detail else ""
            if thing in dragged and marble.us - marbles[dragged[thing]].us < _DRAG_US:
                marbles[dragged[thing]] = marble
                continue
            if thing:
                dragged[thing] = len(marbles)
            marbles.append(marble)
    name = texts(language).get("plots.lane.by_hand")
    return (Group((), Lane("by hand", name, "note", tuple(marbles))),) if marbles else ()


def _done(event: RecordedAction) -> str:
    """Describe what an operator did."""
    match event.kind:
        case "mark":
            return event.text
        case "press":
            return N_("button: {label}", label=event.text)
        case "edit":
            return N_("edited {row}: {change}", row=event.row, change=event.text)
    return as_message(event.text)


def _alone(header: TraceHeader, events: Sequence[RecordedEvent], people: tuple[Group, ...]) -> list[MarbleDiagram]:
    """Return one diagram of all streams of a trace, made without the workbook."""
    known = [kind.value for kind in StreamKind]
    kinds = {s.name: s.kind if s.kind in known else "stream" for s in header.streams}
    marbles: dict[str, list[Marble]] = {name: [] for name in kinds}
    for event in events:
        if isinstance(event, RecordedValue):
            value = value_from_json(event.stream, event.value)
            marbles.setdefault(event.stream, []).append(Marble(event.us, value, event.row))
    order = {"sensor": 0, "done": 0, "actuator": 2}
    names = sorted(marbles, key=lambda n: order.get(kinds.get(n, ""), 1))
    groups = tuple(Group((), Lane(n, n.rpartition("!")[2], kinds.get(n, "stream"), tuple(marbles[n]))) for n in names)
    last = max((e.us for e in events), default=0)
    return [MarbleDiagram(str(header.fields.get("name", "Run")), (*people, *groups), 0, last)] if events else []


def value_from_json(name: str, value: Any) -> Value:
    """Convert JSON to the value that was on the stream; objects become records."""
    if isinstance(value, dict):
        kind, keys = _kind(name, tuple(value))
        return Record(kind, {k: value_from_json(n, value[n]) for n, k in keys})
    if isinstance(value, list):
        return [value_from_json(name, v) for v in value]
    return value


@lru_cache(maxsize=256)
def _kind(name: str, names: tuple[str, ...]) -> tuple[RecordType, tuple[tuple[str, str], ...]]:
    """Return the type of such records, and their fields' names with their keys: the same for all values of a stream."""
    return RecordType(name, tuple(Field(n) for n in names)), tuple((n, key(n)) for n in names)


_scores = kept_while_unchanged(trace_scores, TRACE, 2)
Window = tuple[float | None, float | None]  # seconds; None: from the begin, to the end


def marbles(
    place: Path, behaviour: str, rows: Sequence[int], window: Window, spread: bool, language: str
) -> dict[str, Any]:
    """Draw the streams of a behaviour (blank: the first) in a run's folder as marble diagrams, in a language.

    Without `rows` all are drawn, else these with their inputs; with `spread`, a busy time is drawn in several strips.

    Returns:
        As JSON: the names of all behaviours, the rows of this one with what they do, and the pictures.
    """
    scores = _scores(place, language)
    names = [s.title for s in scores]
    score = next((s for s in scores if s.title == behaviour), scores[0] if scores else None)
    if score is None:
        return {"behaviours": [], "behaviour": "", "rows": [], "seconds": 0.0, "pictures": [], "left_out": 0}
    bars = {b.row: b for g in score.groups for b in g.bars if b.row}
    shown = _shown(score, rows, window)
    pages = draw_marbles([shown], strips=0 if spread else 1) if shown is not None else []
    return {
        "behaviours": names, "behaviour": score.title, "seconds": score.last_us / 1e6,
        "rows": [[n, b.connector, b.formula[:200]] for n, b in sorted(bars.items())],
        "pictures": [p.svg for p in pages[:MOST_PAGES]], "left_out": max(0, len(pages) - MOST_PAGES),
    }  # fmt: skip


def write_run_marbles(
    place: Path, behaviour: str, rows: Sequence[int], window: Window, target: Path
) -> list[str]:  # fmt: skip
    """Write the diagram of a behaviour, stamped, in the format of the suffix; return what it lacks, in words.

    It raises SheetsError when nothing came then, or it cannot be drawn.
    """
    score = next((s for s in _scores(place) if behaviour in ("", s.title)), None)
    shown = None if score is None else _shown(score, rows, window)
    return write_marbles(stamped([] if shown is None else [shown], stamp_of(place)), target)


def _shown(score: MarbleDiagram, rows: Sequence[int], window: Window) -> MarbleDiagram | None:
    """Reduce a diagram to some rows and some time; return None when there is no such time."""
    first, last = window
    begin = 0 if first is None else round(first * 1e6)
    end = score.last_us if last is None else min(round(last * 1e6), score.last_us)
    if rows:  # with the streams that they give and take in, and what was done by hand meanwhile
        bars = [(group.lane.id, bar) for group in score.groups for bar in group.bars if bar.row in rows]
        lanes = {"by hand", *(lane for lane, _ in bars), *(source for _, bar in bars for source in bar.sources)}
        groups = (replace(g, bars=tuple(b for b in g.bars if b.row in rows)) for g in score.only(lanes).groups)
        score = replace(score, groups=tuple(groups))
    return score.between(begin, end) if begin < end else None
