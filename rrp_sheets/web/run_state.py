"""State of a run for its pages: newest values, log, plots, and which row drives which part of the robot.

Notices of the run arrive on one thread, which never waits for a page. Only the newest values are kept, so that many
events cost the pages no more than a few.
"""

from __future__ import annotations

import threading
import time
from collections import Counter, deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from rrp_sheets.engine.run_events import RunObserver
from rrp_sheets.errors import RunBroken
from rrp_sheets.model.exchange import Notice, OperatorAction, WorldState
from rrp_sheets.model.values import Failure, Record, Value
from rrp_sheets.recording.metadata import clock
from rrp_sheets.recording.timeline import Drag, dragged, value_text
from rrp_sheets.runs.run_data import QUIET_US, Commands, RunStart, Summary
from rrp_sheets.texts import N_, listed, sentences
from rrp_sheets.web.completions import in_browser

_KEPT_LINES = 400
_MOST_NEW = 60  # lines in one update; of more, the newest
_LONGEST_LINE = 300  # letters
_SETTLED = 0.7  # seconds of the wall clock after which a thing that was dragged stands where it was put
_AGAIN_US = 10_000_000  # the same trouble of the same row
Line = dict[str, Any]


class RunLog:
    """Log lines with a serial number each; the newest are kept. `rows` are the ids of the rows by their refs."""

    def __init__(self, rows: Mapping[str, str], now: Callable[[], float] = time.monotonic) -> None:
        self._rows = rows
        self._now = now
        self._drag = Drag()
        self._dragged: Line | None = None
        self._moved: float | None = None  # when the thing was put to a place that no page was told of
        self._lines: deque[Line] = deque(maxlen=_KEPT_LINES)
        self._count = 0
        self._told = 0
        self._last: dict[str, int] = {}
        self._commands = Commands()
        self._troubles: dict[tuple[str, str, str], int] = {}

    def add(
        self, us: int, kind: str, text: str, *, row: str = "", by: str = "", stream: str = "", sound: str = ""
    ) -> None:
        """Append a line; one for a user's action or the end also ends a drag."""
        if by or kind == "end":  # somebody does something else
            self._settle()
            self._drag.over()
        self._count += 1
        line = {"i": self._count, "t": us / 1e6, "row": row, "id": self._rows.get(row, ""), "kind": kind,
                "text": _short(text), "by": by, "stream": stream, "sound": sound}  # fmt: skip
        self._lines.append(line)

    def command(self, us: int, row: str, stream: str, value: Value, text: str) -> None:
        """Log a command for an actuator, unless it continues a series of similar commands."""
        if self._commands.tell(us, row, value, stream):
            self.add(us, "command", N_("stops") if value is None else text, row=row, stream=stream)

    def trouble(self, us: int, kind: str, text: str, row: str, stream: str = "") -> None:
        """Log a problem that may recur with every value; the same one is logged again only after a while."""
        key = (kind, row, text if not row else "")
        if us - self._troubles.get(key, -_AGAIN_US) >= _AGAIN_US:
            self._troubles[key] = us
            self.add(us, kind, text, row=row, stream=stream)
        if len(self._troubles) > _KEPT_LINES:
            self._troubles = {k: at for k, at in self._troubles.items() if us - at < _AGAIN_US}

    def again(self, us: int, what: str, kind: str, text: str, by: str) -> None:
        """Log the first of many small steps of an action; the next one only after a pause."""
        last = self._last.get(what, -QUIET_US)
        self._last[what] = us
        if us - last >= QUIET_US:
            self.add(us, kind, text, by=by)

    def put(self, us: int, thing: str, text: str, by: str) -> None:
        """Log that a thing was put somewhere; a drag has one line, with the last place when it has ended."""
        line = self._dragged
        if self._drag.goes_on(us / 1e6, thing, by) and line is not None:
            line["text"], line["t"], self._moved = _short(dragged(thing, text)), us / 1e6, self._now()
            return
        self.add(us, "scene", text, by=by)
        self._dragged = self._lines[-1]
        self._drag.goes_on(us / 1e6, thing, by)

    def _settle(self) -> None:
        """Replace the line of a drag, if it was sent already, by one with the last place."""
        line, moved = self._dragged, self._moved
        self._moved = None
        if line is None or moved is None or line["i"] > self._told or line not in self._lines:
            return
        self._lines.remove(line)
        self._count += 1
        self._dragged = {**line, "i": self._count, "instead": line["i"]}
        self._lines.append(self._dragged)

    def news(self) -> list[Line]:
        """Return the lines added since the last call."""
        if self._moved is not None and self._now() - self._moved > _SETTLED:
            self._settle()
        fresh = [line for line in self._lines if line["i"] > self._told][-_MOST_NEW:]
        self._told = self._count
        return fresh

    def all(self) -> list[Line]:
        """Return the kept lines that were sent already."""
        return [line for line in self._lines if line["i"] <= self._told]


