"""Results of tests, and the judge: each expecting row takes one event of its stream, none is taken twice."""

from __future__ import annotations

import math
import re
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from rrp_sheets.checks.send_expect import Expectation
from rrp_sheets.checks.tests import Case, CaseRow
from rrp_sheets.formulas import Formula
from rrp_sheets.formulas.evaluator import GuardedInterpreter
from rrp_sheets.formulas.operations import is_number, same
from rrp_sheets.model.values import Failure, Record, Value, show
from rrp_sheets.texts import N_, listed

_NEIGHBOURS = 100  # events before and after that are looked at to say when something came
_MOST_TRIES = 4_000  # of finding another event for a row that came too late to get one


@dataclass(frozen=True, slots=True)
class Event:
    """A value on a stream (its id), with the row that gave it; empty for what was sent."""

    us: int
    stream: str
    row: str
    value: Value


@dataclass(frozen=True, slots=True)
class Fault:
    """A formula that failed in a row (its ref, `Tracking!4`), or an actuator that could not use its value."""

    us: int
    row: str
    message: str


@dataclass(frozen=True)
class RowResult:
    """Result of one expecting row of a test: whether what it expects came."""

    row: CaseRow
    passed: bool
    event: Event | None = None  # what came, when it was expected and came; for `nothing`, what came all the same
    got: str = ""  # in words what came instead; empty when it passed
    hints: tuple[str, ...] = ()  # what else may explain it, in words


@dataclass(frozen=True)
class CaseResult:
    """A test sheet that was run."""

    case: Case
    rows: tuple[RowResult, ...]  # a result for every row that expects, in the order of the sheet
    events: tuple[Event, ...] = ()  # everything that came on any stream, in order
    faults: tuple[Fault, ...] = ()  # formulas that failed
    ended_us: int = 0  # where the test's clock stood at the end
    seconds: float = 0.0  # that it took
    # rows that could not send what they should, by row number, in words
    broken: dict[int, str] = field(default_factory=dict)

    @property
    def passed(self) -> bool:
        """True when every row holds."""
        return not self.broken and all(r.passed for r in self.rows)

    @property
    def idle(self) -> bool:
        """True when nothing was expected, so that nothing can hold or fail."""
        return not self.rows and not self.broken

    @property
    def failed_rows(self) -> list[RowResult]:
        """The rows that do not hold."""
        return [r for r in self.rows if not r.passed]


TOLERANCE = 1
"""Frames by which something may come earlier or later than a row says."""


