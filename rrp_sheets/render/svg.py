"""Draws boxes and arrows as SVG. Users' texts are escaped; all ids are made by the program."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from rrp_sheets.model.changed import ADDED, CHANGED, REMOVED, SAME
from rrp_sheets.render import style
from rrp_sheets.render.boxes import ROW_TEXT_LEFT, SIGN_INDENT, Arrow, Box, Drawing, Layout, Point, Way
from rrp_sheets.render.texts import Texts, texts


def draw_svg(
    drawing: Drawing, layout: Layout, *, prefix: str, title: str, description: str, chosen: bool = False,
    words: Texts | None = None,
) -> str:  # fmt: skip
    """Return a drawing as SVG; `prefix` starts every id, title and description are for screen readers.

    With `chosen` the boxes can be chosen in a page: they have a role and a name of their own.
    """
    margin = drawing.margin
    wide, high = layout.width + 2 * margin, layout.height + 2 * margin
    arrows = {(a.tail, a.head): a for a in drawing.arrows}
    placed: list[tuple[Way, Arrow]] = []
    for way in layout.ways:
        points, tip = [_moved(p, margin) for p in way.points], _moved(way.tip, margin) if way.tip else None
        placed.append((replace(way, points=tuple(points), tip=tip), arrows[way.tail, way.head]))
    parts = [draw_arrow(way, arrow, prefix) for way, arrow in placed]
    places = {ident: _moved(place, margin) for ident, place in layout.places.items()}
    parts += [draw_box(b, places[b.id], prefix, chosen=chosen, words=words) for b in drawing.boxes.values()]
    parts += [draw_sign(arrow.status or SAME, _middle(w.points), 4.6) for w, arrow in placed if arrow.labelled]
    ident, role = f"{prefix}-{next(iter(drawing.boxes), 'none')}", "group" if chosen else "img"
    return frame("\n".join(parts), wide, high, ident=ident, title=title, description=description, role=role)


def frame(body: str, wide: float, high: float, *, ident: str, title: str, description: str, role: str = "img") -> str:
    """Return an SVG picture of that size in points, with title and description for screen readers."""
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{wide:.0f}pt" height="{high:.0f}pt" '
        f'viewBox="0 0 {_n(wide)} {_n(high)}" role="{role}" aria-labelledby="{ident}-title {ident}-desc">\n'
        f'<title id="{ident}-title">{style.escape(title)}</title>\n'
        f'<desc id="{ident}-desc">{style.escape(description)}</desc>\n'
        f"{body}\n</svg>\n"
    )


def text(
    x: float, y: float, words: str | style.Line, size: float, *, fill: str = style.INK, mono: bool = False,
    bold: bool = False, italic: bool = False, middle: bool = False, struck: bool = False,
) -> str:  # fmt: skip
    """Draw a line of text; what is marked in it is bold and underlined, or `struck` out."""
    mark = 'text-decoration="line-through"' if struck else 'font-weight="bold" text-decoration="underline"'
    runs: style.Line = ((False, words),) if isinstance(words, str) else words
    spans = "".join(f"<tspan {mark}>{style.escape(w)}</tspan>" if marked else style.escape(w) for marked, w in runs)
    face = style.escape(style.MONO if mono else style.SANS)
    looks = f'font-family="{face}" font-size="{size:g}" fill="{fill}" xml:space="preserve"'
    looks += ' font-weight="bold"' if bold else ""
    looks += ' font-style="italic"' if italic else ""
    looks += ' text-anchor="middle"' if middle else ""
    return f'<text x="{_n(x)}" y="{_n(y)}" {looks}>{spans}</text>'


def draw_icon(icon: str, x: float, y: float, colour: str, scale: float = 0.95) -> str:
    """Draw a connector's icon with its upper left corner at that place."""
    looks = f'fill="none" stroke="{colour}" stroke-width="1.25" stroke-linejoin="round" stroke-linecap="round"'
    place = f"translate({_n(x)} {_n(y)}) scale({scale:g})"
    return f'<g transform="{place}" {looks}>{icon_elements(icon, colour)}</g>'