def _short(text: str, longest: int = _LONGEST_LINE) -> str:
    return text if len(text) <= longest else text[:longest]


_ERROR_SHOWN_US = 1_000_000  # a row's error is shown for at least so long, although a value comes
_LONGEST = 200  # letters of an error's message


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

    def put(self, us: int, value: Value, unit: str) -> None:
        """Take over the next value."""
        self.value, self.us, self.unit = value, us, unit
        self.count += 1
        if self.error and us - self.error_us > _ERROR_SHOWN_US:
            self.error = ""


class LatestValues:
    """Newest values of the rows and streams of a run, and which of them have changed; see `RunState`."""

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
        self._new_streams.add(known.name)
        stream = self._streams.setdefault(known.name, LatestValue(kind=known.kind))
        for entry in (stream, self._entry(row)):
            entry.put(us, value, unit)

    def _entry(self, row: str) -> LatestValue:
        """Return the entry of a row, which changes now; one that is shown nowhere for a row that is not in the grid."""
        ident = self._ids.get(row)
        if ident is None:
            return LatestValue()
        self._new_rows.add(ident)
        return self._rows.setdefault(ident, LatestValue())

    def failed(self, us: int, row: str, message: str) -> None:
        """Record that a row failed to give a value."""
        entry = self._entry(row)
        entry.error, entry.error_us = _short(message, _LONGEST), us

    def renewed(self, us: int, row: str) -> None:
        """Record that a row has a new formula from now on."""
        self._entry(row).renewed_us = us

    def told(self, row: str, value: Value) -> str:
        """Format a value of a row, with its unit."""
        return value_text(value, self._units.get(row, ""))

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


def _row(entry: LatestValue) -> JsonObject:
    text = value_text(entry.value, entry.unit) if entry.count else ""
    row = {"v": text, "at": entry.us / 1e6 if entry.count else None, "n": entry.count, "e": entry.error}
    return row if entry.renewed_us < 0 else {**row, "from": entry.renewed_us / 1e6}


def _stream(entry: LatestValue) -> JsonObject:
    return {"v": value_text(entry.value, entry.unit), "at": entry.us / 1e6, "n": entry.count, "kind": entry.kind}


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
    ends = {f"{name} done".casefold() for name in start.actuators.values()}
    known = {}
    for stream, label in start.streams.items():
        _, _, name = label.partition("!")
        if name.startswith("#"):
            known[stream] = StreamInfo(label, "anonymous")
        elif name:
            known[stream] = StreamInfo(name if plain[name] == 1 else label, "stream")
        elif stream in start.actuators:
            known[stream] = StreamInfo(label, "actuator")
        else:
            known[stream] = StreamInfo(label, "done" if label.casefold() in ends else "sensor")
    return known


JsonObject = dict[str, Any]
ROBOT_AGAIN_US = 1_000_000  # after which all of the robot is told again, for a page that has missed something

_HEARD = {"say": "speech", "sound": "sound", "person": "person"}  # what can be heard again, and its kind of line


