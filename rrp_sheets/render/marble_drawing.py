"""Draws marble diagrams as SVG: a line for each stream, a bar for each row, strips of time below each other."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise

from rrp_sheets.model.values import show
from rrp_sheets.render.diagram import Page
from rrp_sheets.render.marble_diagram import (
    Bar,
    Group,
    Lane,
    Marble,
    MarbleDiagram,
    fitting,
    nice_step,
    seconds_label,
    short,
)
from rrp_sheets.render.style import (
    BADGE,
    DASHES,
    EDGE,
    FILL_AND_LINE,
    FLAG,
    INK,
    LANDSCAPE,
    LEAST_SCALE,
    MONO_PT,
    OFF_LINE,
    SMALL_PT,
    SOFT,
    clean,
    escape,
    shortened,
    width,
    wrap,
)
from rrp_sheets.render.svg import draw_icon, frame, text
from rrp_sheets.render.texts import Texts, texts

WIDE = LANDSCAPE[0]
_LABEL = 118.0  # points for the streams' names
_RIGHT = 10.0
_AXIS = 17.0
_BAR = 14.0
_GAP = 12.0
_LEGEND = 20.0
_TALLEST = LANDSCAPE[1] / LEAST_SCALE  # points; made smaller by so much a page can still be read
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
        blocks = [b for strip in _strips(score, strips) for b in _blocks(strip, score)]
        sheets = list(_sheets(blocks))
        for part, sheet in enumerate(sheets, 1):
            pages.append(_page(score, sheet, f"m{number}p{part}", (part, len(sheets))))
    return pages


def _strips(score: MarbleDiagram, count: int) -> list[MarbleDiagram]:
    span = max(1, score.last_us - score.first_us)
    if count <= 0:
        room = WIDE - _LABEL - _RIGHT
        busiest = max((len({m.us for m in lane.marbles}) for lane in score.lanes), default=0)
        count = min(_MOST_STRIPS, max(1, round(busiest * _WANTED_GAP / room + 0.35)))
    edges = [score.first_us + span * i // count for i in range(count + 1)]
    return [score.between(a, b if b == edges[-1] else b - 1) for a, b in pairwise(edges)]


def _blocks(strip: MarbleDiagram, whole: MarbleDiagram) -> Iterator[_Block]:
    """Yield the streams of a strip in blocks that fit on a page; rows are drawn in the first strip only."""
    first = strip.first_us == whole.first_us
    room = _TALLEST - _AXIS - _LEGEND - _GAP - 2
    x = _span(strip)
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
    """Group blocks by page."""
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


def _page(score: MarbleDiagram, sheet: Sequence[_Block], ident: str, of: tuple[int, int]) -> Page:
    part, parts = of
    pieces: list[str] = []
    y = 2.0
    for block in sheet:
        pieces.append(_draw_block(block, y))
        y += block.height + _GAP
    pieces.append(_legend(y, texts(score.language)))
    high = y + _LEGEND
    for words in wrap(clean(score.foot), _FOOT, 2) if score.foot else ():
        pieces.append(text(14, high + 5, words, 7, fill=SOFT))
        high += 10
    alt = _alt(score)
    svg = frame("\n".join(pieces), WIDE, high, ident=ident, title=clean(score.title), description=alt)
    caption = texts(score.language).get("marbles.part", part=part, parts=parts) if parts > 1 else ""
    rows = [b.row for g in score.groups for b in g.bars]
    return Page(
        title=clean(score.title), caption=caption, svg=svg, dot="", width=WIDE, height=high,
        scale=min(1.0, LANDSCAPE[1] / high), landscape=True,
        rows=(min(rows, default=0), max(rows, default=0)), alt=alt, part=part, parts=parts,
    )  # fmt: skip


def _alt(score: MarbleDiagram) -> str:
    words_of = texts(score.language)
    nameless = words_of.get("marbles.nameless")
    streams = [f"{lane.label or nameless} ({len(lane.marbles)})" for lane in score.lanes[:40]]
    first, last = seconds_label(score.first_us / 1e6), seconds_label(score.last_us / 1e6)
    alt = words_of.get("marbles.alt", title=score.title, first=first, last=last, list=words_of.in_a_row(streams))
    return clean(alt)


def _span(score: MarbleDiagram) -> Span:
    return Span(score.first_us, max(score.last_us, score.first_us + 1), _LABEL + 6, WIDE - _RIGHT)


def _draw_block(block: _Block, top: float) -> str:
    x = _span(block.score)
    bottom = top + _AXIS + sum(block.heights)
    parts = list(_axis(x, top, bottom))
    y = top + _AXIS
    for group, high in zip(block.groups, block.heights, strict=True):
        base = y
        if block.bars and group.bars:
            for bar in group.bars:
                parts.append(_draw_bar(bar, x, base))
                base += _BAR
            base += 3
        parts.append(_label(group, y + high, named=not block.bars))
        parts.append(_draw_lane(group.lane, x, y + high, texts(block.score.language)))
        y += high
    if block.marks:
        parts += _pointers(block.score, x, bottom)
    return "\n".join(parts)


def _axis(x: Span, top: float, bottom: float) -> Iterator[str]:
    step = nice_step((x.last - x.first) / 1e6, max(2, int((x.right - x.left) / _LABELS_APART)))
    number = -(-x.first // round(step * 1e6))
    while number * step * 1e6 <= x.last:
        at = x.at(round(number * step * 1e6))
        yield f'<path d="M{at:.1f} {top + 12:.1f}V{bottom:.1f}" stroke="#dcdcdc" stroke-width="0.6"/>'
        yield text(at, top + 9, seconds_label(number * step), SMALL_PT, fill=SOFT, middle=True)
        number += 1


def _draw_bar(bar: Bar, x: Span, y: float) -> str:
    """Draw a row between the streams: number, icon, inputs, connector and formula; ticks of its clock below."""
    ink = OFF_LINE if bar.off else INK
    left, high = 3.0, _BAR - 1.5
    parts = [
        f'<rect x="{left}" y="{y:.1f}" width="{x.right - left:.1f}" height="{high}" rx="2.5" fill="#f4f2ee" '
        f'stroke="#c9c4ba" stroke-width="0.6"/>',
        _badge(bar, left, y, high) if bar.row else "",
        draw_icon(bar.icon, left + 20, y + 1.2, ink, 0.85),
    ]
    inputs = shortened(", ".join(clean(i) for i in bar.inputs), 190, partial(width, size=SMALL_PT))
    words = f"{inputs} → {bar.connector}"
    parts.append(text(left + 33, y + 9.2, words, SMALL_PT, fill=ink))
    if bar.formula:
        start = left + 33 + width(words, SMALL_PT) + 8
        formula = shortened(clean(bar.formula), x.right - start - 6, partial(width, size=MONO_PT, mono=True))
        parts.append(text(start, y + 9.2, formula, MONO_PT, fill=ink, mono=True))
    parts += [
        f'<path d="M{x.at(t):.1f} {y + high - 4:.1f}v5.5" stroke="{FLAG}" stroke-width="1.1"/>'
        for t in bar.ticks if x.holds(t)
    ]  # fmt: skip
    return "".join(parts)


def _badge(bar: Bar, x: float, y: float, high: float) -> str:
    colour, size = OFF_LINE if bar.off else BADGE, 8 if bar.row < 1000 else 6.5
    box = f'<rect x="{x}" y="{y:.1f}" width="17" height="{high}" rx="2.5" fill="{colour}"/>'
    return box + text(x + 8.5, y + 9.3, str(bar.row), size, fill="#fff", bold=True, middle=True)


def _label(group: Group, bottom: float, *, named: bool) -> str:
    """Draw the stream's name with its sign, and in later strips the numbers of its rows."""
    lane = group.lane
    base = bottom - 11.0
    fill, line = FILL_AND_LINE.get(lane.kind, ("#fff", INK))
    name = clean(lane.label)
    rows = f" {', '.join(str(b.row) for b in group.bars[:3])}" if named and group.bars else ""
    shown = shortened(name, _LABEL - 22 - width(rows, 7.5), partial(width, size=9.5))
    parts = [_sign(lane.kind, 8.0, base, fill, line)]
    if shown:
        parts.append(text(17, base + 3.2, shown, 9.5, bold=lane.kind != "stream"))
    if rows:
        at = 17 + (width(shown, 9.5, bold=True) if shown else 0)
        parts.append(text(at, base + 3.2, rows, 7.5, fill=SOFT))
    return f'<g class="label">{"<title>" + escape(name) + "</title>" if shown != name else ""}{"".join(parts)}</g>'


