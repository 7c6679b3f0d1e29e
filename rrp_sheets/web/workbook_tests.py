"""Tests of an open workbook, and their panel beside a sheet.

A thread runs them after every check if they are quick, in a process with a memory limit. The panel shows which of them
pass, and what the first failing one lacks. Lessons are tests named “Lesson 1 …” that are done one after the other; a
comment `# LESSON 1: …` says what to do. One that was not begun is no failure: it is shown as “not yet”, and the first
of them as the one to do now.
"""

from __future__ import annotations

import re
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

from rrp_sheets.connectors import connectors
from rrp_sheets.documents import Document
from rrp_sheets.documents.grid import Grid
from rrp_sheets.errors import SheetsError
from rrp_sheets.model.workbook import Address
from rrp_sheets.texts import N_, listed, sentences
from rrp_sheets.workers.codec import unpack
from rrp_sheets.workers.worker_process import RestartingWorker, WorkerError

if TYPE_CHECKING:
    from rrp_sheets.testing import CaseResult, RowResult

QUICK = 2.0  # s of CPU time: tests that take longer are run only when somebody asks for it
PATIENT = 60.0  # s of CPU time for tests that somebody has asked for
GRACE = 10.0  # s that a process may take besides, since it is not alone on the machine; then it is ended
START = 20.0  # s more when it has to be started first
PASSES, FAILS, IDLE, WAITS, LATE = "passes", "fails", "idle", "waits", "late"
"""States of a test: it passes or fails; it expects nothing; errors keep it from running; it was not reached in time."""
_TASK = f"{__name__}.run_workbook_tests"
_LESSON = re.compile(r"#*\s*(?:lesson\s+|レッスン\s*)(\d{1,3})(?!\w)", re.IGNORECASE)


def number_of(test: str) -> int | None:
    """Return the number of the lesson that a test belongs to; None for other tests.

    >>> number_of("Lesson 3 Name it"), number_of("レッスン3 場所を言う"), number_of("Lessons"), number_of("Speaks")
    (3, 3, None, None)
    """
    found = _LESSON.match(test.strip())
    return int(found[1]) if found else None


@dataclass(frozen=True)
class Missed:
    """Failing row of a test, in words: what should have come `at` what time, what came, what explains it."""

    row: int
    at: str
    stream: str
    expected: str
    got: str
    notes: str
    hints: tuple[str, ...]


@dataclass(frozen=True)
class Tested:
    """Result of one test.

    Attributes:
        marks: by the row's id, an empty text where the row passes, else the actual value.
        count: how many rows expect something.
        unsent: rows that could not send what they should, in words.
    """

    sheet: str
    state: str
    count: int = 0
    missed: tuple[Missed, ...] = ()
    left_out: int = 0
    unsent: tuple[str, ...] = ()
    marks: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Results:
    """Results of all tests of a workbook.

    Attributes:
        stale: the workbook was changed since then, and they are run only when somebody asks for it.
        rows: the rows that were left out since they have errors, in words.
        held: the tests that have held since the workbook was opened.
        why: says why there is nothing; empty when there is.
    """

    tests: tuple[Tested, ...] = ()
    running: bool = False
    stale: bool = False
    rows: tuple[str, ...] = ()
    held: frozenset[str] = frozenset()
    why: str = ""

    @property
    def passed(self) -> int:
        """Number of tests that pass."""
        return sum(t.state == PASSES for t in self.tests)

    def of(self, sheet: str) -> Tested | None:
        """Return the result of the test on a sheet, if there is one."""
        return next((t for t in self.tests if t.sheet == sheet), None)


@dataclass(frozen=True)
class TestRun:
    """Answer of the process that runs the tests of a workbook.

    Attributes:
        rows: those that were left out since they have errors.
        waiting: the names of the tests that have errors; `late` of those that were not reached in time.
        tests: each with its marks by row number; None when the errors concern the whole workbook.
    """

    rows: tuple[Address, ...]
    waiting: tuple[str, ...]
    late: tuple[str, ...] = ()
    tests: tuple[tuple[Tested, Mapping[int, str]], ...] | None = None


