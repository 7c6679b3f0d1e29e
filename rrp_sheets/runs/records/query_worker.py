"""The query worker reads records and compares workbooks in a process of its own, for a server.

What it reads may come from strangers and be as large as they like. It has a memory limit and some seconds; a server
that asks it goes on answering others meanwhile.
"""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

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
    """Reads records and compares workbooks; from any thread, one thing at a time. The process starts when it is needed.

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
        """The process's number; None while there is none."""
        return self._worker.pid

    def course(self, place: Path) -> dict[str, Any]:
        """The log and the curves of a run; see `records.timeline`."""
        return dict(self._ask(place.name, "course", str(place)))

    def marbles(
        self, place: Path, behaviour: str, rows: list[int], window: tuple[float | None, float | None], spread: bool
    ) -> dict[str, Any]:
        """Marble diagrams of a run; see `records.marbles`."""
        return dict(self._ask(place.name, "marbles", str(place), behaviour, rows, window, spread))

    def compare(self, first: Path, second: Path) -> Comparison:
        """Compare two workbooks by what they mean."""
        return Comparison.from_dict(self._ask(f"{first.name} and {second.name}", "compare", str(first), str(second)))

    def lookback(self, place: Path, what: str, number: int = 0) -> str:
        """A part of a run, to be looked back at; see `lookback.answer`."""
        return str(self._ask(place.name, "lookback", str(place), what, number))

    def drawn(self, first: Path, second: Path) -> str:
        """What changed between two workbooks, drawn and row by row: a part of a page, of our own making."""
        return str(self._ask(f"{first.name} and {second.name}", "drawn", str(first), str(second)))

    def ask(self, what: str, *request: Any) -> Any:
        """What a process of another `program` answers; `what` it is about, in words, for errors."""
        return self._ask(what, *request)

    def close(self) -> None:
        """End the process."""
        self._worker.close()

    def _ask(self, what: str, *request: Any) -> Any:
        """Its answer.

        Raises:
            SheetsError: what it says, that it took too long, or that too many others wait.
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