def _sign(kind: str, x: float, y: float, fill: str, line: str) -> str:
    if kind == "stream":
        return f'<ellipse cx="{x}" cy="{y:.1f}" rx="5" ry="4.2" fill="{fill}" stroke="{line}" stroke-width="1.2"/>'
    if kind == "anonymous":
        return f'<circle cx="{x}" cy="{y:.1f}" r="2.2" fill="{INK}"/>'
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
        words = clean(", ".join(found[:3]) + (" …" if len(found) > 3 else ""))
        wide = width(words, 7.5)
        left = at + 5 if at + 5 + wide < x.right + _RIGHT else at - 5 - wide
        yield f'<path d="M{at:.1f} {y + 1:.1f}l3 5.5h-6z" fill="{FLAG}"/>'
        if left > taken:
            yield text(left, y + 7.5, words, 7.5, fill=FLAG)
            taken = left + wide


def _legend(y: float, words_of: Texts) -> str:
    """Draw the meanings of the signs on one line."""
    signs = tuple((kind, words_of.get(f"marbles.{kind}")) for kind in ("sensor", "stream", "actuator", "done"))
    x, parts = 10.0, [f'<path d="M3 {y + 1:.1f}H{WIDE - _RIGHT:.1f}" stroke="#c9c4ba" stroke-width="0.6"/>']
    for kind, words in signs:
        fill, line = FILL_AND_LINE.get(kind, ("#fff", INK))
        parts += [_sign(kind, x, y + 10, fill, line), text(x + 9, y + 13, words, SMALL_PT, fill=SOFT)]
        x += width(words, SMALL_PT) + 30
    cross = f"M{x - 3:.1f} {y + 7:.1f}l6 6m0 -6l-6 6"
    parts += [f'<path d="{cross}" stroke="{FLAG}" stroke-width="1.6"/>',
              text(x + 8, y + 13, words_of.get("marbles.error"), SMALL_PT, fill=SOFT)]  # fmt: skip
    x += width(words_of.get("marbles.error"), SMALL_PT) + 24
    clock = words_of.get("marbles.clock")
    parts += [f'<path d="M{x:.1f} {y + 7:.1f}v6" stroke="{FLAG}" stroke-width="1.1"/>',
              text(x + 6, y + 13, clock, SMALL_PT, fill=SOFT)]  # fmt: skip
    x += width(clock, SMALL_PT) + 24
    parts += [f'<path d="M{x - 4:.1f} {y + 10:.1f}h22" stroke="{EDGE}" stroke-width="6" stroke-dasharray="1 1.2"/>',
              text(x + 23, y + 13, words_of.get("marbles.many"), SMALL_PT, fill=SOFT)]  # fmt: skip
    return "".join(parts)


