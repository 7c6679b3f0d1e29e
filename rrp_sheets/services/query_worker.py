"""Query worker: a process of its own, for a server, that reads records, exports, deletes, and compares workbooks.

Its input is untrusted and may be of any size. So it has a memory limit and a time limit, and the server goes on
answering other requests meanwhile.
"""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path
from typing import Any

from rrp_sheets.compare.changes import Comparison
from rrp_sheets.errors import SheetsError
from rrp_sheets.model.run_files import TRACE
from rrp_sheets.page_texts import in_language
from rrp_sheets.texts import N_, listed
from rrp_sheets.workers.codec import pack, unpack
from rrp_sheets.workers.worker_process import RestartingWorker, WorkerError, WorkerProcess

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
        tasks: the module whose functions are asked for.
    """

    def __init__(self, within: float = WITHIN, tasks: str = __name__) -> None:
        self._within, self._tasks = within, tasks
        self._places = threading.BoundedSemaphore(MOST)
        self._worker = RestartingWorker(lambda: WorkerProcess(scratch=True))

    @property
    def pid(self) -> int | None:
        """Process ID of the worker; None while there is none."""
        return self._worker.pid

    def course(self, place: Path, language: str) -> dict[str, Any]:
        """Return the log and the curves of a run, in a language; see `recording.timeline`."""
        return dict(self.ask(place.name, "course", str(place), language))

    def marbles(
        self, place: Path, behaviour: str, rows: list[int], window: tuple[float | None, float | None], spread: bool,
        language: str,
    ) -> dict[str, Any]:  # fmt: skip
        """Return marble diagrams of a run, in a language; see `recording.marbles`."""
        return dict(self.ask(place.name, "draw_marbles", str(place), behaviour, rows, window, spread, language))

    def compare(self, first: Path, second: Path) -> Comparison:
        """Compare two workbooks by what they mean."""
        found = self.ask(listed([first.name, second.name], "and"), "compare_workbooks", str(first), str(second))
        return unpack(Comparison, found)

    def lookback(self, place: Path, what: str, number: int, language: str) -> str:
        """Return a part of a run, to be looked back at, in a language; see `lookback.answer`."""
        return str(self.ask(place.name, "lookback", str(place), what, number, language))

    def drawn(self, first: Path, second: Path, language: str) -> str:
        """Return the changes between two workbooks, drawn and row by row, as HTML for a part of a page."""
        return str(self.ask(listed([first.name, second.name], "and"), "drawn", str(first), str(second), language))

    def close(self) -> None:
        """End the process."""
        self._worker.close()

    def ask(self, what: str, task: str, *arguments: Any) -> Any:
        """Return the answer of the process to a request; `what` names the subject in errors.

        Raises:
            SheetsError: the error that it answers, that it took too long, or that too many requests wait.
        """
        with _place(self._places), _place(_all_places):
            try:
                return self._worker.ask([f"{self._tasks}.{task}", *arguments], self._within)
            except WorkerError as error:
                message = N_("{what} cannot be shown: it {why}.", what=what, why=error.why)
                raise SheetsError(message, N_("It is perhaps too large, or damaged.")) from None


@contextmanager
def _place(places: threading.BoundedSemaphore) -> Iterator[None]:
    if not places.acquire(blocking=False):
        raise SheetsError(N_("Too much is asked for at once here."), N_("Wait a minute, and try it again."))
    try:
        yield
    finally:
        places.release()


# ---- in the worker process
def course(place: str, language: str) -> dict[str, Any]:
    """Return the log and the curves of a run; see `build_timeline`."""
    about = (Path(place) / TRACE).stat()
    found = _known_course(place, (about.st_mtime_ns, about.st_size))
    return {**found, "lines": in_language(found["lines"], language)}


@lru_cache(maxsize=2)
def _known_course(place: str, stamp: tuple[int, int]) -> dict[str, Any]:
    """Return the timeline of a run; kept, as a page asks twice: for the log and for the curves."""
    from rrp_sheets.recording.timeline import build_timeline

    return build_timeline(Path(place))


def draw_marbles(
    place: str, behaviour: str, rows: list[int], window: list[float | None], spread: bool, language: str
) -> dict[str, Any]:
    """Draw marble diagrams of a run."""
    from rrp_sheets.recording.marbles import marbles

    return marbles(Path(place), behaviour, rows, (window[0], window[1]), spread, language)


def compare_workbooks(first: str, second: str) -> Any:
    """Compare two workbooks by what they mean."""
    from rrp_sheets.compare import compare
    from rrp_sheets.compare.side import open_checked

    return pack(compare(open_checked(Path(first)), open_checked(Path(second))))


def lookback(place: str, what: str, number: int, language: str) -> str:
    """Return a part of a run, to be looked back at."""
    from rrp_sheets.recording.lookback import answer

    return answer(Path(place), what, number, language)


def drawn(first: str, second: str, language: str) -> str:
    """Draw the changes between two workbooks, as HTML."""
    from rrp_sheets.services.changes_drawn import compared

    return compared(Path(first), Path(second)).html(language)


def export_runs(runs: list[str], target: str) -> list[str]:
    """Write the events of runs into a file; return the notes."""
    from rrp_sheets.recording.exporting import export

    return export([Path(run) for run in runs], Path(target))


def write_marbles(
    run: str, behaviour: str, rows: list[int], window: list[float | None], target: str
) -> list[str]:  # fmt: skip
    """Write marble diagrams of a run into a file."""
    from rrp_sheets.recording.marbles import write_run_marbles

    return write_run_marbles(Path(run), behaviour, rows, (window[0], window[1]), Path(target))


def pair_table(first: str, second: str) -> dict[str, Any]:
    """Return two runs side by side."""
    from rrp_sheets.recording.exporting import pair

    return pair(Path(first), Path(second))


def plan_deletion(folder: str, participant: str, names: list[str], going: list[str]) -> dict[str, Any]:
    """Return what the deletion of a participant would take."""
    from rrp_sheets.recording.deleting import plan

    return plan(Path(folder), participant, names, going).as_dict()


def delete_planned(
    folder: str, participant: str, names: list[str], going: list[str], expected: list[str], below: list[str]
) -> dict[str, Any]:
    """Delete only what was shown: if there is another run since then, nothing goes, and `deleted` is False."""
    from rrp_sheets.recording.deleting import delete, plan

    planned = plan(Path(folder), participant, names, going)
    same = sorted(planned.shown()) == sorted(expected)
    begun = delete(planned, going, below) if same else ()
    return {**planned.as_dict(), "deleted": same, "begun": list(begun)}
