"""Marble diagrams of tests."""

from __future__ import annotations

from dataclasses import replace

from rrp_sheets.checks import Checked
from rrp_sheets.graph import BehaviourGraph
from rrp_sheets.render.marble_diagram import MarbleDiagram, make_score, upstream
from rrp_sheets.render.texts import texts
from rrp_sheets.testing.results import CaseResult

_MOST_LANES = 10
_BEFORE_US, _AFTER_US = 3_000_000, 500_000


def scores(checked: Checked, result: CaseResult) -> list[MarbleDiagram]:
    """Return the events of a test as a marble diagram for each behaviour in which something came."""
    events = [(e.us, e.stream, e.row, e.value) for e in result.events]
    errors = [(f.us, f.row, f.message) for f in result.faults]
    found, language = [], checked.run.language
    for behaviour in checked.graph.behaviours:
        score = make_score(checked.graph, behaviour, events, errors, result.ended_us)
        if any(lane.marbles for lane in score.lanes):
            found.append(
                replace(
                    score, title=f"{result.case.name}: {score.title}", marks=_marks(result, language), language=language
                )
            )
    return found


def _marks(result: CaseResult, language: str) -> tuple[tuple[int, str], ...]:
    return tuple((r.row.time_us, texts(language).get("behaviour.row", n=r.row.row)) for r in result.failed_rows)


def around_failures(checked: Checked, result: CaseResult) -> MarbleDiagram:
    """Draw the time around the first rows that do not hold: their streams and those that these come from."""
    if not result.failed_rows:
        return MarbleDiagram("", (), 0, 0)
    first, language = result.failed_rows[0], checked.run.language
    wanted = [r.row.stream for r in result.failed_rows if r.row.time_us <= first.row.time_us + 5_000_000]
    behaviour = _home(checked, wanted[0])
    if behaviour is None:
        return MarbleDiagram("", (), 0, 0)
    events = [(e.us, e.stream, e.row, e.value) for e in result.events]
    score = make_score(
        checked.graph, behaviour, events, [(f.us, f.row, f.message) for f in result.faults], result.ended_us
    )
    begin = max(0, first.row.time_us - _BEFORE_US)
    sent = [r.time_us for r in result.case.rows if r.sending and r.time_us <= first.row.time_us]
    begin = min(begin, max(sent, default=begin))
    last = max(r.row.time_us for r in result.failed_rows if r.row.time_us <= first.row.time_us + 5_000_000)
    ids = upstream(behaviour, dict.fromkeys(wanted), _MOST_LANES)
    shown = score.only(ids).between(begin, min(last + _AFTER_US, max(result.ended_us, last)))
    return replace(shown, marks=_marks(result, language), language=language)


def _home(checked: Checked, stream: str) -> BehaviourGraph | None:
    """The behaviour whose rows give a stream, or use it."""
    behaviours = checked.graph.behaviours
    for found in (
        [b for b in behaviours if any(s.output == stream for s in b.steps)],
        [b for b in behaviours if any(stream in s.inputs for s in b.steps)],
    ):
        if found:
            return found[0]
    return None