_LANE = 21.0
_HIGH = 12.5  # of a marble
_STEP = 14.0  # from one of several at one time to the next
_MOST_STACKED = 4
_LEAST = 3.2  # points between two marbles that are drawn apart
_VALUE_PT = 7.5
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
    by_time: dict[int, list[Marble]] = {}
    for marble in lane.marbles:
        by_time.setdefault(marble.us, []).append(marble)
    single = [_Place(x.at(us), tuple(found)) for us, found in sorted(by_time.items())]
    return list(_crowds(single))


def _crowds(places: Sequence[_Place]) -> Iterator[_Place]:
    """Turn runs of marbles that are too close to each other into bands."""
    run: list[_Place] = []
    for place in places:
        if run and place.x - run[-1].x >= _LEAST:
            yield from _band(run)
            run = []
        run.append(place)
    yield from _band(run)


def _band(run: list[_Place]) -> list[_Place]:
    if len(run) < 2 or (len(run) < _CROWD and run[-1].x - run[0].x > 2 * _LEAST):
        return run
    return [_Place(run[0].x, tuple(m for p in run for m in p.marbles), run[-1].x)]


def _draw_lane(lane: Lane, x: Span, bottom: float, words_of: Texts) -> str:
    """Draw a stream's line with its marbles; `bottom` is where the next one begins."""
    base = bottom - 11.0
    fill, line = FILL_AND_LINE.get(lane.kind, ("#ececec", INK))
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
            parts.append(_draw_band(place, lane, base, (fill, line), words_of))
            continue
        for level, marble in enumerate(place.marbles[:_MOST_STACKED]):
            y = base - level * _STEP
            more = len(place.marbles) - _MOST_STACKED if level == _MOST_STACKED - 1 else 0
            parts.append(_draw_marble(marble, lane, place.x, y, (gap, end - place.x), (fill, line), more))
    return f'<g class="lane {lane.kind}" data-stream="{escape(clean(lane.label or lane.id))}">{"".join(parts)}</g>'


