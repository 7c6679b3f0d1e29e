"""Behaviours in the ethics pack: diagrams, sentences and the table, row by row, under the sheet's comments."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

from rrp_sheets.errors import SheetsError
from rrp_sheets.graph import BehaviourGraph
from rrp_sheets.model.names import key
from rrp_sheets.model.workbook import Behaviour
from rrp_sheets.render.diagram import Page, draw_diagram
from rrp_sheets.render.measure import clean
from rrp_sheets.render.pack.model import BehaviourPart, Changes, Figure, Sentence, TableRow
from rrp_sheets.render.pack.source import Source, capital
from rrp_sheets.render.sentences import BehaviourText, explain

MOST_DRAWN = 2_000  # rows; a hundred pages
MOST_TOLD = 8  # rows that a paragraph tells; of more the sentences are enough
_SECONDS = 20.0  # for one diagram's layout

Pictures = dict[str, str]
"""SVG texts by file name."""
Draw = Callable[..., tuple[tuple[Figure, ...], list[str]]]


def behaviour_parts(
    source: Source, changes: Changes | None, *, drawn: bool = True
) -> tuple[tuple[BehaviourPart, ...], Pictures]:
    """Return the parts of all behaviours in the order of the sheets, and their diagrams."""
    pictures: Pictures = {}
    draw: Draw = partial(_figures, pictures=pictures) if drawn else lambda *_: ((), [])
    written = {key(b.name): b for b in source.checked.workbook.behaviours}
    marks = changes.marks if changes else {}
    parts = []
    for graph in source.checked.graph.behaviours:
        behaviour = written[graph.key]
        groups = {n: capital(clean(text)) for n, text in behaviour.headings.items()}
        parts.append(_part(source, graph, behaviour, groups, marks.get(graph.key, {}), draw))
    return tuple(parts), pictures


def _part(
    source: Source, graph: BehaviourGraph, behaviour: Behaviour, groups: Mapping[int, str], marks: Mapping[int, str],
    draw: Draw,
) -> BehaviourPart:  # fmt: skip
    said = explain(
        source.checked.graph, source.checked.workbook, source.checked.robot, [graph], language=source.words.language
    )[0]
    flags = source.flags(graph.key)
    figures, why = draw(source, graph, flags, marks)
    off = graph.key not in source.checked.run.behaviours
    notes = [source.get("behaviours.starts_off")] if off and graph.steps else []
    sentences = tuple(
        Sentence(r.number, r.text, tuple(flags.get(r.number, ())), marks.get(r.number, ""), groups.get(r.number, ""))
        for r in said.rows
    )
    rows = tuple(
        TableRow(
            r.number, clean(source.listed_cells(r.inputs)), clean(r.connector.text), r.formula.text.strip(),
            clean(r.output.text), r.on, f"{r.priority:g}" if r.priority else "", clean(r.notes),
            marks.get(r.number, ""), groups.get(r.number, ""),
        )
        for r in behaviour.rows
    )  # fmt: skip
    paragraph = said.paragraph if len(said.rows) <= MOST_TOLD else ""
    return BehaviourPart(
        said.name, *_lists(source, said), paragraph, source.words.sentences([*notes, *why]), figures, sentences, rows
    )


def _lists(source: Source, said: BehaviourText) -> tuple[str, str]:
    """Return the sensors and the actuators of a behaviour, in words."""
    takes_in, acts_on = (
        source.words.get(f"behaviour.{kind}", list=source.listed(names))
        if names
        else source.words.get(f"behaviour.no_{kind}")
        for kind, names in (("sensors", said.sensors), ("actuators", said.actuators))
    )
    return takes_in, acts_on


def _figures(
    source: Source, graph: BehaviourGraph, flags: Mapping[int, list[int]], marks: Mapping[int, str], pictures: Pictures
) -> tuple[tuple[Figure, ...], list[str]]:
    """Return the diagrams, and in words why there are none."""
    if not graph.steps:
        return (), [source.get("behaviours.empty")]
    if len(graph.steps) > MOST_DRAWN:
        return (), [source.get("behaviours.too_long", n=f"{len(graph.steps):,}", most=f"{MOST_DRAWN:,}")]
    problems = {row: numbers[0] for row, numbers in flags.items()}
    words = {row: source.get(f"mark.{mark}") for row, mark in marks.items()}
    try:
        pages = draw_diagram(
            source.checked.graph, graph, problems=problems, words=words, timeout=_SECONDS,
            language=source.words.language, upright=True,
        )  # fmt: skip
    except SheetsError as error:
        return (), [source.get("behaviours.no_diagram", why=error.message)]
    return tuple(_figure(source, page, pictures) for page in pages), []


def _figure(source: Source, page: Page, pictures: Pictures) -> Figure:
    name = f"figure-{len(pictures) + 1}.svg"
    pictures[name] = page.svg
    first, last = page.rows
    entry = "rows" if page.parts == 1 else "part"
    caption = source.get(
        f"behaviours.{entry}", name=page.title, part=page.part, parts=page.parts, first=first, last=last
    )
    wide, high = page.width * page.scale, page.height * page.scale
    return Figure(name, page.alt, caption, wide, high, first, last)