class RunState(RunObserver):
    """Observer of a run that keeps the state its pages show.

    Args:
        rows: the rows' ids by their refs, as they were when the run began.
        units: of what rows give, by their refs.
        changed: called with the name of the notice when the phase or a setting has changed, on the run's thread.
    """

    def __init__(self, rows: Mapping[str, str], units: Mapping[str, str], changed: Callable[[str], None]) -> None:
        self._rows = rows
        self._changed = changed
        self._lock = threading.Lock()
        self._streams: dict[str, StreamInfo] = {}
        self._voices: set[str] = set()
        self._newest = LatestValues(rows, units)
        self._fields: dict[str, JsonObject] = {}
        self._new_fields: set[str] = set()
        self._plots = Plots()
        self._drives = Drives()
        self._robot: WorldState | None = None
        self._new_robot = False
        self._told_robot: JsonObject = {}  # as the pages know it
        self._robot_us = 0  # when they were told all of it
        self._told_us = -1
        self.log = RunLog(rows)
        self.us = 0
        self.start: RunStart | None = None
        self.is_paused = False
        self.behaviours: dict[str, bool] = {}
        self.speed = 1.0
        self.rest: tuple[Summary, RunBroken | None] | None = None  # how it ended
        self.refusal = ""  # why edited rows are not used
        self.picture_number = 0
        self.jpeg = b""
        self._pictured = 0.0  # when the picture came, by this computer's clock

    # ---- what the run tells

    def started(self, start: RunStart) -> None:
        """Take over the streams and behaviours of a run that begins."""
        with self._lock:
            self.start = start
            self._streams = known_streams(start)
            self._voices = {stream for stream, needs in start.resources.items() if "voice" in needs}
            self.behaviours = dict(start.behaviours)
        self._changed("started")

    def event(self, us: int, stream: str, row: str, value: Value) -> None:
        """Record a value on a stream."""
        known = self._streams.get(stream)
        if known is None:
            return
        with self._lock:
            self._newest.value(us, known, row, value)
            if known.kind == "actuator":
                if stream in self._voices and value is not None:
                    return  # what is said is told when it is said
                self.log.command(us, row, known.name, value, self._newest.told(row, value))
                return
            self._plots.take(us, known.name, value, fields=known.kind == "sensor")
            if known.kind == "sensor" and isinstance(value, Record):
                fields = value.as_dict().items()
                self._fields[known.name] = {n: v for n, v in fields if isinstance(v, (int, float, str))}
                self._new_fields.add(known.name)

    def error(self, us: int, row: str, failure: Failure, values: tuple[Value, ...]) -> None:
        """Record that a formula failed."""
        with self._lock:
            self._newest.failed(us, row, failure.message)
            self.log.trouble(us, "error", failure.message, row)

    def notice(self, us: int, notice: Notice) -> None:
        """Log a notice, such as speech, a clamped command or an error."""
        known = self._streams.get(notice.stream)
        name = known.name if known else ""
        with self._lock:
            if kind := _HEARD.get(notice.kind):
                self.log.add(us, kind, notice.text, row=notice.row, stream=name, sound=notice.sound)
                return
            if notice.kind == "error" and notice.row:
                self._newest.failed(us, notice.row, notice.text)
            self.log.trouble(us, notice.kind, notice.text, notice.row, name)

    def frame(self, us: int) -> None:
        """Note the time at which a frame ended."""
        self.us = us

    def paused(self, us: int, is_paused: bool) -> None:
        """Note that the run was paused or resumed."""
        self.is_paused = is_paused
        self._changed("paused")

    def state(self, us: int, state: WorldState) -> None:
        """Record the state of the robot."""
        with self._lock:
            self._robot, self._new_robot = state, True
            self._drives.take(us, state.driving)

    def picture(self, us: int, jpeg: bytes) -> None:
        """Keep the newest picture of the robot's camera."""
        self._pictured = time.monotonic()
        self.picture_number += 1
        if jpeg != self.jpeg:
            self.jpeg = jpeg

    def acted(self, us: int, action: OperatorAction) -> None:
        """Record and log an action of a user or of a row."""
        kind = {"press": "button", "pause": "note", "resume": "note", "step": "note", "speed": "note"}
        with self._lock:
            if action.kind == "switch":
                self.behaviours[str(action.detail["behaviour"])] = bool(action.detail["on"])
            elif action.kind == "speed":
                self.speed = float(action.detail["factor"])
            elif action.kind == "edit":
                self.refusal = ""
                self._edited(us, action)
            if "put" in action.detail and "appears" not in action.detail:  # dragged: many places, one line
                self.log.put(us, str(action.detail["thing"]), action.text, action.by)
            elif action.kind not in ("step", "edit") and (action.by or action.kind != "switch"):  # a row's is a note
                self.log.add(us, kind.get(action.kind, action.kind), action.text, by=action.by)
        if action.kind in ("switch", "speed", "edit"):
            self._changed(action.kind)

    def _edited(self, us: int, action: OperatorAction) -> None:
        """Mark the edited rows that the run uses from now on, and log them if the edit changes the run."""
        rows = [str(row) for row in action.detail.get("rows", ())]
        for row in rows:
            self._newest.renewed(us, row)
        if action.detail.get("changes"):
            what, at = listed(rows[1:]), clock(us / 1e6)
            text = N_("and {rows} used from {time} on" if what else "used from {time} on", rows=what, time=at)
            self.log.add(us, "edit", text, row=rows[0] if rows else "", by=action.by)

    def unused(self, why: str) -> None:
        """Note why the run does not use the edited rows."""
        if why != self.refusal:
            self.refusal = why
            self._changed("unused")

    def refused(self, kind: str, message: str, remedy: str) -> None:
        """Log an action that was refused."""
        text = sentences(message, in_browser(remedy))
        with self._lock:
            if kind == "apply":
                self.refusal = text
            elif kind == "speed":  # an event loop goes by the wall clock
                self.speed = 1.0
            if kind == "put":  # dragged: many times, one line
                self.log.again(self.us, text, "refused", text, by="")
            else:
                self.log.add(self.us, "error" if kind == "apply" else "refused", text)
        self._changed("refused")

    def finishing(self) -> None:
        """Note that the robot is brought to rest."""
        self._changed("finishing")

    def rested(self, summary: Summary, broken: RunBroken | None) -> None:
        """Keep the summary of the run; another run may begin while this one's files are written."""
        self.rest = summary, broken
        self._changed("rested")

    def ended(self, words: str) -> None:
        """Log the end of the run."""
        with self._lock:
            self.log.add(self.us, "end", words)

    # ---- what the pages are told

    def news(self) -> tuple[JsonObject | None, list[Line]]:
        """Return the changes since the last call, or None if there are none, and the new lines of the log."""
        with self._lock:
            lines = self.log.news()
            data = self._data(full=False)
        if len(data) == 1 and self.us == self._told_us:
            return None, lines
        self._told_us = self.us
        return data, lines

    def all(self) -> tuple[JsonObject, list[Line]]:
        """Return everything that was sent so far, for a page that joins."""
        with self._lock:
            return {"full": True, **self._data(full=True)}, self.log.all()

    def _data(self, *, full: bool) -> JsonObject:
        data: JsonObject = {"t": self.us / 1e6}
        rows, streams = self._newest.all() if full else self._newest.news()
        fields = self._fields if full else {n: self._fields[n] for n in self._new_fields}
        parts = {
            "rows": rows, "streams": streams, "fields": fields,
            "plots": self._plots.all(self.us) if full else self._plots.news(),
            "drives": self._drives.all() if full else self._drives.news(),
            "robot": self._robot_data(full=full) if full or self._new_robot else None,
            "eye": self.picture_number,
            "eye_age": self.picture_age if full else 0,
        }  # fmt: skip
        data.update((name, part) for name, part in parts.items() if part)
        if not full:
            self._new_fields, self._new_robot = set(), False
        return data

    @property
    def picture_age(self) -> float:
        """Seconds since the newest picture was taken; 0 without one."""
        return round(time.monotonic() - self._pictured, 1) if self.jpeg else 0

    def _robot_data(self, *, full: bool) -> JsonObject | None:
        """Return the state of the robot; unless `full`, of its parts and joints mostly those that have changed."""
        state = self._robot
        if state is None:
            return None
        data: JsonObject = {
            "joints": {n: round(v, 3) for n, v in state.joints.items()}, "base": [round(v, 4) for v in state.base],
            "eyes": [round(v, 3) for v in state.eyes], "saying": state.saying,
            "things": {n: [round(v, 3) for v in at] for n, at in state.things.items()}, "looks": state.looks,
            "light": round(state.light, 3), "noise": round(state.noise, 3),
        }  # fmt: skip
        if full:
            return data
        if self.us - self._robot_us >= ROBOT_AGAIN_US:
            self._robot_us, self._told_robot = self.us, {}
        before, self._told_robot = self._told_robot, data
        fresh = {name: part for name, part in data.items() if part != before.get(name)}
        if "joints" in fresh and before:
            fresh["joints"] = {n: v for n, v in data["joints"].items() if v != before["joints"].get(n)}
        return fresh

    @property
    def joints(self) -> Mapping[str, float]:
        """Joint angles of the robot in its newest state, rad."""
        with self._lock:
            return {} if self._robot is None else dict(self._robot.joints)

    def button_counts(self) -> dict[str, int]:
        """Return the number of presses of each operator button, by its stream's name."""
        with self._lock:
            buttons = self.start.buttons if self.start else ()
            names = [self._streams[s].name if s in self._streams else s for s, _ in buttons]
            return {name: self._newest.count(name) for name in names}


