"""The tester: runs the tests of workbooks in a process of its own, since they evaluate formulas of strangers."""

from __future__ import annotations

import threading
import time
from pathlib import Path
from typing import Any

from rrp_sheets.errors import SheetsError
from rrp_sheets.processes import Child
from rrp_sheets.runs.office import readable
from rrp_sheets.runs.wire import Lines, line, unpack_error

GRACE = 10.0
"""Seconds that a process may take besides its time, since it is not alone on the machine; then it is ended."""
START = 20.0
"""Seconds more when it has to be started first."""


class Tester:
    """Runs tests; from any thread, one workbook at a time. The process starts when it is needed."""

    __test__ = False  # no test of pytest's

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._closed = False
        self._child: Child | None = None
        self._lines: Lines | None = None

    def run(self, path: Path, within: float) -> dict[str, Any]:
        """Run the tests of a workbook; see `child.run`.

        Args:
            path: of the workbook.
            within: seconds of the processor's time for all tests.

        Raises:
            SheetsError: when the file cannot be read, or the tests had to be ended.
        """
        with self._lock:
            if self._closed:
                raise SheetsError("The server is being ended.")
            patience = within + GRACE
            if self._child is None:
                self._child = Child("rrp_sheets.web.testing.child")
                self._lines = Lines(self._child.link)
                patience += START
            kind, answer = self._ask(self._child, [str(path.absolute()), within], patience)
            if kind not in ("done", "failed"):
                self._drop()
        if kind == "done":
            return dict(answer)
        if kind == "failed":
            raise unpack_error(answer)
        raise SheetsError(
            f"The tests were ended: {answer}.", "Let what they test come less often, or make them shorter."
        )

    def _ask(self, child: Child, request: list[Any], within: float) -> tuple[str, Any]:
        assert self._lines is not None
        deadline = time.monotonic() + within
        try:
            child.link.sendall(line(request))
        except OSError:
            return "gone", f"their process has ended unexpectedly{child.last_words()}"
        while (left := deadline - time.monotonic()) > 0:
            if not readable(child.link.fileno(), left):
                break
            messages = self._lines.receive()
            if messages is None:
                return "gone", f"their process has ended unexpectedly{child.last_words()}"
            if messages:
                kind, answer = messages[0]
                return kind, "they need more memory than tests may have" if kind == "memory" else answer
        child.kill()
        return "late", f"they did not come to an end within {within:g} s"

    def close(self) -> None:
        """End the process, whatever it is doing, and start no other."""
        self._closed = True
        child = self._child
        if child is not None:
            child.kill()
        with self._lock:
            self._drop()

    def _drop(self) -> None:
        if self._child is not None:
            self._child.close(2.0)
            self._child = self._lines = None
