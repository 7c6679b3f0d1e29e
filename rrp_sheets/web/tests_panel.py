"""Panel of the tests beside a sheet: which of them hold, and what the first failing one lacks.

Lessons are tests named “Lesson 1 …” that are done one after the other; a comment `# LESSON 1: …` says what to do. One
that was not begun is no failure: it is shown as “not yet”, and the first of them as the one to do now.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from rrp_sheets.connectors import connectors
from rrp_sheets.documents import Document
from rrp_sheets.documents.grid import Grid
from rrp_sheets.texts import N_, listed
from rrp_sheets.web.workbook_tests import (
    FAILS,
    HOLDS,
    IDLE,
    LATE,
    WAITS,
    Missed,
    Results,
    Tested,
    WorkbookTests,
    counted,
    number_of,
)

MOST_MISSED = 3  # rows of a test that are told beside the sheet
NOW, LATER = "now", "later"
"""Of lessons that do not hold and have not held before: the one to do, and those after it."""
_SIGNS = {HOLDS: "✓", FAILS: "✗", IDLE: "–", WAITS: "!", LATE: "…"}
_WORDS = {
    HOLDS: N_("holds"), FAILS: N_("does not hold"), IDLE: N_("expects nothing"),
    WAITS: N_("waits for errors to be mended"), LATE: N_("was not reached in time"),
    NOW: N_("the lesson to do now"), LATER: N_("not yet"),
}  # fmt: skip
_DONE = {HOLDS: N_("done"), FAILS: N_("does not hold any more")}
"""Words for lessons instead."""
_TOLD = re.compile(r"#+\s*lesson\s+(\d{1,3})\b", re.IGNORECASE)
_WORD = re.compile(r"[A-Za-z]+")
MOST_TERMS = 4
WORDS = frozenset(("stream", "event", "field", "formula", "connector", "actuator", "sensor", "trace"))
"""Words of the field that there is help on; connectors are such words too."""


@dataclass(frozen=True, slots=True)
class TestLine:
    """Test in the list: its state, the icon and the words for that; `here` when its sheet is shown.

    A lesson has the sheet (`told_in`) and the row where it is described; both are empty for other tests.
    """

    __test__ = False  # no test of pytest's

    sheet: str
    state: str
    sign: str
    words: str
    here: bool
    told_in: str = ""
    row: str = ""


@dataclass(frozen=True, slots=True)
class TestsPanel:
    """Panel with the tests of a workbook beside the sheet.

    Attributes:
        count: how many hold, in words.
        first: the name of the test whose failing rows are listed; empty for none.
        state: of that test, as of a line.
        broken: whether it has held before.
        terms: new words of the current lesson, linked to their help.
        missed: those of its rows that do not hold; `left_out` is how many more there are.
        unsent: what could not be sent, in words.
    """

    __test__ = False  # no test of pytest's

    count: str
    done: bool
    lines: tuple[TestLine, ...]
    first: str
    state: str
    broken: bool
    terms: tuple[str, ...]
    missed: tuple[Missed, ...]
    left_out: int
    unsent: tuple[str, ...]
    notes: tuple[str, ...]
    running: bool


def panel_of(tests: WorkbookTests, document: Document, sheet: str) -> TestsPanel | None:
    """Build the panel of a workbook's tests beside a sheet; None for a workbook without tests."""
    names = tests.sheets
    if not names:
        return None
    results = tests.results
    told = lessons_of(document.grids) if any(map(number_of, names)) else {}
    now = next((t.sheet for t in results.tests if number_of(t.sheet) and _undone(t, results)), "")
    lines = tuple(_line(t, sheet, now, results, told) for t in results.tests)
    first = _first(results, sheet, now)
    state = next((line.state for line in lines if first is not None and line.sheet == first.sheet), "")
    lesson = told.get(number_of(now) or 0) if state == NOW else None
    missed = first.missed[:MOST_MISSED] if first is not None else ()
    more = len(first.missed) - len(missed) + first.left_out if first is not None else 0
    return TestsPanel(
        count=counted(results) if results.tests else "", done=bool(lines) and results.holding == len(lines),
        lines=lines, first=first.sheet if first is not None else "", state=state,
        broken=first is not None and first.sheet in results.held, terms=lesson.terms if lesson is not None else (),
        missed=missed, left_out=more,
        unsent=first.unsent[:MOST_MISSED] if first is not None else (), notes=tuple(_notes(results)),
        running=results.running or not (results.tests or results.why),
    )  # fmt: skip