class Tester:
    """Runner of tests in a worker process; from any thread, one workbook at a time. It starts when needed."""

    __test__ = False  # no test of pytest's

    def __init__(self) -> None:
        self._worker = RestartingWorker()

    @property
    def pid(self) -> int | None:
        """Process id of the worker; None while there is none."""
        return self._worker.pid

    def run(self, path: Path, within: float) -> TestRun:
        """Run the tests of a workbook within some seconds of CPU time.

        Raises WorkerError when the tests were ended, or their process ended; SheetsError for an unreadable file.
        """
        try:
            return unpack(TestRun, self._worker.ask([_TASK, str(path.absolute()), within], within + GRACE, START))
        except WorkerError as none:
            remedy = N_("Let what they test come less often, or make them shorter.")
            if none.gone:
                remedy = N_("Press Run tests; they are also run again after the next change.")
            message = N_("The tests were ended: they {why}.", why=none.why)
            raise WorkerError(none.why, gone=none.gone, message=message, remedy=remedy) from None

    def close(self) -> None:
        """End the process, whatever it is doing, and start no other."""
        self._worker.close()


class WorkbookTests:
    """Tests of an open workbook, run in a thread while a page shows it (`watched`).

    `tell` is called when the results change, with an announcement, which may be empty.
    """

    def __init__(
        self, document: Document, tester: Tester, tell: Callable[[str], None], watched: Callable[[], bool]
    ) -> None:
        self._document = document
        self._tester = tester
        self._tell = tell
        self._watched = watched
        self._lock = threading.Lock()
        self._again = self._asked = self._slow = False
        self._version = -1  # of the workbook that the results are of
        self._thread: threading.Thread | None = None
        self._said: dict[str, str] = {}
        self._held: frozenset[str] = frozenset()
        self.results = Results()

    @property
    def sheets(self) -> list[str]:
        """Names of the test sheets."""
        return [name for name, grid in self._document.grids.items() if grid.kind == "test"]

    def marks(self, sheet: str) -> Mapping[str, str]:
        """Return the marks for the rows of a test sheet (see `Tested.marks`); none if the results are stale."""
        found = self.results.of(sheet)
        return found.marks if found is not None and not self.results.stale else {}

    def soon(self, *, asked: bool = False) -> None:
        """Schedule a run of the tests, unless they are slow and nobody asked; requests meanwhile are merged."""
        with self._lock:
            self._again, self._asked = True, self._asked or asked
            if self._thread is None:
                self._thread = threading.Thread(target=self._work, daemon=True)
                self._thread.start()

    def join(self) -> None:
        """Schedule a run of the tests for a page that opens, if they have not run since the newest change."""
        if self._version != self._document.version and self.sheets:
            self.soon()

    def _work(self) -> None:
        while True:
            with self._lock:
                if not self._again:
                    self._thread = None
                    return
                asked, self._again, self._asked = self._asked, False, False
            if asked or self._watched():
                self._run(asked=asked)

    def _run(self, *, asked: bool) -> None:
        if not self.sheets:
            self._say(Results(), "")
            return
        if self._slow and not asked:
            self._say(replace(self.results, stale=True, running=False), "")
            return
        if asked:
            self._say(replace(self.results, running=True), "")
        version = self._document.version
        try:
            answer = self._tester.run(self._document.path, PATIENT if asked else QUICK)
        except SheetsError as error:  # an unreadable file, or a process that was ended from outside, is no slow test
            results = Results(why=sentences(error.message, error.remedy))
            self._slow = isinstance(error, WorkerError) and not error.gone
        else:
            self._slow = bool(answer.late)
            results = self._understood(answer)
        if self._document.version != version:
            return  # the check of what is newer lets them run again
        self._version = version
        self._say(results, self._news(results))

    def _understood(self, answer: TestRun) -> Results:
        if answer.tests is None:
            return Results(why=N_("The tests are run again when the errors are fixed."))
        found: dict[str, Tested] = {}
        for test, marks in answer.tests:
            grid = self._document.grids.get(test.sheet)
            ids = grid.numbers().items() if grid is not None else ()
            found[test.sheet] = replace(test, marks={row: marks[number] for row, number in ids if number in marks})
        for state, names in ((WAITS, answer.waiting), (LATE, answer.late)):
            found |= {name: Tested(name, state) for name in names}
        if answer.rows:  # were left out: a failure says nothing, but that of a lesson, whose rows are yet to be written
            failed = [name for name, test in found.items() if test.state == FAILS]
            found |= {n: Tested(n, WAITS) for n in failed if number_of(n) is None or n in self._held}
        ordered = tuple(found[name] for name in self.sheets if name in found)
        self._held |= {test.sheet for test in ordered if test.state == PASSES}
        rows = tuple(N_("{sheet} row {row}", sheet=a.sheet, row=a.row) for a in answer.rows)
        return Results(ordered, rows=rows, held=self._held)

    def _news(self, results: Results) -> str:
        """Describe what has changed since the last results; empty for nothing."""
        before, self._said = self._said, {t.sheet: t.state for t in results.tests}
        if not before or before == self._said:
            return ""
        now = [n for n, s in self._said.items() if s == PASSES != before.get(n, PASSES)]
        failed = [n for n, s in self._said.items() if s == FAILS and before.get(n) == PASSES]
        news = [N_("{test} is done." if number_of(n) else "{test} now passes.", test=n) for n in now]
        news += [N_("{test} now fails.", test=n) for n in failed]
        return sentences(*news[:3], N_("{count}.", count=counted(results))) if news else ""

    def _say(self, results: Results, news: str) -> None:
        if results != self.results or news:
            self.results = results
            self._tell(news)


