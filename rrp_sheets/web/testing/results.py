"""Results of an open workbook's tests, and the thread that runs them after every check if they are quick."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from rrp_sheets.documents import Document
from rrp_sheets.errors import SheetsError
from rrp_sheets.texts import N_, sentences
from rrp_sheets.web.models import said
from rrp_sheets.web.testing.lessons import number_of
from rrp_sheets.web.testing.tester import Tester
from rrp_sheets.workers.worker_process import WorkerError

QUICK = 2.0
"""Seconds of the processor's time: tests that take longer are run only when somebody asks for it."""
PATIENT = 60.0
"""Seconds for tests that somebody has asked for."""
HOLDS, FAILS, IDLE, WAITS, LATE = "holds", "fails", "idle", "waits", "late"
"""States of a test: its rows hold, or not; it expects nothing; it has errors; it was not reached in time."""


@dataclass(frozen=True)
class Missed:
    """Row of a test that does not hold: the expected and the actual value, and hints, in words."""

    number: int
    ms: float
    stream: str
    expected: str
    got: str
    notes: str = ""
    hints: tuple[str, ...] = ()


@dataclass(frozen=True)
class Tested:
    """Result of one test.

    Attributes:
        marks: by the row's id, an empty text where the row holds, else the actual value.
        count: how many rows expect something.
        unsent: rows that could not send what they should, in words.
    """

    __test__ = False  # no test of pytest's

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
        running: they are being run.
        stale: the workbook was changed since then, and they are run only when somebody asks for it.
        rows: the rows that were left out since they have errors, in words.
        errors: how many errors the workbook has.
        held: the tests that have held since the workbook was opened.
        why: says why there is nothing; empty when there is.
    """

    tests: tuple[Tested, ...] = ()
    running: bool = False
    stale: bool = False
    rows: tuple[str, ...] = ()
    errors: int = 0
    held: frozenset[str] = frozenset()
    why: str = ""

    @property
    def holding(self) -> int:
        """Number of tests that hold."""
        return sum(t.state == HOLDS for t in self.tests)

    def of(self, sheet: str) -> Tested | None:
        """Return the result of the test on a sheet, if there is one."""
        return next((t for t in self.tests if t.sheet == sheet), None)


class WorkbookTests:
    """Tests of an open workbook, run in a thread.

    Args:
        document: the workbook.
        tester: runs them.
        tell: called when the results change, with an announcement; empty for none.
        watched: returns whether a page shows the workbook.
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
        except SheetsError as error:  # where their process was ended from outside, they are not to blame
            results = Results(why=said(error))
            self._slow = not (isinstance(error, WorkerError) and error.gone)
        else:
            self._slow = bool(answer.get("late"))
            results = self._understood(answer)
        if self._document.version != version:
            return  # the check of what is newer lets them run again
        self._version = version
        self._say(results, self._news(results))

    def _understood(self, answer: Mapping[str, Any]) -> Results:
        rows = tuple(N_("{sheet} row {row}", sheet=sheet, row=row) for sheet, row in answer["left"])
        errors = int(answer["errors"])
        if answer["tests"] is None:
            return Results(errors=errors, why=N_("The tests are run again when the errors are mended."))
        found = {case["sheet"]: self._case(case) for case in answer["tests"]}
        for state, names in ((WAITS, answer["waiting"]), (LATE, answer["late"])):
            found |= {name: Tested(name, state) for name in names}
        ordered = tuple(found[name] for name in self.sheets if name in found)
        self._held |= {test.sheet for test in ordered if test.state == HOLDS}
        return Results(ordered, rows=rows, errors=errors, held=self._held)

    def _case(self, case: Mapping[str, Any]) -> Tested:
        name, failing = case["sheet"], case["failing"]
        grid = self._document.grids.get(name)
        ids = {number: row for row, number in grid.numbers().items()} if grid is not None else {}
        told = dict.fromkeys(case["holding"], "") | dict.fromkeys(case["more"], N_("something else"))
        told |= {row["row"]: row["got"] for row in failing}
        unsent = tuple(
            N_("Row {row} could not be sent: {why}", row=number, why=words) for number, words in case["broken"].items()
        )
        missed = tuple(
            Missed(r["row"], r["ms"], r["stream"], r["expected"], r["got"], r["notes"], tuple(r["hints"]))
            for r in failing
        )
        state = FAILS if missed or unsent else HOLDS if case["expects"] else IDLE
        marks = {ids[number]: words for number, words in told.items() if number in ids}
        return Tested(name, state, case["expects"], missed, len(case["more"]), unsent, marks)

    def _news(self, results: Results) -> str:
        """Describe what has changed since the last results; empty for nothing."""
        before, self._said = self._said, {t.sheet: t.state for t in results.tests}
        if not before or before == self._said:
            return ""
        news = [
            N_("{test} is done." if number_of(n) else "{test} holds now.", test=n)
            for n, s in self._said.items()
            if s == HOLDS != before.get(n, HOLDS)
        ]
        failed = [n for n, s in self._said.items() if s == FAILS and before.get(n) == HOLDS]
        news += [N_("{test} does not hold any more.", test=n) for n in failed]
        return sentences(*news[:3], N_("{count}.", count=counted(results))) if news else ""

    def _say(self, results: Results, news: str) -> None:
        if results != self.results or news:
            self.results = results
            self._tell(news)


def counted(results: Results) -> str:
    """Describe how many tests hold: `3 of 10 tests hold`; of lessons, `3 of 10 lessons done`.

    >>> counted(Results((Tested("A", HOLDS),))), counted(Results((Tested("A", HOLDS), Tested("B", FAILS))))
    ('The test holds', '1 of 2 tests holds')
    """
    every, holding = len(results.tests), results.holding
    if every > 1 and all(number_of(t.sheet) for t in results.tests):
        return N_(
            "All {n} lessons are done" if every == holding else "{done} of {n} lessons done", n=every, done=holding
        )
    if every == holding and every:
        return N_("The test holds" if every == 1 else "All {n} tests hold", n=every)
    if every == 1:
        return N_("{holding} of {n} test hold", n=every, holding=holding)
    return N_(
        "{holding} of {n} tests holds" if holding == 1 else "{holding} of {n} tests hold", n=every, holding=holding
    )
