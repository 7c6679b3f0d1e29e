"""A run as its trace has it, for the replay: header, events in their order, how it ended.

As a session may be long, its events are not kept: they are read from the file again in each pass.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any

from rrp_sheets.model.run_files import RecordedEvent, RecordedFailure, RecordedValue
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
        header: its first line.
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
        """Kind of end: `time`, `stopped`, `end run`, `broken`, or `cut` when the record has no end."""
        return "cut" if self.summary is None else self.summary.text("ended") or "time"


def read_record(path: Path) -> Recorded:
    """Read the trace of a run.

    Args:
        path: a run's folder, or its trace.jsonl.

    Raises:
        UnreadableFile: when it is no trace.
    """
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
    here: list[RecordedEvent] = []
    for event in events:
        if here and event.us != here[0].us:
            yield here[0].us, here
            here = []
        here.append(event)
    if here:
        yield here[0].us, here


def content(event: RecordedEvent) -> Any:
    """Return the payload of an event as JSON, without time, stream and row."""
    if isinstance(event, RecordedValue):
        return event.value
    if isinstance(event, RecordedFailure):
        return [event.text, event.code, event.inputs]
    return [event.kind, event.text]
