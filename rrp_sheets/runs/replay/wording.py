"""What a replay found, in words."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from rrp_sheets.runs.replay.differences import EXTRA, MISSING, ORDER, ROW, TIME, VALUE, Count, Difference
from rrp_sheets.runs.replay.result import Replayed
from rrp_sheets.runs.replay.wording_robot import robot_lines
from rrp_sheets.runs.replay.words import Told, in_seconds, in_words, shown

MOST = 40  # lines of a list; the JSON and the table have all
Style = Callable[[str, str], str]


@dataclass(frozen=True)
class RowLine:
    """What is different at a row, or of a sensor stream.

    Attributes:
        whose: the row and its stream, in words.
        text: how many of how many.
        row: in the workbook that was played; empty when it is not in it.
    """

    whose: str
    text: str
    row: str


def _plain(text: str, role: str) -> str:
    return text


def as_text(found: Replayed, style: Style = _plain) -> str:
    """The account for people to read.

    Args:
        found: what to tell.
        style: colours a text by its role: `same`, `different`, `head`, `quiet`.
    """
    lines = [style(verdict(found), "same" if found.same else "different")]
    lines += [style(remark, "quiet") for remark in found.remarks]
    if found.ending:
        lines.append(found.ending)
    if found.differences:
        rows = (f"  {line.whose}: {line.text}." for line in row_lines(found))
        lines += ["", style("Row by row:", "head"), *rows]
        robots = robot_lines(found)
        if robots:
            lines += ["", style("The robot:", "head"), *_listed(robots)]
        else:
            lines += ["", style("What the robot is given stays the same.", "head")]
        if not found.other:
            lines += ["", style("One by one:", "head"), *_listed(each_line(found))]
    if found.unknown:
        lines += ["", style("What a replay cannot know:", "head"), *(f"  {line}" for line in found.unknown)]
    return "\n".join(lines)


def _listed(told: Sequence[Told]) -> list[str]:
    wide = max(len(t.when) for t in told[:MOST])
    lines = [f"  {t.when:>{wide}}  {t.text}" for t in told[:MOST]]
    return [*lines, f"  … and {len(told) - MOST:,} more"] if len(told) > MOST else lines


def verdict(found: Replayed) -> str:
    """The one sentence that says whether it is the same."""
    events = f"{found.compared:,} event{'' if found.compared == 1 else 's'}"
    if found.same:
        if found.other:
            return f"The same: with {found.other} {events} of this session would have come as they came."
        return f"The same: {events} in {round(found.seconds, 1):g} s, as they were recorded."
    if found.other:
        return f"Different: with {found.other}, {_would(found)} in these {round(found.seconds, 1):g} s."
    first = found.first
    words = f" The first at {in_seconds(first.us)}: {_each(first)}" if first is not None else ""
    return f"Different: {_counted(found)}.{words}"


def _would(found: Replayed) -> str:
    extra = len(found.of(EXTRA))
    others = len(found.differences) - extra
    parts = [f"{others:,} of {found.compared:,} events would not have come as they came"] if others else []
    if extra:
        parts.append(f"{extra:,} {'more ' if others or found.compared else ''}would have come")
    return " and ".join(parts) if parts else "the run would have ended otherwise"


def _counted(found: Replayed) -> str:
    extra = len(found.of(EXTRA))
    others = len(found.differences) - extra
    parts = [f"{others:,} of {found.compared:,} events"] if others or not extra else []
    if extra:
        parts.append(f"{extra:,} that {'was' if extra == 1 else 'were'} not recorded")
    return " and ".join(parts)


# ---- row by row
def row_lines(found: Replayed) -> list[RowLine]:
    """A line for each row or sensor stream that has differences: how many of how many, in words."""
    of: dict[tuple[str, str, str], list[Difference]] = {}
    for d in found.differences:
        of.setdefault((d.stream, d.row, d.came_row), []).append(d)
    lines = []
    for count in sorted(found.counts, key=_place):
        here = of.pop((count.stream, count.row, count.came_row), [])
        if here:
            lines.append(_row_line(here, count, found))
    for (stream, row, came_row), here in of.items():  # of a row in place of another one
        count = Count(stream, row, came_row, 0, len(here), 0)
        lines.append(_row_line(here, count, found))
    return lines


def _row_line(here: Sequence[Difference], count: Count, found: Replayed) -> RowLine:
    return RowLine(_whose(count, found), _how_many(here, count, found), count.came_row)


def _place(count: Count) -> tuple[str, int, str]:
    sheet, _, number = (count.came_row or count.row).rpartition("!")
    return sheet, int(number) if number.isdecimal() else 0, count.stream


def _whose(count: Count, found: Replayed) -> str:
    """A row and its stream, in words."""
    name = _name(count.stream)
    row = count.came_row or count.row
    if not row:
        return f"“{name}”" if name else "The engine"
    words = in_words(row)
    if found.other and not count.came_row:
        words += " of the session's workbook"
    elif found.other and not count.row:
        words += " (new)"
    elif found.other and count.row != count.came_row:
        words += f" (in the session {in_words(count.row).rpartition(' row ')[2]})"
    return f"{words} → {name}" if name else words


def _times(count: int) -> str:
    return {0: "never", 1: "once"}.get(count, f"{count:,} times")


def _name(stream: str) -> str:
    """A stream's name without its sheet; one without a name has none."""
    name = stream.rpartition("!")[2]
    return "" if name.startswith("#") else name