def icon_elements(icon: str, colour: str) -> str:
    """Return the elements of a connector's icon, filled where it says so; without icon a circle."""
    elements = icon or '<circle cx="6" cy="6" r="4"/>'
    return elements.replace('class="f"', f'fill="{colour}" stroke="none"')


def draw_arrow(way: Way, arrow: Arrow, prefix: str) -> str:
    """Draw an arrow along its path; its group holds the ids of the boxes at its ends."""
    colour = style.OFF_LINE if arrow.off else style.FILL_AND_LINE["done"][1] if arrow.world else style.EDGE
    thick, dashes = 1.0, style.DASHES if arrow.off or arrow.world else ""
    if arrow.status is not None:
        colour = style.QUIET_OFF if arrow.off and not arrow.status else style.STATUS_STYLES[arrow.status].line
        thick, dashes = {ADDED: 1.9, REMOVED: 1.3}.get(arrow.status, 0.9), _dashes(arrow.off, arrow.status)
    dashed = f' stroke-dasharray="{dashes}"' if dashes else ""
    kind = "arrow off" if arrow.off else "arrow world" if arrow.world else "arrow"
    ends = f'data-from="{prefix}-{way.tail}" data-to="{prefix}-{way.head}"'
    points, tip = way.points, way.tip if not arrow.headless else None
    path = f"M{_xy(points[0])}" + "".join(
        f" C{_xy(points[i])} {_xy(points[i + 1])} {_xy(points[i + 2])}" for i in range(1, len(points) - 2, 3)
    )
    head = ""
    if tip:
        last = points[-1]
        dx, dy = tip[0] - last[0], tip[1] - last[1]
        length = max((dx * dx + dy * dy) ** 0.5, 0.01)
        ux, uy = dx / length, dy / length
        base = (tip[0] - ux * 5.5, tip[1] - uy * 5.5)
        if length > 5.5:
            path += f" L{_xy(base)}"
        left, right = (base[0] - uy * 2.3, base[1] + ux * 2.3), (base[0] + uy * 2.3, base[1] - ux * 2.3)
        head = f'<path d="M{_xy(tip)}L{_xy(left)}L{_xy(right)}z" fill="{colour}"/>'
    return (
        f'<g id="{prefix}-a-{way.tail}-{way.head}" class="{kind}" {ends}>'
        f'<path d="{path}" fill="none" stroke="{colour}" stroke-width="{thick:g}"{dashed}/>{head}</g>'
    )


_SPOKEN = {"sensor": "sensor", "stream": "stream", "actuator": "actuator", "done": "stream"}


def draw_box(box: Box, centre: Point, prefix: str, *, chosen: bool = False, words: Texts | None = None) -> str:
    """Draw a box with its centre at that place, as a group with a stable id."""
    said = words or texts()
    title = f"<title>{style.escape(told)}</title>" if (told := _told(box, said)) else ""
    if box.kind == "row":
        about, inside = f' data-row="{box.row}"', _row(box, centre, said.get("diagram.off"))
    else:
        about = f' data-stream="{style.escape(style.clean(box.stream))}" data-name="{style.escape(box.name)}"'
        inside = _anonymous(box, centre) if box.kind == "anonymous" else _stream(box, centre)
    if chosen and box.kind != "anonymous":
        about += ' role="button" tabindex="-1"'
    if box.flag is not None:
        inside += draw_flag(box.flag, centre[0] + box.width / 2 - 7, centre[1] - box.height / 2 - 8.5)
    if box.status:
        across, up = box.width / 2 - 1, box.height / 2 - 1
        if box.kind == "stream":  # an oval has no corner
            across, up = box.width * 0.42, box.height * 0.44
        inside += draw_sign(box.status, (centre[0] + across, centre[1] - up))
    looks = [box.kind, "off" if box.off else "", style.STATUS_STYLES[box.status].word if box.status else ""]
    return f'<g id="{prefix}-{box.id}" class="{" ".join(filter(None, looks))}"{about}>{title}{inside}</g>'