def _told(marble: Marble) -> str:
    """Return the tooltip of a marble: time, row, and value or error."""
    when = f"{marble.us / 1e6:g} s"
    row = f", {marble.row}" if marble.row else ""
    return escape(clean(f"{when}{row}: {marble.error or show(marble.value, 400)}"))


def _draw_marble(
    marble: Marble, lane: Lane, x: float, y: float, gaps: tuple[float, float], colours: tuple[str, str], more: int
) -> str:
    before, room = gaps
    title = f"<title>{_told(marble)}</title>"
    if marble.error:
        reason = shortened(clean(marble.error[:200]), room - 12, _measure) if room > 40 else ""
        cross = f'<path d="M{x - 3.6:.1f} {y - 3.6:.1f}l7.2 7.2m0 -7.2l-7.2 7.2" stroke="{FLAG}" stroke-width="1.8"/>'
        words = _on_white(x + 6.5, y + 2.8, reason, SMALL_PT - 1) if reason else ""
        return f'<g class="error">{title}{cross}{words}</g>'
    size = _VALUE_PT
    half = min(_HIGH / 2, max(1.1, min(before, room) / 2 - 0.5))
    shown = f"+{more + 1}" if more else fitting(marble.value, min(_LONGEST, room - 0.8) - 5.5, _measure, 16)
    long = max(2 * half, width(shown, size) + 5.5) if shown else 2 * half
    blank = marble.value is None and not more
    return (
        f'<g class="marble">{title}{_shape(lane.kind, x - half, y, long, colours, blank=blank)}'
        + (text(x - half + long / 2, y + 2.7, shown, size, middle=True) if shown else "")
        + "</g>"
    )


def _measure(words: str) -> float:
    return width(words, _VALUE_PT)


def _on_white(x: float, y: float, words: str, size: float) -> str:
    back = f'<rect x="{x - 1:.1f}" y="{y - 6.6:.1f}" width="{width(words, size) + 2:.1f}" height="8.4" fill="#fff"/>'
    return back + text(x, y, words, size, fill=FLAG, italic=True)


