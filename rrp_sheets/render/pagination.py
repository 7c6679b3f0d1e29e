"""Splits a long behaviour into parts of consecutive rows, each for one page."""

from __future__ import annotations

from collections.abc import Sequence

from rrp_sheets.graph import Graph, Step, StreamKind
from rrp_sheets.render.boxes import FROM_OUTSIDE, Note
from rrp_sheets.render.texts import Texts

_NEVER = 50.0  # the cost of cutting an anonymous stream: a dot that goes on elsewhere is hard to follow
Part = tuple[Step, ...]


def split(graph: Graph, steps: Sequence[Step], most: int) -> list[Part]:
    """Parts of at most `most` rows, of similar length, with few streams cut between them."""
    if len(steps) <= most:
        return [tuple(steps)]
    ideal = len(steps) / -(-len(steps) // most)
    crossing = _crossing(graph, steps)
    best: list[tuple[float, tuple[int, ...]]] = [(0.0, ())]  # by how many rows are placed: cost, and where parts end
    for end in range(1, len(steps) + 1):
        best.append(
            min(
                (
                    best[start][0] + crossing[end] + ((end - start - ideal) / ideal) ** 2 * 1.5 + 1.2,
                    (*best[start][1], end),
                )
                for start in range(max(0, end - most), end)
            )
        )
    ends = best[-1][1]
    return [tuple(steps[start:end]) for start, end in zip((0, *ends), ends, strict=False)]


def _crossing(graph: Graph, steps: Sequence[Step]) -> list[float]:
    """What a cut before each row costs; 0 at the end."""
    spans: dict[str, tuple[int, int]] = {}
    for number, step in enumerate(steps):
        for stream in (*step.inputs, step.output):
            first, _ = spans.get(stream, (number, number))
            spans[stream] = (first, number)
    costs = [0.0] * (len(steps) + 1)
    for stream, (first, last) in spans.items():
        kind = graph.streams[stream].kind
        if kind in FROM_OUTSIDE:
            continue
        for cut in range(first + 1, last + 1):
            costs[cut] += _NEVER if kind is StreamKind.ANONYMOUS else 1.0
    return costs


def cut_notes(graph: Graph, parts: Sequence[Part], words: Texts) -> list[dict[str, Note]]:
    """For each part, where its cut streams come from or go to: `{"tracking!far": Note("to part 2")}`."""
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
            if graph.streams[stream].kind in FROM_OUTSIDE:
                continue
            source = made.get(stream, number)
            elsewhere = [str(n) for n in used.get(stream, {}) if n != number]
            if source != number:
                here[stream] = Note(words.get("diagram.from_part", part=source), entry=True)
            elif elsewhere:
                here[stream] = Note(words.get("diagram.to_part", parts=words.in_a_row(elsewhere)))
        notes.append(here)
    return notes