def draw_sign(status: str, centre: Point, size: float = style.SIGN) -> str:
    """Draw the sign of a status: a plus on a filled disc, a minus on an empty one, a wave on a filled square."""
    (x, y), colour = centre, style.STATUS_STYLES[status].line
    if status == CHANGED:
        square = _rect((x - size, y - size, 2 * size, 2 * size), colour, "#fff", 0.8, radius=2)
        wave = f"M{_n(x - size * 0.55)} {_n(y + size * 0.18)}q{_n(size * 0.28)} {_n(-size * 0.6)} {_n(size * 0.55)} "
        wave += f"{_n(-size * 0.18)}t{_n(size * 0.55)} {_n(-size * 0.18)}"
        return square + f'<path d="{wave}" fill="none" stroke="#fff" stroke-width="1.7" stroke-linecap="round"/>'
    new = status == ADDED
    fill, line, thick, ink = (colour, "#fff", 0.8, "#fff") if new else ("#fff", colour, 1.5, colour)
    disc = f'<circle cx="{_n(x)}" cy="{_n(y)}" r="{_n(size)}" fill="{fill}" stroke="{line}" stroke-width="{thick}"/>'
    bar = f"M{_n(x - size * 0.55)} {_n(y)}h{_n(size * 1.1)}"
    if new:
        bar += f"M{_n(x)} {_n(y - size * 0.55)}v{_n(size * 1.1)}"
    return disc + f'<path d="{bar}" stroke="{ink}" stroke-width="1.9" stroke-linecap="round"/>'


def _middle(points: Sequence[Point]) -> Point:
    """Return the middle of the middle piece of a spline."""
    pieces = (len(points) - 1) // 3
    start = pieces // 2 * 3  # pieces share their ends: the next one begins three points further
    a, b, c, d = points[start : start + 4]
    if pieces % 2:
        return (a[0] + 3 * b[0] + 3 * c[0] + d[0]) / 8, (a[1] + 3 * b[1] + 3 * c[1] + d[1]) / 8
    return a


def _told(box: Box, words: Texts) -> str:
    if box.status is not None:
        name = words.get("diagram.told.row", n=box.row, connector=box.name) if box.row else box.name
        return f"{name}, {style.STATUS_STYLES[box.status].word}" if name else ""
    if not box.row:
        kind = _SPOKEN.get(box.kind) if box.name else None
        return words.get(f"diagram.told.{kind}", name=box.name) if kind else ""
    entry = "diagram.told.formula" if box.formula else "diagram.told.row"
    told = words.get(entry, n=box.row, connector=box.name, formula=style.clean(box.formula))
    if box.switched_off:
        return words.get("diagram.told.off", row=told)
    return told if box.flag is None else words.get("diagram.told.problem", row=told, n=box.flag)


def draw_flag(number: int, x: float, y: float) -> str:
    """Draw the flag of a problem with its number."""
    return (
        f'<path d="M{_n(x)} {_n(y)}h15l-3.6 5.5 3.6 5.5h-15z" fill="{style.FLAG}" stroke="#fff" stroke-width="0.6"/>'
        f'<path d="M{_n(x)} {_n(y - 0.3)}v16" stroke="{style.FLAG}" stroke-width="1.5"/>'
        + text(x + 5.8, y + 8.3, str(number), 8 if number < 10 else 7, fill="#fff", bold=True, middle=True)
    )


