"""Reading a trace for its replay: header, entries in their order, how it ended; everything in it is checked.

As a session may be long, its lines are not kept: they are read from the file again in each pass.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from typing import Any

from rrp_sheets.engine.trace import read_trace
from rrp_sheets.errors import UnreadableFile

TRACE = "trace.jsonl"
_LONGEST_US = 366 * 24 * 3_600_000_000  # a year: longer is no run
EVENT, ERROR, HAPPENING, ACT = "event", "error", "happening", "act"
_ACTS = frozenset(("mark", "switch", "press", "scene", "speed", "edit", "pause", "resume", "step"))


@dataclass(frozen=True, slots=True)
class RecordedLine:
    """A line of a trace.

    Attributes:
        us: when, in microseconds of the run's clock.
        kind: `event`, `error`, `happening` (of the world or of the engine's own devices) or `act` (of somebody).
        stream: its name in the trace.
        row: the row that gave it; empty for sensor streams.
        value: as JSON has it; of an error its message, code and inputs.
        what: of a happening or an act its kind: `say`, `switch`, `edit`, …
        text: of a happening or an act in words.
        detail: of an act all that is needed to do it again.
        by: who sent a value or did something; None for an event that nobody sent.
        wall: seconds of the wall clock, of an act: lines of one act have the same.
        number: of the line in the record; -1 of what came in the replay.
    """

    us: int
    kind: str
    stream: str = ""
    row: str = ""
    value: Any = None
    what: str = ""
    text: str = ""
    detail: Mapping[str, Any] = field(default_factory=dict)
    by: str | None = None
    wall: float = 0.0
    number: int = field(default=-1, compare=False)


NO_DETAIL: Mapping[str, Any] = {}
_NO_LINE = (AttributeError, KeyError, TypeError, ValueError, OverflowError, RecursionError)  # what comes of a bad one


class Entries:
    """Entries in the order of time that can be iterated over repeatedly, and are made anew each time."""

    def __init__(self, make: Callable[[], Iterable[RecordedLine]]) -> None:
        self._make = make

    def __iter__(self) -> Iterator[RecordedLine]:
        return iter(self._make())


@dataclass(frozen=True)
class Recorded:
    """A recorded run, as read from its trace.

    Attributes:
        path: of the file.
        header: its first line.
        entries: what came, in its order.
        tail: those of the last time.
        before_us: the last time before that, in µs.
        summary: its last line; None of one that was cut off.
        streams: kinds of the streams by their names, as the header has them.
    """

    path: Path
    header: Mapping[str, Any]
    entries: Entries
    tail: tuple[RecordedLine, ...]
    before_us: int
    summary: Mapping[str, Any] | None
    streams: Mapping[str, str]

    @property
    def place(self) -> Path:
        """Folder of the run."""
        return self.path.parent

    @property
    def engine(self) -> str:
        """Name of the engine; early traces do not have it."""
        return str(self.header.get("engine") or "frame")

    @property
    def last_us(self) -> int:
        """Time of the run's clock at the end (µs); of a record that was cut off, that of its last line."""
        last = self.tail[-1].us if self.tail else 0
        if self.summary is not None:
            return max(last, _us(_number(self.summary.get("simulated_seconds"))))
        return last

    @property
    def ended(self) -> str:
        """Kind of end: `time`, `stopped`, `end run`, `broken`, or `cut` when the record has no end."""
        return "cut" if self.summary is None else str(self.summary.get("ended") or "time")


def read_record(path: Path) -> Recorded:
    """Read the trace of a run.

    Args:
        path: a run's folder, or its trace.jsonl.

    Raises:
        UnreadableFile: when it is no trace.
    """
    file = path / TRACE if path.is_dir() else path
    header: Mapping[str, Any] = {}
    summary: Mapping[str, Any] | None = None
    tail: list[RecordedLine] = []
    count = before = 0
    try:
        for number, line in enumerate(read_trace(file)):
            if number == 0:
                header = _header(line)
            elif line.get("type") == "summary":
                summary = line
                _us(_number(line.get("simulated_seconds")))
            elif "t" in line:
                entry = _entry(line, count)
                count += 1
                if tail and entry.us < tail[-1].us:  # in a run time does not go back
                    raise ValueError(entry.us)
                if tail and entry.us > tail[-1].us:
                    before = tail[-1].us
                    tail.clear()
                tail.append(entry)
    except _NO_LINE:
        raise _no_trace(file) from None
    except OSError as error:
        raise UnreadableFile(
            "FILE001", f"“{file}” cannot be read ({error.strerror}).", "Name a run's folder."
        ) from None
    if not header:
        raise _no_trace(file)
    streams = {str(s["stream"]): str(s.get("kind")) for s in header["streams"]}
    return Recorded(file, header, Entries(lambda: islice(_entries(file), count)), tuple(tail), before, summary, streams)


def _entries(file: Path) -> Iterator[RecordedLine]:
    """Yield the entries of a trace that was read before without fault; it may have grown since."""
    number = 0
    try:
        for line in islice(read_trace(file), 1, None):
            if "t" in line and line.get("type") != "summary":
                yield _entry(line, number)
                number += 1
    except (*_NO_LINE, OSError):  # another program has changed it meanwhile
        raise _no_trace(file) from None


def _no_trace(file: Path) -> UnreadableFile:
    return UnreadableFile("FILE001", f"“{file}” is not a trace, or it is damaged.", "Name a run's folder.")


def _header(line: Mapping[str, Any]) -> Mapping[str, Any]:
    if line.get("type") != "header" or not all(isinstance(s["stream"], str) for s in line["streams"]):
        raise ValueError(line.get("type"))
    seed, rate = line.get("seed", 0), line.get("frame_rate", 30)
    if type(seed) is not int or type(rate) is not int or not 0 < rate <= 240:
        raise ValueError(seed)
    return line


def _entry(line: Mapping[str, Any], number: int) -> RecordedLine:
    us = _us(line["t"])
    row, stream = _text(line, "row"), _text(line, "stream")
    if "value" in line:
        by = _text(line, "by") if line.get("stimulated") is True else None
        return RecordedLine(us, EVENT, stream, row, line["value"], detail=NO_DETAIL, by=by, number=number)
    if "error" in line:
        value = [line["error"], line.get("code"), line.get("inputs")]
        return RecordedLine(us, ERROR, "", row, value, text=_text(line, "error"), number=number)
    what = _text(line, "happening")
    if what in _ACTS:
        detail = line.get("detail") or {}
        if not isinstance(detail, dict):
            raise ValueError(detail)
        return RecordedLine(us, ACT, stream, row, None, what, _text(line, "text"), detail, _text(line, "by"),
                     float(line.get("wall") or 0.0), number)  # fmt: skip
    return RecordedLine(us, HAPPENING, stream, row, None, what, _text(line, "text"), number=number)


def _text(line: Mapping[str, Any], name: str) -> str:
    value = line.get(name, "")
    if not isinstance(value, str):
        raise ValueError(value)
    return value


def _number(value: Any) -> float:
    return value if isinstance(value, (int, float)) and not isinstance(value, bool) else 0.0


def _us(seconds: Any) -> int:
    us = round(float(seconds) * 1_000_000)
    if not 0 <= us <= _LONGEST_US:
        raise ValueError(us)
    return us


_ENCODE = json.JSONEncoder(ensure_ascii=False, separators=(",", ":")).encode


def same_json(value: Any) -> str:
    """Encode a value as text: equal for the same values only, so TRUE is not 1, and 1 is not 1.0."""
    return _ENCODE(value)


def moments(entries: Iterable[RecordedLine]) -> Iterator[tuple[int, list[RecordedLine]]]:
    """Group the lines by their time."""
    here: list[RecordedLine] = []
    for entry in entries:
        if here and entry.us != here[0].us:
            yield here[0].us, here
            here = []
        here.append(entry)
    if here:
        yield here[0].us, here