_ONE_TEST = {
    PASSES: N_("Test passed"), FAILS: N_("Test failed"), IDLE: N_("Test checks nothing"), WAITS: N_("Test not run"),
    LATE: N_("Test was not reached in time"),
}  # fmt: skip


def counted(results: Results) -> str:
    """Describe how many tests pass: `3 of 10 tests passed`; of lessons, `3 of 10 lessons done`.

    >>> counted(Results((Tested("A", WAITS),))), counted(Results((Tested("A", PASSES), Tested("B", FAILS))))
    ('Test not run', '1 of 2 tests passed')
    """
    every, passed = len(results.tests), results.passed
    if every > 1 and all(number_of(t.sheet) for t in results.tests):
        return N_("All {n} lessons are done" if every == passed else "{done} of {n} lessons done", n=every, done=passed)
    if every == 1:
        return _ONE_TEST[results.tests[0].state]
    all_passed = every == passed != 0
    return N_("All {n} tests passed" if all_passed else "{passed} of {n} tests passed", n=every, passed=passed)


# ---- in the worker process
MOST_TOLD = 200  # failing rows of one test that are told in words; the others are only marked
_LONGEST = 300  # letters of one line


def run_workbook_tests(path: str, within: float) -> TestRun:
    """Run the tests of a workbook, as far as its errors allow, until `within` seconds of CPU time are over."""
    from rrp_sheets.testing.run import in_order, run_tests
    from rrp_sheets.workbook import read

    part = in_order(read(Path(path)))
    if part.checked is None:
        return TestRun(part.rows, part.waiting)
    until = time.process_time() + within  # on a busy machine, tests take no more of it than on an idle one
    cases = run_tests(part.checked, lambda: time.process_time() > until).cases
    late = tuple(case.name for case in part.checked.tests[len(cases) :])
    return TestRun(part.rows, part.waiting, late, tuple(_tested(case) for case in cases))


def _tested(case: CaseResult) -> tuple[Tested, dict[int, str]]:
    failed, more = case.failed_rows[:MOST_TOLD], case.failed_rows[MOST_TOLD:]
    missed = tuple(map(_missed, failed))
    broken = list(case.broken.items())[:MOST_TOLD]
    unsent = tuple(N_("Row {row} could not be sent: {why}", row=n, why=_short(words)) for n, words in broken)
    state = FAILS if missed or unsent else PASSES if case.rows else IDLE
    marks = {r.row.row: "" for r in case.rows if r.passed} | {r.row.row: N_("something else") for r in more}
    marks |= {m.row: m.got for m in missed}
    return Tested(case.case.name, state, len(case.rows), missed, len(more), unsent), marks


def _missed(result: RowResult) -> Missed:
    from rrp_sheets.testing.judge import seconds

    row = result.row
    expected = _short(row.expectation.text if row.expectation else "")
    word = expected.strip().casefold()
    return Missed(
        row.row, N_("up to {time}" if word == "nothing" else "at {time}", time=seconds(row.time_us)), _short(row.name),
        N_("any value") if word == "any" else expected, _short(result.got), _short(row.notes),
        tuple(map(_short, result.hints[:3])),
    )  # fmt: skip


def _short(text: str) -> str:
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 1]}…"


MOST_MISSED = 3  # rows of a test that are told beside the sheet
NOW, LATER = "now", "later"
"""Of lessons that fail and have not passed before: the one to do, and those after it."""
_SIGNS = {PASSES: "✓", FAILS: "✗", IDLE: "–", WAITS: "!", LATE: "…"}
_WORDS = {
    PASSES: N_("passed"), FAILS: N_("failed"), IDLE: N_("expects nothing"),
    WAITS: N_("not run because of errors"), LATE: N_("was not reached in time"),
    NOW: N_("the lesson to do now"), LATER: N_("not yet"),
}  # fmt: skip
_DONE = {PASSES: N_("done"), FAILS: N_("now fails")}
"""Words for lessons instead."""
_WORD = re.compile(r"[A-Za-z]+")
MOST_TERMS = 4
WORDS: Mapping[str, str] = {word: word for word in (
    N_("stream"), N_("event"), N_("field"), N_("formula"), N_("connector"), N_("actuator"), N_("sensor"), N_("trace"),
)}  # fmt: skip
"""Words of the field that there is help on; connectors are such words too."""


