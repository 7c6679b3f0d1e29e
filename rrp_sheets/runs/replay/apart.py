"""A replay in a process of its own, for a server: formulas of strangers are never evaluated in it."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from rrp_sheets.errors import SheetsError
from rrp_sheets.processes import Child
from rrp_sheets.runs.office import readable
from rrp_sheets.runs.wire import Lines, line, unpack_error

WITHIN = 180.0
"""Seconds for one replay: several times what an hour of a busy session takes."""
_LISTEN = 0.25  # s


class Stopped(SheetsError):
    """Nobody wants the replay any more."""


def replay_apart(
    trace: Path,
    other: Path | None,
    told: Callable[[float], None],
    stopped: Callable[[], bool] = lambda: False,
    within: float = WITHIN,
) -> dict[str, Any]:
    """Replay a run; the account as :func:`rrp_sheets.runs.replay.account.account` gives it.

    Args:
        trace: a run's folder.
        other: the workbook to play instead of the one that ran.
        told: hears how far it is, from 0 to 1.
        stopped: asked again and again; the process is ended when it says so.
        within: seconds for all of it.

    Raises:
        UnreadableFile: when the trace or a workbook cannot be read.
        Stopped: when it was stopped.
        SheetsError: when it cannot be replayed, needs too much memory or too long.
    """
    child = Child("rrp_sheets.runs.replay.child")
    try:
        return _listen(child, [str(trace), str(other or "")], told, stopped, time.monotonic() + within)
    finally:
        child.close(0.5)


def _listen(
    child: Child, request: list[str], told: Callable[[float], None], stopped: Callable[[], bool], deadline: float
) -> dict[str, Any]:
    lines = Lines(child.link)
    try:
        child.link.sendall(line(request))
    except OSError:
        raise _gone(child) from None
    while time.monotonic() < deadline:
        if stopped():
            child.kill()
            raise Stopped("The replay was stopped.", "Replay it again.")
        if not readable(child.link.fileno(), _LISTEN):
            continue
        messages = lines.receive()
        if messages is None:
            raise _gone(child)
        for kind, answer in messages:
            if kind == "at":
                told(float(answer))
            elif kind == "done":
                return dict(answer)
            elif kind == "failed":
                raise unpack_error(answer)
            else:
                raise SheetsError("This replay needs more memory than it may have.", "Replay it by rrp-sheets replay.")
    child.kill()
    raise SheetsError("This replay does not come to an end.", "Replay it by rrp-sheets replay.")


def _gone(child: Child) -> SheetsError:
    return SheetsError(f"The replay has ended unexpectedly{child.last_words()}.", "Try it again.")
