"""Results of a replay as data, which JSON can hold, and the comparison that finds every difference, event by event."""

from __future__ import annotations

from collections import Counter, defaultdict, deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from heapq import merge
from itertools import groupby, repeat
from typing import Any

from rrp_sheets.model.run_files import RecordedEvent, RecordedFailure, RecordedNotice, Stamp
from rrp_sheets.replay.record import content, same_json
from rrp_sheets.texts import translate

SCHEMA = 1  # of the JSON; grows when an entry changes its meaning or goes


@dataclass(frozen=True)
class Replayed:
    """A recorded run beside its replay.

    Attributes:
        run: the name of its folder.
        workbook: the file that ran.
        other: the file that was replayed instead; empty when it is the one that ran.
        engine: of the replay, `frame` or `event loop`.
        seconds: how much of the run was replayed.
        compared: how many recorded events, errors and words of the engine were compared.
        differences: all of them, in the order of time.
        counts: by stream and row.
        ending: how the replay ended otherwise than the run, in words; empty when it did not.
        remarks: what is to be known of the record and the workbook, in words.
        unknown: what a replay cannot know in this session, in words.
        stamp: of the run.
        actuators: names of the actuator streams, as the trace has them.
        spoken: those of them whose values the robot says, each with the text of its own if it has one.
        recorded: what was compared, in order.
        came: what came instead, in order; streams as the record calls them.
    """

    run: str
    workbook: str
    other: str
    engine: str
    seconds: float
    compared: int
    differences: tuple[Difference, ...]
    counts: tuple[Count, ...]
    ending: str = ""
    remarks: tuple[str, ...] = ()
    unknown: tuple[str, ...] = ()
    stamp: Stamp = field(default_factory=Stamp)
    actuators: tuple[str, ...] = ()
    spoken: Mapping[str, str] = field(default_factory=dict)
    recorded: Iterable[RecordedEvent] = field(default=(), repr=False, compare=False)
    came: Iterable[RecordedEvent] = field(default=(), repr=False, compare=False)

    @property
    def language(self) -> str:
        """Language of the account: that of the workbook that ran."""
        return self.stamp.language

    @property
    def same(self) -> bool:
        """True when nothing differs."""
        return not self.differences and not self.ending

    @property
    def first(self) -> Difference | None:
        """Earliest difference; None when there is none."""
        return self.differences[0] if self.differences else None

    def of(self, kind: str) -> Sequence[Difference]:
        """Return the differences of a kind: `missing`, `extra`, `value`, `time`, `row`, `order`."""
        return [d for d in self.differences if d.kind == kind]

    def as_dict(self, most: int | None = None) -> dict[str, Any]:
        """Return the replay as `replay --json` prints it; with at most so many differences."""
        return {
            "schema": SCHEMA, "same": self.same,
            "run": self.run, "workbook": self.workbook, "other": self.other, "engine": self.engine,
            "seconds": self.seconds, "compared": self.compared, "ending": translate(self.ending, self.language),
            "remarks": [translate(r, self.language) for r in self.remarks],
            "unknown": [translate(u, self.language) for u in self.unknown], "stamp": asdict(self.stamp),
            "actuators": list(self.actuators), "spoken": dict(self.spoken),
            "counts": [asdict(c) for c in self.counts],
            "difference_count": len(self.differences),
            "differences": [asdict(d) for d in self.differences[:most]],
        }  # fmt: skip


MISSING, EXTRA, VALUE, TIME, ROW, ORDER = "missing", "extra", "value", "time", "row", "order"
MOVED_US = 1_000_000
"""So far from each other two equal values are taken for one that came at another time."""


@dataclass(frozen=True, slots=True)
class Difference:
    """One event that differs between record and replay.

    Attributes:
        kind: `missing` (it was recorded, and did not come), `extra` (it came, and was not recorded), `value`, `time`
            (the same value earlier or later), `row` (the same command, by another row) or `order`.
        what: `event`, `error` (a formula failed), or `happening` (something that the engine told).
        stream: its name in the trace; empty for an error.
        us: when it was recorded; of an `extra` when it came (µs).
        came_us: when it came; of a `missing` when it was recorded.
        row: the row that gave it, in the workbook that ran; of an `extra` of a new row empty.
        came_row: the same row in the workbook that was played; empty when it is not in it.
        recorded: the value, as JSON.
        came: the value, as JSON.
    """

    kind: str
    what: str
    stream: str
    us: int
    came_us: int
    row: str
    came_row: str
    recorded: Any = None
    came: Any = None


