"""Log of a run and thinned curves of its numbers, made in one pass over its trace; texts of values and times."""

from __future__ import annotations

import re
from array import array
from collections.abc import Collection, Mapping
from dataclasses import asdict, dataclass, field
from functools import lru_cache
from itertools import islice
from pathlib import Path
from typing import Any

from rrp_sheets.model.exchange import DONE
from rrp_sheets.model.names import key
from rrp_sheets.model.run_files import RecordedAction, RecordedHappening, RecordedNotice, RecordedValue
from rrp_sheets.model.values import Record, Value, show
from rrp_sheets.recording.marbles import value_from_json
from rrp_sheets.recording.messages import as_message
from rrp_sheets.recording.table import units_of
from rrp_sheets.recording.trace_reader import TraceHeader, TraceReader, text_of
from rrp_sheets.robots import load_robot
from rrp_sheets.texts import N_, LazyMessage, listed

MOST_LINES = 2_000  # of the log
MOST_POINTS = 1_200  # of a curve: two for each pixel of a wide screen's plot
MOST_CURVES = 24
_MOST_EVENTS = 2_000_000
_LARGEST = 1e300
_LONGEST_VALUE = 200  # letters
_MOST_COMMANDS = 1_000  # of the log's lines
_OWN_WORDS = frozenset(("say", "sound", "mark", "press", "button", "send", "edit"))  # what people wrote
_QUIET = 2.0  # seconds after which a row that goes on with its commands is told again
_TOLD = frozenset(("Print", "RememberFace", "Behaviour"))  # devices that tell themselves what they do
_HEARD = frozenset(("SayInput", "SayParameter", "PlaySound"))  # and those that tell it when one hears it
_PLAIN = {"stream": 0, "sensor": 1, "actuator": 2}  # whose curves come first: what rows work out …
_FIELDS = {"sensor": 0, "stream": 1, "actuator": 2}  # … and of records what was sensed, which rows pass on


@dataclass
class TimelineEntry:
    """A line of the log."""

    t: float  # seconds since the run began
    kind: str  # `say`, `command`, `error`, `mark`, `edit`, …
    text: str
    row: str = ""  # whose it is, `Tracking!4`
    by: str = ""
    times: int = 1  # that it came
    until: float = 0.0  # when it came last, or a thing was dragged to its last place
    sound: str = ""  # the file with what was said


@dataclass
class _Curve:
    kind: str
    unit: str
    times: array[float] = field(default_factory=lambda: array("d"))
    values: array[float] = field(default_factory=lambda: array("d"))


_Curves = dict[tuple[str, str], _Curve]  # by stream and field, which is blank for a plain number


def build_timeline(place: Path, only: Collection[str] = ()) -> dict[str, Any]:
    """Return the log of the run in a folder, and its curves or those of some streams, as JSON.

    A stream may be named without its sheet, and its field left out: `Red ball`, `Distance`, `Tracking!Red ball.x`.

    Raises:
        UnreadableFile: when it is no trace.
    """
    reader = TraceReader(place)
    log = Log(place, reader.header)
    curves: _Curves = {}
    kinds = {stream.name: stream.kind for stream in reader.header.streams}
    units = units_of(reader)
    last, count = 0.0, 0
    for event in islice(reader, _MOST_EVENTS):
        t = event.t
        last = t if t > last else last
        count += 1
        if isinstance(event, RecordedValue):
            _note(curves, event, kinds, units)
            if event.by is not None or event.stream in log.commanded:
                log.value(event)
        else:
            log.add(event)
    labelled = {f"{text_of(s)}.{text_of(n)}" if n else text_of(s): curve for (s, n), curve in curves.items()}
    wanted = {key(name) for name in only}
    shown, more = _chosen({k: c for k, c in labelled.items() if not only or wanted & _names_of(k)})
    return {
        "lines": [asdict(line) for line in log.lines], "left_out": log.left_out, "seconds": last, "count": count,
        "curves": shown, "more_curves": more,
    }  # fmt: skip


def _names_of(curve: str) -> set[str]:
    """Return the names of a curve, with or without its sheet, with or without its field; as keys.

    >>> sorted(_names_of("Tracking!Ball.x"))
    ['ball', 'ball.x', 'tracking!ball', 'tracking!ball.x']
    """
    names = {curve, curve.rpartition("!")[2]}
    return {key(n) for name in names for n in (name, name.rpartition(".")[0] or name)}