def _shape(kind: str, x: float, y: float, long: float, colours: tuple[str, str], *, blank: bool) -> str:
    """Draw a marble from `x` on: round for streams, square for sensors, double for actuators, dashed for ends."""
    fill, line = ("#fff", colours[1]) if blank else colours
    high = min(_HIGH, long) if long < _HIGH else _HIGH
    radius = high / 2 if kind in ("stream", "anonymous") else 1.5
    look = f'x="{x:.1f}" y="{y - high / 2:.1f}" width="{long:.1f}" height="{high:.1f}" rx="{radius:.1f}"'
    if kind == "actuator" and high > 7:
        outer = f'<rect {look} fill="#fff" stroke="{line}" stroke-width="0.9"/>'
        inner = f'x="{x + 1.6:.1f}" y="{y - high / 2 + 1.6:.1f}" width="{long - 3.2:.1f}" height="{high - 3.2:.1f}"'
        return f'{outer}<rect {inner} fill="{fill}" stroke="{line}" stroke-width="0.6"/>'
    dashes = f' stroke-dasharray="{DASHES}"' if kind == "done" or blank else ""
    thick = 1.5 if kind == "sensor" else 1.0
    return f'<rect {look} fill="{fill}" stroke="{line}" stroke-width="{thick}"{dashes}/>'


def _draw_band(place: _Place, lane: Lane, base: float, colours: tuple[str, str], words_of: Texts) -> str:
    """Draw many values as a hatched band, with their number and the first and the last of them."""
    marbles = place.marbles
    good = [m for m in marbles if not m.error]
    fill, line = colours
    x, wide = place.x - 1.5, max(place.end - place.x, 2) + 3
    failed = len(marbles) - len(good)
    told = []
    if good:
        first, last = (f"{m.us / 1e6:g}" for m in (marbles[0], marbles[-1]))
        values = f"{short(good[0].value)[:40]} … {short(good[-1].value)[:40]}"
        told.append(words_of.get("marbles.band", n=len(good), first=first, last=last, values=values))
    if failed:
        told.append(words_of.get("marbles.band_errors", n=failed, why=next(m.error for m in marbles if m.error)))
    parts = [
        f"<title>{escape(clean(' '.join(told)))}</title>",
        f'<rect x="{x:.1f}" y="{base - 5:.1f}" width="{wide:.1f}" height="10" fill="{fill}" stroke="{line}" '
        f'stroke-width="{0.6 if lane.kind == "stream" else 1.1}"/>',
    ]
    marks = sorted({round(x + 1.5 + (m.us - marbles[0].us) * (wide - 3) / max(1, marbles[-1].us - marbles[0].us), 0)
                    for m in good})  # fmt: skip
    strokes = "".join(f"M{at:.0f} {base - 5:.1f}v10" for at in marks[:: max(1, len(marks) * 2 // int(wide + 1) or 1)])
    if strokes:
        parts.append(f'<path d="{strokes}" stroke="{line}" stroke-width="0.45" opacity="0.7"/>')
    if failed:
        parts.append(f'<path d="M{x:.1f} {base + 6.5:.1f}h{wide:.1f}" stroke="{FLAG}" stroke-width="1.8"/>')
    parts.append(_band_label(marbles, good, (x + wide / 2, base), wide, words_of))
    return f'<g class="band">{"".join(parts)}</g>'


def _band_label(
    marbles: Sequence[Marble], good: Sequence[Marble], at: tuple[float, float], room: float, words_of: Texts
) -> str:
    """Draw the number of values and their range, as far as they fit."""
    (middle, base), n = at, len(marbles)
    values = _range(good) or words_of.get("marbles.errors")
    whole, short_form = words_of.get("marbles.values_are", n=n, values=values), words_of.get("marbles.values", n=n)
    for words in (whole, short_form, str(n)):
        wide = width(words, 7) + 5
        if wide < room:
            back = f'x="{middle - wide / 2:.1f}" y="{base - 4:.1f}" width="{wide:.1f}" height="8" rx="1.5"'
            box = f'<rect {back} fill="#fff" stroke="{EDGE}" stroke-width="0.3"/>'
            return box + text(middle, base + 2.5, words, 7, middle=True)
    return ""


def _range(marbles: Sequence[Marble]) -> str:
    """Return the first and the last value, shortened; empty when there is none."""
    if not marbles:
        return ""
    first, last = short(marbles[0].value)[:14], short(marbles[-1].value)[:14]
    return first if first == last else f"{first} … {last}"
