"""Answers to the page that looks back at a run: overview, pieces of values and poses, sheets, diagrams, pictures.

A long run is sent in pieces. A process of its own (`services/query_worker.py`) reads it, as records are untrusted.
"""

from __future__ import annotations

import base64
import json
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from rrp_sheets.checks import check_workbook
from rrp_sheets.checks.check import robot_of, row_examples
from rrp_sheets.connectors import connectors
from rrp_sheets.diagnostics import Report
from rrp_sheets.errors import SheetsError
from rrp_sheets.graph import Graph, StreamKind
from rrp_sheets.graph.build import build_graph
from rrp_sheets.model.exchange import DONE
from rrp_sheets.model.names import key
from rrp_sheets.model.run_files import POSES, TRACE, WORKBOOK, RecordedEvent, RecordedValue
from rrp_sheets.model.values import Record, RecordType, Value
from rrp_sheets.model.workbook import Row
from rrp_sheets.recording.formatting import told
from rrp_sheets.recording.lookback_index import (
    Index,
    PoseIndex,
    index_poses,
    index_trace,
    is_number,
    picture,
    picture_times,
)
from rrp_sheets.recording.marbles import value_from_json
from rrp_sheets.robots import Robot, load_robot
from rrp_sheets.texts import N_, sentences
from rrp_sheets.workbook import Reading, read

Stamp = tuple[int, int]
_LOST = SheetsError(N_("There is no such part of the run."), N_("Load the page again: the record has perhaps changed."))
_MOST_CHECKED = 1_500  # rows of a workbook whose units are looked for
_MOST_SHOWN = 2_000  # rows of a sheet
_LONGEST = 2_000  # letters of a cell
_SECONDS = 8.0  # for a diagram's layout
_LONGEST_ERROR = 200  # letters
_SEEN = ("x", "y", "width", "height", "distance")  # of what a sensor sees: where the camera's picture shows it
_MOST_NAME = 60  # letters


def answer(place: Path, what: str, number: int = 0) -> str:
    """Return one part of a run.

    Args:
        place: the run's folder.
        what: `sheets`, `overview`, `piece`, `poses` (all as JSON), `diagram` (SVG) or `picture` (JPEG in base64).
        number: of the piece, the diagram or the picture.

    Raises:
        UnreadableFile: it is no trace.
        SheetsError: there is no such part.
    """
    return _ANSWERS[what](place, number)


def _sheets(place: Path, _: int) -> str:
    book = _book(place)
    return _json({"sheets": sheets(book), "why": book.why})


def _overview(place: Path, _: int) -> str:
    index, poses = _index(place), _poses(place)
    kinds = {**{s.stream: "stream" for s in index.series if s.stream}, **index.kinds}
    names = names_of(kinds)
    return _json({
        "seconds": index.seconds, "count": index.count, "pieces": index.piece_times(),
        "series": [[s.row, names.get(s.stream, ""), kinds.get(s.stream, "")] for s in index.series],
        "moments": [vars(line) for line in index.log], "left_out": index.left_out,
        "edits": index.edits, "switches": index.switches,
        "poses": poses.times, "pictures": picture_times(place),
    })  # fmt: skip


def _piece(place: Path, number: int) -> str:
    index = _index(place)
    if not 0 <= number < len(index.starts):
        raise _LOST
    return _json(piece(index, number, _words(place)))


def _pose_piece(place: Path, number: int) -> str:
    poses = _poses(place)
    if not 0 <= number < len(poses.times):
        raise _LOST
    return _json(poses.piece(number))


def _diagram(place: Path, number: int) -> str:
    return drawing(_book(place), number)


def _picture(place: Path, number: int) -> str:
    return base64.b64encode(picture(place, number)).decode("ascii")


_ANSWERS: dict[str, Callable[[Path, int], str]] = {
    "sheets": _sheets, "overview": _overview, "piece": _piece, "poses": _pose_piece, "diagram": _diagram,
    "picture": _picture,
}  # fmt: skip


def _json(data: Any) -> str:
    text = json.dumps(data, ensure_ascii=False, separators=(",", ":"), allow_nan=False)
    return text.replace("<", "\\u003c")  # as markup it would mean nothing, wherever it came to stand


