"""The marbles of one stream: shapes by kind, values in them as far as they fit, crowds as bands."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from rrp_sheets.model.values import show
from rrp_sheets.render.marble_diagram import Lane, Marble
from rrp_sheets.render.marble_values import cut, fitting, short
from rrp_sheets.render.measure import clean, escape, width
from rrp_sheets.render.style import DASHES, EDGE, FILL_AND_LINE, FLAG, INK, SMALL_PT
from rrp_sheets.render.svg import text

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
    """From times (µs) to places on the page (points)."""

    first: int
    last: int
    left: float
    right: float

    def at(self, us: int) -> float:
        """Where a time is; marbles keep some room to the edges."""
        room = self.right - self.left - 8 - _AFTER_LAST
        return self.left + 8 + (us - self.first) * room / (self.last - self.first)

    def holds(self, us: int) -> bool:
        """Whether a time is in it."""
        return self.first <= us <= self.last


@dataclass(frozen=True)
class _Place:
    """What stands at one time, or (a band) what is too crowded to stand apart."""

    x: float
    marbles: tuple[Marble, ...]
    end: float = -1.0  # of a band


def lane_height(lane: Lane, x: Span) -> float:
    """How high a stream's line is: more where several values came at one time."""
    most = max((len(p.marbles) for p in _places(lane, x) if p.end < 0), default=1)
    return _LANE + _STEP * (min(max(most, 1), _MOST_STACKED) - 1)


def _places(lane: Lane, x: Span) -> list[_Place]:
    by_time: dict[int, list[Marble]] = {}
    for marble in lane.marbles:
        by_time.setdefault(marble.us, []).append(marble)
    single = [_Place(x.at(us), tuple(found)) for us, found in sorted(by_time.items())]
    return list(_crowds(single))


def _crowds(places: Sequence[_Place]) -> Iterator[_Place]:
    """Runs of marbles that stand too near each other become bands."""
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


def draw_lane(lane: Lane, x: Span, top: float, bottom: float) -> str:
    """A stream's line with its marbles; `bottom` is where the next one begins."""
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
            parts.append(_draw_band(place, lane, base, end, (fill, line)))
            continue
        for level, marble in enumerate(place.marbles[:_MOST_STACKED]):
            y = base - level * _STEP
            more = len(place.marbles) - _MOST_STACKED if level == _MOST_STACKED - 1 else 0
            parts.append(_draw_marble(marble, lane, place.x, y, (gap, end - place.x), (fill, line), more))
    return f'<g class="lane {lane.kind}" data-stream="{escape(clean(lane.label or lane.id))}">{"".join(parts)}</g>'


def _told(marble: Marble) -> str:
    """What a pointer over the marble tells."""
    when = f"{marble.us / 1e6:g} s"
    row = f", {marble.row}" if marble.row else ""
    return escape(clean(f"{when}{row}: {marble.error or show(marble.value, 400)}"))


def _draw_marble(
    marble: Marble, lane: Lane, x: float, y: float, gaps: tuple[float, float], colours: tuple[str, str], more: int
) -> str:
    before, room = gaps
    title = f"<title>{_told(marble)}</title>"
    if marble.error:
        reason = cut(clean(marble.error[:200]), room - 12, _measure) if room > 40 else ""
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
    """A marble from `x` on: round for streams, square for sensors, double for actuators, dashed for ends."""
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


def _draw_band(place: _Place, lane: Lane, base: float, end: float, colours: tuple[str, str]) -> str:
    """Many values: a hatched band, with how many there are and the first and the last of them."""
    marbles = place.marbles
    good = [m for m in marbles if not m.error]
    fill, line = colours
    x, wide = place.x - 1.5, max(place.end - place.x, 2) + 3
    when = f"{marbles[0].us / 1e6:g} s to {marbles[-1].us / 1e6:g} s"
    values = f"{short(good[0].value)[:40]} … {short(good[-1].value)[:40]}" if good else ""
    failed = len(marbles) - len(good)
    told = f"{len(good)} values from {when}: {values}" if good else ""
    told += f" {failed} errors: {marbles[0].error or next(m.error for m in marbles if m.error)}" if failed else ""
    parts = [
        f"<title>{escape(clean(told))}</title>",
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
    parts.append(_band_label(marbles, good, x + wide / 2, base, wide))
    return f'<g class="band">{"".join(parts)}</g>'


def _band_label(marbles: Sequence[Marble], good: Sequence[Marble], middle: float, base: float, room: float) -> str:
    """How many values and which, as far as it fits."""
    for words in (f"{len(marbles)} values: {_range(good)}", f"{len(marbles)} values", str(len(marbles))):
        wide = width(words, 7) + 5
        if wide < room:
            back = f'x="{middle - wide / 2:.1f}" y="{base - 4:.1f}" width="{wide:.1f}" height="8" rx="1.5"'
            box = f'<rect {back} fill="#fff" stroke="{EDGE}" stroke-width="0.3"/>'
            return box + text(middle, base + 2.5, words, 7, middle=True)
    return ""


def _range(marbles: Sequence[Marble]) -> str:
    """The first and the last value, in short."""
    if not marbles:
        return "errors"
    first, last = short(marbles[0].value)[:14], short(marbles[-1].value)[:14]
    return first if first == last else f"{first} … {last}"
