"""Boxes and arrows made from the changed rows of a behaviour."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from rrp_sheets.connectors import connectors
from rrp_sheets.model.changed import ADDED, REMOVED, ChangedRow, ChangedStream, ComparableText, Link
from rrp_sheets.render.boxes import ROW_TEXT_LEFT, ROW_TOP, Arrow, Box, Drawing
from rrp_sheets.render.changes.lines import Line, marked_lines, plain
from rrp_sheets.render.measure import clean, width, wrap_whole
from rrp_sheets.render.style import FORMULA_LINE, MONO_PT, NAME_COLUMNS, NAME_LINE, NAME_PT, SMALL_PT

_COLUMNS, _LINES = 26, 6
_INDENT = 9.0  # room for a sign before a line
_REMARK_COLUMNS = 30


@dataclass(frozen=True)
class BoxLine:
    """Line in a box: its sign, its words, and whether it is set in a monospaced font."""

    sign: str
    words: Line
    mono: bool = True


@dataclass(frozen=True)
class ChangeBox(Box):
    """Box with the sign of its change.

    Attributes:
        sign: of the row or the stream.
        heading: the connector, or the stream's name in lines.
        told: the lines below the heading.
    """

    sign: str = ""
    heading: tuple[Line, ...] = ()
    told: tuple[BoxLine, ...] = ()


@dataclass(frozen=True)
class ChangeArrow(Arrow):
    """Arrow with the sign of its change; `labelled` when neither of its ends has the same sign."""

    sign: str = ""
    labelled: bool = False


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
    drawing = Drawing()

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


def _arrow(tail: str, head: str, link: Link, row: ChangedRow, stream_sign: str, headless: bool = False) -> ChangeArrow:
    labelled = bool(link.sign) and link.sign not in (row.sign, stream_sign)
    return ChangeArrow(tail, head, row.off, headless, sign=link.sign, labelled=labelled)


def _stream_box(box_id: str, stream: ChangedStream, note: str) -> ChangeBox:
    if stream.kind == "anonymous":
        size = (width(note, SMALL_PT) + 14, 12.0) if note else (7.0, 7.0)
        return ChangeBox(box_id, "anonymous", "", (), *size, stream.id, note, sign=stream.sign)
    heading = marked_lines(((False, stream.name.after),), NAME_COLUMNS, 2)
    told = [BoxLine(REMOVED, line, mono=False) for line in marked_lines(stream.name.was(), NAME_COLUMNS, 2)]
    told = told if stream.name.changed else []
    for name, words in stream.settings:
        told += _both(ComparableText(f"{name}: {words.before}", f"{name}: {words.after}"), mono=False)
    bold = stream.kind != "stream"
    wide = max((width(plain(line), NAME_PT, bold=bold) for line in heading), default=20.0)
    wide = max([wide, *(_width(line) for line in told)])
    high = NAME_LINE * len(heading) + FORMULA_LINE * len(told) + 8
    if note:
        wide, high = max(wide, width(note, SMALL_PT)), high + 10
    across = wide + 16 if bold else wide * 1.16 + 16
    if stream.kind == "stream" and len(heading) + len(told) + bool(note) > 1:  # an oval's corners are missing
        across, high = across + 14, high + 8
    if stream.kind == "actuator":
        across, high = across + 6, high + 5
    lines = tuple(plain(line) for line in heading)
    return ChangeBox(
        box_id, stream.kind, clean(stream.name.after), lines, across, high, stream.id, note, sign=stream.sign,
        heading=heading, told=tuple(told),
    )  # fmt: skip


def _row_box(row: ChangedRow) -> ChangeBox:
    connector = row.connector
    heading: Line = ((row.sign == REMOVED, connector.after or connector.before),)
    if connector.before and connector.after and connector.changed:
        heading = ((True, connector.before), (False, f" → {connector.after}"))
    told = _formula(row)
    told += [
        BoxLine("", line, mono=False)
        for remark in row.remarks
        for line in marked_lines(((False, remark),), _REMARK_COLUMNS, 2)
    ]
    wide = max([width(plain(heading), SMALL_PT, bold=True) + 4, *(_width(line) for line in told)])
    high = ROW_TOP + (FORMULA_LINE * len(told) + 4 if told else 0)
    name = connector.after or connector.before
    found = connectors().get(name)
    return ChangeBox(
        row.id, "row", clean(name), tuple(plain(line.words) for line in told), ROW_TEXT_LEFT + wide + 12, high,
        row=row.number, formula=row.formula.after or row.formula.before, icon=found.icon if found else "",
        off=row.off, sign=row.sign, heading=(heading,), told=tuple(told),
    )  # fmt: skip


def _formula(row: ChangedRow) -> list[BoxLine]:
    words = row.formula
    if row.sign == ADDED:
        return [BoxLine("", line) for line in marked_lines(((False, words.after),), _COLUMNS, _LINES, wrap_whole)]
    if row.sign == REMOVED:
        return [BoxLine("", line) for line in marked_lines(((True, words.before),), _COLUMNS, _LINES, wrap_whole)]
    if not words.changed:
        return [BoxLine("", line) for line in marked_lines(((False, words.after),), _COLUMNS, _LINES, wrap_whole)]
    return _both(words)


def _both(words: ComparableText, mono: bool = True) -> list[BoxLine]:
    """Return the text before and after, each in lines under its sign."""
    out = []
    for sign, runs in ((REMOVED, words.was()), (ADDED, words.now())):
        lines = marked_lines(runs or ((True, "blank"),), _COLUMNS, _LINES, wrap_whole)
        out += [BoxLine(sign if number == 0 else " ", line, mono) for number, line in enumerate(lines)]
    return out


def _width(told: BoxLine) -> float:
    indent = _INDENT if told.sign else 0.0
    marked = any(mark for mark, _ in told.words)
    return indent + width(plain(told.words), MONO_PT, mono=told.mono, bold=marked or not told.mono)
