"""Answers to the page that looks back at a run: overview, pieces of values and poses, sheets, diagrams, pictures.

A process of its own (`services/query_worker.py`) reads the run, as records are untrusted: what is no number or no name
is left out. An index of the trace is made in one pass that decodes few values, so that a long run opens quickly, and
cuts it into pieces of some seconds. A piece knows the last events before it, so that it can be shown alone.
"""

from __future__ import annotations

import base64
import math
import re
import zipfile
from array import array
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import islice
from pathlib import Path
from typing import Any, BinaryIO

from rrp_sheets.checks import check_workbook
from rrp_sheets.checks.check import robot_of, row_examples
from rrp_sheets.connectors import connectors
from rrp_sheets.diagnostics import Report
from rrp_sheets.errors import SheetsError
from rrp_sheets.formulas.operations import is_number
from rrp_sheets.graph import Graph, StreamKind
from rrp_sheets.graph.build import build_graph
from rrp_sheets.model.exchange import DONE
from rrp_sheets.model.names import key
from rrp_sheets.model.run_files import CAMERA, POSES, TRACE, WORKBOOK, RecordedAction, RecordedEvent, RecordedValue
from rrp_sheets.model.values import Record, RecordType
from rrp_sheets.model.workbook import Row
from rrp_sheets.page_texts import json_in
from rrp_sheets.recording.marbles import value_from_json
from rrp_sheets.recording.messages import as_message
from rrp_sheets.recording.metadata import kept_while_unchanged
from rrp_sheets.recording.timeline import Log, value_text
from rrp_sheets.recording.trace_reader import TraceReader, entry_of, text_of
from rrp_sheets.robots import Robot, load_robot
from rrp_sheets.texts import N_, sentences
from rrp_sheets.workbook import read
from rrp_sheets.workbook.xlsx import BROKEN_ZIP

PIECE_SECONDS = 20.0
PIECE_EVENTS = 4_000
_MOST_EVENTS = 4_000_000
_MOST_SERIES = 20_000
_MOST_ACTS = 20_000  # edits and switches
_SENT = b'"stimulated":true'


