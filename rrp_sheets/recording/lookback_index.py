"""Index of the events in a trace, and the poses and camera pictures that `sim/recording.py` has written.

The index is made in one pass that decodes few values, so that a long run opens quickly. A trace is cut into pieces of
some seconds. A piece knows the last events before it, so that it can be shown alone. The files of poses and pictures
are untrusted: what is no number or no name is left out.
"""

from __future__ import annotations

import json
import re
import zipfile
from array import array
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rrp_sheets.model.run_files import CAMERA, POSES, RecordedAction, RecordedEvent, RecordedValue
from rrp_sheets.recording.timeline import Log
from rrp_sheets.recording.trace_reader import TraceReader, text_of
from rrp_sheets.workbook.package import BROKEN_ZIP

PIECE_SECONDS = 20.0
PIECE_EVENTS = 4_000
_MOST_EVENTS = 4_000_000
_MOST_SERIES = 20_000
_MOST_ACTS = 20_000  # edits and switches
_SENT = b'"stimulated":true'


@dataclass(frozen=True, slots=True)
class Series:
    """Key of a series of events: a row and its stream; of a row's errors, without a stream."""

    stream: str
    row: str


@dataclass
class Index:
    """Places and times of the events in a trace, its log, and its pieces.

    Attributes:
        kinds: of the streams: sensor, stream, actuator, done.
        series: by their numbers.
        log: what happened besides the values.
        edits: seconds, place, before, after: what was changed in the workbook meanwhile.
        switches: seconds, behaviour, whether it was switched on.
        seconds: when the last event was.
    """

    reader: TraceReader
    kinds: dict[str, str] = field(default_factory=dict)
    series: list[Series] = field(default_factory=list)
    log: list[Any] = field(default_factory=list)
    left_out: int = 0
    edits: list[tuple[float, str, str, str]] = field(default_factory=list)
    switches: list[tuple[float, str, bool]] = field(default_factory=list)
    seconds: float = 0.0
    times: array[float] = field(default_factory=lambda: array("d"))
    of: array[int] = field(default_factory=lambda: array("l"))
    at: array[int] = field(default_factory=lambda: array("q"))
    starts: list[int] = field(default_factory=list)  # of the pieces: numbers of events
    before: list[array[int]] = field(default_factory=list)  # by piece: the last event of each series, -1 for none

    @property
    def count(self) -> int:
        """Number of events."""
        return len(self.times)

    def piece_times(self) -> list[float]:
        """Return the time at which each piece begins."""
        return [0.0, *(self.times[start] for start in self.starts[1:])]

    def piece(self, number: int) -> tuple[range, array[int]]:
        """Return the numbers of a piece's events, and those of the last ones before it."""
        end = self.starts[number + 1] if number + 1 < len(self.starts) else self.count
        return range(self.starts[number], end), self.before[number]

    def read(self, numbers: list[int]) -> Iterator[tuple[int, RecordedEvent]]:
        """Yield some events, in the order of the file."""
        numbers = sorted(numbers)
        events = self.reader.events_at(self.at[number] for number in numbers)
        yield from ((number, event) for number, event in zip(numbers, events, strict=True) if event is not None)


def index_trace(place: Path) -> Index:
    """Index the trace of a run in one pass.

    Raises:
        UnreadableFile: when it is no trace.
    """
    reader = TraceReader(place)
    streams = reader.header.streams[:_MOST_SERIES]
    found = Index(reader, {text_of(stream.name): stream.kind for stream in streams})
    _Indexer(found, Log(place, reader.header)).index()
    return found


class _Indexer:
    def __init__(self, index: Index, log: Log) -> None:
        self._index = index
        self._log = log
        self._numbers: dict[tuple[bytes | str, bytes | str], int] = {}  # as they stand in the file
        self._named: dict[Series, int] = {}
        self._last: array[int] = array("q")
        self._piece = 0.0  # when the piece of now began
        self._commanded = frozenset(stream.encode() for stream in log.commanded)

    def index(self) -> None:
        index = self._index
        for place, line, value in index.reader.skim():
            if index.count >= _MOST_EVENTS:
                break
            if value is None:
                self._other(index.reader.event(line), place)
                continue
            t, stream, row = value
            self._event(t, self._series(stream, row), place)
            if stream in self._commanded or (line.endswith(b"}\n") and _SENT in line):
                self._happened(index.reader.event(line))
        if not index.starts:
            index.starts, index.before = [0], [array("q")]
        index.log, index.left_out = self._log.lines, self._log.left_out
        index.seconds = max(index.seconds, index.times[-1] if index.count else 0.0)

    def _series(self, stream: bytes | str, row: bytes | str) -> int:
        known = self._numbers.get((stream, row))
        if known is None:
            names = Series(_text(stream), _text(row))
            known = self._numbers[stream, row] = self._named.setdefault(names, len(self._named))
            if known >= _MOST_SERIES:
                raise self._index.reader.damaged()
            if known == len(self._index.series):
                self._index.series.append(names)
                self._last.append(-1)
        return known

    def _event(self, t: float, series: int, place: int) -> None:
        index = self._index
        t = max(t, index.times[-1]) if index.count else t
        new = not index.count or t > index.times[-1]  # what came at one instant stays together
        begun = index.count - index.starts[-1] if index.starts else 0
        if not index.starts or (new and (begun >= PIECE_EVENTS or t - self._piece >= PIECE_SECONDS)):
            index.starts.append(index.count)
            index.before.append(array("q", self._last))
            self._piece = t if index.count else 0.0
        self._last[series] = index.count
        index.times.append(t)
        index.of.append(series)
        index.at.append(place)

    def _other(self, event: RecordedEvent | None, place: int) -> None:
        """Take in an event that is not written as most are; None for a line that has none."""
        if event is None:
            return
        self._index.seconds = max(self._index.seconds, event.t)
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
        if event.kind == "edit" and len(self._index.edits) < _MOST_ACTS:
            place, was, now = (text_of(detail.get(name)) for name in ("place", "was", "now"))
            self._index.edits.append((event.t, place, was, now))
        elif event.kind == "switch" and len(self._index.switches) < _MOST_ACTS:
            self._index.switches.append((event.t, text_of(detail.get("behaviour")), bool(detail.get("on"))))


