"""Tester of workbooks: runs their tests in a worker process, which has a memory limit."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

from rrp_sheets.testing import CaseResult, RowResult
from rrp_sheets.texts import N_
from rrp_sheets.workers.worker_process import RestartingWorker, WorkerError

_TASK = f"{__name__}.run_workbook_tests"
GRACE = 10.0
"""Seconds that a process may take besides its time, since it is not alone on the machine; then it is ended."""
START = 20.0
"""Seconds more when it has to be started first."""


class Tester:
    """Runner of tests in a worker process; from any thread, one workbook at a time. It starts when needed."""

    __test__ = False  # no test of pytest's

    def __init__(self) -> None:
        self._worker = RestartingWorker()

    @property
    def pid(self) -> int | None:
        """Process id of the worker; None while there is none."""
        return self._worker.pid

    def run(self, path: Path, within: float) -> dict[str, Any]:
        """Run the tests of a workbook; see `run_workbook_tests`.

        Args:
            path: of the workbook.
            within: seconds of CPU time for all tests.

        Raises:
            WorkerError: when the tests had to be ended, or their process ended.
            SheetsError: when the file cannot be read.
        """
        try:
            return dict(self._worker.ask([_TASK, str(path.absolute()), within], within + GRACE, START))
        except WorkerError as none:
            remedy = N_("Let what they test come less often, or make them shorter.")
            if none.gone:
                remedy = N_("Press Run tests; they are also run again after the next change.")
            message = N_("The tests were ended: they {why}.", why=none.why)
            raise WorkerError(none.why, gone=none.gone, message=message, remedy=remedy) from None

    def close(self) -> None:
        """End the process, whatever it is doing, and start no other."""
        self._worker.close()


# ---- in the worker process
MOST_TOLD = 200  # rows of one test that do not hold and are told in words; the others are only marked
_LONGEST = 300  # letters of one line


def run_workbook_tests(path: str, within: float) -> dict[str, Any]:
    """Run the tests of a workbook, as far as its errors allow.

    Args:
        path: of the workbook.
        within: seconds of CPU time, after which the current test is aborted and no further one is started.
    """
    from rrp_sheets.testing.run import in_order, run_tests
    from rrp_sheets.workbook import read

    part = in_order(read(Path(path)))
    about = {"errors": part.errors, "left": [(a.sheet, a.row) for a in part.rows], "waiting": part.waiting}
    if part.checked is None:
        return {**about, "tests": None}
    until = time.process_time() + within  # on a busy machine, tests take no more of it than on an idle one
    report = run_tests(part.checked, lambda: time.process_time() > until)
    names = [c.name for c in part.checked.tests]
    return {**about, "tests": [_case(c) for c in report.cases], "late": names[len(report.cases) :]}


def _case(case: CaseResult) -> dict[str, Any]:
    failed = case.failed_rows
    return {
        "sheet": case.case.name,
        "expects": len(case.rows),
        "holding": [r.row.row for r in case.rows if r.passed],
        "failing": [_told(r) for r in failed[:MOST_TOLD]],
        "more": [r.row.row for r in failed[MOST_TOLD:]],
        "broken": {str(number): _short(words) for number, words in list(case.broken.items())[:MOST_TOLD]},
    }


def _told(result: RowResult) -> dict[str, Any]:
    row = result.row
    return {
        "row": row.row, "ms": row.time_us / 1000, "stream": _short(row.name), "notes": _short(row.notes),
        "expected": _short(row.expectation.text if row.expectation else ""), "got": _short(result.got),
        "hints": [_short(hint) for hint in result.hints[:3]],
    }  # fmt: skip


def _short(text: str) -> str:
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 1]}…"
