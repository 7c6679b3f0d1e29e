"""What came of a replay beside what was recorded: event by event, every difference as data."""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from rrp_sheets.runs.replay.record import ERROR, Entry, same_json

MISSING, EXTRA, VALUE, TIME, ROW, ORDER = "missing", "extra", "value", "time", "row", "order"
MOVED_US = 1_000_000
"""So far from each other two equal values are taken for one that came at another time."""


@dataclass(frozen=True, slots=True)
class Difference:
    """One event that is not the same.

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
    """How many events of a row or a sensor stream are the same.

    Attributes:
        stream: its name in the trace; empty for the errors of a row.
        row, came_row: as in :class:`Difference`.
        recorded: how many there were.
        came: how many came now.
        same: how many are the same.
    """

    stream: str
    row: str
    came_row: str
    recorded: int
    came: int
    same: int


@dataclass(frozen=True)
class Found:
    """What was compared.

    Attributes:
        differences: in the order of time.
        counts: by stream and row, in the order of their first events.
    """

    differences: tuple[Difference, ...]
    counts: tuple[Count, ...]


class Comparer:
    """Compares two courses of events.

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

    def compare(self, recorded: Sequence[Entry], came: Sequence[Entry]) -> Found:
        """All differences; streams of both have the names of the record."""
        lanes: dict[tuple[str, str], tuple[list[Entry], list[Entry]]] = {}
        for entry in recorded:
            lanes.setdefault(_lane(entry, entry.row), ([], []))[0].append(entry)
        for entry in came:
            lanes.setdefault(_lane(entry, self._there(entry.row) or f"+{entry.row}"), ([], []))[1].append(entry)
        found: list[Difference] = []
        counts: list[Count] = []
        for lane in lanes.values():
            one, same = self._lane(*lane)
            found += one
            counts += self._counts(lane, same)
        if not found and self._exact:
            found += self._order(recorded, came)
        found.sort(key=lambda d: (min(d.us, d.came_us), d.stream))
        return Found(tuple(found), tuple(counts))

    # ---- one stream
    def _lane(self, was: list[Entry], now: list[Entry]) -> tuple[list[Difference], set[int]]:
        """The differences of a stream, and the recorded events (their identities) that are the same."""
        same: set[int] = set()
        found: list[Difference] = []
        left: list[Entry] = []
        over: list[Entry] = []
        at: dict[int, list[Entry]] = defaultdict(list)
        for entry in now:
            at[entry.us].append(entry)
        begun: dict[int, list[Entry]] = defaultdict(list)
        for entry in was:
            begun[entry.us].append(entry)
        for us in sorted(begun.keys() | at.keys()):
            a, b = self._moment(begun.get(us, []), at.get(us, []), same, found)
            left += a
            over += b
        found += self._moved(left, over)
        found += [self._difference(MISSING, e, None) for e in left]
        found += [self._difference(EXTRA, None, e) for e in over]
        return found, same

    def _moment(
        self, was: list[Entry], now: list[Entry], same: set[int], found: list[Difference]
    ) -> tuple[list[Entry], list[Entry]]:
        """Pair what came at one time: the same values first, then others in their order; what is left of both."""
        values: dict[str, deque[Entry]] = defaultdict(deque)
        for entry in now:
            values[self._text(entry)].append(entry)
        left = []
        used: set[int] = set()
        for entry in was:
            others = values.get(self._text(entry))
            if not others:
                left.append(entry)
                continue
            mine = next((o for o in others if self._same_row(entry, o)), others[0])
            others.remove(mine)
            used.add(id(mine))
            if self._same_row(entry, mine):
                same.add(id(entry))
            else:
                found.append(self._difference(ROW, entry, mine))
        over = [e for e in now if id(e) not in used]
        pairs = min(len(left), len(over))
        found += [self._difference(VALUE, a, b) for a, b in zip(left, over, strict=False)]
        return left[pairs:], over[pairs:]

    def _moved(self, left: list[Entry], over: list[Entry]) -> list[Difference]:
        """Equal values that came at another time, not far away; they leave both lists."""
        waiting: dict[str, deque[Entry]] = defaultdict(deque)
        for entry in over:
            waiting[self._text(entry)].append(entry)
        found, gone = [], set()
        for entry in left:
            others = waiting.get(self._text(entry))
            while others and others[0].us < entry.us - MOVED_US:
                others.popleft()
            if others and others[0].us <= entry.us + MOVED_US:
                other = others.popleft()
                gone |= {id(entry), id(other)}
                found.append(self._difference(TIME, entry, other))
        left[:] = [e for e in left if id(e) not in gone]
        over[:] = [e for e in over if id(e) not in gone]
        return found

    def _same_row(self, a: Entry, b: Entry) -> bool:
        return self._here(a.row) == b.row

    def _text(self, entry: Entry) -> str:
        value = entry.value if entry.kind != "happening" else [entry.what, entry.text]
        return same_json(value if self._exact else _alike(value))

    def _difference(self, kind: str, was: Entry | None, now: Entry | None) -> Difference:
        entry = was or now
        assert entry is not None
        row = was.row if was else self._there(now.row) if now else ""
        came_row = now.row if now else self._here(was.row) if was else ""
        return Difference(
            kind, entry.kind, entry.stream, (was or entry).us, (now or entry).us, row, came_row,
            _value(was), _value(now),
        )  # fmt: skip

    def _order(self, recorded: Sequence[Entry], came: Sequence[Entry]) -> list[Difference]:
        """The first two that came in another order, when all else is the same."""
        for a, b in zip(recorded, came, strict=False):
            if (a.us, a.kind, a.stream, a.row) != (b.us, b.kind, b.stream, b.row) or self._text(a) != self._text(b):
                return [self._difference(ORDER, a, b)]
        return []

    def _counts(self, lane: tuple[list[Entry], list[Entry]], same: set[int]) -> list[Count]:
        """By row: several may command one actuator stream."""
        rows: dict[tuple[str, str], list[int]] = {}
        for entry in lane[0]:
            count = rows.setdefault((entry.row, self._here(entry.row)), [0, 0, 0])
            count[0] += 1
            count[2] += id(entry) in same
        for entry in lane[1]:
            rows.setdefault((self._there(entry.row), entry.row), [0, 0, 0])[1] += 1
        stream = (lane[0] or lane[1])[0].stream
        return [Count(stream, row, came, *numbers) for (row, came), numbers in rows.items()]


def _lane(entry: Entry, row: str) -> tuple[str, str]:
    """What is compared with each other: the events of a stream, the errors of a row, what the engine tells."""
    if entry.kind == ERROR:
        return ERROR, row
    return entry.kind, entry.stream


def _value(entry: Entry | None) -> Any:
    if entry is None:
        return None
    return entry.text if entry.kind == "happening" else entry.value


def _alike(value: Any) -> Any:
    """Numbers that are equal are the same, however they were worked out."""
    if isinstance(value, float) and value.is_integer():
        return int(value)
    if isinstance(value, list):
        return [_alike(v) for v in value]
    if isinstance(value, dict):
        return {n: _alike(v) for n, v in value.items()}
    return value
