"""Outputs of a replay: its differences as a table or as marbles, in a file, and its account as JSON for a page."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from rrp_sheets.model.run_files import RecordedEvent, RecordedValue, Stamp
from rrp_sheets.recording.marbles import stamped, value_from_json
from rrp_sheets.recording.table import Seconds, about_runs, csv_cell, properties_of, refuse_other_table
from rrp_sheets.render.marble_diagram import Group, Lane, Marble, MarbleDiagram
from rrp_sheets.render.marble_drawing import draw_marbles
from rrp_sheets.replay.record import same_json
from rrp_sheets.replay.report import AccountLine, each_line, robot_lines, row_lines, verdict
from rrp_sheets.replay.result import EXTRA, MISSING, ROW, TIME, VALUE, Difference, Replayed
from rrp_sheets.texts import N_, translate
from rrp_sheets.workbook.files import unwritable, write_atomically

SUFFIXES = (".xlsx", ".csv", ".svg", ".pdf", ".png")
_HEADER = ("time_s", "kind", "stream", "row", "row_now", "recorded", "came", "came_at_s", "what")
_WIDTHS = (10, 10, 24, 16, 16, 30, 30, 12, 10)
MOST_STREAMS = 6
_MOST_MARKS = 8
_MARKS_APART = 0.06  # of the window
_WHOLE_US = 30_000_000  # a time that is shown as a whole
_SHOWN_US = 20_000_000  # of a longer one, so much
_BEFORE_US = 2_000_000
_MARKS = {
    MISSING: N_("gone"), EXTRA: N_("new"), VALUE: N_("other value"), TIME: N_("other time"), ROW: N_("other row"),
}  # fmt: skip
MOST = 300  # lines of a list
_MOST_PICTURES = 4


def write(found: Replayed, target: Path) -> list[str]:
    """Write the differences in the format of the suffix; return what the picture lacks, in words.

    Raises SheetsError when it cannot be written, or would take the place of what is no table of a run.
    """
    suffix = target.suffix.casefold()
    refuse_other_table(target)
    try:
        if suffix == ".csv":
            write_atomically(target, _csv(found).encode("utf-8-sig", "replace"))
            return []
        if suffix == ".xlsx":
            from rrp_sheets.workbook.table import write_table

            about, properties = [about_runs([found.stamp])], properties_of([found.stamp])
            count = len(found.differences)
            write_table(target, "differences", _HEADER, _rows(found), _WIDTHS, about, properties, count)
            return []
    except OSError as error:
        raise unwritable(target, error) from None
    scores = difference_scores(found)
    if not scores:
        return [N_("There is no difference to draw, so “{name}” was not written.", name=target.name)]
    from rrp_sheets.render.output import write_marbles

    return write_marbles(scores, target)


def _rows(found: Replayed) -> Iterator[list[Any]]:
    for d in found.differences:
        recorded, came = (same_json(v) if isinstance(v, (list, dict)) else v for v in (d.recorded, d.came))
        yield [Seconds(d.us / 1e6), d.kind, d.stream or None, d.row or None, d.came_row or None, recorded, came,
               Seconds(d.came_us / 1e6), d.what]  # fmt: skip


def _csv(found: Replayed) -> str:
    out = io.StringIO(newline="")
    writer = csv.writer(out)
    stamp = found.stamp.row().values()  # in every row, as in the table of a run: a file beside it gets lost
    writer.writerow([*_HEADER, *Stamp.columns()])
    writer.writerows([csv_cell(v) for v in (*row, *stamp)] for row in _rows(found))
    return out.getvalue()


def difference_scores(found: Replayed) -> list[MarbleDiagram]:
    """Return the diagram of the first streams that differ, actuator streams first, around the first difference."""
    names = dict.fromkeys(d.stream for d in found.differences if d.what == "event" and d.kind in _MARKS)
    streams = sorted(names, key=lambda n: n not in found.actuators)[:MOST_STREAMS]
    if not streams:
        return []
    here = [d for d in found.differences if d.stream in streams and d.what == "event"]
    first, last = 0, max(round(found.seconds * 1e6), 1)
    if last > _WHOLE_US:
        first = max(0, min(d.us for d in here) - _BEFORE_US)
        last = min(last, first + _SHOWN_US)
    groups = []
    courses = [_by_stream(course, streams, first, last) for course in (found.recorded, found.came)]
    for stream in streams:
        kind = "actuator" if stream in found.actuators else "stream"
        name = stream.rpartition("!")[2]
        if name.startswith("#"):
            name = translate(N_("row {n}", n=name[1:]), found.language)
        for which, label in enumerate((name, f"  {translate(N_('instead'), found.language)}")):
            groups.append(Group((), Lane(f"{stream} {which}", label, kind, tuple(courses[which][stream]))))
    words = N_("{run}: as it was recorded, and below each line replayed")
    if found.other:
        words = N_("{run}: as it was recorded, and below each line with {other}")
    title = N_(words, run=found.run, other=found.other)
    marks = tuple((us, translate(mark, found.language)) for us, mark in _marks(here, first, last))
    score = MarbleDiagram(translate(title, found.language), tuple(groups), 0, last, marks)
    return stamped([score.between(first, last)], found.stamp)


def _by_stream(
    events: Iterable[RecordedEvent], streams: Sequence[str], first: int, last: int
) -> dict[str, list[Marble]]:
    """Return the values of some streams within a window (µs), in one pass."""
    found: dict[str, list[Marble]] = {stream: [] for stream in streams}
    for e in events:
        if first <= e.us <= last and isinstance(e, RecordedValue) and e.stream in found:
            found[e.stream].append(Marble(e.us, value_from_json(e.stream, e.value), e.row))
    return found


def _marks(here: Sequence[Difference], first: int, last: int) -> tuple[tuple[int, str], ...]:
    """Return marks at the first differences, without those that would stand on each other."""
    marks: list[tuple[int, str]] = []
    for d in here:
        us = d.came_us if d.kind == EXTRA else d.us
        if first <= us <= last and (not marks or us - marks[-1][0] >= (last - first) * _MARKS_APART):
            marks.append((us, _MARKS[d.kind]))
    return tuple(marks[:_MOST_MARKS])


def account(found: Replayed) -> dict[str, Any]:
    """Return what a page shows of a replay, as JSON."""
    robot, language = robot_lines(found), found.language
    each = [] if found.other else each_line(found)

    def told(line: AccountLine) -> dict[str, Any]:
        return {**asdict(line), "when": translate(line.when, language), "text": translate(line.text, language)}

    return {
        "same": found.same, "verdict": translate(verdict(found), language),
        "remarks": [translate(r, language) for r in found.remarks], "ending": translate(found.ending, language),
        "rows": [
            {"whose": translate(line.whose, language), "text": translate(line.text, language), "row": line.row}
            for line in row_lines(found)[:MOST]
        ],
        "robot": [told(line) for line in robot[:MOST]], "robot_left_out": max(0, len(robot) - MOST),
        "each": [told(line) for line in each[:MOST]], "each_left_out": max(0, len(each) - MOST),
        "unknown": [translate(u, language) for u in found.unknown], "differs": bool(found.differences),
        "pictures": [p.svg for p in draw_marbles(difference_scores(found), strips=1)[:_MOST_PICTURES]],
    }  # fmt: skip