_KEPT_INTERVALS = 400
_GAP_US = 700_000  # a row that drives again so soon has never stopped, for a reader: eyes set twice a second


@dataclass(slots=True, eq=False)
class Interval:
    """Time in which a row drives a resource of the robot; `ended` is None while it goes on."""

    resource: str
    row: str
    began: int
    ended: int | None = None

    def as_list(self) -> list[object]:
        """Return the interval as a list, with times in seconds."""
        return [self.resource, self.row, self.began / 1e6, None if self.ended is None else self.ended / 1e6]


class Drives:
    """Intervals in which rows drive resources of the robot; the newest are kept."""

    def __init__(self) -> None:
        self._kept: deque[Interval] = deque(maxlen=_KEPT_INTERVALS)
        self._last: dict[str, Interval] = {}
        self._new: dict[Interval, None] = {}  # in their order

    def take(self, us: int, driving: Mapping[str, str]) -> None:
        """Update the intervals by the rows that drive resources at a moment."""
        for resource, last in self._last.items():
            if last.ended is None and driving.get(resource) != last.row:
                last.ended = us
                self._new[last] = None
        for resource, row in driving.items():
            before = self._last.get(resource)
            if before is not None and before.row == row and (before.ended is None or us - before.ended <= _GAP_US):
                if before.ended is not None:
                    before.ended = None
                    self._new[before] = None
                continue
            fresh = self._last[resource] = Interval(resource, row, us)
            self._kept.append(fresh)
            self._new[fresh] = None

    def news(self) -> list[list[object]]:
        """Return the intervals that began or ended since the last call."""
        data = [s.as_list() for s in self._new]
        self._new.clear()
        return data

    def all(self) -> list[list[object]]:
        """Return the intervals that are kept."""
        return [s.as_list() for s in self._kept]


