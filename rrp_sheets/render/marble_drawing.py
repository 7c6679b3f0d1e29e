"""Draws marble diagrams as SVG: a line for each stream, a bar for each row, strips of time below each other."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import groupby, pairwise
from operator import attrgetter

from rrp_sheets.model.values import show
from rrp_sheets.render import style
from rrp_sheets.render.diagram import Page
from rrp_sheets.render.marble_diagram import (
    Bar,
    Group,
    Lane,
    Marble,
    MarbleDiagram,
    fitting,
    seconds_label,
    short,
    ticks,
)
from rrp_sheets.render.svg import draw_icon, frame, text
from rrp_sheets.render.texts import Texts, texts

WIDE = style.LANDSCAPE[0]
_LABEL = 118.0  # points for the streams' names
_RIGHT = 10.0
_AXIS = 17.0
_BAR = 14.0
_GAP = 12.0
_LEGEND = 20.0
_TALLEST = style.LANDSCAPE[1] / style.LEAST_SCALE  # points; made smaller by so much a page can still be read
_MOST_STRIPS = 6
_WANTED_GAP = 15.0  # points between two marbles of the busiest stream
_LABELS_APART = 48.0
_FOOT = 190  # letters of a line at the foot


@dataclass(frozen=True)
class _Block:
    """Streams of a span of time that fit on one page."""

    score: MarbleDiagram
    groups: tuple[Group, ...]
    bars: bool
    heights: tuple[float, ...]
    marks: bool

    @property
    def height(self) -> float:
        return _AXIS + sum(self.heights) + (12 if self.marks else 0)


def draw_marbles(scores: Sequence[MarbleDiagram], *, strips: int = 0) -> list[Page]:
    """Draw marble diagrams, each from a new page on, its time in `strips`; with 0 the busiest stream says how many."""
    pages: list[Page] = []
    for number, score in enumerate(scores, 1):
        if not score.groups:
            continue
        sheets = list(_sheets([b for strip in _strips(score, strips) for b in _blocks(strip, score)]))
        pages += [_page(score, s, f"m{number}p{n}", n, len(sheets)) for n, s in enumerate(sheets, 1)]
    return pages


def _strips(score: MarbleDiagram, count: int) -> list[MarbleDiagram]:
    span = max(1, score.last_us - score.first_us)
    if count <= 0:
        busiest = max((len({m.us for m in lane.marbles}) for lane in score.lanes), default=0)
        count = min(_MOST_STRIPS, max(1, round(busiest * _WANTED_GAP / (WIDE - _LABEL - _RIGHT) + 0.35)))
    edges = [score.first_us + span * i // count for i in range(count + 1)]
    return [score.between(a, b if b == edges[-1] else b - 1) for a, b in pairwise(edges)]


def _blocks(strip: MarbleDiagram, whole: MarbleDiagram) -> Iterator[_Block]:
    """Yield the streams of a strip in blocks that fit on a page; rows are drawn in the first strip only."""
    first, x = strip.first_us == whole.first_us, _span(strip)
    room = _TALLEST - _AXIS - _LEGEND - _GAP - 2
    marked = any(strip.first_us <= us <= strip.last_us for us, _ in strip.marks)
    groups: list[Group] = []
    heights: list[float] = []
    for group in strip.groups:
        high = lane_height(group.lane, x) + (_BAR * len(group.bars) + 3 if first and group.bars else 0)
        if groups and sum(heights) + high > room:
            yield _Block(strip, tuple(groups), first, tuple(heights), False)
            groups, heights = [], []
        groups.append(group)
        heights.append(high)
    yield _Block(strip, tuple(groups), first, tuple(heights), marked)


def _sheets(blocks: Sequence[_Block]) -> Iterator[list[_Block]]:
    sheet: list[_Block] = []
    used = 0.0
    for block in blocks:
        if sheet and used + block.height + _GAP > _TALLEST - _LEGEND:
            yield sheet
            sheet, used = [], 0.0
        sheet.append(block)
        used += block.height + _GAP
    if sheet:
        yield sheet


def _page(score: MarbleDiagram, sheet: Sequence[_Block], ident: str, part: int, parts: int) -> Page:
    words_of, title = texts(score.language), style.clean(score.title)
    pieces: list[str] = []
    y = 2.0
    for block in sheet:
        pieces.append(_draw_block(block, y))
        y += block.height + _GAP
    pieces.append(_legend(y, words_of))
    high = y + _LEGEND
    for words in style.wrap(style.clean(score.foot), _FOOT, 2) if score.foot else ():
        pieces.append(text(14, high + 5, words, 7, fill=style.SOFT))
        high += 10
    nameless = words_of.get("marbles.nameless")
    streams = words_of.in_a_row([f"{lane.label or nameless} ({len(lane.marbles)})" for lane in score.lanes[:40]])
    first, last = seconds_label(score.first_us / 1e6), seconds_label(score.last_us / 1e6)
    alt = style.clean(words_of.get("marbles.alt", title=score.title, first=first, last=last, list=streams))
    rows = [b.row for g in score.groups for b in g.bars]
    return Page(
        title, words_of.get("marbles.part", part=part, parts=parts) if parts > 1 else "",
        frame("\n".join(pieces), WIDE, high, ident=ident, title=title, description=alt), "", WIDE, high,
        min(1.0, style.LANDSCAPE[1] / high), True, (min(rows, default=0), max(rows, default=0)), alt, part, parts,
    )  # fmt: skip


def _span(score: MarbleDiagram) -> Span:
    return Span(score.first_us, max(score.last_us, score.first_us + 1), _LABEL + 6, WIDE - _RIGHT)


def _draw_block(block: _Block, top: float) -> str:
    x, y = _span(block.score), top + _AXIS
    bottom = top + _AXIS + sum(block.heights)
    parts = []
    for us, label in ticks(x.first, x.last, int((x.right - x.left) / _LABELS_APART)):
        at = x.at(us)
        parts.append(f'<path d="M{at:.1f} {top + 12:.1f}V{bottom:.1f}" stroke="#dcdcdc" stroke-width="0.6"/>')
        parts.append(text(at, top + 9, label, style.SMALL_PT, fill=style.SOFT, middle=True))
    for group, high in zip(block.groups, block.heights, strict=True):
        base = y
        for bar in group.bars if block.bars else ():
            parts.append(_draw_bar(bar, x, base))
            base += _BAR
        y += high
        parts.append(_label(group, y, named=not block.bars))
        parts.append(_draw_lane(group.lane, x, y, texts(block.score.language)))
    if block.marks:
        parts += _pointers(block.score, x, bottom)
    return "\n".join(parts)


def _draw_bar(bar: Bar, x: Span, y: float) -> str:
    """Draw a row between the streams: number, icon, inputs, connector and formula; ticks of its clock below."""
    ink = style.OFF_LINE if bar.off else style.INK
    left, high = 3.0, _BAR - 1.5
    inputs = style.cut(", ".join(map(style.clean, bar.inputs)), 190, style.SMALL_PT)
    words = f"{inputs} → {bar.connector}"
    place = f'x="{left}" y="{y:.1f}" width="{x.right - left:.1f}" height="{high}" rx="2.5"'
    parts = [f'<rect {place} fill="#f4f2ee" stroke="#c9c4ba" stroke-width="0.6"/>']
    if bar.row:
        badge, size = style.OFF_LINE if bar.off else style.BADGE, 8 if bar.row < 1000 else 6.5
        parts.append(f'<rect x="{left}" y="{y:.1f}" width="17" height="{high}" rx="2.5" fill="{badge}"/>')
        parts.append(text(left + 8.5, y + 9.3, str(bar.row), size, fill="#fff", bold=True, middle=True))
    parts += [
        draw_icon(bar.icon, left + 20, y + 1.2, ink, 0.85),
        text(left + 33, y + 9.2, words, style.SMALL_PT, fill=ink),
    ]
    if bar.formula:
        start = left + 33 + style.width(words, style.SMALL_PT) + 8
        formula = style.cut(style.clean(bar.formula), x.right - start - 6, style.MONO_PT, mono=True)
        parts.append(text(start, y + 9.2, formula, style.MONO_PT, fill=ink, mono=True))
    parts += [
        f'<path d="M{x.at(t):.1f} {y + high - 4:.1f}v5.5" stroke="{style.FLAG}" stroke-width="1.1"/>'
        for t in bar.ticks if x.holds(t)
    ]  # fmt: skip
    return "".join(parts)


def _label(group: Group, bottom: float, *, named: bool) -> str:
    """Draw the stream's name with its sign, and in later strips the numbers of its rows."""
    lane, base = group.lane, bottom - 11.0
    name = style.clean(lane.label)
    rows = f" {', '.join(str(b.row) for b in group.bars[:3])}" if named and group.bars else ""
    shown = style.cut(name, _LABEL - 22 - style.width(rows, 7.5), 9.5)
    parts = [_sign(lane.kind, 8.0, base)]
    if shown:
        parts.append(text(17, base + 3.2, shown, 9.5, bold=lane.kind != "stream"))
    if rows:
        at = 17 + (style.width(shown, 9.5, bold=True) if shown else 0)
        parts.append(text(at, base + 3.2, rows, 7.5, fill=style.SOFT))
    title = f"<title>{style.escape(name)}</title>" if shown != name else ""
    return f'<g class="label">{title}{"".join(parts)}</g>'


