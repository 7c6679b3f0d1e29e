"""Plots of a run's numbers over one time axis, with lanes of events above them, as SVG.

Every plot has one line, and every kind of event has a shape of its own, so that nothing depends on colour alone.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import floor
from statistics import median

from rrp_sheets.render import style
from rrp_sheets.render.marble_diagram import nice_step
from rrp_sheets.render.output import metadata
from rrp_sheets.render.svg import frame, text
from rrp_sheets.render.texts import Texts, texts

WIDE = 780.0  # points, of the whole picture
_LEFT, _RIGHT = 168.0, 18.0
_ROOM = WIDE - _LEFT - _RIGHT  # of a plot, from left to right
_HIGH, _GAP = 58.0, 14.0  # of a plot, and between two
_LANE = 17.0
_FAINT = "#d5d8dc"
_TICKS = 8  # of the time axis, at most
_BREAK = 6.0  # times the usual distance of two points: a line does not go across a longer gap
_OTHER = ' stroke-dasharray="4 2.5"'
_SELDOM = 1.0  # s between two values
_DOTTED = 80  # points: so few are drawn as dots too
_LETTERS = 120  # of a note that are looked at
_MOST_NOTES = 400  # of a lane


@dataclass(frozen=True)
class Curve:
    """Numeric stream, or a numeric field of a stream's records.

    Attributes:
        kind: `sensor`, `stream`, `actuator`.
        unit: `m`; blank when it has none.
        points: seconds and values, perhaps fewer than the `count` that there were.
        other: the points of another run, drawn over these as a dashed line.
    """

    name: str
    kind: str
    unit: str
    points: Sequence[tuple[float, float]]
    count: int
    other: Sequence[tuple[float, float]] = ()


@dataclass(frozen=True)
class PlotNote:
    """Event at `t` seconds, until `until`, in the lane of that name (see `LANES`)."""

    t: float
    until: float
    lane: str
    text: str


LANES = ("said", "heard", "button", "mark", "by_hand", "note", "error")
"""Kinds of notes, in the order of their lanes above the plots."""


def draw_plots(
    title: str, curves: Sequence[Curve], notes: Sequence[PlotNote], seconds: float, *,
    foot: str = "", more: str = "", about: Mapping[str, str] | None = None, legend: tuple[str, str] | None = None,
    language: str = "en",
) -> tuple[str, float, float]:  # fmt: skip
    """Return the picture of a run of so many seconds as SVG, and its width and height in points.

    `foot` says where it comes from and `more` what is not shown; `about` is the SVG's metadata. `legend` names the line
    and the dashed one, when the curves have both; the `language` is that of the picture's own words.
    """
    words_of = texts(language)
    ends = [way[-1][0] for c in curves for way in (c.points, c.other) if way]
    scale = _Scale(max(seconds, *(n.until for n in notes), *ends, 0.001))
    y = 30.0
    heading = style.cut(style.clean(title), WIDE - 28, 13, bold=True)
    pieces = [text(14, 20, heading, 13, bold=True)]
    for number, name in enumerate(legend or ()):
        x = WIDE - 240 + 118 * number
        line = f'fill="none" stroke="{style.INK}" stroke-width="1.4"{_OTHER * number}'
        pieces += [f'<path d="M{x:.1f} 17h24" {line}/>', text(x + 30, 20, name, style.SMALL_PT)]
    lanes = [(lane, [n for n in notes if n.lane == lane]) for lane in LANES]
    lanes = [(lane, found) for lane, found in lanes if found]
    top = y + (_LANE * len(lanes) + 8 if lanes else 0)
    bottom = top + (_HIGH + _GAP) * len(curves)
    pieces += _grid(scale, y, bottom, [n.t for n in notes if n.lane in ("mark", "button")])
    for lane, found in lanes:
        pieces += _lane(scale, lane, words_of.get(f"plots.lane.{lane}"), found, y)
        y += _LANE
    for number, curve in enumerate(curves):
        pieces += _plot(scale, curve, words_of, top + (_HIGH + _GAP) * number)
    y = bottom + 4
    pieces += [text(scale.x(t), y + 6, f"{t:g}", style.SMALL_PT, fill=style.SOFT, middle=True) for t in scale.ticks()]
    pieces.append(text(14, y + 6, words_of.get("plots.time"), style.SMALL_PT, fill=style.SOFT))
    y += 22
    for words in (more, *(piece for part in foot.split("\n") for piece in style.wrap(style.clean(part), 190, 2))):
        if words:
            pieces.append(text(14, y, words, 7, fill=style.SOFT))
            y += 10
    body = metadata(about or {}) + f'<rect width="{WIDE:g}" height="{y:.1f}" fill="#fff"/>' + "\n".join(pieces)
    names = words_of.in_a_row([style.clean(c.name) for c in curves])
    alt = words_of.get("plots.alt", n=len(curves), seconds=f"{seconds:g}", list=names)
    return frame(body, WIDE, y, ident="plots", title=style.clean(title), description=alt), WIDE, y


@dataclass(frozen=True)
class _Scale:
    """Conversion of times (s) to horizontal positions."""

    seconds: float

    def x(self, t: float) -> float:
        return _LEFT + _ROOM * min(max(t, 0.0), self.seconds) / self.seconds

    def ticks(self) -> list[float]:
        step = nice_step(self.seconds, _TICKS)
        return [round(n * step, 9) for n in range(floor(self.seconds / step + 1e-9) + 1)]


def _grid(scale: _Scale, top: float, bottom: float, marked: Sequence[float]) -> Iterator[str]:
    for t in scale.ticks():
        yield _upright(scale.x(t), top, bottom - _GAP + 4, f'stroke="{_FAINT}" stroke-width="0.6"')
    dashed = f'stroke="{style.SOFT}" stroke-width="0.7" stroke-dasharray="2 2"'
    for t in marked[:_MOST_NOTES]:
        yield _upright(scale.x(t), top, bottom - _GAP, dashed)


def _upright(x: float, top: float, bottom: float, looks: str) -> str:
    return f'<path d="M{x:.1f} {top:.1f}V{bottom:.1f}" {looks}/>'


def _lane(scale: _Scale, lane: str, name: str, notes: Sequence[PlotNote], y: float) -> Iterator[str]:
    """Draw a lane of events: a shape for each, and its words where there is room for them."""
    count = f"  {len(notes)}" if len(notes) > 1 else ""
    yield text(14, y + 11, f"{name}{count}", style.SMALL_PT, bold=True)
    free = 0.0
    shown = notes[:: len(notes) // _MOST_NOTES + 1]
    for note, after in zip(shown, [*shown[1:], None], strict=True):
        x = scale.x(note.t)
        if note.until > note.t:
            yield f'<path d="M{x:.1f} {y + 8:.1f}H{scale.x(note.until):.1f}" stroke="{style.INK}" stroke-width="1"/>'
        yield _shape(lane, x, y + 8)
        end = WIDE - 6 if after is None else scale.x(after.t) - 6
        begin = max(x, scale.x(note.until)) + 6
        if begin >= free and end - begin > 24:
            words = style.cut(style.clean(note.text[:_LETTERS]), end - begin, 8)
            if len(words) > 2:
                yield text(begin, y + 11, words, 8)
                free = begin + style.width(words, 8)


def _shape(lane: str, x: float, y: float) -> str:
    filled, line = f'fill="{style.INK}" stroke="#fff" stroke-width="0.5"', f'stroke="{style.INK}"'
    shapes = {
        "said": f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3.6" {filled}/>',
        "heard": f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3" fill="#fff" {line} stroke-width="1.3"/>',
        "button": f'<path d="M{x - 3.2:.1f} {y - 3.2:.1f}h6.4v6.4h-6.4z" {filled}/>',
        "mark": f'<path d="M{x - 4:.1f} {y - 4:.1f}h8l-4 8z" {filled}/>',
        "by_hand": f'<path d="M{x:.1f} {y - 4.4:.1f}l4.4 4.4l-4.4 4.4l-4.4 -4.4z" {filled}/>',
        "note": f'<path d="M{x:.1f} {y - 4:.1f}v8" {line} stroke-width="1.6"/>',
        "error": f'<path d="M{x - 3.4:.1f} {y - 3.4:.1f}l6.8 6.8m0 -6.8l-6.8 6.8" {line} stroke-width="1.8"/>',
    }
    return shapes[lane]


def _plot(scale: _Scale, curve: Curve, words: Texts, top: float) -> Iterator[str]:
    values = [v for way in (curve.points, curve.other) for _, v in way]
    low, high = min(values, default=0.0), max(values, default=0.0)
    line = style.FILL_AND_LINE.get(curve.kind, style.FILL_AND_LINE["stream"])[1]
    pad = (high - low) * 0.06 or abs(high) * 0.05 or 0.5
    bottom, span = low - pad, high - low + 2 * pad

    def place(value: float) -> float:
        return top + _HIGH * (1 - (value - bottom) / span)

    frame_place = f'x="{_LEFT:g}" y="{top:.1f}" width="{_ROOM:.1f}" height="{_HIGH:g}"'
    yield f'<rect {frame_place} fill="none" stroke="{style.EDGE}" stroke-width="0.6"/>'
    if bottom < 0 < bottom + span and low != 0 != high:
        zero = f"M{_LEFT:g} {place(0):.1f}h{_ROOM:.1f}"
        yield f'<path d="{zero}" stroke="{style.SOFT}" stroke-width="0.5" stroke-dasharray="1 3"/>'
    yield from _name(curve, words, top)
    for value in dict.fromkeys((high, low)):
        shown = f"{value:.4g}"
        yield text(_LEFT - 5 - style.width(shown, 8), place(value) + 3, shown, 8, fill=style.SOFT)
    yield from _line(scale, curve.points, place, line, "")
    yield from _line(scale, curve.other, place, style.INK, _OTHER)


def _line(
    scale: _Scale, points: Sequence[tuple[float, float]], place: Callable[[float], float], ink: str, dashes: str
) -> Iterator[str]:
    for run in _unbroken(points):
        if len(run) > 1:
            way = "L".join(f"{scale.x(t):.1f} {place(v):.1f}" for t, v in run)
            yield f'<path d="M{way}" fill="none" stroke="{ink}" stroke-width="1.2" stroke-linejoin="round"{dashes}/>'
        if len(run) == 1 or len(points) <= _DOTTED:
            for t, v in run:
                hollow = f'fill="#fff" stroke="{ink}" stroke-width="0.9"' if dashes else f'fill="{ink}"'
                yield f'<circle cx="{scale.x(t):.1f}" cy="{place(v):.1f}" r="1.7" {hollow}/>'


def _name(curve: Curve, words_of: Texts, top: float) -> Iterator[str]:
    room = _LEFT - 14 - 44  # the numbers of the axis stand at its right
    lines = style.wrap(style.clean(curve.name), 20, 2)
    for number, words in enumerate(lines):
        shown = style.cut(words, room, style.NAME_PT, bold=True)
        yield text(14, top + 12 + 12 * number, shown, style.NAME_PT, bold=True)
    y = top + 12 + 12 * len(lines)
    kind = f"plots.kind.{curve.kind}"
    parts = [words_of.get(kind) if words_of.has(kind) else curve.kind]
    if not curve.other:
        parts.append(words_of.get("plots.values", n=f"{curve.count:,}"))
    told = words_of.in_a_row(parts)
    parts = [told] if style.width(told, 8) <= room else parts
    unit = [words_of.get("plots.unit", unit=curve.unit)] if curve.unit else []
    for words in filter(None, unit + parts):
        yield text(14, y, style.cut(words, room, 8), 8, fill=style.SOFT)
        y += 10


def _unbroken(points: Sequence[tuple[float, float]]) -> Iterator[list[tuple[float, float]]]:
    """Yield the stretches of a curve between its gaps.

    >>> [len(run) for run in _unbroken([(0, 1), (0.1, 1), (0.2, 1), (9, 1), (9.1, 1)])]
    [3, 2]
    """
    gaps = [b[0] - a[0] for a, b in pairwise(points)]
    usual = median(gaps) if gaps else 0.0
    most = max(1.0, _BREAK * usual) if usual <= _SELDOM else 0.0  # what comes seldom is no curve, but single events
    found: list[tuple[float, float]] = []
    for point in points:
        if found and point[0] - found[-1][0] > most:
            yield found
            found = []
        found.append(point)
    if found:
        yield found
