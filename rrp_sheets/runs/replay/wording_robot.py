"""What the robot did otherwise, or would have done, in words."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby
from typing import Any

from rrp_sheets.runs.replay.differences import EXTRA, MISSING, ROW, TIME, VALUE, Difference
from rrp_sheets.runs.replay.result import Replayed
from rrp_sheets.runs.replay.words import Told, in_seconds, in_words, shown

_TOGETHER_US = 2_000_000  # between two of a row that are told in one line


def robot_lines(found: Replayed) -> list[Told]:
    """What the robot would have done otherwise, in the order of time; what goes on is one line."""
    actuators = set(found.actuators)
    mine = [d for d in found.differences if d.stream in actuators and d.what == "event" and d.kind != ROW]
    lines: list[Told] = []
    by_stream = sorted(mine, key=lambda d: (d.stream, d.row, d.came_row))
    for (stream, *_), group in groupby(by_stream, key=lambda d: (d.stream, d.row, d.came_row)):
        for run in _runs(sorted(group, key=_when), spoken=stream in found.spoken):
            lines.append(_robot_line(run, found))
    return sorted(lines, key=lambda t: t.us)


def _when(difference: Difference) -> int:
    return difference.came_us if difference.kind == EXTRA else difference.us


def _runs(here: Sequence[Difference], *, spoken: bool) -> Iterator[list[Difference]]:
    """Differences of one kind that follow each other closely; every sentence of the robot counts by itself."""
    run: list[Difference] = []
    for d in here:
        if run and (spoken or d.kind != run[-1].kind or _when(d) - _when(run[-1]) > _TOGETHER_US):
            yield run
            run = []
        run.append(d)
    if run:
        yield run


def _robot_line(run: Sequence[Difference], found: Replayed) -> Told:
    first, last = run[0], run[-1]
    row = first.came_row or first.row
    when = in_seconds(_when(last), 2)
    if len(run) > 1:
        when = f"{in_seconds(_when(first), 2).removesuffix(' s')} to {when}"
    words = _spoken_words(first, found) if first.stream in found.spoken else _given_words(run, found)
    return Told(when, _when(first), f"{words} ({in_words(row)})", row)


def _spoken_words(d: Difference, found: Replayed) -> str:
    own = found.spoken[d.stream].text
    recorded, came = (_quoted(own or value) for value in (d.recorded, d.came))
    would = bool(found.other)
    if d.kind == MISSING:
        if d.recorded is None:
            return "would not have been silenced" if would else "was not silenced"
        return f"would not have said {recorded}" if would else f"did not say {recorded}"
    if d.kind == EXTRA:
        if d.came is None:
            return "would have been silenced" if would else "was silenced"
        return f"would have said {came}" if would else f"said {came}"
    if d.kind == TIME:
        said = f"said {came} at {in_seconds(d.came_us)} instead"
        return f"would have {said}" if would else said
    if d.kind == VALUE:
        return f"would have said {came} instead of {recorded}" if would else f"said {came} instead of {recorded}"
    return "would have said it in another order" if would else "said it in another order"


def _quoted(value: Any) -> str:
    return f"“{value}”" if isinstance(value, str) else shown(value)


def _given_words(run: Sequence[Difference], found: Replayed) -> str:
    d, many, name = run[0], len(run), f"“{run[0].stream}”"
    would = bool(found.other)
    blank = all((r.recorded if d.kind == MISSING else r.came) is None for r in run)
    if d.kind == MISSING:
        verb = "would not have been" if would else "was not"
    else:
        verb = "would have been" if would else "was"
    if blank and d.kind in (MISSING, EXTRA):  # blank stops what it is doing
        return f"{name} {verb} stopped{f' {many:,} times' if many > 1 else ''}"
    if d.kind in (MISSING, EXTRA):
        what = shown(d.recorded if d.kind == MISSING else d.came) if many == 1 else f"{many:,} values"
    elif d.kind == TIME:
        what = f"{shown(d.came)} at {in_seconds(d.came_us)} instead" if many == 1 else f"{many:,} values at other times"
    elif d.kind == VALUE:
        what = f"{shown(d.came)} instead of {shown(d.recorded)}" if many == 1 else f"{many:,} other values"
    else:
        what = "its values in another order"
    return f"{name} {verb} given {what}"
