"""Small marble drawings of a connector's example, for a narrow panel whose style sheet gives the colours and fonts.

`marble_drawing` draws for paper: whole behaviours, in points, with colours of its own.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from markupsafe import Markup, escape

from rrp_sheets.model.values import Record, Value
from rrp_sheets.render.marble_diagram import Bar, Lane, Marble, MarbleDiagram, short

_WIDE = 400  # pixels, where the marbles have room in it
_NAME, _RIGHT, _LANE, _BAR, _AXIS = 52, 40, 36, 32, 24
_RADIUS, _LETTER, _GAP = 12, 4, 4  # of a marble; half a letter's width; between two marbles
_STEPS = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0)  # seconds between the marks of the time
_LEAST_STEP = 44  # pixels


def draw_example(score: MarbleDiagram) -> Markup:
    """Draw the example of a connector: its inputs, a bar for the connector, the output, the time.

    Args:
        score: whose last group has the connector's bar and its output.
    """
    *inputs, output = score.groups
    lanes = [group.lane for group in inputs]
    time = _Time(max(score.last_us, 1) / 1e6, (*lanes, output.lane))
    pieces, y = [], 16
    for lane in lanes:
        pieces.append(_lane(lane, y, time))
        y += _LANE
    for bar in output.bars:
        pieces.append(_bar(bar, y, time))
        y += _BAR + 6
    pieces.append(_lane(output.lane, y + 4, time, out=True))
    wide, high = time.wide, y + _LANE + _AXIS - 12
    pieces.append(_axis(time, high - 6))
    told = "; ".join(
        [*map(_told, lanes), *(f"{b.connector} {b.formula}".strip() for b in output.bars), _told(output.lane)]
    )
    return Markup(
        f'<svg class="marble-picture" viewBox="0 0 {wide} {high}" width="{wide}" height="{high}" role="img" '
        f'aria-label="{escape(told)}">{"".join(pieces)}</svg>'
    )


class _Time:
    """Horizontal time scale of an example, wide enough that marbles overlap neither each other nor the name."""

    def __init__(self, span: float, lanes: Sequence[Lane]) -> None:
        self.span = span
        self.left = _NAME + max((_half(lane.marbles[0]) for lane in lanes if lane.marbles), default=_RADIUS)
        self.scale = max((_WIDE - self.left - _RIGHT) / span, *map(_least, lanes))
        self.wide = round(self.left + span * self.scale + _RIGHT)

    def x(self, seconds: float) -> float:
        return round(self.left + seconds * self.scale, 1)


def _least(lane: Lane) -> float:
    """Return the pixels per second at which no two marbles of a stream touch."""
    pairs = zip(lane.marbles, lane.marbles[1:], strict=False)
    return max(((_half(a) + _half(b) + _GAP) / max((b.us - a.us) / 1e6, 0.05) for a, b in pairs), default=0.0)


def _lane(lane: Lane, y: int, time: _Time, *, out: bool = False) -> str:
    marbles = []
    round_by = 2 if lane.kind == "actuator" else _RADIUS  # a square, as in the diagram
    for marble in lane.marbles:
        x, half = time.x(marble.us / 1e6), _half(marble)
        marbles.append(
            f'<rect class="marble" x="{x - half:g}" y="{y - _RADIUS}" width="{2 * half}" height="{2 * _RADIUS}" '
            f'rx="{round_by}"/><text class="value" x="{x:g}" y="{y + 4}">{escape(_text(marble))}</text>'
        )
    return (
        f'<g class="lane is-{lane.kind}{" is-out" if out else ""}"><text class="name" x="0" y="{y + 4}">'
        f'{escape(lane.label)}</text><path class="line" d="M{_NAME} {y}H{time.wide - 8}m-5 -4 5 4 -5 4"/>'
        f"{''.join(marbles)}</g>"
    )


def _bar(bar: Bar, y: int, time: _Time) -> str:
    """Draw the bar of the connector, with ticks where its clock acts."""
    top = y - _BAR // 2
    ticks = "".join(f'<path class="tick" d="M{time.x(us / 1e6):g} {top}v-6"/>' for us in bar.ticks)
    formula = f' <tspan class="formula">{escape(bar.formula)}</tspan>' if bar.formula else ""
    return (
        f'<g class="bar"><rect x="{_NAME}" y="{top}" width="{time.wide - _NAME - 8}" height="{_BAR - 4}" rx="4"/>'
        f'<g class="sign" transform="translate({_NAME + 8} {top + 8})">{bar.icon}</g>'
        f'<text x="{_NAME + 28}" y="{top + 18}">{escape(bar.connector)}{formula}</text>{ticks}</g>'
    )


def _axis(time: _Time, y: int) -> str:
    step = next((s for s in _STEPS if s * time.scale >= _LEAST_STEP), _STEPS[-1])
    times = (step * n for n in range(int(time.span / step + 1e-6) + 1))
    marks = "".join(f'<text class="time" x="{time.x(t):g}" y="{y}">{t:.3g} s</text>' for t in times)
    return f'<g aria-hidden="true">{marks}</g>'


def _half(marble: Marble) -> int:
    return max(_RADIUS, len(_text(marble)) * _LETTER + 4)


def _text(marble: Marble) -> str:
    return "!" if marble.error else example_value(marble.value)


def _told(lane: Lane) -> str:
    found: Iterable[str] = (f"{_text(m)} at {m.us / 1e6:g} s" for m in lane.marbles)
    return f"{lane.label}: {', '.join(found) or 'nothing'}"


def example_value(value: Value) -> str:
    """Return a value as it stands on a marble of an example; a record as the values of its fields.

    >>> example_value(0.12345), example_value("red"), example_value(None)
    ('0.123', 'red', 'blank')
    """
    if isinstance(value, Record):
        return f"({'; '.join(example_value(v) for v in value.as_dict().values())})"
    return short(value)