def _sign(kind: str, x: float, y: float) -> str:
    fill, line = style.FILL_AND_LINE.get(kind, ("#fff", style.INK))
    if kind == "stream":
        return f'<ellipse cx="{x}" cy="{y:.1f}" rx="5" ry="4.2" fill="{fill}" stroke="{line}" stroke-width="1.2"/>'
    if kind == "anonymous":
        return f'<circle cx="{x}" cy="{y:.1f}" r="2.2" fill="{style.INK}"/>'
    box = f'<rect x="{x - 5}" y="{y - 4.2:.1f}" width="10" height="8.4" '
    if kind == "actuator":
        inner = f'<rect x="{x - 3}" y="{y - 2.2:.1f}" width="6" height="4.4" fill="{fill}" stroke="{line}"/>'
        return f'{box}fill="#fff" stroke="{line}" stroke-width="1"/>{inner}'
    dashes = ' stroke-dasharray="2 1.4"' if kind == "done" else ""
    return f'{box}fill="{fill}" stroke="{line}" stroke-width="1.6"{dashes}/>'


def _pointers(score: MarbleDiagram, x: Span, y: float) -> Iterator[str]:
    """Yield arrows at the marked times, with the marks of one time together; a text that would overlap is left out."""
    by_time: dict[int, list[str]] = {}
    for us, words in score.marks:
        if x.holds(us):
            by_time.setdefault(us, []).append(words)
    taken = 0.0
    for us, found in sorted(by_time.items()):
        at = x.at(us)
        words = style.clean(", ".join(found[:3]) + (" …" if len(found) > 3 else ""))
        wide = style.width(words, 7.5)
        left = at + 5 if at + 5 + wide < x.right + _RIGHT else at - 5 - wide
        yield f'<path d="M{at:.1f} {y + 1:.1f}l3 5.5h-6z" fill="{style.FLAG}"/>'
        if left > taken:
            yield text(left, y + 7.5, words, 7.5, fill=style.FLAG)
            taken = left + wide


