"""Client of the test process; tests evaluate untrusted formulas, so they do not run in the server."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from rrp_sheets.runs.worker_process import RestartingWorker, WorkerError, WorkerProcess

GRACE = 10.0
"""Seconds that a process may take besides its time, since it is not alone on the machine; then it is ended."""
START = 20.0
"""Seconds more when it has to be started first."""


class Tester:
    """Runner of tests in a worker process; from any thread, one workbook at a time. It starts when needed."""

    __test__ = False  # no test of pytest's

    def __init__(self) -> None:
        self._worker = RestartingWorker(lambda: WorkerProcess("rrp_sheets.web.testing.tester_child"))

    @property
    def pid(self) -> int | None:
        """Process id of the worker; None while there is none."""
        return self._worker.pid

    def run(self, path: Path, within: float) -> dict[str, Any]:
        """Run the tests of a workbook; see `child.run`.

        Args:
            path: of the workbook.
            within: seconds of CPU time for all tests.

        Raises:
            WorkerError: when the tests had to be ended, or their process ended.
            SheetsError: when the file cannot be read.
        """
        try:
            (answer,) = self._worker.ask([str(path.absolute()), within], within + GRACE, START)
        except WorkerError as none:
            remedy = "Let what they test come less often, or make them shorter."
            if none.gone:
                remedy = "Press Run tests; they are also run again after the next change."
            message = f"The tests were ended: they {none.why}."
            raise WorkerError(none.why, gone=none.gone, message=message, remedy=remedy) from None
        return dict(answer)

    def close(self) -> None:
        """End the process, whatever it is doing, and start no other."""
        self._worker.close()
