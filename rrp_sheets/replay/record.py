"""A run as its trace has it, for the replay: header, events in their order, how it ended.

As a session may be long, its events are not kept: they are read from the file again in each pass.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import groupby, islice
from operator import attrgetter
from pathlib import Path
from typing import Any

from rrp_sheets.graph import StreamKind
from rrp_sheets.model.run_files import RecordedEvent, RecordedFailure, RecordedNotice, RecordedValue, kind_of_end
from rrp_sheets.recording.trace_reader import LONGEST_US, TraceHeader, TraceReader, TraceSummary


class Events:
    """Events in the order of time that can be iterated over repeatedly, and are made anew each time."""

    def __init__(self, make: Callable[[], Iterable[RecordedEvent]]) -> None:
        self._make = make

    def __iter__(self) -> Iterator[RecordedEvent]:
        return iter(self._make())


@dataclass(frozen=True)
class Recorded:
    """A recorded run, as read from its trace.

    Attributes:
        path: of the file.
        events: what came, in its order.
        tail: those of the last time.
        before_us: the last time before that, in µs.
        summary: its last line; None of one that was cut off.
        streams: kinds of the streams by their names, as the header has them.
    """

    path: Path
    header: TraceHeader
    events: Events
    tail: tuple[RecordedEvent, ...]
    before_us: int
    summary: TraceSummary | None
    streams: Mapping[str, str]

    @property
    def place(self) -> Path:
        """Folder of the run."""
        return self.path.parent

    @property
    def engine(self) -> str:
        """Name of the engine; early traces do not have it."""
        return self.header.text("engine") or "frame"

    @property
    def last_us(self) -> int:
        """Time of the run's clock at the end (µs); of a record that was cut off, that of its last line."""
        last = self.tail[-1].us if self.tail else 0
        if self.summary is not None:
            return max(last, round(self.summary.seconds * 1_000_000))
        return last

    @property
    def ended(self) -> str:
        """Kind of end: `time`, `stopped`, `killed`, `end run`, `broken`, or `cut` when the record has no end."""
        if self.summary is None:
            return "cut"
        return kind_of_end(self.summary.text("ended") or "time", self.summary.text("stopped_by"))

    @property
    def played(self) -> Events:
        """Events that can be played again: of a run that broke off, those before its last moment."""
        if self.ended != "broken":
            return self.events
        last = self.last_us
        return Events(lambda: (e for e in self.events if e.us < last))

    @property
    def until_us(self) -> int:
        """Time of the run's clock (µs) up to which it can be played again."""
        if self.ended != "broken":
            return self.last_us
        final = self.tail[-1].us if self.tail else 0
        return final if final < self.last_us else self.before_us

    @property
    def at_end(self) -> tuple[RecordedEvent, ...] | None:
        """Ends of commands that the end of the run has ended: the last lines, which no row has seen.

        None of a run that had no proper end.
        """
        last, found = self.last_us, []
        if self.ended in ("cut", "broken"):
            return None
        for event in reversed(self.tail):
            if isinstance(event, RecordedNotice) and event.us == last:
                continue
            if event.us != last or not isinstance(event, RecordedValue) or event.row or event.by is not None:
                break
            ended = event.value if isinstance(event.value, dict) else {}
            if self.streams.get(event.stream) != StreamKind.DONE.value or ended.get("completed") is not False:
                break
            found.append(event)
        return tuple(reversed(found))


def read_record(path: Path) -> Recorded:
    """Read the trace of a run, by its folder or its trace.jsonl. Raises UnreadableFile when it is no trace."""
    reader = TraceReader(path, is_named=True)
    header = reader.header
    seed, rate = header.fields.get("seed", 0), header.fields.get("frame_rate", 30)
    numbers = type(seed) is int and type(rate) is int and 0 < rate <= 240
    if not numbers or not isinstance(header.fields.get("streams"), list):
        raise reader.damaged()
    tail: list[RecordedEvent] = []
    count = before = 0
    for event in _numbered(reader):
        count += 1
        if tail and event.us != tail[-1].us:
            before = tail[-1].us
            if event.us < before:  # in a run time does not go back
                raise reader.damaged()
            tail.clear()
        tail.append(event)
    summary = reader.summary
    if summary is not None and not 0 <= summary.seconds <= LONGEST_US / 1e6:
        raise reader.damaged()
    events = Events(lambda: islice(_numbered(reader), count))  # the file may have grown since
    streams = {s.name: s.kind for s in header.streams}
    return Recorded(reader.path, header, events, tuple(tail), before, summary, streams)


def _numbered(reader: TraceReader) -> Iterator[RecordedEvent]:
    for number, event in enumerate(reader):
        event.number = number
        yield event


_ENCODE = json.JSONEncoder(ensure_ascii=False, separators=(",", ":")).encode


def same_json(value: Any) -> str:
    """Encode a value as text: equal for the same values only, so TRUE is not 1, and 1 is not 1.0."""
    return _ENCODE(value)


def moments(events: Iterable[RecordedEvent]) -> Iterator[tuple[int, list[RecordedEvent]]]:
    """Group the events by their time."""
    for us, here in groupby(events, key=attrgetter("us")):
        yield us, list(here)


def content(event: RecordedEvent) -> Any:
    """Return the payload of an event as JSON, without time, stream and row."""
    if isinstance(event, RecordedValue):
        return event.value
    if isinstance(event, RecordedFailure):
        return [event.text, event.code, event.inputs]
    return [event.kind, event.text]
