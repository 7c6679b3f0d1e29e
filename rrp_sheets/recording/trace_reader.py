"""Reader of traces: validates what may come from anyone, and yields the events of a run as typed objects.

A trace is read line by line, in each pass anew, as a session may be long. A last line that a crash cut off is left out.
"""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, BinaryIO

from rrp_sheets.errors import UnreadableFile
from rrp_sheets.model.run_files import (
    ACTIONS,
    TRACE,
    RecordedAction,
    RecordedEvent,
    RecordedFailure,
    RecordedNotice,
    RecordedValue,
)
from rrp_sheets.texts import N_, os_reason

LONGEST_US = 366 * 24 * 3_600_000_000  # a year: longer is no run
_LONGEST_SECONDS = LONGEST_US / 1e6
_LONGEST_NUMBER = 300  # digits: numbers of formulas have 16
_DEEPEST = 60  # lists in lists
_LONGEST_LINE = 1 << 27  # bytes: ten thousand texts of a formula's greatest length, and some
_LONGEST_END = 1 << 20  # bytes of a header or a summary
_USUAL_END = 1 << 14
_LONGEST_TEXT = 300
_FAULTS = (AttributeError, KeyError, TypeError, ValueError, OverflowError, RecursionError)  # what comes of a bad line

# As `RecordedValue.entry` writes it; any other spelling of the same is read more slowly.
_VALUE = re.compile(rb'\{"t":([0-9.e+-]+),"stream":"([^"\\]*)","row":"([^"\\]*)","value":')


# ---- the parts of a trace besides its events
@dataclass(frozen=True, slots=True)
class RecordedStream:
    """Stream that a header names; `device` is empty for the stream of a row."""

    name: str
    kind: str
    device: str


@dataclass(frozen=True)
class TraceLine:
    """Line of a trace that is not an event."""

    fields: Mapping[str, Any] = field(default_factory=dict)

    def text(self, name: str) -> str:
        """Return a field as a short text; see `text_of`."""
        return text_of(self.fields.get(name))


@dataclass(frozen=True)
class TraceSummary(TraceLine):
    """Last line of a trace."""

    @property
    def seconds(self) -> float:
        """Length of the run, which may be any number."""
        seconds = self.fields.get("simulated_seconds", self.fields.get("t"))
        return seconds if isinstance(seconds, (int, float)) and not isinstance(seconds, bool) else 0.0


@dataclass(frozen=True)
class TraceHeader(TraceLine):
    """First line of a trace; of an empty trace it has no fields."""

    streams: tuple[RecordedStream, ...] = ()


def text_of(value: Any) -> str:
    """Return a value of a trace as a short text; blank for none, and for what is no plain value.

    >>> text_of("P-07"), text_of(7), text_of(None), text_of([1])
    ('P-07', '7', '', '')
    """
    if isinstance(value, str):
        return value.encode("utf-8", "replace").decode()[:_LONGEST_TEXT]
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return f"{value:g}" if isinstance(value, float) else str(value)[:_LONGEST_TEXT]
    return ""


def read_ends(trace: Path) -> tuple[TraceHeader | None, TraceSummary | None, float]:
    """Return header, summary and last time (s) of a trace, without reading all of it; raise OSError when it cannot.

    The header is None when the first line is none, and has no fields when that line is not whole yet.
    """
    with trace.open("rb") as file:
        first = file.readline(_LONGEST_END)
        first = first if first.endswith(b"\n") else b""
        size = file.seek(0, os.SEEK_END)
        whole: list[bytes] = []
        for most in (_USUAL_END, _LONGEST_END):
            file.seek(max(0, size - most))
            *whole, _ = file.read(most).split(b"\n")
            if len(whole) > 1:
                break
    header, last = (entry_of(line) for line in (first, whole[-1] if whole else b""))
    ending = TraceSummary(last)
    seconds = float(ending.seconds) if 0 <= ending.seconds < 1e9 else 0.0
    begun = TraceHeader(header) if header.get("type") == "header" or not first else None
    return begun, ending if last.get("type") == "summary" else None, seconds


