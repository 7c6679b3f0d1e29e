"""Marble diagrams in plain text, for terminals."""

from __future__ import annotations

from collections.abc import Sequence

from rrp_sheets.render.marble_diagram import Lane, Marble, MarbleDiagram
from rrp_sheets.render.marble_values import fitting, short
from rrp_sheets.render.measure import clean, columns

_SIGNS = {"sensor": "□", "stream": "○", "anonymous": "·", "actuator": "▣", "done": "◇"}
_LABEL = 20
_MOST_LABEL = 30


def marble_text(score: MarbleDiagram, width: int = 100) -> list[str]:
    """Return the lines of a marble diagram: a time axis, a line for each stream, and the marks.

    Args:
        score: what is drawn.
        width: columns that may be taken.
    """
    if not score.groups:
        return []
    longest = max((columns(_label(lane)) for lane in score.lanes), default=0)
    label = min(max(_LABEL, longest + 1), _MOST_LABEL)
    room = max(20, width - label - 1)
    scale = _Scale(score.first_us, max(score.last_us, score.first_us + 1), room)
    lines = [" " * label + _axis(scale)]
    lines += [_fit(_label(lane), label) + _line(lane, scale) for lane in score.lanes]
    marks = _marks(score.marks, scale)
    if marks:
        lines += [" " * label + line for line in marks]
    return [line.rstrip() for line in lines]


class _Scale:
    """Conversion of times to columns."""

    def __init__(self, first: int, last: int, room: int) -> None:
        self.first, self.last, self.room = first, last, room

    def at(self, us: int) -> int:
        return min(self.room - 1, round((us - self.first) * (self.room - 1) / (self.last - self.first)))


def _label(lane: Lane) -> str:
    return f"{_SIGNS.get(lane.kind, '○')} {clean(lane.label or lane.id.partition('!')[2])}"


def _fit(text: str, wide: int) -> str:
    while columns(text) > wide - 1:
        text = text[:-2].rstrip() + "…"
    return text + " " * (wide - columns(text))


def nice_step(span: float, most: int) -> float:
    """Return a round distance between the labels of an axis that needs at most `most` of them.

    >>> nice_step(10, 6), nice_step(1.3, 10)
    (2.0, 0.2)
    """
    step = 1e-3
    while True:
        for factor in (1, 2, 5):
            if span / (step * factor) <= most:
                return round(step * factor, 9)
        step *= 10


def seconds_label(seconds: float) -> str:
    """Return the label of a time: `0 s`, `2.5 s`."""
    return f"{round(seconds, 3):g} s"


def _axis(scale: _Scale) -> str:
    step = nice_step((scale.last - scale.first) / 1e6, max(2, scale.room // 12))
    line = [" "] * (scale.room + 8)
    number = -(-scale.first // round(step * 1e6))
    while number * step * 1e6 <= scale.last:
        text = seconds_label(number * step)
        at = scale.at(round(number * step * 1e6))
        line[at : at + len(text)] = text
        number += 1
    return "".join(line)


def _line(lane: Lane, scale: _Scale) -> str:
    """Return a stream's line with as much of each value as fits before the next; several in one place: `●2`."""
    places: dict[int, list[Marble]] = {}
    for marble in lane.marbles:
        places.setdefault(scale.at(marble.us), []).append(marble)
    starts = sorted(places)
    line, column = "", 0
    for at, following in zip(starts, [*starts[1:], scale.room + 6], strict=False):
        line += "─" * (at - column)
        shown = _mark(places[at], following - at - 1)
        line += shown
        column = max(at, column) + columns(shown)
    return line + "─" * (scale.room - column)


def _mark(marbles: Sequence[Marble], room: int) -> str:
    if any(m.error for m in marbles):
        return "✗"
    if len(marbles) == 1:
        return fitting(marbles[0].value, room) or "●"
    text = f"({' '.join(short(m.value) for m in marbles)})"
    if columns(text) <= room:
        return text
    return "●" + (str(len(marbles)) if len(marbles) < 10 else "+") if room >= 2 else "●"


def _marks(marks: Sequence[tuple[int, str]], scale: _Scale) -> list[str]:
    """Return the pointers below the lines: `▲ row 9`."""
    rows: list[str] = []
    for us, words in sorted(marks):
        if not scale.first <= us <= scale.last:
            continue
        at, text = scale.at(us), f"▲ {clean(words)}"
        for i, row in enumerate(rows):
            if columns(row) < at:
                rows[i] = row + " " * (at - columns(row)) + text
                break
        else:
            rows.append(" " * at + text)
    return rows[:5]