def _how_many(here: Sequence[Difference], count: Count, found: Replayed) -> str:
    would = bool(found.other)
    if here[0].what == "error":
        times = _times(count.came), _times(count.recorded)
        return f"its formula {'would have failed' if would else 'failed'} {times[0]}, in the session {times[1]}"
    say = {
        MISSING: ("would not have come", "did not come"), VALUE: ("would have had another value", "had another value"),
        TIME: ("would have come at another time", "came at another time"),
        ROW: ("would have come from another row", "came from another row"),
        ORDER: ("would have come in another order", "came in another order"),
    }  # fmt: skip
    parts: list[str] = []
    for kind, words in say.items():
        number = sum(d.kind == kind for d in here)
        if number:
            of = f"{number:,} of {count.recorded:,} events" if not parts else f"{number:,}"
            parts.append(f"{of} {words[0] if would else words[1]}")
    extra = sum(d.kind == EXTRA for d in here)
    if extra:
        more = "more " if parts or count.recorded else ""
        noun = "" if parts else f"event{'' if extra == 1 else 's'} "
        parts.append(f"{extra:,} {more}{noun}{'would have come' if would else 'came'}")
    return ", ".join(parts)


# ---- one by one
def each_line(found: Replayed) -> list[Told]:
    """Every difference in words."""
    return [Told(in_seconds(d.us), d.us, _each(d), d.came_row or d.row) for d in found.differences]


def _each(d: Difference) -> str:
    row = d.came_row or d.row
    where = f"{in_words(row)}{f' → {_name(d.stream)}' if _name(d.stream) else ''}" if row else f"“{_name(d.stream)}”"
    recorded, came = (_error(v) if d.what == "error" else shown(v) for v in (d.recorded, d.came))
    if d.kind == MISSING:
        return f"{where}: {recorded} was recorded and did not come"
    if d.kind == EXTRA:
        return f"{where}: {came} came and was not recorded"
    if d.kind == VALUE:
        return f"{where}: {recorded} was recorded, {came} came"
    if d.kind == TIME:
        return f"{where}: {recorded} came at {in_seconds(d.came_us)} instead"
    if d.kind == ROW:
        return f"{recorded} came from {in_words(d.came_row)} instead of {in_words(d.row)}"
    return f"{where}: {recorded} was recorded, {came} came before it"


def _error(value: Any) -> str:
    return f"the error “{value[0]}”" if isinstance(value, list) and value else shown(value)
