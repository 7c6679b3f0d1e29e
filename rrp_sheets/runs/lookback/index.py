"""Index of the events in a trace, made in one pass that decodes few values, so that a long run opens quickly.

A trace is cut into pieces of some seconds. A piece knows the last events before it, so that it can be shown alone.
"""

from __future__ import annotations

import re
from array import array
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, BinaryIO

from rrp_sheets.errors import UnreadableFile
from rrp_sheets.runs.records.metadata import TRACE, entry_of, text_of
from rrp_sheets.runs.records.timeline import Log

PIECE_SECONDS = 20.0
PIECE_EVENTS = 4_000
_MOST_EVENTS = 4_000_000
_MOST_SERIES = 20_000
_MOST_ACTS = 20_000  # edits and switches
_LONGEST_LINE = 1 << 22  # bytes
_LONGEST_SECONDS = 366 * 24 * 3600.0

# As `engine/trace.py` writes an event; any other spelling of the same is read more slowly.
_EVENT = re.compile(rb'\{"t":([0-9.e+-]+),"stream":"([^"\\]*)","row":"([^"\\]*)","value":')
_SENT = b'"stimulated":true'
Entry = dict[str, Any]


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

    path: Path
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

    def read(self, numbers: list[int]) -> Iterator[tuple[int, Entry]]:
        """Yield the whole entries of some events, in the order of the file."""
        with self.path.open("rb") as file:
            for number in sorted(numbers):
                file.seek(self.at[number])
                entry = entry_of(file.readline(_LONGEST_LINE))
                if entry is not None:
                    yield number, entry


def index_trace(place: Path) -> Index:
    """Index the trace of a run in one pass.

    Raises:
        UnreadableFile: when it is no trace.
    """
    found = Index(place / TRACE)
    try:
        if not found.path.is_file():  # a pipe would be waited for without an end
            raise ValueError(place)
        with found.path.open("rb") as file:
            _Reader(found, Log(place)).read(file)
    except (AttributeError, KeyError, TypeError, ValueError, OverflowError, RecursionError):
        raise UnreadableFile("FILE001", f"“{place.name}” is not a record of a run.", "Copy its folder again.") from None
    return found


class _Reader:
    def __init__(self, index: Index, log: Log) -> None:
        self._index = index
        self._log = log
        self._numbers: dict[tuple[bytes | str, bytes | str], int] = {}  # as they stand in the file
        self._named: dict[Series, int] = {}
        self._last: array[int] = array("q")
        self._piece = 0.0  # when the piece of now began
        self._commanded: frozenset[bytes] = frozenset()  # streams as they stand in the file

    def read(self, file: BinaryIO) -> None:
        place = 0
        index = self._index
        while index.count < _MOST_EVENTS and (line := file.readline(_LONGEST_LINE)).endswith(b"\n"):
            found = _EVENT.match(line)
            if found is not None:
                self._event(float(found[1]), self._series(found[2], found[3]), place)
                if found[2] in self._commanded or (line.endswith(b"}\n") and _SENT in line):
                    self._happened(entry_of(line))
            else:
                self._other(entry_of(line), place)
            place += len(line)
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
                raise ValueError(known)
            if known == len(self._index.series):
                self._index.series.append(names)
                self._last.append(-1)
        return known

    def _event(self, t: float, series: int, place: int) -> None:
        index = self._index
        if not 0 <= t <= _LONGEST_SECONDS:
            raise ValueError(t)
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

    def _other(self, entry: Entry | None, place: int) -> None:
        """Take in the header, the summary, an error, or anything that happened."""
        if entry is None:
            raise ValueError(place)
        index = self._index
        if entry.get("type") == "header":
            streams = [s for s in entry.get("streams") or () if isinstance(s, dict)]
            index.kinds = {text_of(s.get("stream")): text_of(s.get("kind")) for s in streams[:_MOST_SERIES]}
            self._log.begin(entry)
            self._commanded = frozenset(stream.encode() for stream in self._log.commanded)
            return
        if "t" not in entry:
            return
        t = float(entry["t"])
        index.seconds = max(index.seconds, t)
        if "value" in entry:
            self._event(t, self._series(text_of(entry.get("stream")), text_of(entry.get("row"))), place)
            self._happened(entry)
            return
        if "row" in entry and ("error" in entry or entry.get("happening") == "error"):
            self._event(t, self._series("", text_of(entry["row"])), place)
        self._happened(entry)

    def _happened(self, entry: Entry | None) -> None:
        """Add to the log everything but values, and values that are commands or were sent by hand."""
        if entry is None or not isinstance(entry.get("t"), (int, float)):
            return
        t = float(entry["t"])
        if "value" in entry:
            if entry.get("stimulated") is True:
                self._log.sent(t, entry)
            elif text_of(entry.get("stream")) in self._log.commanded:
                self._log.command(t, entry)
            return
        self._log.add(t, entry)
        detail = entry.get("detail")
        if not isinstance(detail, Mapping):
            return
        kind = entry.get("happening")
        if kind == "edit" and len(self._index.edits) < _MOST_ACTS:
            place, was, now = (text_of(detail.get(name)) for name in ("place", "was", "now"))
            self._index.edits.append((t, place, was, now))
        elif kind == "switch" and len(self._index.switches) < _MOST_ACTS:
            self._index.switches.append((t, text_of(detail.get("behaviour")), bool(detail.get("on"))))


def _text(name: bytes | str) -> str:
    return text_of(name.decode("utf-8", "replace") if isinstance(name, bytes) else name)
