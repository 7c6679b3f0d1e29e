"""The streams of a run, and the newest value of every row and stream, formatted when they are sent."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from rrp_sheets.model.values import Value
from rrp_sheets.recording.formatting import told
from rrp_sheets.runs.run_data import RunStart

_FORGIVEN_US = 1_000_000  # a row's error is shown for at least so long, although a value comes
_LONGEST = 200  # letters of an error's message
JsonObject = dict[str, Any]


@dataclass(slots=True)
class LatestValue:
    """Newest value of a row or a stream, how many came, and its last error."""

    value: Value = None
    unit: str = ""
    us: int = -1
    count: int = 0
    error: str = ""
    error_us: int = -1
    kind: str = ""
    renewed_us: int = -1


class LatestValues:
    """Newest values of the rows and streams of a run, and which of them have changed.

    Args:
        rows: the rows' ids by their refs.
        units: of what rows give, by their refs.
    """

    def __init__(self, rows: Mapping[str, str], units: Mapping[str, str]) -> None:
        self._ids = rows
        self._units = units
        self._rows: dict[str, LatestValue] = {}
        self._streams: dict[str, LatestValue] = {}
        self._new_rows: set[str] = set()
        self._new_streams: set[str] = set()

    def value(self, us: int, known: StreamInfo, row: str, value: Value) -> None:
        """Record a value on a stream, from a row or a device."""
        unit = self._units.get(row, "")
        stream = self._streams.setdefault(known.name, LatestValue(kind=known.kind))
        _put(stream, us, value, unit)
        self._new_streams.add(known.name)
        ident = self._ids.get(row)
        if ident is not None:
            _put(self._rows.setdefault(ident, LatestValue()), us, value, unit)
            self._new_rows.add(ident)

    def failed(self, us: int, row: str, message: str) -> None:
        """Record that a row failed to give a value."""
        ident = self._ids.get(row)
        if ident is not None:
            entry = self._rows.setdefault(ident, LatestValue())
            entry.error, entry.error_us = message[:_LONGEST], us
            self._new_rows.add(ident)

    def renewed(self, us: int, row: str) -> None:
        """Record that a row has a new formula from now on."""
        ident = self._ids.get(row)
        if ident is not None:
            self._rows.setdefault(ident, LatestValue()).renewed_us = us
            self._new_rows.add(ident)

    def told(self, row: str, value: Value) -> str:
        """Format a value of a row, with its unit."""
        return told(value, self._units.get(row, ""))

    def count(self, stream: str) -> int:
        """Return the number of values that a stream has had."""
        found = self._streams.get(stream)
        return found.count if found else 0

    def news(self) -> tuple[dict[str, JsonObject], dict[str, JsonObject]]:
        """Return the rows and the streams that have changed since the last call."""
        rows = {i: _row(self._rows[i]) for i in self._new_rows}
        streams = {n: _stream(self._streams[n]) for n in self._new_streams}
        self._new_rows, self._new_streams = set(), set()
        return rows, streams

    def all(self) -> tuple[dict[str, JsonObject], dict[str, JsonObject]]:
        """Return the newest values of all rows and all streams."""
        return {i: _row(e) for i, e in self._rows.items()}, {n: _stream(e) for n, e in self._streams.items()}


def _put(entry: LatestValue, us: int, value: Value, unit: str) -> None:
    entry.value, entry.us, entry.unit = value, us, unit
    entry.count += 1
    if entry.error and us - entry.error_us > _FORGIVEN_US:
        entry.error = ""


def _row(entry: LatestValue) -> JsonObject:
    text = told(entry.value, entry.unit) if entry.count else ""
    row = {"v": text, "at": entry.us / 1e6 if entry.count else None, "n": entry.count, "e": entry.error}
    return row if entry.renewed_us < 0 else {**row, "from": entry.renewed_us / 1e6}


def _stream(entry: LatestValue) -> JsonObject:
    return {"v": told(entry.value, entry.unit), "at": entry.us / 1e6, "n": entry.count, "kind": entry.kind}


@dataclass(frozen=True, slots=True)
class StreamInfo:
    """Name of a stream on the pages, and its kind (sensor, stream, actuator, done or anonymous)."""

    name: str
    kind: str


def known_streams(start: RunStart) -> dict[str, StreamInfo]:
    """Return the streams of a run by their ids.

    The sheet's name is part of a stream's name only when two sheets have a stream of that name.
    """
    plain = Counter(label.partition("!")[2] or label for label in start.streams.values())
    known = {}
    for stream, label in start.streams.items():
        _, _, name = label.partition("!")
        if name.startswith("#"):
            known[stream] = StreamInfo(label, "anonymous")
        elif name:
            known[stream] = StreamInfo(name if plain[name] == 1 else label, "stream")
        else:
            known[stream] = StreamInfo(label, _kind(stream, label, start))
    return known


def _kind(stream: str, label: str, start: RunStart) -> str:
    if stream in start.actuators:
        return "actuator"
    ends = {f"{name} done".casefold() for name in start.actuators.values()}
    return "done" if label.casefold() in ends else "sensor"