MOST_KEYS = 80
KEPT_US = 60_000_000  # of the run's clock
_KEPT = 900  # points of a key
_PER_TELLING = 4  # points of a key that are told at once: the first, the last, and the extremes between them
Point = tuple[int, float]


class Plots:
    """Numeric values of streams for plots, by the stream's name or `name.field`."""

    def __init__(self) -> None:
        self._kept: dict[str, deque[Point]] = {}
        self._new: dict[str, list[Point]] = {}

    def take(self, us: int, name: str, value: Value, *, fields: bool) -> None:
        """Add a value; of a record its numeric fields, if `fields` is true."""
        parts: dict[str, Value] = {name: value}
        if isinstance(value, Record):
            parts = {f"{name}.{field}": part for field, part in value.as_dict().items()} if fields else {}
        for key, number in parts.items():
            if isinstance(number, bool) or not isinstance(number, (int, float)):
                continue
            if key not in self._kept:
                if len(self._kept) >= MOST_KEYS:
                    continue
                self._kept[key] = deque(maxlen=_KEPT)
            self._new.setdefault(key, []).append((us, float(number)))

    def news(self) -> list[list[object]]:
        """Return the points added since the last call, thinned."""
        data = []
        for key, points in self._new.items():
            thin = _thinned(points)
            self._kept[key].extend(thin)
            data.append(_plain(key, thin))
        self._new = {}
        return data

    def all(self, us: int) -> list[list[object]]:
        """Return the points of the last minute that were sent already."""
        kept = ((k, [p for p in points if p[0] >= us - KEPT_US]) for k, points in self._kept.items())
        return [_plain(k, points) for k, points in kept if points]


def _plain(key: str, points: list[Point]) -> list[object]:
    return [key, [[us / 1e6, float(f"{v:.4g}")] for us, v in points]]


def _thinned(points: list[Point]) -> list[Point]:
    """Return at most four of the points: the first, the smallest, the largest and the last.

    >>> _thinned([(1, 5.0), (2, 9.0), (3, 1.0), (4, 2.0), (5, 3.0)])
    [(1, 5.0), (2, 9.0), (3, 1.0), (5, 3.0)]
    """
    if len(points) <= _PER_TELLING:
        return points
    inner = points[1:-1]
    extremes = {min(inner, key=lambda p: p[1]), max(inner, key=lambda p: p[1])}
    return [points[0], *sorted(extremes), points[-1]]
