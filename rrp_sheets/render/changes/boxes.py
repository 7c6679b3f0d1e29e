"""Boxes and arrows made from the changed rows of a behaviour."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rrp_sheets.connectors import connectors
from rrp_sheets.model.changed import ADDED, REMOVED, ChangedRow, ChangedStream, ComparableText, Link
from rrp_sheets.render.boxes import Arrow, Box, BoxLine, Drawing, Note, row_box, stream_box
from rrp_sheets.render.measure import Line, marked_lines, wrap_whole
from rrp_sheets.render.style import NAME_COLUMNS, PADDING, SIGN

_COLUMNS, _LINES = 26, 6
_REMARK_COLUMNS = 30


def make_change_drawing(
    rows: Sequence[ChangedRow], streams: Mapping[str, ChangedStream], ids: Mapping[str, str], notes: Mapping[str, str],
    part: int = 1,
) -> Drawing:  # fmt: skip
    """Return the boxes and arrows of some rows.

    Args:
        rows: in their order.
        streams: by id.
        ids: the box id of every stream.
        notes: where a stream comes from or goes to, when that is not drawn here.
        part: the number of the part.
    """
    drawing = Drawing(margin=PADDING + SIGN)

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
    heading = marked_lines(((stream.sign == REMOVED, name),), NAME_COLUMNS, 2)
    was = marked_lines(stream.name.was(), NAME_COLUMNS, 2) if stream.name.changed else ()
    lines = [BoxLine(line, REMOVED, n > 0, mono=False) for n, line in enumerate(was)]
    for setting, words in stream.settings:
        lines += _both(ComparableText(f"{setting}: {words.before}", f"{setting}: {words.after}"), mono=False)
    return stream_box(box_id, stream.kind, stream.id, name, heading, tuple(lines), note=Note(note), status=stream.sign)


def _row_box(row: ChangedRow) -> Box:
    connector = row.connector
    heading: Line = ((row.sign == REMOVED, connector.after or connector.before),)
    if connector.before and connector.after and connector.changed:
        heading = ((True, connector.before), (False, f" → {connector.after}"))
    lines = _formula(row)
    lines += [
        BoxLine(line, mono=False)
        for remark in row.remarks
        for line in marked_lines(((False, remark),), _REMARK_COLUMNS, 2)
    ]
    name = connector.after or connector.before
    found = connectors().get(name)
    return row_box(
        row.id, row.number, name, found.icon if found else "", heading, tuple(lines),
        formula=row.formula.after or row.formula.before, off=row.off, status=row.sign,
    )  # fmt: skip


def _formula(row: ChangedRow) -> list[BoxLine]:
    words = row.formula
    if row.sign not in (ADDED, REMOVED) and words.changed:
        return _both(words)
    runs = ((row.sign == REMOVED, words.before if row.sign == REMOVED else words.after),)
    return [BoxLine(line) for line in marked_lines(runs, _COLUMNS, _LINES, wrap_whole)]


def _both(words: ComparableText, mono: bool = True) -> list[BoxLine]:
    """Return the text before and after, each in lines under its sign."""
    out = []
    for status, runs in ((REMOVED, words.was()), (ADDED, words.now())):
        lines = marked_lines(runs or ((True, "blank"),), _COLUMNS, _LINES, wrap_whole)
        out += [BoxLine(line, status, n > 0, mono) for n, line in enumerate(lines)]
    return out