class Log:
    """Log of a run, made from the events of its trace one by one.

    Attributes:
        commanded: the actuator streams whose commands are told, with the device of each.
    """

    def __init__(self, place: Path, header: TraceHeader) -> None:
        self.lines: list[TimelineEntry] = []
        self.left_out = 0
        devices = {s.name: s.device for s in header.streams if s.kind == "actuator"}
        self.commanded = {name: device for name, device in devices.items() if device not in _TOLD}
        self._printing = {name for name, device in devices.items() if device == "Print"}
        self._place = place
        self._commands: dict[tuple[str, str], tuple[TimelineEntry, Any]] = {}  # the last of each row, with its value
        self._commands_told = 0
        self._open: dict[tuple[str, str], TimelineEntry] = {}  # errors that come again and again are one line
        self._said = 0
        self._drag = Drag()
        self._dragged: TimelineEntry | None = None

    def value(self, event: RecordedValue) -> None:
        """Add a value that was sent by hand, or is a command for an actuator; not any other one."""
        if event.by is not None:
            text = show(value_from_json(event.stream, event.value), _LONGEST_VALUE)
            if not isinstance(event.value, dict):  # the text of a record names the stream itself
                text = f"{text_of(event.stream)}: {text}"
            self.add(RecordedAction(event.us, "", "", "send", text, event.by, 0.0))
        elif event.stream in self.commanded:
            self._command(event)

    def _command(self, event: RecordedValue) -> None:
        """Add a command for an actuator; one that goes on with the row's last one is counted in its line."""
        t, stream, row, value = event.t, event.stream, text_of(event.row), event.value
        device = self.commanded[stream]
        if device in _HEARD and value is not None:
            return
        before, last = self._commands.get((stream, row), (None, None))
        plain = value is None or isinstance(value, str)
        goes_on = value == last if plain else not (last is None or isinstance(last, str))
        if before is not None and goes_on and t - before.until <= _QUIET:
            before.times, before.until = before.times + 1, t
            self._commands[stream, row] = before, value
            return
        line = TimelineEntry(t, "command", _commanded(stream, device, value), row, until=t)
        self._commands[stream, row] = line, value
        self._commands_told += 1
        if len(self.lines) >= MOST_LINES or self._commands_told > _MOST_COMMANDS:
            self.left_out += 1
            return
        self.lines.append(line)

    def add(self, event: RecordedHappening) -> None:
        """Add something else that happened."""
        t, kind, text = event.t, text_of(event.kind) or "note", text_of(event.text)
        by = put = ""  # who did it, and the thing that was put somewhere
        if isinstance(event, RecordedAction):
            by = text_of(event.by)
            if "put" in event.detail and not event.detail.get("appears"):
                put = text_of(event.detail.get("thing"))
        row = text_of(event.row or event.stream)
        before = self._open.get((row, text)) if kind in ("error", "clamp") else None
        if before is not None:
            before.times, before.until = before.times + 1, t
            return
        if self._goes_on(t, put, by, text):
            return
        shown = text if kind in _OWN_WORDS or event.stream in self._printing else as_message(text)
        line = TimelineEntry(t, kind, shown, row, by, until=t)
        if kind in ("say", "sound", "person"):
            self._said += kind == "say"
            sound = event.sound if isinstance(event, RecordedNotice) else ""
            sound = sound or (f"say-{self._said:03}.wav" if kind == "say" else "/")
            line.sound = sound if "/" not in sound and (self._place / sound).is_file() else ""
        if len(self.lines) >= MOST_LINES:
            self.left_out += 1
            return
        self.lines.append(line)
        if put:
            self._dragged = line
        if kind in ("error", "clamp"):
            self._open[row, text] = line

    def _goes_on(self, t: float, thing: str, by: str, text: str) -> bool:
        """Return whether a drag of a thing continues; its line then gets the new place."""
        if not thing:
            if by:
                self._drag.over()
            return False
        if not self._drag.goes_on(t, thing, by) or self._dragged is None:
            self._dragged = None
            return False
        self._dragged.text, self._dragged.until = dragged(thing, as_message(text)), t
        return True


def _commanded(stream: str, device: str, value: Any) -> str:
    """Describe a command: the stream, and the value where that says what is done."""
    if value is None:
        return N_("{stream}: stops", stream=stream)
    says = isinstance(value, str) or (not isinstance(value, (dict, bool)) and device not in _triggered())
    return f"{stream}: {show(value_from_json(stream, value), _LONGEST_VALUE)}" if says else stream


@lru_cache(maxsize=1)
def _triggered() -> frozenset[str]:
    """Return the devices that any value only triggers."""
    return frozenset(d.name for d in load_robot().devices.values() if d.takes.startswith("any event"))


def _note(
    curves: _Curves, event: RecordedValue, kinds: Mapping[str, str], units: Mapping[str, Mapping[str, str]]
) -> None:
    """Add a value's numbers to the curves; called a million times for a long run, so it is kept simple."""
    t, stream, value = event.t, event.stream, event.value
    parts = value.items() if isinstance(value, dict) else (("", value),)
    for name, part in parts:
        kind = type(part)
        if (kind is float or kind is int) and -_LARGEST < part < _LARGEST:  # no truth value, no NaN
            curve = curves.get((stream, name))
            if curve is None:
                if len(curves) >= 20 * MOST_CURVES:
                    continue
                unit = units.get(stream, {}).get(key(name), "")
                curve = curves[stream, name] = _Curve(kinds.get(stream, ""), unit)
            curve.times.append(t)
            curve.values.append(part)


