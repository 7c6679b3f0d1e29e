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
_TOGETHER_US = 5_000_000  # rows that fail so soon after the first are shown with it


def scores(checked: Checked, result: CaseResult) -> list[MarbleDiagram]:
    """Return the events of a test as a marble diagram for each behaviour in which something came."""
    found = [_score(checked, result, behaviour) for behaviour in checked.graph.behaviours]
    return [
        replace(score, title=f"{result.case.name}: {score.title}")
        for score in found
        if any(lane.marbles for lane in score.lanes)
    ]


def _score(checked: Checked, result: CaseResult, behaviour: BehaviourGraph) -> MarbleDiagram:
    events = [(e.us, e.stream, e.row, e.value) for e in result.events]
    errors = [(f.us, f.row, f.message) for f in result.faults]
    score = make_score(checked.graph, behaviour, events, errors, result.ended_us)
    words = texts(checked.run.language)
    marks = tuple((r.row.time_us, words.get("behaviour.row", n=r.row.row)) for r in result.failed_rows)
    return replace(score, marks=marks, language=checked.run.language)


def around_failures(checked: Checked, result: CaseResult) -> MarbleDiagram:
    """Draw the time around the first rows that do not hold: their streams and those that these come from."""
    nothing = MarbleDiagram("", (), 0, 0)
    if not result.failed_rows:
        return nothing
    first_us = result.failed_rows[0].row.time_us
    failed = [r.row for r in result.failed_rows if r.row.time_us <= first_us + _TOGETHER_US]
    behaviour = _home(checked, failed[0].stream)
    if behaviour is None:
        return nothing
    begin = max(0, first_us - _BEFORE_US)
    sent = [r.time_us for r in result.case.rows if r.sending and r.time_us <= first_us]
    begin = min(begin, max(sent, default=begin))
    last = max(row.time_us for row in failed)
    ids = upstream(behaviour, dict.fromkeys(row.stream for row in failed), _MOST_LANES)
    until = min(last + _AFTER_US, max(result.ended_us, last))
    return _score(checked, result, behaviour).only(ids).between(begin, until)


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
