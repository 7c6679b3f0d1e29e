"""Draws the boxes and arrows of a change as SVG. Changes differ by line and sign, not by colour only."""

from __future__ import annotations

from rrp_sheets.model.changed import ADDED, CHANGED, REMOVED, SAME
from rrp_sheets.render.boxes import ROW_TEXT_LEFT, Drawing
from rrp_sheets.render.changes.boxes import BoxLine, ChangeArrow, ChangeBox
from rrp_sheets.render.changes.lines import Line
from rrp_sheets.render.dot import Layout, Point, Way
from rrp_sheets.render.measure import escape
from rrp_sheets.render.style import (
    DASHES,
    FORMULA_LINE,
    MONO,
    MONO_PT,
    NAME_LINE,
    NAME_PT,
    PADDING,
    SANS,
    SMALL_PT,
    SOFT,
)  # fmt: skip
from rrp_sheets.render.svg import draw_badge, draw_icon, frame, text

_QUIET = "#a2a2a2"  # lines of what stayed
_QUIET_INK = "#5c5c5c"
_INK = {SAME: _QUIET_INK, ADDED: "#123f1c", REMOVED: "#6e1414", CHANGED: "#4d3300"}
LINE = {SAME: _QUIET, ADDED: "#1b6e2f", REMOVED: "#a11d1d", CHANGED: "#8a5a00"}
FILL = {SAME: "#fff", ADDED: "#e2f3e4", REMOVED: "#fff", CHANGED: "#fff3d2"}
_THICK = {SAME: 0.9, ADDED: 2.2, REMOVED: 1.4, CHANGED: 1.7}
_WORDS = {ADDED: "new", REMOVED: "gone", CHANGED: "changed"}
SIGN = 7.0  # half a sign's size
MARGIN = PADDING + SIGN


def draw_change(drawing: Drawing, layout: Layout, *, prefix: str, title: str, description: str) -> str:
    """Return the picture of a change as SVG; `prefix` starts every id."""
    wide, high = layout.width + 2 * MARGIN, layout.height + 2 * MARGIN
    arrows = {(a.tail, a.head): a for a in drawing.arrows}
    parts, labels = [], []
    for way in layout.ways:
        arrow = arrows[way.tail, way.head]
        assert isinstance(arrow, ChangeArrow)
        parts.append(_arrow(way, arrow))
        if arrow.labelled:  # above everything else
            labels.append(draw_sign(arrow.sign, _middle([_moved(p) for p in way.points]), 4.6))
    for box in drawing.boxes.values():
        assert isinstance(box, ChangeBox)
        parts.append(draw_change_box(box, _moved(layout.places[box.id]), prefix))
    return frame("\n".join([*parts, *labels]), wide, high, ident=prefix, title=title, description=description)


def draw_change_box(box: ChangeBox, centre: Point, prefix: str) -> str:
    """Draw a box with its centre at that place, and its sign at its upper right corner."""
    draw = _row if box.kind == "row" else _dot if box.kind == "anonymous" else _stream
    inside = draw(box, centre)
    if box.sign:
        corner = (centre[0] + box.width / 2 - 1, centre[1] - box.height / 2 + 1)
        if box.kind == "stream":  # its corner is empty
            corner = (centre[0] + box.width * 0.42, centre[1] - box.height * 0.44)
        inside += draw_sign(box.sign, corner)
    name = f"Row {box.row}, {box.name}" if box.kind == "row" else box.name
    told = f"{name}, {_WORDS.get(box.sign, 'as before')}" if name else ""
    title = f"<title>{escape(told)}</title>" if told else ""
    return f'<g id="{prefix}-{box.id}" class="{box.kind} {_WORDS.get(box.sign, "kept")}">{title}{inside}</g>'