def _anonymous(box: Box, centre: Point) -> str:
    x, y = centre
    dot_x = x - box.width / 2 + 4 if box.note else x
    looks = f'fill="{style.OFF_LINE if box.off else style.INK}"'
    if box.status is not None:
        line = style.STATUS_STYLES[box.status].line
        looks = f'fill="{"#fff" if box.status == REMOVED else line}" stroke="{line}"'
    dot = f'<circle cx="{_n(dot_x)}" cy="{_n(y)}" r="3.2" {looks}/>'
    return dot + (text(dot_x + 7, y + 3, box.note, style.SMALL_PT, fill=style.SOFT, italic=True) if box.note else "")


_THICK = {"row": 0.9, "stream": 1.2, "sensor": 2.2, "done": 1.4, "actuator": 1.1}


def _look(box: Box) -> tuple[str, str, str, float, str]:
    """Return fill, line, ink, thickness and dashes of a row's or stream's box: by its status, else by its kind."""
    if box.status is not None:
        found = style.STATUS_STYLES[box.status]
        thick = found.thick + (0.9 if box.kind == "sensor" else 0)
        return found.fill, found.line, found.ink, thick, _dashes(box.off, box.status)
    fill, line = (style.OFF_FILL, style.OFF_LINE) if box.off else style.FILL_AND_LINE.get(box.kind, ("#fff", style.BOX))
    dashed = box.off or box.kind == "done"  # the loop that goes through the world is dashed
    return fill, line, style.OFF_INK if box.off else style.INK, _THICK[box.kind], style.DASHES if dashed else ""


def _dashes(off: bool, status: str) -> str:
    return style.DASHES if status == REMOVED or (off and not status) else ""


def _stream(box: Box, centre: Point) -> str:
    cx, cy = centre
    x, y, w, h = cx - box.width / 2, cy - box.height / 2, box.width, box.height
    fill, line, ink, thick, dashes = _look(box)
    if box.kind == "stream":
        dashed = f' stroke-dasharray="{dashes}"' if dashes else ""
        place = f'cx="{_n(cx)}" cy="{_n(cy)}" rx="{_n(w / 2)}" ry="{_n(h / 2)}"'
        shape = f'<ellipse {place} fill="{fill}" stroke="{line}" stroke-width="{thick:g}"{dashed}/>'
    elif box.kind == "actuator":
        shape = _rect((x, y, w, h), "#fff", line, thick, dashes=dashes)
        shape += _rect((x + 2.6, y + 2.6, w - 5.2, h - 5.2), fill, line, min(thick, 1.1), dashes=dashes)
    else:
        shape = _rect((x, y, w, h), fill, line, thick, dashes=dashes)
    tall = style.NAME_LINE * len(box.heading) + style.FORMULA_LINE * len(box.lines) + (10 if box.note else 0)
    base = cy - tall / 2 + 9.2
    for number, words in enumerate(box.heading):
        y = base + style.NAME_LINE * number
        shape += text(cx, y, words, style.NAME_PT, fill=ink, bold=box.kind != "stream", middle=True, struck=True)
    base += style.NAME_LINE * len(box.heading) - 1
    for number, told in enumerate(box.lines):
        sign = f"{told.status} " if told.status and not told.continued else ""
        colour = style.STATUS_STYLES[told.status].line
        shape += text(cx, base + style.FORMULA_LINE * number, ((False, sign), *told.words), style.MONO_PT, fill=colour,
                      mono=told.mono, middle=True, struck=told.status == REMOVED)  # fmt: skip
    if box.note:
        y = base + style.FORMULA_LINE * len(box.lines)
        shape += text(cx, y, box.note, style.SMALL_PT, fill=style.SOFT, italic=True, middle=True)
    if box.room:  # the page writes the newest value here, and then moves the name up by half a line
        y = cy + (style.NAME_LINE * len(box.heading) + style.VALUE_LINE) / 2 - 2.5
        most = _n(w * (0.84 if len(box.heading) < 2 else 0.7))
        now = text(cx, y, "", style.SMALL_PT, fill=style.INK, bold=True, middle=True)
        shape += now.replace("<text ", f'<text class="now" data-wide="{most}" ')
    return shape


