"""Replay in a worker process, for a server, which never evaluates untrusted formulas itself."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from rrp_sheets.errors import SheetsError
from rrp_sheets.texts import N_
from rrp_sheets.workers.worker_process import WorkerError, WorkerProcess

WITHIN = 180.0
"""Seconds for one replay: several times what an hour of a busy session takes."""
_NICE = 5  # a run that somebody watches comes first
_TASK = f"{__name__}.replay_as_account"


class Stopped(SheetsError):
    """Error of a replay that nobody wants any more."""


def replay_apart(
    trace: Path,
    other: Path | None,
    told: Callable[[float], None],
    stopped: Callable[[], bool] = lambda: False,
    within: float = WITHIN,
) -> dict[str, Any]:
    """Replay a run in a worker process; return the account of :func:`rrp_sheets.replay.output.account`.

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

    def listen(part: float | None) -> None:
        if stopped():
            worker.kill()
            raise Stopped(N_("The replay was stopped."), N_("Replay it again."))
        if part is not None:
            told(part)

    worker = WorkerProcess()
    try:
        listen(None)
        return dict(worker.ask([_TASK, str(trace), str(other or "")], within, listen))
    except WorkerError as none:
        remedy = N_("Try it again.") if none.gone else N_("Replay it by rrp-sheets replay.")
        raise SheetsError(N_("The replay {why}.", why=none.why), remedy) from None
    finally:
        worker.close(0.5)


def replay_as_account(trace: str, other: str, report_progress: Callable[[float], None]) -> dict[str, Any]:
    """Replay a run in the worker process; see `replay_apart`."""
    from rrp_sheets.replay.output import account
    from rrp_sheets.replay.replaying import replay

    if hasattr(os, "nice"):
        os.nice(_NICE)
    return account(replay(Path(trace), Path(other) if other else None, report_progress))
