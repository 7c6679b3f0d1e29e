"""Marble diagrams of differences: every stream that differs is drawn twice, as it was recorded and as it came."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from rrp_sheets.render.marble_diagram import Group, Lane, Marble, MarbleDiagram
from rrp_sheets.runs.marbles import stamped, value_from_json
from rrp_sheets.runs.replay.differences import EXTRA, MISSING, ROW, TIME, VALUE, Difference
from rrp_sheets.runs.replay.record import RecordedLine
from rrp_sheets.runs.replay.result import Replayed

MOST_STREAMS = 6
_MOST_MARKS = 8
_MARKS_APART = 0.06  # of the window
_WHOLE_US = 30_000_000  # a time that is shown as a whole
_SHOWN_US = 20_000_000  # of a longer one, so much
_BEFORE_US = 2_000_000
_MARKS = {MISSING: "gone", EXTRA: "new", VALUE: "other value", TIME: "other time", ROW: "other row"}


def difference_scores(found: Replayed) -> list[MarbleDiagram]:
    """Return the diagram of the first streams that differ, around the first difference; none when nothing does."""
    streams = _streams(found)
    if not streams:
        return []
    here = [d for d in found.differences if d.stream in streams and d.what == "event"]
    first, last = _window(here, round(found.seconds * 1e6))
    now = f"with {found.other}" if found.other else "replayed"
    groups = []
    courses = [_by_stream(course, streams, first, last) for course in (found.recorded, found.came)]
    for stream in streams:
        kind = "actuator" if stream in found.actuators else "stream"
        name = stream.rpartition("!")[2]
        name = f"row {name[1:]}" if name.startswith("#") else name
        for which, label in enumerate((name, "  instead")):
            groups.append(Group((), Lane(f"{stream} {which}", label, kind, tuple(courses[which][stream]))))
    title = f"{found.run}: as it was recorded, and below each line {now}"
    score = MarbleDiagram(title, tuple(groups), 0, last, _marks(here, first, last))
    return stamped([score.between(first, last)], found.stamp)


def _streams(found: Replayed) -> list[str]:
    """Return the first streams that differ, actuator streams before the others."""
    names = dict.fromkeys(d.stream for d in found.differences if d.what == "event" and d.kind in _MARKS)
    return sorted(names, key=lambda n: n not in found.actuators)[:MOST_STREAMS]


def _window(here: Sequence[Difference], until: int) -> tuple[int, int]:
    if until <= _WHOLE_US:
        return 0, max(until, 1)
    first = max(0, min(d.us for d in here) - _BEFORE_US)
    return first, min(until, first + _SHOWN_US)


def _by_stream(
    entries: Iterable[RecordedLine], streams: Sequence[str], first: int, last: int
) -> dict[str, list[Marble]]:
    """Return the values of some streams within a window (µs), in one pass."""
    found: dict[str, list[Marble]] = {stream: [] for stream in streams}
    for e in entries:
        if first <= e.us <= last and e.kind == "event" and e.stream in found:
            found[e.stream].append(Marble(e.us, value_from_json(e.stream, e.value), e.row))
    return found


def _marks(here: Sequence[Difference], first: int, last: int) -> tuple[tuple[int, str], ...]:
    """Return marks at the first differences, without those that would stand on each other."""
    marks: list[tuple[int, str]] = []
    for d in here:
        us = d.came_us if d.kind == EXTRA else d.us
        if not first <= us <= last or (marks and us - marks[-1][0] < (last - first) * _MARKS_APART):
            continue
        marks.append((us, _MARKS[d.kind]))
        if len(marks) == _MOST_MARKS:
            break
    return tuple(marks)