@dataclass(frozen=True, slots=True)
class TestLine:
    """Test in the list: its state, the icon and the words for that; `here` when its sheet is shown.

    A lesson has the sheet (`told_in`) and the row where it is described; both are empty for other tests.
    """

    sheet: str
    state: str
    sign: str
    words: str
    here: bool
    told_in: str = ""
    row: str = ""


@dataclass(frozen=True, slots=True)
class TestsPanel:
    """Panel with the tests of a workbook beside the sheet; `count` says how many pass.

    Attributes:
        first: the name of the test whose failing rows are listed; empty for none. `state` is as of its line.
        broken: whether it has passed before.
        terms: new words of the current lesson, linked to their help.
    """

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
    first = _first(results, sheet, now) or Tested("", "")
    state = next((line.state for line in lines if line.sheet == first.sheet), "")
    lesson = told.get(number_of(now) or 0) if state == NOW else None
    missed = first.missed[:MOST_MISSED]
    return TestsPanel(
        count=counted(results) if results.tests else "", done=bool(lines) and results.passed == len(lines),
        lines=lines, first=first.sheet, state=state, broken=first.sheet in results.held,
        terms=lesson.terms if lesson else (), missed=missed,
        left_out=len(first.missed) - len(missed) + first.left_out, unsent=first.unsent[:MOST_MISSED],
        notes=tuple(_notes(results)), running=results.running or not (results.tests or results.why),
    )  # fmt: skip


def _undone(test: Tested, results: Results) -> bool:
    return test.state != PASSES and test.sheet not in results.held


def _line(test: Tested, sheet: str, now: str, results: Results, told: Mapping[int, Lesson]) -> TestLine:
    number, state, here = number_of(test.sheet), test.state, test.sheet == sheet
    if number is None:
        return TestLine(test.sheet, state, _SIGNS[state], _WORDS[state], here)
    if state == FAILS and _undone(test, results):
        state = NOW if test.sheet == now else LATER
    sign, words = _SIGNS.get(state, str(number)), _DONE.get(state, _WORDS[state])
    place = (lesson.sheet, lesson.row) if (lesson := told.get(number)) else ("", "")
    return TestLine(test.sheet, state, sign, words, here, *place)


def _first(results: Results, sheet: str, now: str) -> Tested | None:
    """Return the test whose rows are listed: that of the sheet, or else the first that fails, new lessons last."""
    here = results.of(sheet)
    if here is not None:
        return here if here.state == FAILS else None
    failing = [t for t in results.tests if t.state == FAILS]
    begun = [t for t in failing if not (number_of(t.sheet) and _undone(t, results))]
    return next(iter(begun), None) or next((t for t in failing if t.sheet == now), None)


def _notes(results: Results) -> list[str]:
    notes = [results.why] if results.why else []
    if results.rows and not results.why:
        rows, more = listed(results.rows[:3]), len(results.rows) - 3
        if more > 0:
            rows = N_("{rows} and {n} more", rows=rows, n=more)
        if all(t.state == WAITS for t in results.tests):
            notes.append(N_("Not run, because of errors in {rows}.", rows=rows))
        elif any(t.state == WAITS for t in results.tests):
            notes.append(N_("Tests with the sign ! were not run, because of errors in {rows}.", rows=rows))
        else:
            notes.append(N_("Skipped because of errors: {rows}.", rows=rows))
    if results.stale:
        why = N_("This is from before the newest change. These tests take long: press Run tests to see how it is now.")
        notes.append(why)
    if any(t.state == LATE for t in results.tests):
        notes.append(N_("The tests take long. Press Run tests to let them have more time."))
    return notes


@dataclass(frozen=True, slots=True)
class Lesson:
    """Lesson of a workbook: the behaviour whose comments describe it, and the id of the row that begins it.

    Its `terms` are words with a help topic that no earlier lesson uses.
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
            terms = tuple(dict.fromkeys(t for t in terms_in(words) if t not in met))
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
        begins = _LESSON.match(text)
        if begins:
            if number:
                yield number, first, words
            number, first, words = int(begins[1]), row, "" if number else words
        words += f" {text}"
    if number:
        yield number, first, words


def terms_in(words: str) -> Iterator[str]:
    """Yield the connectors and the words of the glossary in a text, in their order."""
    names = {c.name for c in connectors()}
    for word in _WORD.findall(words):
        single = word.lower().removesuffix("s")
        if word in names:
            yield word
        elif single in WORDS:
            yield WORDS[single]