@dataclass(frozen=True)
class Frames:
    """The frames of a run at a rate (frames a second).

    >>> frames = Frames(30)
    >>> frames.at(100_000), frames.at(100_001), frames.time(3)
    (3, 4, 100000)
    """

    rate: int

    def at(self, us: int) -> int:
        """The first frame at or after a time."""
        return -(-us * self.rate // 1_000_000)

    def time(self, frame: int) -> int:
        """Return the time of a frame, in microseconds."""
        return frame * 1_000_000 // self.rate


@dataclass
class _Lane:
    """The events of one stream, and which row has taken which."""

    events: list[Event]
    frames: list[int]
    taken: dict[int, int]  # event → row, as places in their lists
    later: dict[int, int] = field(default_factory=dict)  # from a taken event to one behind it, as far as is known

    def take(self, event: int, row: int) -> None:
        """Let a row have an event; it stays taken, whichever row has it later."""
        self.taken[event] = row
        self.later.setdefault(event, event + 1)

    def free(self, window: range) -> Iterator[int]:
        """The events of a window that no row has taken, without a look at each of those that are."""
        at = self._next(window.start)
        while at < window.stop:
            yield at
            at = self._next(at + 1)

    def _next(self, event: int) -> int:
        """The first free place from there on; the way to it is shortened for the next time."""
        later = self.later
        while event in later:
            behind = later[event]
            later[event] = later.get(behind, behind)
            event = behind
        return event

    def between(self, first: int, last: int) -> range:
        return range(bisect_left(self.frames, first), bisect_right(self.frames, last))


@dataclass
class _Wanted:
    row: CaseRow
    holds: Holds
    window: range
    lane: _Lane


def judge(case: Case, events: Sequence[Event], faults: Sequence[Fault], frames: Frames) -> tuple[RowResult, ...]:
    """A result for every row that expects, in the order of the sheet."""
    lanes: dict[str, _Lane] = {}
    for event in events:
        lane = lanes.setdefault(event.stream, _Lane([], [], {}))
        lane.events.append(event)
        lane.frames.append(frames.at(event.us))
    interpreter = GuardedInterpreter()
    wanted: dict[int, _Wanted] = {}
    for place, row in enumerate(case.rows):
        if row.expectation and row.expectation.kind != "nothing":
            lane = lanes.setdefault(row.stream, _Lane([], [], {}))
            frame = frames.at(row.time_us)
            window = lane.between(frame - TOLERANCE, frame + TOLERANCE)
            wanted[place] = _Wanted(row, make_holds(row.expectation, interpreter), window, lane)
    found = _share_out(wanted)
    results = {place: _judged(mine, found.get(place), faults, frames) for place, mine in wanted.items()}
    for place, mine in wanted.items():
        if place not in found:  # what came in its place is not told again by a row that expects nothing
            instead = next(mine.lane.free(mine.window), None)
            if instead is not None:
                mine.lane.take(instead, place)
    first = since(case, frames)
    for place, row in enumerate(case.rows):
        if row.expectation and place not in wanted:
            results[place] = _nothing(row, first[place], lanes.get(row.stream), frames)
    return tuple(results[place] for place in sorted(results))


def _share_out(wanted: Mapping[int, _Wanted]) -> dict[int, Event]:
    """Assign events to as many rows as possible, the earliest and most specific rows first; returns them by row."""

    def particular(place: int) -> tuple[int, int]:
        kind = wanted[place].row.expectation
        assert kind is not None
        rank = {"value": 0, "about": 1, "fields": 1, "condition": 2}.get(kind.kind, 3)
        return wanted[place].row.time_us, rank

    hopeless: set[tuple[int, str, range]] = set()  # where a row got none, another of the same kind gets none either
    for place in sorted(wanted, key=particular):
        row = wanted[place].row
        same = (id(wanted[place].lane), row.expectation.text if row.expectation else "", wanted[place].window)
        if same not in hopeless and not _take(place, wanted, set(), [_MOST_TRIES]):
            hopeless.add(same)
    found = {}
    for lane in {id(w.lane): w.lane for w in wanted.values()}.values():
        found.update({place: lane.events[i] for i, place in lane.taken.items()})
    return found


def _take(place: int, wanted: Mapping[int, _Wanted], asked: set[int], tries: list[int]) -> bool:
    """Let a row take an event, if need be one whose row can take another (an augmenting path)."""
    mine = wanted[place]
    lane = mine.lane
    for i in lane.free(mine.window):
        if not mine.holds(lane.events[i].value):
            lane.take(i, place)
            return True
    for i in mine.window:
        if i not in lane.taken or i in asked:
            continue
        tries[0] -= 1
        if tries[0] < 0:
            return False
        if mine.holds(lane.events[i].value):
            continue
        asked.add(i)
        if len(asked) < 200 and _take(lane.taken[i], wanted, asked, tries):
            lane.take(i, place)
            return True
    return False


# ---- words


def _judged(mine: _Wanted, event: Event | None, faults: Sequence[Fault], frames: Frames) -> RowResult:
    row, lane = mine.row, mine.lane
    if event is not None:
        return RowResult(row, True, event)
    near = [lane.events[i] for i in mine.window[:_NEIGHBOURS]]
    hints: list[str] = []
    if near:
        reasons = [mine.holds(e.value) for e in near]
        got = listed([came(e) for e in near[:3]], ", then")
        if len(near) > 3:
            got = N_("{shown} and {n} more", shown=got, n=len(mine.window) - 3)
        hints += [r for r in dict.fromkeys(reasons) if r not in ("", "different")][:2]
        if not all(reasons):
            hints.append(N_("Another row of this test has matched it. Each value counts for one row."))
    elif not lane.events:
        got = N_("no value arrived on “{name}” in this test", name=row.name)
    else:
        got = N_("no value arrived at {ms}", ms=seconds(row.time_us))
    if lane.events:
        hints += _elsewhere(mine)
    at = frames.at(row.time_us)
    for fault in [f for f in faults if at - TOLERANCE <= frames.at(f.us) <= at + TOLERANCE][:3]:  # they may explain it
        words = {"row": fault.row, "ms": seconds(fault.us), "message": fault.message}
        hints.append(N_("{row} could not be calculated at {ms}: {message}", **words))
    return RowResult(row, False, None, got, tuple(hints))


def _elsewhere(mine: _Wanted) -> list[str]:
    """Return hints when the expected value came outside of the window, or when the nearest event came."""
    lane, row = mine.lane, mine.row
    inside = set(mine.window)
    middle = mine.window.start
    about = range(max(0, middle - _NEIGHBOURS), min(len(lane.events), middle + _NEIGHBOURS))
    outside = sorted((i for i in about if i not in inside), key=lambda i: abs(lane.events[i].us - row.time_us))
    fitting = next((i for i in outside if i not in lane.taken and not mine.holds(lane.events[i].value)), None)
    if fitting is not None:
        return [N_("The expected value arrived at {ms}.", ms=seconds(lane.events[fitting].us))]
    if inside or not outside:
        return []
    event = lane.events[outside[0]]
    return [N_("The nearest value was {value} at {ms}.", value=show(event.value, 80), ms=seconds(event.us))]


def _nothing(row: CaseRow, since_frame: int, lane: _Lane | None, frames: Frames) -> RowResult:
    """Judge a row that expects nothing: since the row before, only events that other rows expect may have come."""
    if lane is None:
        return RowResult(row, True)
    assert row.expectation is not None
    late = [i for i in lane.between(since_frame, frames.at(row.time_us)) if i not in lane.taken]
    if row.expectation.blanks:
        late = [i for i in late if lane.events[i].value is not None]
    if not late:
        return RowResult(row, True)
    events = [lane.events[i] for i in late]
    got = came(events[0])
    if len(events) > 1:
        got = N_("{shown} and {n} more", shown=got, n=len(events) - 1)
    return RowResult(row, False, events[0], got)


def since(case: Case, frames: Frames) -> list[int]:
    """Return for each row the frame from which a `nothing` would count in it: since the row before.

    Rows are taken by their times, those of one time as they stand in the sheet. Rows that expect at one time are one
    list, so the row before is the one before that list: a row that sends at that time and stands above, or else the
    latest of an earlier time. What came at the very time of rows that only expect belongs to these, so it counts from
    just after them; what a sending row causes at once counts. Without any row before it is the start.
    """
    times = sorted({r.time_us for r in case.rows})
    sending = {r.time_us for r in case.rows if r.sending}
    before = dict(zip(times[1:], times, strict=False))
    sent: set[int] = set()
    found = []
    for row in case.rows:
        us = row.time_us if row.time_us in sent else before.get(row.time_us)
        found.append(0 if us is None else frames.at(us) + (us not in sending))
        if row.sending:
            sent.add(row.time_us)
    return found


def came(event: Event) -> str:
    """`“Hello” at 2 s from Talk!4`."""
    value, ms = show(event.value, 90), seconds(event.us)
    return N_("{value} at {ms} from {row}" if event.row else "{value} at {ms}", value=value, ms=ms, row=event.row)


def seconds(us: int) -> str:
    """A time of a test, as its rows are written.

    >>> seconds(2_000_000), seconds(33_333)
    ('2000 ms', '33.3 ms')
    """
    ms = us / 1000
    return f"{ms:.0f} ms" if ms == int(ms) else f"{ms:.1f} ms"


_DECIMAL_COMMA = re.compile(r"[+-]?\d+,\d+")
RELATIVE = 1e-9
NEAR_ZERO = 1e-12
"""Numbers that differ by less are equal: 0.1 + 0.2 - 0.3 is 0 in the eyes of people."""

Holds = Callable[[Value], str]
"""From a value to what is wrong with it, in words; an empty text when it is as expected."""


def make_holds(expectation: Expectation, interpreter: GuardedInterpreter) -> Holds:
    """Return a function that tells what is wrong with a value, or an empty text when it is as expected."""
    if expectation.kind == "any":
        return lambda value: ""
    if expectation.kind == "about":
        return _about(expectation)
    if expectation.kind == "condition":
        return _condition(expectation, interpreter)
    if expectation.kind == "fields":
        return _fields(expectation, interpreter)
    wanted = expectation.value
    if isinstance(wanted, Formula):
        wanted = wanted.prepare(interpreter)()
        if type(wanted) is Failure:
            words = wanted.message
            return lambda value: words
    return lambda value: "" if equal(value, wanted, exact=expectation.quoted) else _kind_hint(value, wanted)


def equal(value: Value, wanted: Value, *, exact: bool = False) -> bool:
    """Return whether two values are equal as in formulas (capitals do not matter), numbers to 1e-9 relative.

    With `exact`, spaces at the ends of a text count.

    >>> equal(0.1 + 0.2, 0.3), equal("hello ", "Hello"), equal("1", 1), equal([1.0, "a"], (1, "A"))
    (True, True, False, True)
    """
    if is_number(value) and is_number(wanted):
        return value == wanted or math.isclose(value, wanted, rel_tol=RELATIVE, abs_tol=NEAR_ZERO)
    if isinstance(value, str) and isinstance(wanted, str):
        return same(value, wanted) if exact else same(_bare(value), _bare(wanted))
    if isinstance(value, (list, tuple)) and isinstance(wanted, (list, tuple)):
        return len(value) == len(wanted) and all(equal(a, b, exact=exact) for a, b in zip(value, wanted, strict=True))
    if isinstance(value, Record) and isinstance(wanted, Record):
        keys = value.values.keys()
        return keys == wanted.values.keys() and all(equal(value.values[k], wanted.values[k]) for k in keys)
    return same(value, wanted)


def _bare(text: str) -> str:
    return " ".join(text.split())


def _kind_hint(value: Value, wanted: Value) -> str:
    if isinstance(value, str) and not isinstance(wanted, str) and _bare(value) == show(wanted, 60):
        return N_('It is a text; write "{value}" in quotes to expect it.', value=value)
    if isinstance(wanted, str) and is_number(value) and wanted == show(value):
        return N_("It is a number; write {wanted} without quotes to expect it.", wanted=wanted)
    if isinstance(wanted, str) and is_number(value) and _DECIMAL_COMMA.fullmatch(wanted):
        return N_("Write numbers with a point: {value}.", value=wanted.replace(",", "."))
    if isinstance(value, Record):
        return N_("It is a record; write for example any, or field=value.")
    return "different"


def _about(expectation: Expectation) -> Holds:
    wanted, within = expectation.value, expectation.within
    assert isinstance(wanted, float)

    def holds(value: Value) -> str:
        if not is_number(value):
            return N_("It is not a number.")
        slack = abs(wanted) * RELATIVE + NEAR_ZERO
        return "" if abs(value - wanted) <= within + slack else "different"

    return holds


def _condition(expectation: Expectation, interpreter: GuardedInterpreter) -> Holds:
    assert expectation.condition is not None
    evaluate = expectation.condition.prepare(interpreter)

    def holds(value: Value) -> str:
        result = evaluate(value)
        if type(result) is Failure:
            return N_("The condition cannot be calculated for it: {reason}", reason=result.message)
        return "" if (result is True or (is_number(result) and result != 0)) else "different"

    return holds


def _fields(expectation: Expectation, interpreter: GuardedInterpreter) -> Holds:
    parts = [(name, make_holds(one, interpreter)) for name, one in expectation.fields]

    def holds(value: Value) -> str:
        if not isinstance(value, Record):
            is_text_alike = isinstance(value, str) and equal(value, expectation.text)
            return "" if is_text_alike else N_("It is not a record with fields.")
        for name, one in parts:
            try:
                field = value.get(name)
            except KeyError:
                return N_("It has no field “{name}”.", name=name)
            wrong = one(field)
            if wrong:
                return N_("Its {name} is {value}.", name=name, value=show(field))
        return ""

    return holds
