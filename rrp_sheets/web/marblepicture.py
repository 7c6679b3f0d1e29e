"""A connector's example as a picture: a line for each stream, with a marble for each value."""

from __future__ import annotations

import re
from collections.abc import Sequence

from markupsafe import Markup, escape

_PLACE = 15  # pixels for each sign of a row of marbles
_LANE, _LEFT, _RADIUS = 36, 64, 12
_MARBLE = re.compile(r"\([^)]*\)|[^-]+")


def marble_picture(rows: Sequence[tuple[str, str]]) -> Markup:
    """The picture of some rows of marbles such as `--1---2-`; the last one is what comes out."""
    longest = max(len(line) for _, line in rows)
    width, height = _LEFT + longest * _PLACE + 24, len(rows) * _LANE + 8
    lanes = [_lane(name, line, i * _LANE + 22, width, out=i == len(rows) - 1) for i, (name, line) in enumerate(rows)]
    told = "; ".join(f"{name}: {', '.join(_MARBLE.findall(line)) or 'nothing'}" for name, line in rows)
    return Markup(
        f'<svg class="marble-picture" viewBox="0 0 {width} {height}" width="{width}" height="{height}" role="img" '
        f'aria-label="{escape(told)}">{"".join(lanes)}</svg>'
    )


def _lane(name: str, line: str, y: int, width: int, *, out: bool) -> str:
    marbles = []
    for match in _MARBLE.finditer(line):
        x = _LEFT + match.start() * _PLACE + _PLACE // 2
        half = max(_RADIUS, len(match[0]) * 4 + 4)
        marbles.append(
            f'<rect class="marble" x="{x - half}" y="{y - _RADIUS}" width="{2 * half}" height="{2 * _RADIUS}" '
            f'rx="{_RADIUS}"/><text class="value" x="{x}" y="{y + 4}">{escape(match[0])}</text>'
        )
    return (
        f'<g class="lane{" is-out" if out else ""}"><text class="name" x="0" y="{y + 4}">{escape(name)}</text>'
        f'<path class="line" d="M{_LEFT} {y}H{width - 8}m-5 -4 5 4 -5 4"/>{"".join(marbles)}</g>'
    )