# ---- kept while the files are the same
def _index(place: Path) -> Index:
    return _known_index(place, _stamp(place / TRACE))


def _poses(place: Path) -> PoseIndex:
    return _known_poses(place, _stamp(place / POSES))


def _book(place: Path) -> RecordedWorkbook:
    return _known_book(place, _stamp(place / WORKBOOK))


def _words(place: Path) -> ValueFormatter:
    book = _book(place)
    return ValueFormatter(book.robot, book.units)


def _stamp(path: Path) -> Stamp:
    try:
        about = path.stat()
    except FileNotFoundError:
        return (0, 0)
    return about.st_mtime_ns, about.st_size


@lru_cache(maxsize=2)
def _known_index(place: Path, stamp: Stamp) -> Index:
    return index_trace(place)


@lru_cache(maxsize=2)
def _known_poses(place: Path, stamp: Stamp) -> PoseIndex:
    return index_poses(place)


@lru_cache(maxsize=4)
def _known_book(place: Path, stamp: Stamp) -> RecordedWorkbook:
    return read_book(place)


@dataclass(frozen=True)
class RecordedWorkbook:
    """Workbook that ran, as read from the folder of its run.

    Attributes:
        graph: None when the copy cannot be read; `why` says why.
        units: of what rows give, by their refs.
    """

    robot: Robot
    graph: Graph | None
    units: Mapping[str, str]
    why: str = ""


def read_book(place: Path) -> RecordedWorkbook:
    """Read the workbook of a run; if it cannot be read, the result has the reason."""
    try:
        reading = read(place / WORKBOOK)
    except SheetsError as error:
        return RecordedWorkbook(load_robot(), None, {}, sentences(error.message, error.remedy))
    robot = robot_of(reading.workbook, Report())
    if sum(len(b.rows) for b in reading.workbook.behaviours) > _MOST_CHECKED:
        return RecordedWorkbook(robot, build_graph(reading.workbook, robot, connectors(), Report()), {})
    return _checked(reading)


def _checked(reading: Reading) -> RecordedWorkbook:
    checked = check_workbook(reading.workbook, reading.report, lints=False)
    numbers = {
        ref: fact.known.unit
        for ref, fact in row_examples(checked).items()
        if isinstance(fact.example, (int, float)) and not isinstance(fact.example, bool)
    }
    return RecordedWorkbook(checked.robot, checked.graph, numbers)


def sheets(book: RecordedWorkbook) -> list[dict[str, Any]]:
    """Return the behaviours as JSON: name, rows, and the kinds of names in them (sensor, stream, actuator, done)."""
    if book.graph is None:
        return []
    return [
        {
            "name": b.name, "rows": [_row(s.row) for s in b.steps[:_MOST_SHOWN]],
            "left_out": max(0, len(b.steps) - _MOST_SHOWN), "kinds": _kinds(book.graph, b.key),
        }
        for b in book.graph.behaviours
    ]  # fmt: skip


def _row(row: Row) -> list[Any]:
    """Return a row's number, whether it is on, and the texts of its cells."""
    cells = (row.inputs_cell.text, row.connector.text, row.formula.text, row.output.text, row.notes)
    return [row.number, row.on, *(text[:_LONGEST] for text in cells)]


def _kinds(graph: Graph, behaviour: str) -> dict[str, str]:
    own = f"{behaviour}!"
    return {
        key(s.name): s.kind.value
        for s in graph.streams.values()
        if s.kind is not StreamKind.ANONYMOUS and (s.id.startswith(own) or "!" not in s.id)
    }


def drawing(book: RecordedWorkbook, number: int) -> str:
    """Return the diagram of a behaviour as SVG, for a page that highlights parts of it; empty when there is none.

    Raises:
        SheetsError: it is too long, or cannot be laid out.
    """
    from rrp_sheets.documents.drawings import MOST_ROWS
    from rrp_sheets.render.diagram import draw_diagram

    if book.graph is None or not 0 <= number < len(book.graph.behaviours):
        return ""
    behaviour = book.graph.behaviours[number]
    if any(i not in book.graph.streams for s in behaviour.steps for i in (*s.inputs, s.output)):
        return ""
    if len(behaviour.steps) > MOST_ROWS:
        raise SheetsError(
            N_("“{name}” is too long to be drawn: more than {most} rows.", name=behaviour.name, most=MOST_ROWS), ""
        )
    drawn = draw_diagram(book.graph, behaviour, whole=True, room=True, timeout=_SECONDS)
    return drawn[0].svg if drawn else ""


