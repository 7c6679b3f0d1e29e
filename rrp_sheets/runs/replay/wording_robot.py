"""What the robot did otherwise, or would have done, in words."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby
from typing import Any

from rrp_sheets.diagnostics.phrase import Phrase
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
        when = Phrase("{first:.10g} to {last}", first=round(_when(first) / 1e6, 2), last=when)
    words = _spoken_words(first, found) if first.stream in found.spoken else _given_words(run, found)
    return Told(when, _when(first), Phrase("{what} ({row})", what=words, row=in_words(row)), row)


def _spoken_words(d: Difference, found: Replayed) -> str:
    own = found.spoken[d.stream].text
    recorded, came = (_quoted(own or value) for value in (d.recorded, d.came))
    would = bool(found.other)
    if d.kind == MISSING and d.recorded is None:
        return "would not have been silenced" if would else "was not silenced"
    if d.kind == EXTRA and d.came is None:
        return "would have been silenced" if would else "was silenced"
    words = {
        MISSING: ("would not have said {recorded}", "did not say {recorded}"),
        EXTRA: ("would have said {came}", "said {came}"),
        TIME: ("would have said {came} at {when} instead", "said {came} at {when} instead"),
        VALUE: ("would have said {came} instead of {recorded}", "said {came} instead of {recorded}"),
    }.get(d.kind, ("would have said it in another order", "said it in another order"))
    return Phrase(words[not would], recorded=recorded, came=came, when=in_seconds(d.came_us))


def _quoted(value: Any) -> str:
    return Phrase("“{text}”", text=value) if isinstance(value, str) else shown(value)


def _given_words(run: Sequence[Difference], found: Replayed) -> str:
    d, many = run[0], len(run)
    would = "would have been" if found.other else "was"
    if d.kind == MISSING:
        would = "would not have been" if found.other else "was not"
    blank = all((r.recorded if d.kind == MISSING else r.came) is None for r in run)
    if blank and d.kind in (MISSING, EXTRA):  # blank stops what it is doing
        words = f"“{{name}}” {would} stopped{' {n} times' if many > 1 else ''}"
    elif d.kind in (MISSING, EXTRA):
        words = f"“{{name}}” {would} given {'{value}' if many == 1 else '{n} values'}"
    elif d.kind == TIME:
        words = f"“{{name}}” {would} given {'{value} at {when} instead' if many == 1 else '{n} values at other times'}"
    elif d.kind == VALUE:
        words = f"“{{name}}” {would} given {'{value} instead of {other}' if many == 1 else '{n} other values'}"
    else:
        words = f"“{{name}}” {would} given its values in another order"
    value = shown(d.recorded if d.kind == MISSING else d.came)
    when = in_seconds(d.came_us)
    return Phrase(words, name=d.stream, n=f"{many:,}", value=value, other=shown(d.recorded), when=when)