@dataclass(frozen=True, slots=True)
class Count:
    """Numbers of events of a row or a sensor stream, and of those that are the same.

    Attributes:
        stream: its name in the trace; empty for the errors of a row.
        row, came_row: as in :class:`Difference`.
    """

    stream: str
    row: str
    came_row: str
    recorded: int
    came: int
    same: int


class Comparer:
    """Comparison of the events of a record with those of its replay.

    Args:
        here: the place of a row in the workbook that was played, for one of the workbook that ran; empty when it is
            not in it.
        there: the other way round.
        exact: whether 1 and 1.0 are different, and the order within a moment counts.
    """

    def __init__(self, here: Callable[[str], str], there: Callable[[str], str], *, exact: bool) -> None:
        self._here = here
        self._there = there
        self._exact = exact

    def compare(
        self, recorded: Iterable[RecordedEvent], came: Iterable[RecordedEvent]
    ) -> tuple[tuple[Difference, ...], tuple[Count, ...]]:
        """Return all differences in the order of time, and the counts in the order of the first events.

        Both are read once and side by side, time by time: only what has no counterpart is kept. In both, streams
        have the names of the record.
        """
        lanes: dict[tuple[str, str], _Lane] = {}
        swapped: tuple[RecordedEvent, RecordedEvent] | None = None  # the first that came in another order
        for was, now in _side_by_side(recorded, came):
            here: dict[tuple[str, str], tuple[list[RecordedEvent], list[RecordedEvent]]] = {}
            for event in was:
                here.setdefault(_lane(event, event.row), ([], []))[0].append(event)
            for event in now:
                here.setdefault(_lane(event, self._there(event.row) or f"+{event.row}"), ([], []))[1].append(event)
            for key, pair in here.items():
                lane = lanes.get(key)
                if lane is None:
                    lane = lanes[key] = _Lane((pair[0] or pair[1])[0].stream)
                # by row, as several rows may command one actuator stream
                lane.was.update((event.row, self._here(event.row)) for event in pair[0])
                lane.now.update((self._there(event.row), event.row) for event in pair[1])
                self._moment(*pair, lane)
            if self._exact and swapped is None:
                swapped = next((pair for pair in zip(was, now, strict=False) if not self._is_same(*pair)), None)
        found: list[Difference] = []
        counts: list[Count] = []
        for lane in sorted(lanes.values(), key=lambda lane: not lane.was):
            lane.found += self._moved(lane.left, lane.over)
            lane.found += [self._difference(MISSING, e, None) for e in lane.left]
            lane.found += [self._difference(EXTRA, None, e) for e in lane.over]
            found += lane.found
            counts += lane.counts()
        if not found and swapped is not None:  # each event has its counterpart at the same time
            found.append(self._difference(ORDER, *swapped))
        found.sort(key=lambda d: (min(d.us, d.came_us), d.stream))
        return tuple(found), tuple(counts)

    # ---- one stream
    def _moment(self, was: list[RecordedEvent], now: list[RecordedEvent], lane: _Lane) -> None:
        """Pair what came at one time: equal values first, then others in their order; the lane keeps what is left."""
        if len(was) == len(now) == 1 and _is_alike(was[0], now[0]) and self._same_row(was[0], now[0]):
            lane.same[was[0].row] += 1
            return
        values: dict[str, deque[RecordedEvent]] = defaultdict(deque)
        for event in now:
            values[self._text(event)].append(event)
        left = []
        used: set[int] = set()
        for event in was:
            others = values.get(self._text(event))
            if not others:
                left.append(event)
                continue
            mine = next((o for o in others if self._same_row(event, o)), others[0])
            others.remove(mine)
            used.add(id(mine))
            if self._same_row(event, mine):
                lane.same[event.row] += 1
            else:
                lane.found.append(self._difference(ROW, event, mine))
        over = [e for e in now if id(e) not in used]
        pairs = min(len(left), len(over))
        lane.found += [self._difference(VALUE, a, b) for a, b in zip(left, over, strict=False)]
        lane.left += left[pairs:]
        lane.over += over[pairs:]

    def _moved(self, left: list[RecordedEvent], over: list[RecordedEvent]) -> list[Difference]:
        """Pair equal values that came at another time, not far away, and remove them from both lists."""
        waiting: dict[str, deque[RecordedEvent]] = defaultdict(deque)
        for event in over:
            waiting[self._text(event)].append(event)
        found, gone = [], set()
        for event in left:
            others = waiting.get(self._text(event))
            while others and others[0].us < event.us - MOVED_US:
                others.popleft()
            if others and others[0].us <= event.us + MOVED_US:
                other = others.popleft()
                gone |= {id(event), id(other)}
                found.append(self._difference(TIME, event, other))
        left[:] = [e for e in left if id(e) not in gone]
        over[:] = [e for e in over if id(e) not in gone]
        return found

    def _is_same(self, a: RecordedEvent, b: RecordedEvent) -> bool:
        if (a.us, a.what, a.stream, a.row) != (b.us, b.what, b.stream, b.row):
            return False
        return _is_alike(a, b) or self._text(a) == self._text(b)

    def _same_row(self, a: RecordedEvent, b: RecordedEvent) -> bool:
        return self._here(a.row) == b.row

    def _text(self, event: RecordedEvent) -> str:
        return same_json(content(event) if self._exact else _alike(content(event)))

    def _difference(self, kind: str, was: RecordedEvent | None, now: RecordedEvent | None) -> Difference:
        event = was or now
        assert event is not None
        row = was.row if was else self._there(now.row) if now else ""
        came_row = now.row if now else self._here(was.row) if was else ""
        return Difference(
            kind, event.what, event.stream, (was or event).us, (now or event).us, row, came_row,
            _told(was), _told(now),
        )  # fmt: skip