def names_of(kinds: Mapping[str, str]) -> dict[str, str]:
    """Return the streams' names as the run panel has them: without their sheet, where that is unambiguous.

    >>> names_of({"Red ball": "sensor", "A!Far": "stream", "B!Near": "stream", "C!Near": "stream", "A!#4": "anonymous"})
    {'Red ball': 'Red ball', 'A!Far': 'Far', 'B!Near': 'B!Near', 'C!Near': 'C!Near', 'A!#4': 'A!#4'}
    """
    plain = Counter(label.partition("!")[2] or label for label in kinds)
    found = {}
    for label in kinds:
        _, _, name = label.partition("!")
        found[label] = name if name and name[0] != "#" and plain[name] == 1 else label
    return found


class ValueFormatter:
    """Formatter that puts the values of a trace into words.

    Args:
        robot: whose sensors give records.
        units: of what rows give, by their refs.
    """

    def __init__(self, robot: Robot, units: Mapping[str, str]) -> None:
        self._units = units
        self._types: dict[tuple[str, ...], RecordType] = {_fields(DONE): DONE}
        for device in robot.devices.values():
            if device.payload is not None:
                self._types.setdefault(_fields(device.payload), device.payload)

    def told(self, stream: str, row: str, value: Any) -> str:
        """Return a text for a value of a row, or of a sensor (then without a row)."""
        return told(self._value(stream, value), self._units.get(row, ""))

    def _value(self, stream: str, value: Any) -> Value:
        """Decode a value; the type of a record is found by its fields, as the trace does not name it."""
        kind = self._types.get(tuple(value)) if isinstance(value, dict) else None
        if kind is None:
            return value_from_json(stream, value)
        return Record(kind, {key(n): value_from_json(stream, v) for n, v in value.items()})


def _fields(kind: RecordType) -> tuple[str, ...]:
    return tuple(f.name for f in kind.fields)


def piece(index: Index, number: int, words: ValueFormatter) -> dict[str, Any]:
    """Return a piece of a run as JSON: of each series the times, texts (places in `words`), and what was seen."""
    numbers, before = index.piece(number)
    series: dict[int, dict[str, list[Any]]] = {}
    table: dict[str, int] = {}
    wanted = [n for n in before if n >= 0] + list(numbers)
    for place, event in index.read(wanted):
        of = index.of[place]
        told_series = series.setdefault(of, {"t": [], "v": []})
        text = _text(index, of, event, words)
        told_series["t"].append(index.times[place])
        told_series["v"].append(table.setdefault(text, len(table)))
        seen = None
        if isinstance(event, RecordedValue) and not event.row:  # what a sensor gave, no command
            seen = _seen(event.value)
        if seen is not None:
            told_series.setdefault("s", [None] * (len(told_series["t"]) - 1)).append(seen)
        elif "s" in told_series:
            told_series["s"].append(None)
    return {"words": list(table), "series": series}


def _text(index: Index, of: int, event: RecordedEvent, words: ValueFormatter) -> str:
    if not isinstance(event, RecordedValue):
        return event.text[:_LONGEST_ERROR]
    named = index.series[of]
    return words.told(named.stream, named.row, event.value)


def _seen(value: Any) -> list[Any] | None:
    """Return the place of a thing in the camera's picture: angles (rad), distance (m), name; None if it has none."""
    if not isinstance(value, dict) or not all(is_number(value.get(n)) for n in ("x", "y")):
        return None
    numbers = [round(float(value[n]), 4) if is_number(value.get(n)) else None for n in _SEEN]
    name = value.get("name")
    return [*numbers, name[:_MOST_NAME] if isinstance(name, str) else ""]
