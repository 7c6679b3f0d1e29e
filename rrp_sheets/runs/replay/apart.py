"""Replay in a worker process, for a server, which never evaluates untrusted formulas itself."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from rrp_sheets.errors import SheetsError
from rrp_sheets.runs.wire import unpack_error
from rrp_sheets.runs.worker_process import WorkerError, WorkerProcess

WITHIN = 180.0
"""Seconds for one replay: several times what an hour of a busy session takes."""
_LISTEN = 0.25  # s


class Stopped(SheetsError):
    """Error of a replay that nobody wants any more."""


def replay_apart(
    trace: Path,
    other: Path | None,
    told: Callable[[float], None],
    stopped: Callable[[], bool] = lambda: False,
    within: float = WITHIN,
) -> dict[str, Any]:
    """Replay a run in a worker process; return the account of :func:`rrp_sheets.runs.replay.output.account`.

    Args:
        trace: a run's folder.
        other: the workbook to play instead of the one that ran.
        told: called with the progress, from 0 to 1.
        stopped: polled; the process is ended when it returns True.
        within: seconds for all of it.

    Raises:
        UnreadableFile: when the trace or a workbook cannot be read.
        Stopped: when it was stopped.
        SheetsError: when it cannot be replayed, needs too much memory or too long.
    """
    worker = WorkerProcess("rrp_sheets.runs.replay.child")
    try:
        said = worker.answers([str(trace), str(other or "")], within, every=_LISTEN)
        while True:
            message = next(said)
            if stopped():
                worker.kill()
                raise Stopped("The replay was stopped.", "Replay it again.")
            if message is None:
                continue
            kind, answer = message
            if kind == "done":
                return dict(answer)
            if kind == "failed":
                raise unpack_error(answer)
            if kind == "memory":
                raise WorkerError("needed more memory than it may have")
            told(float(answer))
    except WorkerError as none:
        remedy = "Try it again." if none.gone else "Replay it by rrp-sheets replay."
        raise SheetsError(f"The replay {none.why}.", remedy) from None
    finally:
        worker.close(0.5)