def entry_of(line: bytes) -> dict[str, Any]:
    """Parse a line of any file of a run; one that is no JSON object has no entries."""
    try:
        found = json.loads(line)
    except (ValueError, RecursionError):
        return {}
    return found if isinstance(found, dict) else {}


# ---- reading
class TraceReader:
    """Reader of the events of a trace, in their order; may be iterated over again.

    Args:
        path: a run's folder, or its trace.
        is_named: whether somebody has named it, not chosen a run from a list: its errors name the file then.

    Attributes:
        begins: bytes before its events, none when the header is not whole.
        summary: its last line, when an iteration has come there.

    Raises:
        UnreadableFile: there is no such file, or it is no trace; iterating raises it as well.
    """

    def __init__(self, path: Path, *, is_named: bool = False) -> None:
        self.path = path / TRACE if path.is_dir() else path
        self.summary: TraceSummary | None = None
        self._is_named = is_named
        if not self.path.is_file():  # a pipe would be waited for without an end
            raise UnreadableFile(
                "FILE001", N_("There is no recording “{path}”.", path=self.path), N_("Name a run's folder.")
            )
        with self._opened() as file:
            line = file.readline().decode()
            self.header = _header(_parsed(line)) if line.endswith("\n") else TraceHeader()
            self.begins = file.tell() if line.endswith("\n") else 0

    def damaged(self) -> UnreadableFile:
        """Return the error for a trace whose content cannot be that of a run."""
        if self._is_named:
            words = N_("“{path}” is not a recording, or it is damaged.", path=self.path)
            return UnreadableFile("FILE001", words, N_("Name a run's folder."))
        words = N_("“{run}” is not the recording of a run.", run=self.path.parent.name)
        return UnreadableFile("FILE001", words, N_("Copy its folder again."))

    def __iter__(self) -> Iterator[RecordedEvent]:
        return self.containing()

    def containing(self, *parts: bytes) -> Iterator[RecordedEvent]:
        """Yield all events, or those whose lines contain one of some byte strings.

        With `parts`, lines that contain none of them are skipped unread, invalid ones included; without, an invalid
        line ends the reading.
        """
        with self._opened() as file:
            file.readline()
            for line in _lines(file):
                if not parts or any(map(line.__contains__, parts)):
                    event = None
                    with suppress(*_FAULTS if parts else ()):
                        event = self._event(line)
                    if event is not None:
                        yield event

    def skim(self) -> Iterator[tuple[int, bytes, tuple[float, bytes, bytes] | None]]:
        """Yield place, line, and of most values time (s), stream and row, as the line has them, without decoding it.

        For a line with None in their stead, and for the value, ask `event`.
        """
        with self._opened() as file:
            place = len(file.readline())
            for line in _lines(file):
                found = _VALUE.match(line)
                if found is None:
                    yield place, line, None
                else:
                    t = float(found[1])
                    if not 0 <= t <= _LONGEST_SECONDS:
                        raise ValueError(t)
                    yield place, line, (t, found[2], found[3])
                place += len(line)

    def event(self, line: bytes) -> RecordedEvent | None:
        """Return the event on a line; None for a line without one, as the summary."""
        try:
            return self._event(line)
        except _FAULTS:
            raise self.damaged() from None

    def events_at(self, places: Iterable[int]) -> Iterator[RecordedEvent | None]:
        """Yield the events at some places that `skim` has told; None for one that cannot be read."""
        with self._opened() as file:
            for place in places:
                file.seek(place)
                try:
                    yield self._event(file.readline(_LONGEST_LINE))
                except _FAULTS:
                    yield None

    @contextmanager
    def _opened(self) -> Iterator[BinaryIO]:
        try:
            with self.path.open("rb") as file:
                yield file
        except OSError as error:
            words = N_("“{path}” cannot be read ({reason}).", path=self.path, reason=os_reason(error))
            raise UnreadableFile("FILE001", words, N_("Name a run's folder.")) from None
        except _FAULTS:
            raise self.damaged() from None

    def _event(self, line: bytes) -> RecordedEvent | None:
        entry = _parsed(line.decode())
        if entry.get("type") == "summary":
            self.summary = TraceSummary(entry)
        elif "t" in entry:
            return _event(entry)
        return None