class Index:
    """Places and times of the events in a trace, its log, and its pieces, made in one pass over the trace.

    Raises:
        UnreadableFile: it is no trace.
    """

    def __init__(self, place: Path) -> None:
        self.reader = TraceReader(place)
        streams = self.reader.header.streams[:_MOST_SERIES]
        self.kinds = {text_of(stream.name): stream.kind for stream in streams}  # sensor, stream, actuator, done
        self.series: list[tuple[str, str]] = []  # stream and row; a row's errors are one without stream
        self.edits: list[tuple[float, str, str, str]] = []  # in the workbook: seconds, place, was, now
        self.switches: list[tuple[float, str, bool]] = []  # seconds, behaviour, whether it is on now
        self.seconds = 0.0  # when the last event was
        self.times: array[float] = array("d")
        self.of: array[int] = array("l")
        self.at: array[int] = array("q")
        self.starts: list[int] = []  # of the pieces: numbers of events
        self.before: list[array[int]] = []  # by piece: the last event of each series, -1 for none
        self._log = Log(place, self.reader.header)
        self._numbers: dict[tuple[bytes | str, bytes | str], int] = {}  # of the series, as they stand in the file
        self._named: dict[tuple[str, str], int] = {}
        self._last: array[int] = array("q")
        self._piece = 0.0  # when the piece of now began
        self._read()
        self.log, self.left_out = self._log.lines, self._log.left_out  # what happened besides the values

    @property
    def count(self) -> int:
        """Number of events."""
        return len(self.times)

    def piece(self, number: int) -> tuple[range, array[int]]:
        """Return the numbers of a piece's events, and those of the last ones before it."""
        end = self.starts[number + 1] if number + 1 < len(self.starts) else self.count
        return range(self.starts[number], end), self.before[number]

    def _read(self) -> None:
        commanded = frozenset(stream.encode() for stream in self._log.commanded)
        for place, line, value in self.reader.skim():
            if self.count >= _MOST_EVENTS:
                break
            if value is None:
                self._other(self.reader.event(line), place)
                continue
            t, stream, row = value
            self._event(t, self._series(stream, row), place)
            if stream in commanded or (line.endswith(b"}\n") and _SENT in line):
                self._happened(self.reader.event(line))
        if not self.starts:
            self.starts, self.before = [0], [array("q")]
        self.seconds = max(self.seconds, self.times[-1] if self.count else 0.0)

    def _series(self, stream: bytes | str, row: bytes | str) -> int:
        known = self._numbers.get((stream, row))
        if known is None:
            given = (n.decode("utf-8", "replace") if isinstance(n, bytes) else n for n in (stream, row))
            first, second = map(text_of, given)
            known = self._numbers[stream, row] = self._named.setdefault((first, second), len(self._named))
            if known >= _MOST_SERIES:
                raise self.reader.damaged()
            if known == len(self.series):
                self.series.append((first, second))
                self._last.append(-1)
        return known

    def _event(self, t: float, series: int, place: int) -> None:
        t = max(t, self.times[-1]) if self.count else t
        new = not self.count or t > self.times[-1]  # what came at one instant stays together
        begun = self.count - self.starts[-1] if self.starts else 0
        if not self.starts or (new and (begun >= PIECE_EVENTS or t - self._piece >= PIECE_SECONDS)):
            self.starts.append(self.count)
            self.before.append(array("q", self._last))
            self._piece = t if self.count else 0.0
        self._last[series] = self.count
        self.times.append(t)
        self.of.append(series)
        self.at.append(place)

    def _other(self, event: RecordedEvent | None, place: int) -> None:
        """Take in an event that is not written as most are; None for a line that has none."""
        if event is None:
            return
        self.seconds = max(self.seconds, event.t)
        if isinstance(event, RecordedValue):
            self._event(event.t, self._series(event.stream, event.row), place)
        elif event.row and event.kind == "error":
            self._event(event.t, self._series("", event.row), place)
        self._happened(event)

    def _happened(self, event: RecordedEvent | None) -> None:
        """Add to the log everything but values, and values that are commands or were sent by hand."""
        if isinstance(event, RecordedValue):
            self._log.value(event)
        elif event is not None:
            self._log.add(event)
        if not isinstance(event, RecordedAction):
            return
        detail = event.detail
        if event.kind == "edit" and len(self.edits) < _MOST_ACTS:
            place, was, now = (text_of(detail.get(name)) for name in ("place", "was", "now"))
            self.edits.append((event.t, place, was, now))
        elif event.kind == "switch" and len(self.switches) < _MOST_ACTS:
            self.switches.append((event.t, text_of(detail.get("behaviour")), bool(detail.get("on"))))


_index = kept_while_unchanged(Index, TRACE, 2)


POSE_PIECE_SECONDS = 30.0
_FULL = b'"full":true'
_MOST_LINES = 2_000_000
_LONGEST_LINE = 1 << 18  # bytes
_MOST_PARTS = 200  # joints, or things
_MOST_PICTURES = 5_000
_LARGEST_PICTURE = 1 << 20  # bytes
_LARGEST_ZIP = 1 << 30
_PICTURE = re.compile(r"\d{5,8}\.\d{3}\.jpg")
_JPEG = b"\xff\xd8\xff"


class PoseIndex:
    """Times and places of the pieces of a run's poses, none without such a file. Each piece begins with a full pose."""

    def __init__(self, place: Path) -> None:
        self.path = place / POSES
        self.times: list[float] = []
        self.places: list[int] = []
        if not self.path.is_file() or self.path.is_symlink():
            return
        at = 0
        with self.path.open("rb") as file:
            for line in islice(_whole_lines(file), _MOST_LINES):
                pose = _pose(line) if _FULL in line else None
                if pose is not None and (not self.times or pose["t"] - self.times[-1] >= POSE_PIECE_SECONDS):
                    self.times.append(pose["t"])
                    self.places.append(at)
                at += len(line)

    def piece(self, number: int) -> list[dict[str, Any]]:
        """Return the poses of a piece, each with what has changed since the one before."""
        end = self.places[number + 1] if number + 1 < len(self.places) else math.inf
        poses = []
        with self.path.open("rb") as file:
            file.seek(self.places[number])
            for line in _whole_lines(file):
                if file.tell() > end:
                    break
                if (pose := _pose(line)) is not None:
                    poses.append(pose)
        return poses