def draw_sign(sign: str, centre: Point, size: float = SIGN) -> str:
    """Draw the sign of a change: a plus on a filled disc, a minus on an empty one, a wave on a filled square."""
    (x, y), colour = centre, LINE[sign]
    if sign == CHANGED:
        shape = (
            f'<rect x="{x - size:.1f}" y="{y - size:.1f}" width="{2 * size:.1f}" height="{2 * size:.1f}" rx="2" '
            f'fill="{colour}" stroke="#fff" stroke-width="0.8"/>'
        )
        wave = f"M{x - size * 0.55:.1f} {y + size * 0.18:.1f}q{size * 0.28:.1f} {-size * 0.6:.1f} {size * 0.55:.1f} "
        wave += f"{-size * 0.18:.1f}t{size * 0.55:.1f} {-size * 0.18:.1f}"
        return shape + f'<path d="{wave}" fill="none" stroke="#fff" stroke-width="1.7" stroke-linecap="round"/>'
    ink, fill = ("#fff", colour) if sign == ADDED else (colour, "#fff")
    shape = (
        f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{size:.1f}" fill="{fill}" stroke="{ink if fill != "#fff" else colour}" '
    )
    shape += f'stroke-width="{0.8 if sign == ADDED else 1.5}"/>'
    bar = f"M{x - size * 0.55:.1f} {y:.1f}h{size * 1.1:.1f}"
    if sign == ADDED:
        bar += f"M{x:.1f} {y - size * 0.55:.1f}v{size * 1.1:.1f}"
    return shape + f'<path d="{bar}" stroke="{ink}" stroke-width="1.9" stroke-linecap="round"/>'


def _line(x: float, y: float, line: Line, size: float, *, fill: str, gone: bool, mono: bool = False,
          bold: bool = False, italic: bool = False, middle: bool = False) -> str:  # fmt: skip
    """Draw a line of text; what is marked in it is struck out where it is `gone`, else bold and underlined."""
    mark = 'text-decoration="line-through"' if gone else 'font-weight="bold" text-decoration="underline"'
    spans = "".join(f"<tspan {mark}>{escape(w)}</tspan>" if marked else escape(w) for marked, w in line)
    looks = [
        f'font-family="{escape(MONO if mono else SANS)}" font-size="{size:g}" fill="{fill}" xml:space="preserve"',
        'font-weight="bold"' if bold else "", 'font-style="italic"' if italic else "",
        'text-anchor="middle"' if middle else "",
    ]  # fmt: skip
    return f'<text x="{x:.1f}" y="{y:.1f}" {" ".join(filter(None, looks))}>{spans}</text>'


def _row(box: ChangeBox, centre: Point) -> str:
    x, y, w, h = centre[0] - box.width / 2, centre[1] - box.height / 2, box.width, box.height
    ink, line = _INK[box.sign], LINE[box.sign]
    parts = [
        f'<rect x="{x:.1f}" y="{y:.1f}" width="{w:.1f}" height="{h:.1f}" rx="3" fill="{FILL[box.sign]}" '
        f'stroke="{line}" stroke-width="{_THICK[box.sign]}"{_dashes(box)}/>',
        draw_badge(box.row, x, y, h, line if box.sign else "#7d7d7d"),
        draw_icon(box.icon, x + 20.5, y + 3.4, ink),
        _line(x + ROW_TEXT_LEFT, y + 12.4, box.heading[0], SMALL_PT, fill=ink, gone=True, bold=box.sign == ADDED),
    ]
    for number, told in enumerate(box.told):
        parts.append(_told(told, x + ROW_TEXT_LEFT, y + 23.6 + FORMULA_LINE * number, ink, box.sign == REMOVED))
    return "".join(parts)


def _told(told: BoxLine, x: float, y: float, ink: str, ghost: bool) -> str:
    sign = told.sign.strip()
    before = text(x, y, sign, MONO_PT + 1, fill=LINE[sign], bold=True) if sign else ""
    indent = 9.0 if told.sign else 0.0
    gone = ghost or sign == REMOVED or (told.sign == " " and ghost)
    colour = LINE[sign] if sign else ink
    return before + _line(x + indent, y, told.words, MONO_PT, fill=colour, gone=gone, mono=told.mono,
                          italic=not told.mono and not told.sign)  # fmt: skip


