"""Query worker: a process of its own, for a server, that reads records and compares workbooks.

Its input is untrusted and may be of any size. So it has a memory limit and a time limit, and the server goes on
answering other requests meanwhile.
"""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from rrp_sheets.compare.as_json import from_dict
from rrp_sheets.compare.changes import Comparison
from rrp_sheets.errors import SheetsError
from rrp_sheets.runs.worker_process import RestartingWorker, WorkerError, WorkerProcess

WITHIN = 30.0
"""Seconds for one answer, the start of the process included."""
MOST = 8
"""Requests at once to one query worker: who comes then is told so, and keeps no thread of the server waiting."""
MOST_OF_ALL = 18
"""Requests at once to all query workers: the server has more threads, so that a run can always be stopped."""
_all_places = threading.BoundedSemaphore(MOST_OF_ALL)


class QueryWorker:
    """Worker that reads records and compares workbooks; from any thread, one request at a time. It starts when needed.

    Args:
        within: seconds for one answer.
        program: the module that is the process.
    """

    def __init__(self, within: float = WITHIN, program: str = "rrp_sheets.runs.records.query_child") -> None:
        self._within = within
        self._places = threading.BoundedSemaphore(MOST)
        self._worker = RestartingWorker(lambda: WorkerProcess(program, scratch=True))

    @property
    def pid(self) -> int | None:
        """Process ID of the worker; None while there is none."""
        return self._worker.pid

    def course(self, place: Path) -> dict[str, Any]:
        """Return the log and the curves of a run; see `records.timeline`."""
        return dict(self._ask(place.name, "course", str(place)))

    def marbles(
        self, place: Path, behaviour: str, rows: list[int], window: tuple[float | None, float | None], spread: bool
    ) -> dict[str, Any]:
        """Return marble diagrams of a run; see `records.marbles`."""
        return dict(self._ask(place.name, "marbles", str(place), behaviour, rows, window, spread))

    def compare(self, first: Path, second: Path) -> Comparison:
        """Compare two workbooks by what they mean."""
        return from_dict(self._ask(f"{first.name} and {second.name}", "compare", str(first), str(second)))

    def lookback(self, place: Path, what: str, number: int = 0) -> str:
        """Return a part of a run, to be looked back at; see `lookback.answer`."""
        return str(self._ask(place.name, "lookback", str(place), what, number))

    def drawn(self, first: Path, second: Path) -> str:
        """Return the changes between two workbooks, drawn and row by row, as HTML for a part of a page."""
        return str(self._ask(f"{first.name} and {second.name}", "drawn", str(first), str(second)))

    def ask(self, what: str, *request: Any) -> Any:
        """Return the answer of a process of another `program`; `what` names the subject in errors."""
        return self._ask(what, *request)

    def close(self) -> None:
        """End the process."""
        self._worker.close()

    def _ask(self, what: str, *request: Any) -> Any:
        """Return the answer of the process to a request.

        Raises:
            SheetsError: the error that it answers, that it took too long, or that too many requests wait.
        """
        with _place(self._places), _place(_all_places):
            try:
                (answer,) = self._worker.ask(request, self._within)
            except WorkerError as none:
                message = f"{what} cannot be shown: it {none.why}."
                raise SheetsError(message, "It is perhaps too large, or damaged.") from None
        return answer


@contextmanager
def _place(places: threading.BoundedSemaphore) -> Iterator[None]:
    if not places.acquire(blocking=False):
        raise SheetsError("Too much is asked for at once here.", "Wait a minute, and try it again.")
    try:
        yield
    finally:
        places.release()