def _whole_lines(file: BinaryIO) -> Iterator[bytes]:
    while (line := file.readline(_LONGEST_LINE)).endswith(b"\n"):
        yield line


_poses = kept_while_unchanged(PoseIndex, POSES, 2)


def _pose(line: bytes) -> dict[str, Any] | None:
    entry = entry_of(line)
    if not is_drawable_number(entry.get("t")):
        return None
    begin = {"t": float(entry["t"]), **({"full": True} if entry.get("full") is True else {})}
    joints = {n: v for n, v in _named(entry.get("joints")) if is_drawable_number(v)}
    things = {n: v for n, v in _named(entry.get("things")) if v is None or _numbers(v, 3)}
    looks = {n: look for n, v in _named(entry.get("looks")) if (look := _look(v)) is not None}
    named = {n: part for n, part in (("joints", joints), ("things", things), ("looks", looks)) if part}
    places = {n: entry[n] for n, count in (("base", 6), ("eyes", 3)) if _numbers(entry.get(n), count)}
    numbers = {n: entry[n] for n in ("light", "noise") if is_drawable_number(entry.get(n))}
    saying = {"saying": entry["saying"][:500]} if isinstance(entry.get("saying"), str) else {}
    return {**begin, **named, **places, **numbers, **saying}


def _named(part: Any) -> list[tuple[str, Any]]:
    given = part if isinstance(part, dict) else {}
    return [(name[:100], v) for name, v in islice(given.items(), _MOST_PARTS)]


def _look(look: Any) -> dict[str, Any] | None:
    """Return a thing's appearance (texts, numbers, truth values, sizes of three numbers); None without a size."""
    if not isinstance(look, Mapping):
        return None
    plain = {n: v for n, v in look.items() if isinstance(v, bool) or is_drawable_number(v) or _numbers(v, 3)}
    words = {n: v[:100] for n, v in look.items() if isinstance(v, str)}
    sized = "size" in plain or look.get("kind") == "person"
    return {**plain, **words} if sized else None


def is_drawable_number(value: Any) -> bool:
    """Return whether a value is a number that a page can place."""
    return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) < 1e6


def _numbers(value: Any, count: int) -> bool:
    return isinstance(value, list) and len(value) == count and all(map(is_drawable_number, value))


def picture_times(place: Path) -> list[float]:
    """Return the times at which the camera's pictures were taken; the number of a picture is its place here."""
    return [float(name.removesuffix(".jpg")) for name in _picture_names(place)]


def picture(place: Path, number: int) -> bytes:
    """Return a picture as JPEG; empty when there is none that can be shown."""
    names = _picture_names(place)
    if not 0 <= number < len(names):
        return b""
    try:
        with zipfile.ZipFile(place / CAMERA) as archive:
            data = archive.read(names[number])
    except BROKEN_ZIP:
        return b""
    return data if data.startswith(_JPEG) else b""


def _picture_names(place: Path) -> list[str]:
    path = place / CAMERA
    try:
        if path.is_symlink() or not path.is_file() or path.stat().st_size > _LARGEST_ZIP:
            return []
        with zipfile.ZipFile(path) as archive:
            entries = archive.infolist()
    except BROKEN_ZIP:
        return []
    names = {
        e.filename for e in entries
        if e.compress_type == zipfile.ZIP_STORED and e.file_size <= _LARGEST_PICTURE and _PICTURE.fullmatch(e.filename)
    }  # fmt: skip
    return sorted(names)[:_MOST_PICTURES]


_MOST_CHECKED = 1_500  # rows of a workbook whose units are looked for
_MOST_SHOWN = 2_000  # rows of a sheet
_LONGEST = 2_000  # letters of a cell
_SECONDS = 8.0  # for a diagram's layout
_LONGEST_ERROR = 200  # letters
_SEEN = ("x", "y", "width", "height", "distance")  # of what a sensor sees: where the camera's picture shows it
_MOST_NAME = 60  # letters


