"""What a replay found, in words."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from rrp_sheets.diagnostics.languages import told
from rrp_sheets.diagnostics.phrase import Phrase, listed
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


_SAY = {
    MISSING: ("would not have come", "did not come"), VALUE: ("would have had another value", "had another value"),
    TIME: ("would have come at another time", "came at another time"),
    ROW: ("would have come from another row", "came from another row"),
    ORDER: ("would have come in another order", "came in another order"),
}  # fmt: skip
"""What became of an event, by the kind of its difference: with another workbook, and with the one that ran."""


def _plain(text: str, role: str) -> str:
    return text


def as_text(found: Replayed, style: Style = _plain) -> str:
    """The account for people to read, in the language of the workbook that ran.

    Args:
        found: what to tell.
        style: colours a text by its role: `same`, `different`, `head`, `quiet`.
    """

    def say(text: str, role: str = "") -> str:
        words = told(text, found.language)
        return style(words, role) if role else words

    lines = [say(verdict(found), "same" if found.same else "different")]
    lines += [say(remark, "quiet") for remark in found.remarks]
    if found.ending:
        lines.append(say(found.ending))
    if found.differences:
        rows = (say(Phrase("  {whose}: {what}.", whose=line.whose, what=line.text)) for line in row_lines(found))
        lines += ["", say("Row by row:", "head"), *rows]
        robots = robot_lines(found)
        if robots:
            lines += ["", say("The robot:", "head"), *_listed(robots, found.language)]
        else:
            lines += ["", say("What the robot is given stays the same.", "head")]
        if not found.other:
            lines += ["", say("One by one:", "head"), *_listed(each_line(found), found.language)]
    if found.unknown:
        lines += ["", say("What a replay cannot know:", "head"), *(f"  {say(line)}" for line in found.unknown)]
    return "\n".join(lines)


def _listed(lines: Sequence[Told], language: str) -> list[str]:
    shown = [(told(line.when, language), told(line.text, language)) for line in lines[:MOST]]
    wide = max(len(when) for when, _ in shown)
    found = [f"  {when:>{wide}}  {text}" for when, text in shown]
    more = Phrase("… and {n} more", n=f"{len(lines) - MOST:,}")
    return [*found, f"  {told(more, language)}"] if len(lines) > MOST else found


def verdict(found: Replayed) -> str:
    """The one sentence that says whether it is the same."""
    events = _events(found.compared)
    seconds = f"{round(found.seconds, 1):g}"
    if found.same and found.other:
        same = "The same: with {other} {events} of this session would have come as they came."
        return Phrase(same, other=found.other, events=events)
    if found.same:
        return Phrase("The same: {events} in {seconds} s, as they were recorded.", events=events, seconds=seconds)
    if found.other:
        different = "Different: with {other}, {what} in these {seconds} s."
        return Phrase(different, other=found.other, what=_would(found), seconds=seconds)
    first = found.first
    if first is None:
        return Phrase("Different: {what}.", what=_counted(found))
    words = "Different: {what}. The first at {when}: {first}"
    return Phrase(words, what=_counted(found), when=in_seconds(first.us), first=_each(first))


def _events(count: int) -> str:
    return Phrase("{n} event" if count == 1 else "{n} events", n=f"{count:,}")


def _would(found: Replayed) -> str:
    extra = len(found.of(EXTRA))
    others, of = len(found.differences) - extra, f"{found.compared:,}"
    parts: list[str] = []
    if others:
        parts.append(Phrase("{n} of {of} events would not have come as they came", n=f"{others:,}", of=of))
    if extra:
        more = "{n} more would have come" if others or found.compared else "{n} would have come"
        parts.append(Phrase(more, n=f"{extra:,}"))
    return listed(parts, "and") if parts else "the run would have ended otherwise"


def _counted(found: Replayed) -> str:
    extra = len(found.of(EXTRA))
    others, of = len(found.differences) - extra, f"{found.compared:,}"
    parts: list[str] = []
    if others or not extra:
        parts.append(Phrase("{n} of {of} events", n=f"{others:,}", of=of))
    if extra:
        parts.append(Phrase(f"{{n}} that {'was' if extra == 1 else 'were'} not recorded", n=f"{extra:,}"))
    return listed(parts, "and")


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
        words = Phrase("{row} of the session's workbook", row=words)
    elif found.other and not count.row:
        words = Phrase("{row} (new)", row=words)
    elif found.other and count.row != count.came_row:
        words = Phrase("{row} (in the session {was})", row=words, was=count.row.rpartition("!")[2])
    return Phrase("{row} → {name}", row=words, name=name) if name else words


def _times(count: int) -> str:
    return {0: "never", 1: "once"}.get(count) or Phrase("{n} times", n=f"{count:,}")


def _name(stream: str) -> str:
    """A stream's name without its sheet; one without a name has none."""
    name = stream.rpartition("!")[2]
    return "" if name.startswith("#") else name


def _how_many(here: Sequence[Difference], count: Count, found: Replayed) -> str:
    would = bool(found.other)
    if here[0].what == "error":
        failed = "would have failed" if would else "failed"
        words = f"its formula {failed} {{came}}, in the session {{then}}"
        return Phrase(words, came=_times(count.came), then=_times(count.recorded))
    parts: list[str] = []
    for kind, (would_have, did) in _SAY.items():
        number = sum(d.kind == kind for d in here)
        if number:
            head = "{n}" if parts else "{n} of {of} events"
            words = f"{head} {would_have if would else did}"
            parts.append(Phrase(words, n=f"{number:,}", of=f"{count.recorded:,}"))
    extra = sum(d.kind == EXTRA for d in here)
    if extra:
        more = "more " if parts or count.recorded else ""
        noun = "" if parts else "event " if extra == 1 else "events "
        words = f"{{n}} {more}{noun}{'would have come' if would else 'came'}"
        parts.append(Phrase(words, n=f"{extra:,}"))
    return listed(parts)


# ---- one by one
def each_line(found: Replayed) -> list[Told]:
    """Every difference in words."""
    return [Told(in_seconds(d.us), d.us, _each(d), d.came_row or d.row) for d in found.differences]


def _each(d: Difference) -> str:
    row, name = d.came_row or d.row, _name(d.stream)
    where: str = f"“{name}”"
    if row:
        where = Phrase("{row} → {name}", row=in_words(row), name=name) if name else in_words(row)
    recorded, came = (_error(v) if d.what == "error" else shown(v) for v in (d.recorded, d.came))
    if d.kind == ROW:
        words = "{recorded} came from {now} instead of {then}"
        return Phrase(words, recorded=recorded, now=in_words(d.came_row), then=in_words(d.row))
    words = {
        MISSING: "{where}: {recorded} was recorded and did not come",
        EXTRA: "{where}: {came} came and was not recorded",
        VALUE: "{where}: {recorded} was recorded, {came} came",
        TIME: "{where}: {recorded} came at {when} instead",
    }.get(d.kind, "{where}: {recorded} was recorded, {came} came before it")
    return Phrase(words, where=where, recorded=recorded, came=came, when=in_seconds(d.came_us))


def _error(value: Any) -> str:
    return Phrase("the error “{text}”", text=value[0]) if isinstance(value, list) and value else shown(value)
