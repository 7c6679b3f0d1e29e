"""Draws a behaviour as diagram pages: division into parts, layout by Graphviz, pictures as SVG; and their legend."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from typing import TypeVar

from rrp_sheets.connectors import connectors
from rrp_sheets.graph import BehaviourGraph, Graph, Step
from rrp_sheets.render import boxes, style
from rrp_sheets.render.boxes import FROM_OUTSIDE, TIMEOUT, Box, Drawing, Layout, Marks, Note
from rrp_sheets.render.svg import draw_badge, draw_box, draw_flag, draw_icon, draw_svg, frame, text
from rrp_sheets.render.texts import Texts, texts
from rrp_sheets.texts import translate

_FEWEST_UPRIGHT = 2  # rows of a part that may not be turned
_AT_ONCE = 4  # Graphviz processes side by side
_CUT_COSTS = {"stream": 1.0, "anonymous": 50.0}  # a dot that goes on elsewhere is hard to follow; others cost nothing
_LEGEND_LINE = 20.0  # from line to line of the legend
_LEGEND_X = (14.0, 170.0, 326.0)  # where its columns begin
_LEGEND_KINDS = ("sensor", "stream", "actuator", "anonymous", "done")
Row = TypeVar("Row")
Part = tuple[Step, ...]


@dataclass(frozen=True)
class Page:
    """Picture of a behaviour, or of a part of one; sizes are in points.

    Attributes:
        caption: which part of how many, with its first and last row (“Part 1 of 3: rows 2 to 9”; of marbles and in
            comparisons without them); empty for one part. In a comparison that of the first part, also of one that is
            alone, says too which rows are not drawn.
        svg: the picture; ids are `b1-r4` for the row 4 of the first behaviour, `b1-s2` for a stream.
        dot: the text that Graphviz got.
        scale: by which it fits an A4 page, at most 1; for that the page is turned to `landscape`.
        rows: the first and the last row.
        alt: for people who do not see the picture.
    """

    title: str
    caption: str
    svg: str
    dot: str
    width: float
    height: float
    scale: float
    landscape: bool
    rows: tuple[int, int]
    alt: str
    part: int = 1
    parts: int = 1
    language: str = "en"


@dataclass(frozen=True)
class _Fitted:
    """A drawing with its layout, and how well it fits a page (smaller is better)."""

    badness: tuple[bool, bool, bool, float, int]
    drawing: Drawing
    dot: str
    layout: Layout
    scale: float
    landscape: bool


def draw_diagram(
    graph: Graph, behaviour: BehaviourGraph, *, problems: Mapping[int, int] | None = None,
    words: Mapping[int, str] | None = None, title: str = "", whole: bool = False, room: bool = False,
    upright: bool = False, binary: str | None = None, timeout: float = TIMEOUT, language: str = "en",
) -> list[Page]:  # fmt: skip
    """Draw a behaviour for A4 pages, in parts when it is long.

    Args:
        graph: of the whole workbook.
        behaviour: one of the graph's.
        problems: the number of the flag that a row bears, by the row's number.
        words: a short word on a row ("changed"), by the row's number.
        title: shown as heading; the behaviour's name by default.
        whole: draw it as one picture however large it becomes, for a screen that scrolls.
        room: for a panel of a live page: narrow, with room for the newest value under each name, and boxes to choose.
        upright: divide a wide one rather than turn the page; what cannot be divided becomes smaller.
        binary: the Graphviz program; by default the best of this machine.
        timeout: of each layout, in seconds.
        language: of the words that are not the workbook's.

    Raises:
        SheetsError: Graphviz is missing or took too long.
    """
    if not behaviour.steps:
        return []
    marks = Marks(dict(problems or {}), dict(words or {}))
    job = _Job(graph, behaviour, marks, partial(boxes.lay_out, binary=binary, timeout=timeout), room, upright)
    said = texts(language)
    fewest = _FEWEST_UPRIGHT if upright else style.FEWEST_ROWS
    parts = split_steps(graph, behaviour.steps, len(behaviour.steps) if whole else style.MOST_ROWS)
    while True:
        with ThreadPoolExecutor(_AT_ONCE) as pool:
            fitted = list(pool.map(job.draw, parts, cut_notes(graph, parts, said), range(1, len(parts) + 1)))
        if whole:
            break
        divided: list[Part] = []
        for part, fit in zip(parts, fitted, strict=True):
            too_large = fit.badness[0] and len(part) > fewest
            divided += split_steps(graph, part, -(-len(part) // 2)) if too_large else [part]
        if len(divided) == len(parts):
            break
        parts = divided
    number = next((n for n, b in enumerate(graph.behaviours, 1) if b.key == behaviour.key), 1)
    name = style.clean(title or behaviour.name)
    return [
        _page(name, f"b{number}", (part, place, len(parts)), fit, room, said)
        for place, (part, fit) in enumerate(zip(parts, fitted, strict=True), 1)
    ]


def to_dot(graph: Graph, behaviours: Sequence[BehaviourGraph]) -> str:
    """Return whole behaviours as one graph in the DOT language, a cluster for each; the same on every machine."""
    return boxes.dot_file([
        (b.name, boxes.make_drawing(graph, b, b.steps, wrapping=style.WRAPPINGS[0], marks=Marks(), notes={}))
        for b in behaviours
        if b.steps
    ])  # fmt: skip


@dataclass(frozen=True)
class _Job:
    """Inputs shared by the drawings of all parts of a behaviour."""

    graph: Graph
    behaviour: BehaviourGraph
    marks: Marks
    lay_out: partial[Layout]
    room: bool = False
    upright: bool = False

    def draw(self, part: Part, notes: Mapping[str, Note], number: int) -> _Fitted:
        """Return the first candidate that fits an upright page at full size, else the best one."""
        best: _Fitted | None = None
        for candidate in self._candidates(part, notes, number):
            if best is None or candidate.badness < best.badness:
                best = candidate
            if (best.scale >= 1 and not best.landscape) or len(part) > style.MOST_ROWS:
                break
        assert best is not None
        return best

    def _candidates(self, part: Part, notes: Mapping[str, Note], number: int) -> Iterator[_Fitted]:
        entries = any(note.entry for note in notes.values())
        for wrapping in (style.BESIDE_A_TABLE,) if self.room else style.WRAPPINGS:
            drawing = boxes.make_drawing(
                self.graph, self.behaviour, part, wrapping=wrapping, marks=self.marks, notes=notes, part=number,
                room=self.room,
            )  # fmt: skip
            for pinned in (True, False) if entries else (True,):
                dot = boxes.dot_text(drawing, self.behaviour.name, pin_entries=pinned, narrow=self.room)
                layout = self.lay_out(dot)
                wide, high = layout.width + 2 * drawing.margin, layout.height + 2 * drawing.margin
                sizes = ((False, style.PAGE),) if self.upright else ((False, style.PAGE), (True, style.LANDSCAPE))
                for landscape, (most_wide, most_high) in sizes:
                    scale = min(1.0, most_wide / wide, most_high / high)
                    badness = (scale < style.LEAST_SCALE, landscape, not pinned, -round(scale, 2), -wrapping.columns)
                    yield _Fitted(badness, drawing, dot, layout, scale, landscape)


def _page(title: str, prefix: str, place: tuple[Part, int, int], fit: _Fitted, chosen: bool, words: Texts) -> Page:
    part, part_number, parts = place
    first, last = part[0].number, part[-1].number
    caption = words.get("diagram.caption", n=part_number, m=parts, first=first, last=last) if parts > 1 else ""
    whole_title = words.get("diagram.title", title=title, n=part_number, m=parts) if parts > 1 else title

    def names(kind: str) -> str:
        found = [box.name for box in fit.drawing.boxes.values() if box.kind == kind]
        return words.in_a_row(found) or words.get("diagram.none")

    rows = words.get("diagram.rows" if first != last else "diagram.row", first=first, last=last, n=first)
    alt = words.get("diagram.alt", title=whole_title, rows=rows, sensors=names("sensor"), actuators=names("actuator"))
    svg = draw_svg(
        fit.drawing, fit.layout, prefix=prefix, title=whole_title, description=alt, chosen=chosen, words=words
    )
    return Page(
        title, caption, svg, fit.dot, fit.layout.width + 2 * style.PADDING, fit.layout.height + 2 * style.PADDING,
        fit.scale, fit.landscape, (first, last), alt, part_number, parts, words.language,
    )  # fmt: skip


def split_steps(graph: Graph, steps: Sequence[Step], most: int) -> list[Part]:
    """Split rows of a graph into parts of at most `most` rows."""
    kinds = {i: graph.streams[i].kind.value for step in steps for i in (*step.inputs, step.output)}
    return split([(step, (*step.inputs, step.output)) for step in steps], most, kinds)


def split(rows: Sequence[tuple[Row, Iterable[str]]], most: int, kinds: Mapping[str, str]) -> list[tuple[Row, ...]]:
    """Split rows, each with its streams, into parts of similar length and at most `most` rows, with few streams cut."""
    if len(rows) <= most:
        return [tuple(row for row, _ in rows)]
    ideal = len(rows) / -(-len(rows) // most)
    crossing = _crossing([streams for _, streams in rows], kinds)
    best: list[tuple[float, tuple[int, ...]]] = [(0.0, ())]  # by how many rows are placed: cost, and where parts end
    for end in range(1, len(rows) + 1):
        ways = []
        for start in range(max(0, end - most), end):
            cost, ends = best[start]
            ways.append((cost + crossing[end] + ((end - start - ideal) / ideal) ** 2 * 1.5 + 1.2, (*ends, end)))
        best.append(min(ways))
    ends = best[-1][1]
    return [tuple(row for row, _ in rows[start:end]) for start, end in zip((0, *ends), ends, strict=False)]


def _crossing(rows: Sequence[Iterable[str]], kinds: Mapping[str, str]) -> list[float]:
    """Return the cost of a cut before each row; 0 at the end."""
    spans: dict[str, tuple[int, int]] = {}
    for number, streams in enumerate(rows):
        for stream in streams:
            first, _ = spans.get(stream, (number, number))
            spans[stream] = (first, number)
    costs = [0.0] * (len(rows) + 1)
    for stream, (first, last) in spans.items():
        for cut in range(first + 1, last + 1):
            costs[cut] += _CUT_COSTS.get(kinds[stream], 0.0)
    return costs


def cut_notes(graph: Graph, parts: Sequence[Part], words: Texts) -> list[dict[str, Note]]:
    """Return for each part the notes on its cut streams: `{"tracking!far": Note("to part 2")}`."""
    made: dict[str, int] = {}
    used: dict[str, dict[int, None]] = {}
    for number, part in enumerate(parts, 1):
        for step in part:
            made.setdefault(step.output, number)
            for stream in step.inputs:
                used.setdefault(stream, {})[number] = None
    notes: list[dict[str, Note]] = []
    for number, part in enumerate(parts, 1):
        here: dict[str, Note] = {}
        for stream in dict.fromkeys(i for step in part for i in (*step.inputs, step.output)):
            if graph.streams[stream].kind.value in FROM_OUTSIDE:
                continue
            source = made.get(stream, number)
            elsewhere = [str(n) for n in used.get(stream, {}) if n != number]
            if source != number:
                here[stream] = Note(words.get("diagram.from_part", part=source), entry=True)
            elif elsewhere:
                here[stream] = Note(words.get("diagram.to_part", parts=words.in_a_row(elsewhere)))
        notes.append(here)
    return notes


def draw_legend(language: str = "en", used: Collection[str] = ()) -> tuple[str, float, float]:
    """Return the legend as SVG, its width and its height in points; of some connectors, or of all of them."""
    words = texts(language)
    wide, y, (left, middle, right) = style.PAGE[0], 40.0, _LEGEND_X
    title, alt, size = words.get("legend.title"), words.get("legend.alt"), style.NAME_PT
    parts = [text(left, 19, title, size, bold=True)]
    for kind, x, row in zip(_LEGEND_KINDS, (left, middle, right, left, left), (0, 0, 0, 1, 2), strict=True):
        box = Box(f"sign-{kind}", kind, "", *((7.0, 7.0) if kind == "anonymous" else (28.0, 17.0)))
        parts.append(draw_box(box, (x + 14, y + row * 24), "legend", words=words))
        parts.append(text(x + 36, y + row * 24 + 3.4, words.get(f"legend.{kind}"), size))
    parts += [
        f'<rect x="{middle}" y="{y + 16}" width="28" height="16" rx="3" fill="{style.OFF_FILL}" '
        f'stroke="{style.OFF_LINE}" stroke-width="0.9" stroke-dasharray="3 2.2"/>',
        text(middle + 36, y + 27.4, words.get("legend.off"), size),
        draw_flag(1, right + 7, y + 17),
        text(right + 36, y + 27.4, words.get("legend.flag"), size),
    ]
    y += 64
    example = connectors().get("filter")
    parts += [
        f'<rect x="{left}" y="{y}" width="36" height="18" rx="3" fill="#fff" stroke="{style.INK}" stroke-width="0.9"/>',
        draw_badge(3, left, y, 18, style.BADGE),
        draw_icon(example.icon if example else "", left + 21, y + 3.4, style.INK),
        text(left + 44, y + 12.4, words.get("legend.row"), size),
    ]
    y += 36
    known = [c for c in dict.fromkeys(connectors()) if c.legend and (not used or c.name in used)]
    half = -(-len(known) // 2)
    for number, connector in enumerate(known):
        x, line = (left if number < half else wide / 2 + 8), y + number % half * _LEGEND_LINE
        about = translate(connector.legend_message(), language)
        meaning = words.get("legend.meaning", connector=connector.name, meaning=about)
        parts.append(draw_icon(connector.icon, x + 4, line - 9, style.INK, 1))
        parts.append(text(x + 26, line, meaning, size - 1 if style.width(meaning, size) > wide / 2 - 30 else size))
    high = y + half * _LEGEND_LINE - 6
    border = (f'<rect x="0.5" y="0.5" width="{wide - 1:g}" height="{high - 1:g}" rx="4" fill="#fff" stroke="#9a9a9a" '
              'stroke-width="0.7"/>')  # fmt: skip
    return frame("\n".join([border, *parts]), wide, high, ident="legend", title=title, description=alt), wide, high