def answer(place: Path, what: str, number: int = 0, language: str = "en") -> str:
    """Return one part of the run in a folder, in a language; the number is that of the piece, diagram or picture.

    The parts are `sheets`, `overview`, `piece`, `poses` (all as JSON), `diagram` (SVG) and `picture` (JPEG in base64).

    Raises:
        UnreadableFile: it is no trace.
        SheetsError: there is no such part.
    """
    if what == "diagram":
        return drawing(_book(place), number, language)
    if what == "picture":
        return base64.b64encode(picture(place, number)).decode("ascii")
    text = json_in(_part(place, what, number), language)
    return text.replace("<", "\\u003c")  # as markup it would mean nothing, wherever it came to stand


def _part(place: Path, what: str, number: int) -> Any:
    match what:
        case "sheets":
            book = _book(place)
            return {"sheets": sheets(book), "why": book.why}
        case "overview":
            return _overview(place)
        case "piece":
            index = _index(place)
            if 0 <= number < len(index.starts):
                return piece(index, number, _book(place))
        case "poses":
            poses = _poses(place)
            if 0 <= number < len(poses.times):
                return poses.piece(number)
        case _:
            raise KeyError(what)
    raise SheetsError(
        N_("There is no such part of the run."), N_("Reload the page: perhaps the recording has changed.")
    )


def _overview(place: Path) -> dict[str, Any]:
    index = _index(place)
    kinds = {**{stream: "stream" for stream, _ in index.series if stream}, **index.kinds}
    names = names_of(kinds)
    return {
        "seconds": index.seconds, "count": index.count,
        "pieces": [0.0, *(index.times[start] for start in index.starts[1:])],  # when each begins
        "series": [[row, names.get(stream, ""), kinds.get(stream, "")] for stream, row in index.series],
        "moments": [vars(line) for line in index.log], "left_out": index.left_out,
        "edits": index.edits, "switches": index.switches,
        "poses": _poses(place).times, "pictures": picture_times(place),
    }  # fmt: skip


@dataclass(frozen=True)
class RecordedWorkbook:
    """Workbook that ran, as read from the folder of its run."""

    robot: Robot
    graph: Graph | None  # None when the copy cannot be read; `why` says why
    units: Mapping[str, str]  # of what rows give, by their refs
    why: str = ""

    @cached_property
    def _types(self) -> dict[tuple[str, ...], RecordType]:
        """Types of records by the names of their fields, as the trace does not name them; of two alike the first."""
        payloads = (device.payload for device in self.robot.devices.values() if device.payload is not None)
        return {tuple(f.name for f in kind.fields): kind for kind in reversed((DONE, *payloads))}

    def told(self, stream: str, row: str, value: Any) -> str:
        """Return a text for a value of a row, or of a sensor (then without a row)."""
        kind = self._types.get(tuple(value)) if isinstance(value, dict) else None
        if kind is None:
            decoded = value_from_json(stream, value)
        else:
            decoded = Record(kind, {key(n): value_from_json(stream, v) for n, v in value.items()})
        return value_text(decoded, self.units.get(row, ""))


def read_book(place: Path) -> RecordedWorkbook:
    """Read the workbook of a run; if it cannot be read, the result has the reason."""
    try:
        reading = read(place / WORKBOOK)
    except SheetsError as error:
        return RecordedWorkbook(load_robot(), None, {}, sentences(error.message, error.remedy))
    if sum(len(b.rows) for b in reading.workbook.behaviours) > _MOST_CHECKED:
        robot = robot_of(reading.workbook, Report())
        return RecordedWorkbook(robot, build_graph(reading.workbook, robot, connectors(), Report()), {})
    checked = check_workbook(reading.workbook, reading.report, lints=False)
    units = {ref: fact.known.unit for ref, fact in row_examples(checked).items() if is_number(fact.example)}
    return RecordedWorkbook(checked.robot, checked.graph, units)


_book = kept_while_unchanged(read_book, WORKBOOK, 4)


