"""Worker process that runs tests: `python -m rrp_sheets.web.testing.tester_child LINK`, started by `tester` only.

It has a memory limit, and ends when the connection does.
"""

from __future__ import annotations

import os
import socket
import threading
import time
from functools import partial
from pathlib import Path
from queue import SimpleQueue
from typing import Any

from rrp_sheets.processes import Lines, line
from rrp_sheets.runs.worker_loop import answer, begin
from rrp_sheets.testing import CaseResult, RowResult

MOST_TOLD = 200  # rows of one test that do not hold and are told in words; the others are only marked
_LONGEST = 300  # letters of one line


def run(path: str, within: float) -> dict[str, Any]:
    """Run the tests of a workbook, as far as its errors allow.

    Args:
        path: of the workbook.
        within: seconds of CPU time, after which the current test is aborted and no further one is started.
    """
    from rrp_sheets.testing.partly import in_order
    from rrp_sheets.testing.run import run_tests
    from rrp_sheets.workbook import read

    part = in_order(read(Path(path)))
    about = {"errors": part.errors, "left": [a.sheet + f" row {a.row}" for a in part.rows], "waiting": part.waiting}
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


def _listen(link: socket.socket, asked: SimpleQueue[list[Any]]) -> None:
    """Read requests until the connection closes; then exit at once, even during tests."""
    for message in Lines(link):
        asked.put(message)
    os._exit(0)


def main() -> None:
    """Serve until the connection closes."""
    link = begin()
    asked: SimpleQueue[list[Any]] = SimpleQueue()
    threading.Thread(target=_listen, args=(link, asked), daemon=True).start()
    while True:
        path, within = asked.get()
        link.sendall(line(answer(partial(run, path, within))))


if __name__ == "__main__":
    main()