def _legend(y: float, words_of: Texts) -> str:
    """Draw the meanings of the signs on one line."""
    x, parts = 10.0, [f'<path d="M3 {y + 1:.1f}H{WIDE - _RIGHT:.1f}" stroke="#c9c4ba" stroke-width="0.6"/>']
    draw_words = partial(text, y=y + 13, size=style.SMALL_PT, fill=style.SOFT)
    for kind in ("sensor", "stream", "actuator", "done"):
        words = words_of.get(f"marbles.{kind}")
        parts += [_sign(kind, x, y + 10), draw_words(x + 9, words=words)]
        x += style.width(words, style.SMALL_PT) + 30
    error, clock, many = (words_of.get(f"marbles.{name}") for name in ("error", "clock", "many"))
    cross = f"M{x - 3:.1f} {y + 7:.1f}l6 6m0 -6l-6 6"
    parts += [f'<path d="{cross}" stroke="{style.FLAG}" stroke-width="1.6"/>', draw_words(x + 8, words=error)]
    x += style.width(error, style.SMALL_PT) + 24
    tick = f"M{x:.1f} {y + 7:.1f}v6"
    parts += [f'<path d="{tick}" stroke="{style.FLAG}" stroke-width="1.1"/>', draw_words(x + 6, words=clock)]
    x += style.width(clock, style.SMALL_PT) + 24
    band = f"M{x - 4:.1f} {y + 10:.1f}h22"
    dashes = f'stroke="{style.EDGE}" stroke-width="6" stroke-dasharray="1 1.2"'
    parts += [f'<path d="{band}" {dashes}/>', draw_words(x + 23, words=many)]
    return "".join(parts)


_LANE = 21.0
_HIGH = 12.5  # of a marble
_STEP = 14.0  # from one of several at one time to the next
_MOST_STACKED = 4
_LEAST = 3.2  # points between two marbles that are drawn apart
_VALUE_PT = 7.5
_measure = partial(style.width, size=_VALUE_PT)
_LONGEST = 92.0  # points of a marble with a text in it
_AFTER_LAST = 44.0  # points of room for the value of a marble at the very end
_CROWD = 4  # so many marbles at least make a band


