"""Boxes and arrows made from the rows of a behaviour: everything that a drawing shows except positions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from rrp_sheets.graph import BehaviourGraph, Graph, Step, Stream, StreamKind
from rrp_sheets.render.measure import clean, columns, width, wrap, wrap_whole
from rrp_sheets.render.style import (
    FORMULA_LINE,
    MONO_PT,
    NAME_COLUMNS,
    NAME_LINE,
    NAME_PT,
    SMALL_PT,
    VALUE_LINE,
    VALUE_ROOM,
    Wrapping,
)  # fmt: skip

_KINDS = {
    StreamKind.SENSOR: "sensor",
    StreamKind.ORDINARY: "stream",
    StreamKind.ACTUATOR: "actuator",
    StreamKind.ANONYMOUS: "anonymous",
    StreamKind.DONE: "done",
}
FROM_OUTSIDE = (StreamKind.SENSOR, StreamKind.ACTUATOR, StreamKind.DONE)  # stand in every part that uses them
ROW_TEXT_LEFT = 35.0  # from a row's left border: number, icon, then its text
ROW_TEXT_NARROW = 22.0  # and from there its formula, where it must be narrow
ROW_TOP = 18.0


@dataclass(frozen=True)
class Box:
    """Box of a drawing: a stream or a row.

    Attributes:
        id: unique within the behaviour, made by us: `r4` for the row 4, `s2` for a stream; a stream that stands in a
            further part has the part behind it (`s2-p3`).
        kind: `sensor`, `stream`, `actuator`, `done` (the end of an actuator's commands), `anonymous` or `row`.
        name: a stream's full name, or a row's connector.
        lines: the name's lines, or those of a row's formula.
        note: where a stream that is cut between two parts goes on.
        entry: it comes from another part.
        room: there is room under the name for the newest value.
        beside: where the formula starts when it stands beside the connector's name, else 0.
        indent: where its lines start when they stand below the name.
        off: drawn grey; `switched_off`: the row itself is, so that it says "off".
    """

    id: str
    kind: str
    name: str
    lines: tuple[str, ...]
    width: float
    height: float
    stream: str = ""
    note: str = ""
    entry: bool = False
    room: bool = False
    off: bool = False
    switched_off: bool = False
    row: int = 0
    formula: str = ""
    icon: str = ""
    beside: float = 0.0
    indent: float = ROW_TEXT_LEFT
    flag: int | None = None
    mark: str = ""


@dataclass(frozen=True)
class Arrow:
    """An arrow between two boxes; without a head when it ends in a dot.

    `world`: from an actuator to its done stream, a connection outside the program.
    """

    tail: str
    head: str
    off: bool = False
    headless: bool = False
    world: bool = False


@dataclass(frozen=True)
class Note:
    """Words on a stream that is cut between two parts: where it goes on, or (`entry`) where it comes from."""

    words: str
    entry: bool = False


@dataclass
class Drawing:
    """Boxes by id and arrows, in the order of the rows."""

    boxes: dict[str, Box] = field(default_factory=dict)
    arrows: list[Arrow] = field(default_factory=list)


@dataclass(frozen=True)
class Marks:
    """Marks drawn onto rows, by row number: the number of a problem's flag, and a word such as "changed"."""

    flags: Mapping[int, int] = field(default_factory=dict)
    words: Mapping[int, str] = field(default_factory=dict)


def stream_ids(behaviour: BehaviourGraph) -> dict[str, str]:
    """Return the box id of every stream, numbered by first appearance, so that it is the same in every part."""
    streams = dict.fromkeys(i for step in behaviour.steps for i in (*step.inputs, step.output))
    return {stream: f"s{n}" for n, stream in enumerate(streams, 1)}


def make_drawing(
    graph: Graph,
    behaviour: BehaviourGraph,
    steps: Sequence[Step],
    *,
    wrapping: Wrapping,
    marks: Marks,
    notes: Mapping[str, Note],
    part: int = 1,
    room: bool = False,
) -> Drawing:
    """Return the boxes and arrows of some steps.

    `notes` says by stream id where a cut stream comes from or goes to ("from part 1"); `part` is the
    number of the part, for the ids of streams that stand in several. With `room`, values fit under streams' names.
    """
    ids = stream_ids(behaviour)
    drawing = Drawing()

    def place(stream_id: str) -> str:
        stream = graph.streams[stream_id]
        in_several = stream_id in notes or stream.kind in FROM_OUTSIDE
        box_id = ids[stream_id] + (f"-p{part}" if part > 1 and in_several else "")
        if box_id not in drawing.boxes:
            drawing.boxes[box_id] = _stream_box(box_id, stream, notes.get(stream_id, Note("")), room)
        return box_id

    for step in steps:
        inputs = [place(i) for i in dict.fromkeys(step.inputs)]
        row = _row_box(step, wrapping, marks, ROW_TEXT_NARROW if room else ROW_TEXT_LEFT)
        drawing.boxes[row.id] = row
        for box_id in inputs:
            drawing.arrows.append(Arrow(box_id, row.id, row.off or drawing.boxes[box_id].off))
        output = place(step.output)
        anonymous = drawing.boxes[output].kind == "anonymous"
        drawing.arrows.append(Arrow(row.id, output, row.off, headless=anonymous))
    drawing.arrows += _through_the_world(graph, drawing)
    return drawing


def _through_the_world(graph: Graph, drawing: Drawing) -> list[Arrow]:
    """Return the arrows from actuators to their done streams."""
    actuators = {box.stream: box for box in drawing.boxes.values() if box.kind == "actuator"}
    dones = [(box, graph.streams[box.stream].done_of) for box in drawing.boxes.values() if box.kind == "done"]
    return [Arrow(actuators[of].id, box.id, box.off, world=True) for box, of in dones if of in actuators]


def _stream_box(box_id: str, stream: Stream, cut: Note, room: bool) -> Box:
    kind = _KINDS[stream.kind]
    note, entry = cut.words, cut.entry
    if kind == "anonymous":
        size = (width(note, SMALL_PT) + 14, 12.0) if note else (7.0, 7.0)
        return Box(box_id, kind, "", (), *size, stream.id, note, entry, off=not stream.active)
    bold = kind != "stream"
    lines = wrap(stream.name, NAME_COLUMNS, 2)
    text = max(width(line, NAME_PT, bold=bold) for line in lines)
    high = NAME_LINE * len(lines) + 8
    if note:
        text, high = max(text, width(note, SMALL_PT)), high + 10
    room = room and kind == "stream"
    if room:
        text, high = max(text, VALUE_ROOM), high + VALUE_LINE
    across = text + 16 if bold else text * 1.16 + 16
    if kind == "stream" and len(lines) + bool(note) > 1:  # an oval's corners are missing
        across, high = across + 10, high + 4
    if kind == "actuator":  # its second border
        across, high = across + 6, high + 5
    return Box(
        box_id, kind, clean(stream.name), lines, across, high, stream.id, note, entry, room,
        off=kind == "stream" and not stream.active,
    )  # fmt: skip


def _row_box(step: Step, wrapping: Wrapping, marks: Marks, indent: float) -> Box:
    formula = step.row.formula.text
    set_in_lines = wrap_whole if wrapping.whole else wrap
    lines = set_in_lines(formula, wrapping.columns, wrapping.lines) if formula else ()
    name = step.connector.name
    name_width = width(name, SMALL_PT)
    formula_width = max((width(line, MONO_PT, mono=True) for line in lines), default=0.0)
    mark = clean(marks.words.get(step.number, ""))
    mark_width = width(mark, MONO_PT, bold=True) + 14 if mark else 0.0
    is_beside = len(lines) == 1 and columns(lines[0]) <= wrapping.beside
    if is_beside:
        text, high = name_width + 6 + formula_width + mark_width, ROW_TOP
    else:
        text = max(name_width + 4 + mark_width, formula_width - ROW_TEXT_LEFT + indent)
        high = ROW_TOP + (FORMULA_LINE * len(lines) + 3 if lines else 0)
    return Box(
        f"r{step.number}", "row", name, lines, ROW_TEXT_LEFT + text + 7, high,
        off=not (step.row.on and step.active), switched_off=not step.row.on, row=step.number, formula=formula,
        icon=step.connector.icon, beside=name_width + 6 if is_beside else 0.0, indent=indent,
        flag=marks.flags.get(step.number), mark=mark,
    )  # fmt: skip