def _text(name: bytes | str) -> str:
    return text_of(name.decode("utf-8", "replace") if isinstance(name, bytes) else name)


POSE_PIECE_SECONDS = 30.0
_FULL = b'"full":true'
_MOST_LINES = 2_000_000
_LONGEST_LINE = 1 << 18  # bytes
_MOST_PARTS = 200  # joints, or things
_MOST_PICTURES = 5_000
_LARGEST_PICTURE = 1 << 20  # bytes
_LARGEST_ZIP = 1 << 30
_PICTURE = re.compile(r"(\d{5,8}\.\d{3})\.jpg")
_JPEG = b"\xff\xd8\xff"


@dataclass
class PoseIndex:
    """Times and places of the pieces of a file of poses. Each piece begins with a full pose."""

    path: Path
    times: list[float] = field(default_factory=list)
    places: list[int] = field(default_factory=list)

    def piece(self, number: int) -> list[dict[str, Any]]:
        """Return the poses of a piece, each with what has changed since the one before."""
        end = self.places[number + 1] if number + 1 < len(self.places) else None
        found = []
        with self.path.open("rb") as file:
            file.seek(self.places[number])
            while end is None or file.tell() < end:
                line = file.readline(_LONGEST_LINE)
                if not line.endswith(b"\n"):
                    break
                pose = _pose(line)
                if pose is not None:
                    found.append(pose)
        return found


def index_poses(place: Path) -> PoseIndex:
    """Look through the poses of a run; the index has no pieces when there are none."""
    found = PoseIndex(place / POSES)
    if not found.path.is_file() or found.path.is_symlink():
        return found
    at = 0
    with found.path.open("rb") as file:
        for _ in range(_MOST_LINES):
            line = file.readline(_LONGEST_LINE)
            if not line.endswith(b"\n"):
                break
            if _FULL in line and (pose := _pose(line)) is not None:
                t = pose["t"]
                if not found.times or t - found.times[-1] >= POSE_PIECE_SECONDS:
                    found.times.append(t)
                    found.places.append(at)
            at += len(line)
    return found


def _pose(line: bytes) -> dict[str, Any] | None:
    try:
        entry = json.loads(line)
    except (ValueError, RecursionError):
        return None
    if not isinstance(entry, dict) or not is_number(entry.get("t")):
        return None
    found: dict[str, Any] = {"t": float(entry["t"])}
    if entry.get("full") is True:
        found["full"] = True
    joints = {n: v for n, v in _named(entry.get("joints")) if is_number(v)}
    things = {n: v for n, v in _named(entry.get("things")) if v is None or _numbers(v, 3)}
    looks = {n: look for n, v in _named(entry.get("looks")) if (look := _look(v)) is not None}
    parts = {
        "joints": joints, "things": things, "looks": looks,
        "base": v if _numbers(v := entry.get("base"), 6) else None,
        "eyes": v if _numbers(v := entry.get("eyes"), 3) else None,
        "light": v if is_number(v := entry.get("light")) else None,
        "noise": v if is_number(v := entry.get("noise")) else None,
        "saying": v[:500] if isinstance(v := entry.get("saying"), str) else None,
    }  # fmt: skip
    found.update((name, part) for name, part in parts.items() if part is not None and part != {})
    return found


def _named(part: Any) -> list[tuple[str, Any]]:
    if not isinstance(part, dict):
        return []
    return [(name[:100], v) for name, v in list(part.items())[:_MOST_PARTS]]


def _look(look: Any) -> dict[str, Any] | None:
    """Return a thing's appearance (texts, numbers, truth values, sizes of three numbers); None without a size."""
    if not isinstance(look, Mapping):
        return None
    plain = {n: v for n, v in look.items() if isinstance(v, bool) or is_number(v) or _numbers(v, 3)}
    words = {n: v[:100] for n, v in look.items() if isinstance(v, str)}
    sized = "size" in plain or look.get("kind") == "person"
    return {**plain, **words} if sized else None


def is_number(value: Any) -> bool:
    """Return whether a value is a number that a page can place."""
    return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) < 1e6


def _numbers(value: Any, count: int) -> bool:
    return isinstance(value, list) and len(value) == count and all(map(is_number, value))


def picture_times(place: Path) -> list[float]:
    """Return the times at which the camera's pictures were taken; the number of a picture is its place here."""
    return [float(m[1]) for name in _picture_names(place) if (m := _PICTURE.fullmatch(name))]


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