def sheets(book: RecordedWorkbook) -> list[dict[str, Any]]:
    """Return the behaviours as JSON: name, rows, and the kinds of names in them (sensor, stream, actuator, done)."""
    if book.graph is None:
        return []
    named = [s for s in book.graph.streams.values() if s.kind is not StreamKind.ANONYMOUS]
    return [
        {
            "name": b.name, "rows": [_row(s.row) for s in b.steps[:_MOST_SHOWN]],
            "left_out": max(0, len(b.steps) - _MOST_SHOWN),
            "kinds": {key(s.name): s.kind.value for s in named if s.id.startswith(f"{b.key}!") or "!" not in s.id},
        }
        for b in book.graph.behaviours
    ]  # fmt: skip


def _row(row: Row) -> list[Any]:
    """Return a row's number, whether it is on, and the texts of its cells."""
    cells = (row.inputs_cell.text, row.connector.text, row.formula.text, row.output.text, row.notes)
    return [row.number, row.on, *(text[:_LONGEST] for text in cells)]


def drawing(book: RecordedWorkbook, number: int, language: str) -> str:
    """Return the diagram of a behaviour as SVG in a language, for a page that lights parts of it; empty for none.

    It raises SheetsError when it is too long, or cannot be laid out.
    """
    from rrp_sheets.render.diagram import draw_diagram
    from rrp_sheets.render.output import MOST_ROWS

    if book.graph is None or not 0 <= number < len(book.graph.behaviours):
        return ""
    behaviour = book.graph.behaviours[number]
    if any(i not in book.graph.streams for s in behaviour.steps for i in (*s.inputs, s.output)):
        return ""
    if len(behaviour.steps) > MOST_ROWS:
        message = N_("“{name}” is too large to draw (over {most} rows).", name=behaviour.name, most=MOST_ROWS)
        raise SheetsError(message)
    drawn = draw_diagram(book.graph, behaviour, whole=True, room=True, timeout=_SECONDS, language=language)
    return drawn[0].svg if drawn else ""


def names_of(kinds: Mapping[str, str]) -> dict[str, str]:
    """Return the streams' names as the run panel has them: without their sheet, where that is unambiguous.

    >>> names_of({"Red ball": "sensor", "A!Far": "stream", "B!Near": "stream", "C!Near": "stream", "A!#4": "anonymous"})
    {'Red ball': 'Red ball', 'A!Far': 'Far', 'B!Near': 'B!Near', 'C!Near': 'C!Near', 'A!#4': 'A!#4'}
    """
    names = {label: label.partition("!")[2] for label in kinds}
    count = Counter(name or label for label, name in names.items())
    return {label: name if name and name[0] != "#" and count[name] == 1 else label for label, name in names.items()}


def piece(index: Index, number: int, book: RecordedWorkbook) -> dict[str, Any]:
    """Return a piece of a run as JSON: of each series the times, texts (places in `words`), and what was seen."""
    numbers, before = index.piece(number)
    series: dict[int, dict[str, list[Any]]] = {}
    table: dict[str, int] = {}
    wanted = sorted([n for n in before if n >= 0] + list(numbers))
    events = index.reader.events_at(index.at[n] for n in wanted)
    for place, event in zip(wanted, events, strict=True):
        if event is None:
            continue
        of = index.of[place]
        told_series = series.setdefault(of, {"t": [], "v": []})
        seen = None
        if not isinstance(event, RecordedValue):
            text = event.text if len(event.text) <= _LONGEST_ERROR else event.text[:_LONGEST_ERROR]
            text = as_message(text)
        else:
            text = book.told(*index.series[of], event.value)
            seen = None if event.row else _seen(event.value)  # what a sensor gave, no command
        told_series["t"].append(index.times[place])
        told_series["v"].append(table.setdefault(text, len(table)))
        if seen is not None:
            told_series.setdefault("s", [None] * (len(told_series["t"]) - 1)).append(seen)
        elif "s" in told_series:
            told_series["s"].append(None)
    return {"words": list(table), "series": series}


def _seen(value: Any) -> list[Any] | None:
    """Return the place of a thing in the camera's picture: angles (rad), distance (m), name; None if it has none."""
    if not isinstance(value, dict) or not all(is_drawable_number(value.get(n)) for n in ("x", "y")):
        return None
    numbers = [round(float(value[n]), 4) if is_drawable_number(value.get(n)) else None for n in _SEEN]
    name = value.get("name")
    return [*numbers, name[:_MOST_NAME] if isinstance(name, str) else ""]