def _row(box: Box, centre: Point, off: str) -> str:
    x, y, w, h = centre[0] - box.width / 2, centre[1] - box.height / 2, box.width, box.height
    fill, line, ink, thick, dashes = _look(box)
    badge = style.OFF_LINE if box.off else style.BADGE
    if box.status is not None:
        badge = line if box.status else style.QUIET_BADGE
    heading = box.heading[0]
    parts = [
        _rect((x, y, w, h), fill, line, thick, radius=3, dashes=dashes),
        draw_badge(box.row, x, y, h, badge),
        draw_icon(box.icon, x + 20.5, y + 3.4, ink),
        text(x + ROW_TEXT_LEFT, y + 12.4, heading, style.SMALL_PT, fill=ink, bold=box.status == ADDED, struck=True),
    ]
    for number, told in enumerate(box.lines):
        line_y = y + (12.3 if box.beside else 23.6 + style.FORMULA_LINE * number)
        left = x + (ROW_TEXT_LEFT + box.beside if box.beside else box.indent)
        colour = style.STATUS_STYLES[told.status].line if told.status else ink
        if told.status:
            if not told.continued:
                parts.append(text(left, line_y, told.status, style.MONO_PT + 1, fill=colour, bold=True))
            left += SIGN_INDENT
        parts.append(text(left, line_y, told.words, style.MONO_PT, fill=colour, mono=told.mono,
                          italic=not told.mono and not told.status,
                          struck=REMOVED in (told.status, box.status)))  # fmt: skip
    if box.switched_off:
        across = max(17.0, style.width(off, 8) + 4)
        parts.append(_rect((x + w - across - 1, y - 6.5, across, 10), "#fff", style.OFF_LINE, 0.7, radius=2))
        parts.append(text(x + w - across / 2 - 1, y + 1.4, off, 8, fill="#555", middle=True))
    if box.mark:
        across = style.width(box.mark, style.MONO_PT, bold=True) + 7
        middle = x + w - across / 2 - 4
        parts.append(_rect((x + w - across - 4, y + 3.8, across, 11), style.INK, "none", 0, radius=2))
        parts.append(text(middle, y + 12, box.mark, style.MONO_PT, fill="#fff", bold=True, middle=True))
    return "".join(parts)


def draw_badge(number: int, x: float, y: float, high: float, colour: str) -> str:
    """Draw the dark left end of a row's box with its number."""
    size = 9 if number < 100 else 7.5 if number < 1000 else 6
    shape = f"M{_n(x + 3)} {_n(y)}H{_n(x + 17)}V{_n(y + high)}H{_n(x + 3)}a3 3 0 0 1 -3 -3V{_n(y + 3)}a3 3 0 0 1 3 -3z"
    digits = text(x + 8.6, y + 12.6, str(number), size, fill="#fff", bold=True, middle=True)
    return f'<path d="{shape}" fill="{colour}"/>{digits}'


def _rect(
    box: tuple[float, float, float, float], fill: str, line: str, thick: float, *, radius: float = 0, dashes: str = ""
) -> str:
    x, y, w, h = box
    corners = f' rx="{radius:g}"' if radius else ""
    corners += f' stroke-dasharray="{dashes}"' if dashes else ""
    return (
        f'<rect x="{_n(x)}" y="{_n(y)}" width="{_n(w)}" height="{_n(h)}"{corners} fill="{fill}" stroke="{line}" '
        f'stroke-width="{thick:g}"/>'
    )


def _moved(point: Point, by: float) -> Point:
    return point[0] + by, point[1] + by


def _xy(point: Point) -> str:
    return f"{_n(point[0])} {_n(point[1])}"


def _n(value: float) -> str:
    """Format a coordinate with at most one decimal, and no minus zero."""
    return f"{round(value, 1) + 0:g}" if abs(value) < 100_000 else f"{value:.1f}"