def _stream(box: ChangeBox, centre: Point) -> str:
    cx, cy = centre
    x, y, w, h = cx - box.width / 2, cy - box.height / 2, box.width, box.height
    line, fill, ink, thick = LINE[box.sign], FILL[box.sign], _INK[box.sign], _THICK[box.sign]
    looks = f'fill="{fill}" stroke="{line}"{_dashes(box)}'
    if box.kind == "stream":
        shape = (
            f'<ellipse cx="{cx:.1f}" cy="{cy:.1f}" rx="{w / 2:.1f}" ry="{h / 2:.1f}" {looks} stroke-width="{thick}"/>'
        )
    else:
        thick += 0.9 if box.kind == "sensor" else 0
        shape = f'<rect x="{x:.1f}" y="{y:.1f}" width="{w:.1f}" height="{h:.1f}" {looks} stroke-width="{thick}"/>'
        if box.kind == "actuator":
            inner = f'x="{x + 3:.1f}" y="{y + 3:.1f}" width="{w - 6:.1f}" height="{h - 6:.1f}"'
            shape += f'<rect {inner} fill="none" stroke="{line}" stroke-width="0.9"{_dashes(box)}/>'
    tall = NAME_LINE * len(box.heading) + FORMULA_LINE * len(box.told) + (10 if box.note else 0)
    base = cy - tall / 2 + 9.2
    for number, words in enumerate(box.heading):
        marked = tuple((box.sign == REMOVED, w) for _, w in words)
        shape += _line(cx, base + NAME_LINE * number, marked, NAME_PT, fill=ink, gone=True,
                       bold=box.kind != "stream", middle=True)  # fmt: skip
    base += NAME_LINE * len(box.heading) - 1
    for number, told in enumerate(box.told):
        sign = told.sign.strip()
        words = ((False, f"{sign} "), *told.words) if sign else told.words
        shape += _line(cx, base + FORMULA_LINE * number, words, MONO_PT, fill=LINE[sign], gone=sign == REMOVED,
                       middle=True)  # fmt: skip
    if box.note:
        y = base + FORMULA_LINE * len(box.told)
        shape += text(cx, y, box.note, SMALL_PT, fill=SOFT, italic=True, middle=True)
    return shape


def _dot(box: ChangeBox, centre: Point) -> str:
    x, y = centre
    dot_x = x - box.width / 2 + 4 if box.note else x
    fill = "#fff" if box.sign == REMOVED else LINE[box.sign]
    dot = f'<circle cx="{dot_x:.1f}" cy="{y:.1f}" r="3.2" fill="{fill}" stroke="{LINE[box.sign]}"/>'
    return dot + (text(dot_x + 7, y + 3, box.note, SMALL_PT, fill=SOFT, italic=True) if box.note else "")


def _dashes(box: ChangeBox) -> str:
    return f' stroke-dasharray="{DASHES}"' if box.sign == REMOVED or (box.off and not box.sign) else ""


def _arrow(way: Way, arrow: ChangeArrow) -> str:
    colour = LINE[arrow.sign] if arrow.sign else "#bdbdbd" if arrow.off else _QUIET
    thick = {ADDED: 1.9, REMOVED: 1.3}.get(arrow.sign, 0.9)
    dashes = f' stroke-dasharray="{DASHES}"' if arrow.sign == REMOVED or (arrow.off and not arrow.sign) else ""
    points = [_moved(p) for p in way.points]
    path = f"M{_xy(points[0])}" + "".join(
        f" C{_xy(points[i])} {_xy(points[i + 1])} {_xy(points[i + 2])}" for i in range(1, len(points) - 2, 3)
    )
    head = ""
    if way.tip and not arrow.headless:
        tip, last = _moved(way.tip), points[-1]
        dx, dy = tip[0] - last[0], tip[1] - last[1]
        length = max((dx * dx + dy * dy) ** 0.5, 0.01)
        ux, uy = dx / length, dy / length
        base = (tip[0] - ux * 5.5, tip[1] - uy * 5.5)
        left, right = (base[0] - uy * 2.5, base[1] + ux * 2.5), (base[0] + uy * 2.5, base[1] - ux * 2.5)
        path += f" L{_xy(base)}" if length > 5.5 else ""
        head = f'<path d="M{_xy(tip)}L{_xy(left)}L{_xy(right)}z" fill="{colour}"/>'
    return f'<path d="{path}" fill="none" stroke="{colour}" stroke-width="{thick}"{dashes}/>{head}'


def _middle(points: list[Point]) -> Point:
    """Return the middle of the middle piece of a spline."""
    pieces = (len(points) - 1) // 3
    start = (pieces // 2) * 3
    a, b, c, d = points[start : start + 4]
    if pieces % 2:
        return (a[0] + 3 * b[0] + 3 * c[0] + d[0]) / 8, (a[1] + 3 * b[1] + 3 * c[1] + d[1]) / 8
    return a


def _moved(point: Point) -> Point:
    return point[0] + MARGIN, point[1] + MARGIN


def _xy(point: Point) -> str:
    return f"{point[0]:.1f} {point[1]:.1f}"