def _chosen(curves: Mapping[str, _Curve]) -> tuple[list[dict[str, Any]], int]:
    """Return the curves that are shown, and the number of others: plain numbers first, fields of records after them."""

    def place(labelled: tuple[str, _Curve]) -> tuple[bool, int]:
        is_field = "." in labelled[0].rpartition("!")[2]
        return is_field, (_FIELDS if is_field else _PLAIN).get(labelled[1].kind, 3)

    moving = sorted(((label, curve) for label, curve in curves.items() if len(curve.times) > 1), key=place)
    chosen = moving[:MOST_CURVES]
    short = [label.rpartition("!")[2] for label, _ in chosen]
    found = [
        {
            "name": name if short.count(name) == 1 else label, "kind": curve.kind, "count": len(curve.times),
            "unit": curve.unit, "points": [[round(t, 4), v] for t, v in thinned(curve.times, curve.values)],
        }
        for (label, curve), name in zip(chosen, short, strict=True)
    ]  # fmt: skip
    return found, len(moving) - len(chosen)


def thinned(times: array[float], values: array[float], most: int = MOST_POINTS) -> list[tuple[float, float]]:
    """Thin a curve to at most so many points with the same look: of each stretch the lowest and the highest.

    >>> thinned(array("d", range(6)), array("d", [0, 9, 0, 0, -9, 0]), 4)
    [(0.0, 0.0), (1.0, 9.0), (3.0, 0.0), (4.0, -9.0)]
    """
    count = len(times)
    if count <= most:
        return list(zip(times, values, strict=True))
    found: list[tuple[float, float]] = []
    stretches = most // 2
    for n in range(stretches):
        places = range(count * n // stretches, count * (n + 1) // stretches)
        low, high = min(places, key=values.__getitem__), max(places, key=values.__getitem__)
        found += [(times[i], values[i]) for i in sorted({low, high})]
    return found


_GAP = 3.0  # seconds between two places, at most


class Drag:
    """State that decides whether a thing that is put somewhere is still being dragged.

    >>> drag = Drag()
    >>> [drag.goes_on(t, "Red ball", "Mika") for t in (1.0, 1.1, 5.0)]
    [False, True, False]
    """

    def __init__(self) -> None:
        self._what: tuple[str, str] | None = None
        self._last = 0.0

    def goes_on(self, t: float, thing: str, by: str) -> bool:
        """Return whether this placement, at `t` seconds of the run, continues the one before."""
        what, last = (thing.casefold(), by), self._last
        goes_on = what == self._what and t - last < _GAP
        self._what, self._last = what, t
        return goes_on

    def over(self) -> None:
        """End the drag, as something else was done."""
        self._what = None


def dragged(thing: str, text: str) -> str:
    """Return the text for a thing that was put to its last place, when there were others before.

    >>> dragged("Red ball", as_message("Red ball is placed at 0.50, 0.10, 0.42 m."))
    'Red ball is dragged to 0.50, 0.10, 0.42 m.'
    """
    place = text.places.get("place") if isinstance(text, LazyMessage) else None
    return N_("{thing} is dragged to {place} m.", thing=thing, place=place) if place else text


LONGEST = 80  # letters of a value
_TELLING = ("name", "label", "word", "colour", "zone", "pressed", "distance", "value", "new", "count")
_UNIT = re.compile(r"^\(?-?[\d.,]+(?:e-?\d+)? ([^\s\d()]{1,8})\)?$")


def value_text(value: Value, unit: str = "") -> str:
    """Return a short text of a value; of a record one or two telling fields.

    >>> value_text(0.4567, "m"), value_text("left"), value_text(None)
    ('0.457 m', '“left”', 'blank')
    >>> value_text(DONE.make(value=1, completed=True, seconds=2.21))
    'completed after 2.2 s'
    """
    if isinstance(value, Record):
        return _record(value)
    text = N_("blank") if value is None else show(value, LONGEST)
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    return f"{text} {unit}" if unit and number else text


def _record(value: Record) -> str:
    fields = value.as_dict()
    if value.type == DONE:
        seconds = fields.get("seconds")
        completed = bool(fields.get("completed"))
        if not isinstance(seconds, (int, float)):
            return N_("completed" if completed else "broken off")
        return N_("completed after {n:.1f} s" if completed else "broken off after {n:.1f} s", n=seconds)
    units = {f.name: f.unit for f in value.type.fields}
    telling = [n for n in _TELLING if fields.get(n) not in (None, "")][:2] or list(fields)[:2]
    text = listed([f"{n} {value_text(fields[n], units.get(n, ''))}" for n in telling])
    return text if len(text) <= LONGEST else text[: LONGEST - 1] + "…"


def unit_of(example: str) -> str:
    """Return the unit of an example value as the check shows it.

    >>> unit_of("0.48 m"), unit_of("(12 °)"), unit_of("“left”"), unit_of("0.5")
    ('m', '°', '', '')
    """
    found = _UNIT.match(example)
    return found[1] if found else ""
