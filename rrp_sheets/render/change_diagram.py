"""Diagram pages of the changes in a behaviour: which rows are drawn, their boxes and arrows, and the legend."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial

from rrp_sheets.connectors import connectors
from rrp_sheets.model.changed import (
    ADDED,
    CHANGED,
    REMOVED,
    SAME,
    ChangedBehaviour,
    ChangedRow,
    ChangedStream,
    ComparableText,
    Link,
)
from rrp_sheets.render import style
from rrp_sheets.render.boxes import TIMEOUT, Arrow, Box, BoxLine, Drawing, Note, dot_text, lay_out, row_box, stream_box
from rrp_sheets.render.diagram import Page, split
from rrp_sheets.render.svg import draw_sign, draw_svg, frame, text

MOST_DRAWN = 180
"""Rows that are drawn of one behaviour: ten parts. Lists name all."""
_AT_ONCE = 4  # parts that are laid out side by side
_COLUMNS, _LINES = 26, 6  # of a formula
_REMARK_COLUMNS = 30  # of a line of a remark
_HINTS = (
    "A formula that changed: first as it was, below as it is.",
    "Rows that are gone have the number that they had.",
)
_STATUSES = (ADDED, REMOVED, CHANGED, SAME)


def draw_changes(behaviour: ChangedBehaviour, number: int = 1, timeout: float = TIMEOUT) -> list[Page]:
    """Draw the changes in a behaviour: the changed rows and those that they are connected to.

    Ids in the picture have the `number` of the behaviour; `timeout` is that of each layout, in seconds.

    Raises:
        SheetsError: Graphviz is missing or took too long.
    """
    shown = drawn_rows(behaviour)
    kinds = {s.id: s.kind for s in behaviour.streams.values()}
    parts = split([(row, _streams(row)) for row in shown], style.MOST_ROWS, kinds)
    ids = {stream: f"s{n}" for n, stream in enumerate(behaviour.streams, 1)}
    draw = partial(_page, behaviour, ids, _left_out(behaviour, shown), number, timeout)
    with ThreadPoolExecutor(_AT_ONCE) as pool:
        return list(pool.map(draw, parts, range(1, len(parts) + 1), [len(parts)] * len(parts)))


def drawn_rows(behaviour: ChangedBehaviour) -> list[ChangedRow]:
    """Return all rows of a short behaviour; of a long one the changed rows and their neighbours in the graph."""
    rows = behaviour.rows
    if len(rows) <= style.MOST_ROWS:
        return list(rows)
    marked = {s.id for s in behaviour.streams.values() if s.sign}
    changed = [r for r in rows if r.sign or marked & _streams(r)][:MOST_DRAWN]
    wanted = {r.id for r in changed}
    reads = {link.stream for r in changed for link in r.takes}
    makes = {link.stream for r in changed for link in r.gives}
    for row in rows:
        beside = reads & {link.stream for link in row.gives} or makes & {link.stream for link in row.takes}
        if beside and len(wanted) < MOST_DRAWN:
            wanted.add(row.id)
    return [r for r in rows if r.id in wanted]


def _streams(row: ChangedRow) -> set[str]:
    return {link.stream for link in (*row.takes, *row.gives)}


def _left_out(behaviour: ChangedBehaviour, shown: Sequence[ChangedRow]) -> str:
    ids = {r.id for r in shown}
    hidden = [r for r in behaviour.rows if r.id not in ids]
    numbers = [r.number for r in hidden if not r.sign]
    told = [f"not drawn: {ranges(numbers)}, unchanged"] if numbers else []
    if more := len(hidden) - len(numbers):
        told.append(f"and {more:,} further changed rows, which the list has")
    return "; ".join(told)


def ranges(numbers: Iterable[int]) -> str:
    """Return row numbers in words.

    >>> ranges([2, 3, 4, 7]), ranges([5])
    ('rows 2–4 and 7', 'row 5')
    """
    runs: list[list[int]] = []
    for n in numbers:
        if runs and runs[-1][1] == n - 1:
            runs[-1][1] = n
        else:
            runs.append([n, n])
    words = [f"{a}–{b}" if a != b else f"{a}" for a, b in runs]
    if len(words) > 6:
        words = [*words[:3], "…", *words[-2:]]
    *before, last = words
    listed = f"{', '.join(before)} and {last}" if before else last
    one = len(runs) == 1 and runs[0][0] == runs[0][1]
    return f"row {listed}" if one else f"rows {listed}"


def _page(
    behaviour: ChangedBehaviour, ids: dict[str, str], left_out: str, number: int, timeout: float,
    rows: tuple[ChangedRow, ...], part: int, parts: int,
) -> Page:  # fmt: skip
    drawing = make_change_drawing(rows, behaviour.streams, ids, _notes(behaviour, rows), part)
    dot = dot_text(drawing, behaviour.name)
    layout = lay_out(dot, timeout=timeout)
    wide, high = layout.width + 2 * drawing.margin, layout.height + 2 * drawing.margin
    name = style.clean(behaviour.name)
    whole = f"{name}, part {part} of {parts}" if parts > 1 else name
    counts = [(sum(r.sign == status for r in rows), style.STATUS_STYLES[status].word) for status in _STATUSES]
    told = ", ".join(f"{count} row{'s' if count > 1 else ''} {word}" for count, word in counts if count)
    alt = f"What changed in the behaviour {whole}: {told}. The table of rows says the same."
    prefix = f"c{number}" + (f"-p{part}" if part > 1 else "")
    svg = draw_svg(drawing, layout, prefix=prefix, title=f"What changed in {whole}", description=alt)
    captions = [f"Part {part} of {parts}" if parts > 1 else "", left_out if part == 1 else ""]
    upright, turned = (min(1.0, most[0] / wide, most[1] / high) for most in (style.PAGE, style.LANDSCAPE))
    return Page(
        name, "; ".join(filter(None, captions)), svg, dot, wide, high, max(upright, turned), turned > upright,
        (rows[0].number, rows[-1].number), alt, part, parts,
    )  # fmt: skip


def _notes(behaviour: ChangedBehaviour, rows: Sequence[ChangedRow]) -> dict[str, str]:
    """Return the origins of the streams that rows of this part read and rows elsewhere make, by stream."""
    here = {r.id for r in rows}
    made = {link.stream for r in rows for link in r.gives}
    read = {link.stream for r in rows for link in r.takes} - made
    notes: dict[str, str] = {}
    for row in behaviour.rows:
        for link in row.gives if row.id not in here else ():
            if link.stream in read and behaviour.streams[link.stream].kind in ("stream", "anonymous"):
                notes.setdefault(link.stream, f"from row {row.number}")
    return notes


def legend_page(title: str) -> Page:
    """Return the legend of the pictures as a page under the given title."""
    x, parts = 8.0, []
    for status in _STATUSES:
        look, dashes = style.STATUS_STYLES[status], f' stroke-dasharray="{style.DASHES}"' if status == REMOVED else ""
        parts.append(f'<rect x="{x:.1f}" y="9" width="30" height="16" rx="3" fill="{look.fill}" stroke="{look.line}" '
                     f'stroke-width="{look.thick}"{dashes}/>')  # fmt: skip
        if status:
            parts.append(draw_sign(status, (x + 29, 10), 6.0))
        parts.append(text(x + 40, 21, look.word, style.NAME_PT))
        x += 40 + style.width(look.word, style.NAME_PT) * style.OTHER_FACES + 16
    for number, hint in enumerate(_HINTS):
        parts.append(text(8, 43 + 12 * number, hint, style.SMALL_PT, fill=style.SOFT, italic=True))
    wide = max(x, *(style.width(hint, style.SMALL_PT) * style.OTHER_FACES + 16 for hint in _HINTS))
    high = 38.0 + 12 * len(_HINTS)
    alt = ("Legend: a plus and a thick line for what is new, a minus and dashes for what is gone, a wave for what "
           "changed.")  # fmt: skip
    svg = frame("\n".join(parts), wide, high, ident="change-legend", title="How to read the pictures", description=alt)
    return Page(style.clean(title), "", svg, "", wide, high, 1.0, False, (0, 0), alt)


def make_change_drawing(
    rows: Sequence[ChangedRow], streams: Mapping[str, ChangedStream], ids: Mapping[str, str], notes: Mapping[str, str],
    part: int = 1,
) -> Drawing:  # fmt: skip
    """Return the boxes and arrows of some rows; `notes` tell where a stream comes from when that is not drawn here."""
    drawing = Drawing(margin=style.PADDING + style.SIGN)

    def place(stream: str) -> str:
        box_id = ids[stream] + (f"-p{part}" if part > 1 else "")
        if box_id not in drawing.boxes:
            drawing.boxes[box_id] = _stream_box(box_id, streams[stream], notes.get(stream, ""))
        return box_id

    for row in rows:
        heads = [(place(link.stream), link) for link in row.takes]
        box = _row_box(row)
        drawing.boxes[box.id] = box
        for box_id, link in heads:
            drawing.arrows.append(_arrow(box_id, box.id, link, row, streams[link.stream].sign))
        for link in row.gives:
            box_id = place(link.stream)
            headless = drawing.boxes[box_id].kind == "anonymous"
            drawing.arrows.append(_arrow(box.id, box_id, link, row, streams[link.stream].sign, headless))
    return drawing


def _arrow(tail: str, head: str, link: Link, row: ChangedRow, stream_sign: str, headless: bool = False) -> Arrow:
    labelled = bool(link.sign) and link.sign not in (row.sign, stream_sign)
    return Arrow(tail, head, row.off, headless, status=link.sign, labelled=labelled)


def _stream_box(box_id: str, stream: ChangedStream, note: str) -> Box:
    name = stream.name.after
    heading = style.marked_lines(((stream.sign == REMOVED, name),), style.NAME_COLUMNS, 2)
    was = style.marked_lines(stream.name.was(), style.NAME_COLUMNS, 2) if stream.name.changed else ()
    lines = [BoxLine(line, REMOVED, n > 0, mono=False) for n, line in enumerate(was)]
    for setting, words in stream.settings:
        lines += _both(ComparableText(f"{setting}: {words.before}", f"{setting}: {words.after}"), mono=False)
    return stream_box(box_id, stream.kind, stream.id, name, heading, tuple(lines), note=Note(note), status=stream.sign)


def _row_box(row: ChangedRow) -> Box:
    connector, words, removed = row.connector, row.formula, row.sign == REMOVED
    name = connector.after or connector.before
    heading: style.Line = ((removed, name),)
    if connector.before and connector.after and connector.changed:
        heading = ((True, connector.before), (False, f" → {connector.after}"))
    if row.sign not in (ADDED, REMOVED) and words.changed:
        lines = _both(words)
    else:
        runs = ((removed, words.before if removed else words.after),)
        lines = [BoxLine(line) for line in style.marked_lines(runs, _COLUMNS, _LINES, style.wrap_whole)]
    for remark in row.remarks:
        lines += [BoxLine(line, mono=False) for line in style.marked_lines(((False, remark),), _REMARK_COLUMNS, 2)]
    found = connectors().get(name)
    return row_box(
        row.id, row.number, name, found.icon if found else "", heading, tuple(lines),
        formula=words.after or words.before, off=row.off, status=row.sign,
    )  # fmt: skip


def _both(words: ComparableText, mono: bool = True) -> list[BoxLine]:
    """Return the text before and after, each in lines under its sign."""
    return [
        BoxLine(line, status, n > 0, mono)
        for status, runs in ((REMOVED, words.was()), (ADDED, words.now()))
        for n, line in enumerate(style.marked_lines(runs or ((True, "blank"),), _COLUMNS, _LINES, style.wrap_whole))
    ]