@dataclass
class _Lane:
    """State of the comparison of one stream.

    Attributes:
        same: how many recorded events of a row are the same.
        left, over: recorded events that did not come, and such that came, with no counterpart at their time.
        was, now: how many were recorded and came, by the row and its place in the other workbook.
    """

    stream: str
    same: Counter[str] = field(default_factory=Counter)
    found: list[Difference] = field(default_factory=list)
    left: list[RecordedEvent] = field(default_factory=list)
    over: list[RecordedEvent] = field(default_factory=list)
    was: Counter[tuple[str, str]] = field(default_factory=Counter)
    now: Counter[tuple[str, str]] = field(default_factory=Counter)

    def counts(self) -> list[Count]:
        return [
            Count(self.stream, *rows, self.was[rows], self.now[rows], self.same[rows[0]] if rows in self.was else 0)
            for rows in {**self.was, **self.now}
        ]


def _side_by_side(
    first: Iterable[RecordedEvent], second: Iterable[RecordedEvent]
) -> Iterator[tuple[list[RecordedEvent], list[RecordedEvent]]]:
    """Yield the events of both for each time, in the order of time."""
    both = merge(zip(first, repeat(0)), zip(second, repeat(1)), key=lambda entry: entry[0].us)
    for _, here in groupby(both, key=lambda entry: entry[0].us):
        sides: tuple[list[RecordedEvent], list[RecordedEvent]] = [], []
        for event, side in here:
            sides[side].append(event)
        yield sides


def _lane(event: RecordedEvent, row: str) -> tuple[str, str]:
    """Return the key of what is compared together: events of a stream, errors of a row, notices of the engine."""
    return event.what, row if isinstance(event, RecordedFailure) else event.stream


def _is_alike(a: RecordedEvent, b: RecordedEvent) -> bool:
    """Return whether two events are the same at the first look, as most are; others may be the same too."""
    return a.us == b.us and type(a) is type(b) and repr(content(a)) == repr(content(b))


def _told(event: RecordedEvent | None) -> Any:
    if event is None:
        return None
    return event.text if isinstance(event, RecordedNotice) else content(event)


def _alike(value: Any) -> Any:
    """Return a value in which equal numbers are the same, however they were computed."""
    if isinstance(value, float) and value.is_integer():
        return int(value)
    if isinstance(value, list):
        return [_alike(v) for v in value]
    if isinstance(value, dict):
        return {n: _alike(v) for n, v in value.items()}
    return value
