"""The tutorial beside a sheet: one lesson with its steps, what of them is written already, and its test."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

from flask import Blueprint, abort

from rrp_sheets.documents import Document
from rrp_sheets.documents.grid import Grid
from rrp_sheets.help.tutorial import TutorialLesson, TutorialStep, lesson_of
from rrp_sheets.model.workbook import truth_of
from rrp_sheets.texts import translate
from rrp_sheets.web.models import TextPiece, pieces, show
from rrp_sheets.web.requests import page_language, workbook_or_404
from rrp_sheets.web.workbook_tests import (
    FAILS,
    MOST_TERMS,
    PASSES,
    Lesson,
    Missed,
    WorkbookTests,
    lessons_of,
    number_of,
    terms_in,
)
from rrp_sheets.workbook.schema import BEHAVIOUR

blueprint = Blueprint("lessons", __name__)
_COLUMNS = {column.name: column.kind for column in BEHAVIOUR.columns}


@dataclass(frozen=True, slots=True)
class StepLine:
    """Step of a lesson as it is shown: `state` is done, now or later; `cells` are those that it writes, as JSON.

    Each of the cells has the id of its row, the kind of its column and its text.
    """

    text: tuple[TextPiece, ...]
    state: str
    cells: str


@dataclass(frozen=True, slots=True)
class LessonMark:
    """Mark for a lesson in the row of all: its number and title, and whether its test passes."""

    number: int
    title: str
    done: bool


@dataclass(frozen=True, slots=True)
class LessonPanel:
    """Panel with one lesson.

    Attributes:
        place: the number of the lesson among those of the workbook, from 1.
        sheet: the name of the behaviour in which its rows stand; `row` is the id of their heading.
        state: of the test, as in `workbook_tests`; empty before it has run.
        missed: the first rows of the test that fail.
        shows: the cells of the first step that is not done, as JSON; empty when all are.
        unready: whether the test results are not of the newest change.
    """

    template: ClassVar[str] = "lesson.html"
    name: str
    here: str
    place: int
    test: str
    title: str
    about: str
    marks: tuple[LessonMark, ...]
    steps: tuple[StepLine, ...]
    sheet: str
    row: str
    terms: tuple[str, ...]
    state: str
    missed: tuple[Missed, ...]
    shows: str
    unready: bool


@blueprint.get("/book/<name>/lesson/<int:number>")
@blueprint.get("/book/<name>/lesson/<int:number>/<sheet>")
def lesson(name: str, number: int, sheet: str = "") -> str:
    """Show a lesson of a workbook; with number 0 the first whose test does not pass."""
    session = workbook_or_404(name)
    panel = lesson_panel(session.tests, session.document, name, session.document.current(sheet), number)
    return show(panel) if panel else abort(404)


def lesson_panel(
    tests: WorkbookTests, document: Document, name: str, sheet: str, number: int = 0
) -> LessonPanel | None:
    """Build the panel of a lesson; None for a workbook without lessons of the tutorial."""
    found = [known for test in tests.sheets if (known := lesson_of(test))]
    if not found:
        return None
    results = tests.results
    passes = [(result := results.of(one.test)) is not None and result.state == PASSES for one in found]
    first = next((n for n, done in enumerate(passes, 1) if not done), 1)
    place = number if 1 <= number <= len(found) else first
    chosen, done = found[place - 1], passes[place - 1]
    told = lessons_of(document.grids)
    here = told.get(number_of(chosen.test) or 0)
    steps = _steps(chosen, told, document.grids, done=done)
    result = results.of(chosen.test)
    return LessonPanel(
        name=name, here=sheet, place=place, test=chosen.test, title=chosen.title, about=chosen.about,
        marks=tuple(LessonMark(n, one.title, yes) for n, (one, yes) in enumerate(zip(found, passes, strict=True), 1)),
        steps=steps, sheet=here.sheet if here else "", row=here.row if here else "",
        terms=_terms(found)[place - 1], state=result.state if result else "",
        missed=result.missed[:1] if result and result.state == FAILS else (),
        shows=next((step.cells for step in steps if step.state == "now"), ""),
        unready=results.stale or results.running or result is None,
    )  # fmt: skip


def _steps(
    chosen: TutorialLesson, told: Mapping[int, Lesson], grids: Mapping[str, Grid], *, done: bool
) -> tuple[StepLine, ...]:
    lines: list[StepLine] = []
    own = number_of(chosen.test) or 0
    for step in chosen.steps:
        place = told.get(step.of or own)
        grid = grids.get(place.sheet) if place else None
        rows = _rows_below(grid, place.row) if grid and place else []
        written = done or (grid is not None and any(_is_written(grid, row, step.cells) for row in rows))
        now = not written and all(line.state == "done" for line in lines)
        state = "done" if written else "now" if now else "later"
        lines.append(StepLine(pieces(translate(chosen.said(step), page_language())), state, _cells(step, rows)))
    return tuple(lines)


def _rows_below(grid: Grid, heading: str) -> list[str]:
    """Return the rows between a heading and the next."""
    if heading not in grid.rows:
        return []
    found: list[str] = []
    for row in grid.rows[grid.rows.index(heading) + 1 :]:
        texts = grid.texts.get(row, {})
        if texts and texts[min(texts)].lstrip().startswith("#"):
            break
        found.append(row)
    return found


def _is_written(grid: Grid, row: str, cells: Mapping[str, str]) -> bool:
    now = {_COLUMNS.get(column.name, ""): grid.text(row, column.number) for column in grid.columns}
    if truth_of(cells.get("on", "")) and truth_of(now.get("on", "")) is False:
        return False
    return all(_plain(now.get(kind, "")) == _plain(text) for kind, text in cells.items() if kind != "on")


def _plain(text: str) -> str:
    return "".join(text.split()).casefold()


def _cells(step: TutorialStep, rows: list[str]) -> str:
    row = rows[step.row - 1] if step.row <= len(rows) else ""
    return json.dumps([{"row": row, "kind": kind, "text": text} for kind, text in step.cells.items()]) if row else ""


def _terms(lessons: Sequence[TutorialLesson]) -> list[tuple[str, ...]]:
    """Return the words of each lesson that there is help on and that no lesson before has."""
    met: set[str] = set()
    found = []
    for one in lessons:
        texts = (one.about, *map(one.said, one.steps))
        new = dict.fromkeys(term for text in texts for term in terms_in(text) if term not in met)
        met |= new.keys()
        found.append(tuple(new)[:MOST_TERMS])
    return found