def _undone(test: Tested, results: Results) -> bool:
    """Return whether a test has not held since the workbook was opened."""
    return test.state != HOLDS and test.sheet not in results.held


def _line(test: Tested, sheet: str, now: str, results: Results, told: Mapping[int, Lesson]) -> TestLine:
    number, state, here = number_of(test.sheet), test.state, test.sheet == sheet
    if number is None:
        return TestLine(test.sheet, state, _SIGNS[state], _WORDS[state], here)
    if state == FAILS and _undone(test, results):
        state = NOW if test.sheet == now else LATER
    sign, words = _SIGNS.get(state, str(number)), _DONE.get(state, _WORDS[state])
    lesson = told.get(number)
    if lesson is None:
        return TestLine(test.sheet, state, sign, words, here)
    return TestLine(test.sheet, state, sign, words, here, lesson.sheet, lesson.row)


def _first(results: Results, sheet: str, now: str) -> Tested | None:
    """Return the test whose rows are listed: that of the sheet, or else the first that fails, new lessons last."""
    here = results.of(sheet)
    if here is not None:
        return here if here.state == FAILS else None
    failing = [t for t in results.tests if t.state == FAILS]
    begun = [t for t in failing if not (number_of(t.sheet) and _undone(t, results))]
    return next(iter(begun), None) or next((t for t in failing if t.sheet == now), None)


def _notes(results: Results) -> list[str]:
    notes = []
    if results.why:
        notes.append(results.why)
    elif results.rows:
        more = len(results.rows) - 3
        notes.append(
            N_(
                "Left out, because of errors there: {rows} and {n} more."
                if more > 0
                else "Left out, because of errors there: {rows}.",
                rows=listed(results.rows[:3]),
                n=more,
            )
        )
    if results.stale:
        notes.append(
            N_("This is from before the newest change. These tests take long: press Run tests to see how it is now.")
        )
    if any(t.state == LATE for t in results.tests):
        notes.append(N_("The tests take long. Press Run tests to let them have more time."))
    return notes


@dataclass(frozen=True, slots=True)
class Lesson:
    """Place of a lesson in a workbook, and the terms that it introduces.

    Attributes:
        sheet: the behaviour whose comments describe it.
        row: the id of the row that begins it.
        terms: words with a help topic that no earlier lesson uses.
    """

    sheet: str
    row: str
    terms: tuple[str, ...]


def lessons_of(grids: Mapping[str, Grid]) -> dict[int, Lesson]:
    """Return the lessons in the behaviours of a workbook, by their numbers."""
    told: dict[int, Lesson] = {}
    met: set[str] = set()
    for grid in grids.values():
        if grid.kind != "behaviour":
            continue
        for number, row, words in _told(grid):
            terms = tuple(dict.fromkeys(t for t in _terms(words) if t not in met))
            met |= set(terms)
            told.setdefault(number, Lesson(grid.name, row, terms[:MOST_TERMS]))
    return told


def _told(grid: Grid) -> Iterator[tuple[int, str, str]]:
    """Yield the number, first row and comments of each lesson; the first includes the comments before it."""
    number, first, words = 0, "", ""
    for row in grid.rows:
        texts = grid.texts.get(row, {})
        text = texts[min(texts)].strip() if texts else ""
        if not text.startswith("#"):
            continue
        begins = _TOLD.match(text)
        if begins:
            if number:
                yield number, first, words
            number, first, words = int(begins[1]), row, "" if number else words
        words += f" {text}"
    if number:
        yield number, first, words


def _terms(words: str) -> Iterator[str]:
    """Yield the connectors and the words of the glossary in a text, in their order."""
    names = {c.name for c in connectors()}
    for word in _WORD.findall(words):
        single = word.lower().removesuffix("s")
        if word in names:
            yield word
        elif single in WORDS:
            yield single
