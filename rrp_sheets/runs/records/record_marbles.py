"""Marble diagrams of some rows and some time of a recorded run."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

from rrp_sheets.errors import UnreadableFile
from rrp_sheets.render.marble_diagram import MarbleDiagram
from rrp_sheets.render.marble_drawing import draw_marbles
from rrp_sheets.render.output import write_marbles
from rrp_sheets.runs.marbles import stamped, trace_scores
from rrp_sheets.runs.records.metadata import TRACE, stamp_of

MOST_PAGES = 12


def marbles(
    place: Path, behaviour: str, rows: Sequence[int], window: tuple[float | None, float | None], spread: bool
) -> dict[str, Any]:
    """Draw the streams of a behaviour as marble diagrams.

    Args:
        place: the run's folder.
        behaviour: its name; blank: the first.
        rows: only these, with their inputs; all when empty.
        window: seconds; None: from the begin, to the end.
        spread: whether a busy time is drawn in several strips instead of one.

    Returns:
        As JSON: the names of all behaviours, the rows of this one with what they do, and the pictures.
    """
    scores = _read(place)
    names = [s.title for s in scores]
    score = next((s for s in scores if s.title == behaviour), scores[0] if scores else None)
    if score is None:
        return {"behaviours": [], "behaviour": "", "rows": [], "seconds": 0.0, "pictures": [], "left_out": 0}
    bars = {b.row: b for g in score.groups for b in g.bars if b.row}
    shown = _shown(score, rows, window)
    pages = draw_marbles([shown], strips=0 if spread else 1) if shown is not None else []
    return {
        "behaviours": names, "behaviour": score.title, "seconds": score.last_us / 1e6,
        "rows": [[n, b.connector, b.formula[:200]] for n, b in sorted(bars.items())],
        "pictures": [p.svg for p in pages[:MOST_PAGES]], "left_out": max(0, len(pages) - MOST_PAGES),
    }  # fmt: skip


def write_run_marbles(
    place: Path, behaviour: str, rows: Sequence[int], window: tuple[float | None, float | None], target: Path
) -> list[str]:
    """Write the diagram of a behaviour, stamped, in the format of the suffix; return what it lacks, in words.

    Raises:
        SheetsError: nothing came then, or it cannot be drawn.
    """
    score = next((s for s in _read(place) if behaviour in ("", s.title)), None)
    shown = None if score is None else _shown(score, rows, window)
    return write_marbles(stamped([] if shown is None else [shown], stamp_of(place)), target)


def _read(place: Path) -> list[MarbleDiagram]:
    about = (place / TRACE).stat()
    try:
        return _scores(place, (about.st_mtime_ns, about.st_size))
    except (KeyError, TypeError, ValueError, OverflowError, RecursionError):
        raise UnreadableFile("FILE001", f"“{place.name}” is not a record of a run.", "Copy its folder again.") from None


def _shown(
    score: MarbleDiagram, rows: Sequence[int], window: tuple[float | None, float | None]
) -> MarbleDiagram | None:
    """Reduce a diagram to some rows and some time; return None when there is no such time."""
    first, last = window
    shown = score.only(_lanes(score, set(rows))) if rows else score
    if rows:
        groups = (replace(g, bars=tuple(b for b in g.bars if b.row in rows)) for g in shown.groups)
        shown = replace(shown, groups=tuple(groups))
    begin = 0 if first is None else round(first * 1e6)
    end = score.last_us if last is None else min(round(last * 1e6), score.last_us)
    return shown.between(begin, end) if begin < end else None


@lru_cache(maxsize=2)
def _scores(place: Path, stamp: tuple[int, int]) -> list[MarbleDiagram]:
    return trace_scores(place)


def _lanes(score: MarbleDiagram, rows: Collection[int]) -> set[str]:
    """Return the streams that some rows give, those that they take in, and what was done by hand meanwhile."""
    found = {"by hand"}
    inputs: set[str] = set()
    for group in score.groups:
        for bar in group.bars:
            if bar.row in rows:
                found.add(group.lane.id)
                inputs.update(bar.inputs)
    for group in score.groups:
        if group.lane.label in inputs or any(f"row {b.row}" in inputs for b in group.bars):
            found.add(group.lane.id)
    return found
