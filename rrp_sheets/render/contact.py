"""A contact sheet: pictures of a run's moments in rows, each with its time and what happened then; as SVG."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass

from rrp_sheets.render.measure import clean, shortened, wrap
from rrp_sheets.render.plots import WIDE
from rrp_sheets.render.stamped import metadata
from rrp_sheets.render.style import EDGE, SOFT
from rrp_sheets.render.svg import frame, text
from rrp_sheets.render.texts import Texts, texts

COLUMNS = 4
_EDGE, _BETWEEN = 14.0, 10.0
_LINE = 11.5
_LINES = 3  # of what happened, under a picture
_TIME = 44.0  # points, for the time before them
_LETTERS = 30


@dataclass(frozen=True)
class Moment:
    """A picture.

    Attributes:
        jpeg: the picture; `wide` and `high` in pixels.
        when: its time, in words.
        told: what happened from then until the next one; the most important first.
    """

    jpeg: bytes
    wide: int
    high: int
    when: str
    told: tuple[str, ...] = ()


def draw_contact(
    title: str,
    moments: Sequence[Moment],
    *,
    foot: str = "",
    about: dict[str, str] | None = None,
    language: str = "en",
) -> tuple[str, float, float]:
    """The sheet as SVG, and its width and height in points; see `draw_plots`."""
    words_of = texts(language)
    wide = (WIDE - 2 * _EDGE - (COLUMNS - 1) * _BETWEEN) / COLUMNS
    pieces = [text(_EDGE, 22, shortened(clean(title), WIDE - 2 * _EDGE, 13, bold=True), 13, bold=True)]
    y = 34.0
    for row in range(0, len(moments), COLUMNS):
        shown = moments[row : row + COLUMNS]
        highest = max(wide * m.high / max(m.wide, 1) for m in shown)
        for number, moment in enumerate(shown):
            pieces += _tile(moment, words_of, _EDGE + number * (wide + _BETWEEN), y, wide)
        y += highest + 12 + _LINE * max(1, *(len(_told(m, words_of)) for m in shown)) + 8
    for words in wrap(clean(foot), 190, 3):
        pieces.append(text(_EDGE, y, words, 7, fill=SOFT))
        y += 10
    body = metadata(about or {}) + f'<rect width="{WIDE:g}" height="{y:.1f}" fill="#fff"/>' + "\n".join(pieces)
    alt = (
        words_of.get("moments.alt", n=len(moments))
        + " "
        + " ".join(f"{m.when}: {'; '.join(clean(t) for t in m.told[:_LINES])}." for m in moments if m.told)
    )
    return frame(body, WIDE, y, ident="moments", title=clean(title), description=alt), WIDE, y


def _tile(moment: Moment, words_of: Texts, x: float, y: float, wide: float) -> list[str]:
    high = wide * moment.high / max(moment.wide, 1)
    data = base64.b64encode(moment.jpeg).decode()
    place = f'x="{x:.1f}" y="{y:.1f}" width="{wide:.1f}" height="{high:.1f}"'
    found = [
        f'<image {place} href="data:image/jpeg;base64,{data}"/>',
        f'<rect {place} fill="none" stroke="{EDGE}" stroke-width="0.6"/>',
        text(x, y + high + 12, moment.when, 10, bold=True),
    ]
    for number, words in enumerate(_told(moment, words_of)):
        found.append(text(x + _TIME, y + high + 12 + _LINE * number, shortened(words, wide - _TIME, 9), 9))
    return found


def _told(moment: Moment, words_of: Texts) -> list[str]:
    """What happened, in the lines that there are: at most two for each, and how many more there were."""
    lines: list[str] = []
    for number, told in enumerate(moment.told):
        broken = wrap(clean(told[:160]), _LETTERS, 2)
        last = number == len(moment.told) - 1
        if len(lines) + len(broken) + (not last) > _LINES:
            more = words_of.get("moments.more", n=len(moment.told) - number)
            return [*lines, more] if lines else [*broken[: _LINES - 1], words_of.get("moments.and_more")]
        lines += broken
    return lines