@dataclass(frozen=True)
class Span:
    """Conversion of times (µs) to places on the page (points)."""

    first: int
    last: int
    left: float
    right: float

    def at(self, us: int) -> float:
        """Return the place of a time; marbles keep some room to the edges."""
        room = self.right - self.left - 8 - _AFTER_LAST
        return self.left + 8 + (us - self.first) * room / (self.last - self.first)

    def holds(self, us: int) -> bool:
        """Return whether a time lies in the span."""
        return self.first <= us <= self.last


@dataclass(frozen=True)
class _Place:
    """Marbles of one time, or (a band) marbles that are too close to be drawn apart."""

    x: float
    marbles: tuple[Marble, ...]
    end: float = -1.0  # of a band


def lane_height(lane: Lane, x: Span) -> float:
    """Return the height of a stream's line: more where several values came at one time."""
    most = max((len(p.marbles) for p in _places(lane, x) if p.end < 0), default=1)
    return _LANE + _STEP * (min(max(most, 1), _MOST_STACKED) - 1)


def _places(lane: Lane, x: Span) -> list[_Place]:
    """Return the marbles of a lane by their places; runs of marbles that are too close to each other are bands."""
    runs: list[list[_Place]] = []
    for us, found in groupby(sorted(lane.marbles, key=attrgetter("us")), attrgetter("us")):
        place = _Place(x.at(us), tuple(found))
        if runs and place.x - runs[-1][-1].x < _LEAST:
            runs[-1].append(place)
        else:
            runs.append([place])
    places: list[_Place] = []
    for run in runs:
        if len(run) < 2 or (len(run) < _CROWD and run[-1].x - run[0].x > 2 * _LEAST):
            places += run
        else:
            places.append(_Place(run[0].x, tuple(m for p in run for m in p.marbles), run[-1].x))
    return places


def _draw_lane(lane: Lane, x: Span, bottom: float, words_of: Texts) -> str:
    """Draw a stream's line with its marbles; `bottom` is where the next one begins."""
    base = bottom - 11.0
    colours = style.FILL_AND_LINE.get(lane.kind, ("#ececec", style.INK))
    line = colours[1]
    parts = [
        f'<path d="M{x.left:.1f} {base:.1f}H{x.right:.1f}" stroke="{line}" stroke-width="0.9"/>',
        f'<path d="M{x.right - 5:.1f} {base - 2.6:.1f}l5 2.6l-5 2.6" fill="none" stroke="{line}" stroke-width="0.9"/>',
    ]
    places = _places(lane, x)
    before = x.left - _HIGH
    for place, following in zip(places, [*places[1:], None], strict=False):
        end = following.x if following else x.right + 2
        gap, before = place.x - before, max(place.x, place.end)
        if place.end >= 0:
            parts.append(_draw_band(place, lane, base, colours, words_of))
            continue
        for level, marble in enumerate(place.marbles[:_MOST_STACKED]):
            more = len(place.marbles) - _MOST_STACKED if level == _MOST_STACKED - 1 else 0
            at = (place.x, base - level * _STEP)
            parts.append(_draw_marble(marble, lane, at, (gap, end - place.x), colours, more))
    name = style.escape(style.clean(lane.label or lane.id))
    return f'<g class="lane {lane.kind}" data-stream="{name}">{"".join(parts)}</g>'


def _draw_marble(
    marble: Marble, lane: Lane, at: tuple[float, float], gaps: tuple[float, float], colours: tuple[str, str], more: int
) -> str:
    (x, y), (before, room) = at, gaps
    row = f", {marble.row}" if marble.row else ""
    told = f"{marble.us / 1e6:g} s{row}: {marble.error or show(marble.value, 400)}"
    title = f"<title>{style.escape(style.clean(told))}</title>"
    if marble.error:
        reason = style.shortened(style.clean(marble.error[:200]), room - 12, _measure) if room > 40 else ""
        cross = f"M{x - 3.6:.1f} {y - 3.6:.1f}l7.2 7.2m0 -7.2l-7.2 7.2"
        words, size = "", style.SMALL_PT - 1
        if reason:
            wide = style.width(reason, size) + 2
            words = f'<rect x="{x + 5.5:.1f}" y="{y - 3.8:.1f}" width="{wide:.1f}" height="8.4" fill="#fff"/>'
            words += text(x + 6.5, y + 2.8, reason, size, fill=style.FLAG, italic=True)
        return f'<g class="error">{title}<path d="{cross}" stroke="{style.FLAG}" stroke-width="1.8"/>{words}</g>'
    half = min(_HIGH / 2, max(1.1, min(before, room) / 2 - 0.5))
    shown = f"+{more + 1}" if more else fitting(marble.value, min(_LONGEST, room - 0.8) - 5.5, _measure, 16)
    long = max(2 * half, _measure(shown) + 5.5) if shown else 2 * half
    shape = _shape(lane.kind, x - half, y, long, colours, blank=marble.value is None and not more)
    words = text(x - half + long / 2, y + 2.7, shown, _VALUE_PT, middle=True) if shown else ""
    return f'<g class="marble">{title}{shape}{words}</g>'


