"""Draws the legend of the diagrams."""

from __future__ import annotations

from rrp_sheets.connectors import connectors
from rrp_sheets.render.boxes import Box
from rrp_sheets.render.measure import width
from rrp_sheets.render.style import BADGE, INK, NAME_PT, OFF_FILL, OFF_LINE, PAGE
from rrp_sheets.render.svg import draw_badge, draw_box, draw_flag, draw_icon, frame, text
from rrp_sheets.render.texts import texts

_LINE = 20.0
_COLUMNS = (14.0, 170.0, 326.0)


def draw_legend(language: str = "en") -> tuple[str, float, float]:
    """Return the legend as SVG, its width and its height in points."""
    words = texts(language)
    wide = PAGE[0]
    parts = [text(_COLUMNS[0], 19, words.get("legend.title"), NAME_PT, bold=True)]
    y = 40.0
    signs = [("sensor", 0, 0), ("stream", 1, 0), ("actuator", 2, 0), ("anonymous", 0, 1), ("done", 0, 2)]
    for kind, column, row in signs:
        size = (7.0, 7.0) if kind == "anonymous" else (28.0, 17.0)
        box = Box(f"sign-{kind}", kind, "", *size)
        parts.append(draw_box(box, (_COLUMNS[column] + 14, y + row * 24), "legend", words=words))
        parts.append(text(_COLUMNS[column] + 36, y + row * 24 + 3.4, words.get(f"legend.{kind}"), NAME_PT))
    x = _COLUMNS[1]
    parts.append(
        f'<rect x="{x}" y="{y + 16}" width="28" height="16" rx="3" fill="{OFF_FILL}" stroke="{OFF_LINE}" '
        'stroke-width="0.9" stroke-dasharray="3 2.2"/>'
    )
    parts.append(text(x + 36, y + 27.4, words.get("legend.off"), NAME_PT))
    parts.append(draw_flag(1, _COLUMNS[2] + 7, y + 17))
    parts.append(text(_COLUMNS[2] + 36, y + 27.4, words.get("legend.flag"), NAME_PT))
    y += 64
    parts.append(
        f'<rect x="{_COLUMNS[0]}" y="{y}" width="36" height="18" rx="3" fill="#fff" stroke="{INK}" stroke-width="0.9"/>'
    )
    parts.append(draw_badge(3, _COLUMNS[0], y, 18, BADGE))
    parts.append(draw_icon(_icon("filter"), _COLUMNS[0] + 21, y + 3.4, INK))
    parts.append(text(_COLUMNS[0] + 44, y + 12.4, words.get("legend.row"), NAME_PT))
    y += 36
    known = [c for c in dict.fromkeys(connectors()) if words.has(f"legend.connector.{c.name}")]
    half = -(-len(known) // 2)
    for number, connector in enumerate(known):
        x, line = (_COLUMNS[0] if number < half else wide / 2 + 8), y + number % half * _LINE
        about = words.get(f"legend.connector.{connector.name}")
        meaning = words.get("legend.meaning", connector=connector.name, meaning=about)
        parts.append(draw_icon(connector.icon, x + 4, line - 9, INK, 1))
        parts.append(text(x + 26, line, meaning, NAME_PT - (1 if width(meaning, NAME_PT) > wide / 2 - 30 else 0)))
    high = y + half * _LINE - 6
    border = (
        f'<rect x="0.5" y="0.5" width="{wide - 1:g}" height="{high - 1:g}" rx="4" fill="#fff" stroke="#9a9a9a" '
        'stroke-width="0.7"/>'
    )
    body = "\n".join([border, *parts])
    title = words.get("legend.title")
    return frame(body, wide, high, ident="legend", title=title, description=words.get("legend.alt")), wide, high


def _icon(name: str) -> str:
    connector = connectors().get(name)
    return connector.icon if connector else ""