def _lines(file: BinaryIO) -> Iterator[bytes]:
    """Yield the whole lines of a trace; raise ValueError for one that is longer than any run writes."""
    while (line := file.readline(_LONGEST_LINE)).endswith(b"\n"):
        yield line
    if len(line) == _LONGEST_LINE:
        raise ValueError("too long")


def _parsed(line: str) -> dict[str, Any]:
    """Parse a line; raise one of `_FAULTS` for what no run has: a bad time, a huge number, lists in lists in lists."""
    line = line.strip(" \t\r\n")
    entry, end = (_decode if len(line) <= _LONGEST_NUMBER else _decode_carefully)(line)
    if end < len(line):
        raise ValueError(line)
    if "\\u" in line and ("\\ud" in line or "\\uD" in line):  # perhaps half of a letter, which could not be written
        entry = json.loads(json.dumps(entry, ensure_ascii=False).encode("utf-8", "replace"))
    if line.count("[") + line.count("{") > _DEEPEST and _is_deep(entry):
        raise ValueError("too deep")
    if type(entry) is not dict or not 0 <= entry.get("t", 0) <= _LONGEST_SECONDS:
        raise ValueError(entry)
    return entry


def _whole(digits: str) -> int:
    if len(digits) > _LONGEST_NUMBER:
        raise ValueError("too large")
    return int(digits)


_decode = json.JSONDecoder().raw_decode
_decode_carefully = json.JSONDecoder(parse_int=_whole).raw_decode


def _is_deep(value: Any) -> bool:
    level = [value]
    for _ in range(_DEEPEST):
        level = [p for v in level if isinstance(v, (dict, list)) for p in (v.values() if isinstance(v, dict) else v)]
        if not level:
            return False
    return True


def _header(entry: Mapping[str, Any]) -> TraceHeader:
    if entry.get("type") != "header":
        raise ValueError(entry.get("type"))
    streams = entry.get("streams") or ()
    if not all(type(stream["stream"]) is str for stream in streams):
        raise TypeError(streams)
    found = (RecordedStream(s["stream"], text_of(s.get("kind")), text_of(s.get("device"))) for s in streams)
    return TraceHeader(entry, tuple(found))


def _event(entry: Mapping[str, Any]) -> RecordedEvent:
    us = round(entry["t"] * 1_000_000)
    row, stream = _text(entry, "row"), _text(entry, "stream")
    if "value" in entry:
        by = _text(entry, "by") if entry.get("stimulated") is True else None
        return RecordedValue(us, stream, row, entry["value"], by)
    if "error" in entry:
        inputs = entry.get("inputs") or []
        if not isinstance(inputs, list):
            raise TypeError(inputs)
        return RecordedFailure(us, stream, row, _text(entry, "error"), _text(entry, "code"), inputs)
    kind, text = _text(entry, "happening"), _text(entry, "text")
    if kind not in ACTIONS:
        return RecordedNotice(us, stream, row, kind, text, _text(entry, "sound"))
    detail = entry.get("detail") or {}
    if not isinstance(detail, dict):
        raise TypeError(detail)
    return RecordedAction(us, stream, row, kind, text, _text(entry, "by"), float(entry.get("wall") or 0.0), detail)


def _text(entry: Mapping[str, Any], name: str) -> str:
    value = entry.get(name)
    if value is not None and type(value) is not str:
        raise TypeError(value)
    return value or ""