def _shape(kind: str, x: float, y: float, long: float, colours: tuple[str, str], *, blank: bool) -> str:
    """Draw a marble from `x` on: round for streams, square for sensors, double for actuators, dashed for ends."""
    fill, line = ("#fff", colours[1]) if blank else colours
    high = min(_HIGH, long)
    radius = high / 2 if kind in ("stream", "anonymous") else 1.5
    look = f'x="{x:.1f}" y="{y - high / 2:.1f}" width="{long:.1f}" height="{high:.1f}" rx="{radius:.1f}"'
    if kind == "actuator" and high > 7:
        outer = f'<rect {look} fill="#fff" stroke="{line}" stroke-width="0.9"/>'
        inner = f'x="{x + 1.6:.1f}" y="{y - high / 2 + 1.6:.1f}" width="{long - 3.2:.1f}" height="{high - 3.2:.1f}"'
        return f'{outer}<rect {inner} fill="{fill}" stroke="{line}" stroke-width="0.6"/>'
    dashes = f' stroke-dasharray="{style.DASHES}"' if kind == "done" or blank else ""
    thick = 1.5 if kind == "sensor" else 1.0
    return f'<rect {look} fill="{fill}" stroke="{line}" stroke-width="{thick}"{dashes}/>'


def _draw_band(place: _Place, lane: Lane, base: float, colours: tuple[str, str], words_of: Texts) -> str:
    """Draw many values as a hatched band, with their number and the first and the last of them."""
    marbles, (fill, line) = place.marbles, colours
    good, errors = [m for m in marbles if not m.error], [m.error for m in marbles if m.error]
    x, wide = place.x - 1.5, max(place.end - place.x, 2) + 3
    begin, end = marbles[0].us, marbles[-1].us
    told = []
    if good:
        values = f"{short(good[0].value)[:40]} … {short(good[-1].value)[:40]}"
        first, last = f"{begin / 1e6:g}", f"{end / 1e6:g}"
        told.append(words_of.get("marbles.band", n=len(good), first=first, last=last, values=values))
    if errors:
        told.append(words_of.get("marbles.band_errors", n=len(errors), why=errors[0]))
    parts = [
        f"<title>{style.escape(style.clean(' '.join(told)))}</title>",
        f'<rect x="{x:.1f}" y="{base - 5:.1f}" width="{wide:.1f}" height="10" fill="{fill}" stroke="{line}" '
        f'stroke-width="{0.6 if lane.kind == "stream" else 1.1}"/>',
    ]
    marks = sorted({round(x + 1.5 + (m.us - begin) * (wide - 3) / max(1, end - begin), 0) for m in good})
    strokes = "".join(f"M{at:.0f} {base - 5:.1f}v10" for at in marks[:: max(1, len(marks) * 2 // int(wide + 1) or 1)])
    if strokes:
        parts.append(f'<path d="{strokes}" stroke="{line}" stroke-width="0.45" opacity="0.7"/>')
    if errors:
        parts.append(f'<path d="M{x:.1f} {base + 6.5:.1f}h{wide:.1f}" stroke="{style.FLAG}" stroke-width="1.8"/>')
    parts.append(_band_label(len(marbles), good, (x + wide / 2, base), wide, words_of))
    return f'<g class="band">{"".join(parts)}</g>'


def _band_label(n: int, good: Sequence[Marble], at: tuple[float, float], room: float, words_of: Texts) -> str:
    """Draw the number of values and their range, as far as they fit."""
    middle, base = at
    ends = dict.fromkeys(short(m.value)[:14] for m in (good[0], good[-1])) if good else ()
    values = " … ".join(ends) or words_of.get("marbles.errors")
    whole, short_form = words_of.get("marbles.values_are", n=n, values=values), words_of.get("marbles.values", n=n)
    for words in (whole, short_form, str(n)):
        wide = style.width(words, 7) + 5
        if wide < room:
            back = f'x="{middle - wide / 2:.1f}" y="{base - 4:.1f}" width="{wide:.1f}" height="8" rx="1.5"'
            box = f'<rect {back} fill="#fff" stroke="{style.EDGE}" stroke-width="0.3"/>'
            return box + text(middle, base + 2.5, words, 7, middle=True)
    return ""
