"""Index of the events in a trace, made in one pass that decodes few values, so that a long run opens quickly.

A trace is cut into pieces of some seconds. A piece knows the last events before it, so that it can be shown alone.
"""

from __future__ import annotations

from array import array
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rrp_sheets.model.run_files import RecordedAction, RecordedEvent, RecordedValue
from rrp_sheets.recording.timeline import Log
from rrp_sheets.recording.trace_reader import TraceReader, text_of

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
