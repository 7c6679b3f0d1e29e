"""The process of a replay: `python -m rrp_sheets.runs.replay.child LINK`, started by `apart` only.

Formulas of strangers are evaluated here, with a memory limit. It does one replay, tells how far it is, and ends; also
when the connection does.
"""

from __future__ import annotations

import os
import signal
import socket
import sys
from pathlib import Path
from typing import Any

from rrp_sheets.errors import SheetsError
from rrp_sheets.runs.limits import limit_memory
from rrp_sheets.runs.replay.account import account
from rrp_sheets.runs.replay.replaying import replay
from rrp_sheets.runs.wire import Lines, line, pack_error

_NICE = 5  # a run that somebody watches comes first


def main() -> None:
    """Answer one request."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the program
    limit_memory()
    if hasattr(os, "nice"):
        os.nice(_NICE)
    link = socket.socket(fileno=int(sys.argv[1]))
    for trace, other in Lines(link):
        link.sendall(line(_answer(link, trace, other)))
        return


def _answer(link: socket.socket, trace: str, other: str) -> list[Any]:
    def told(part: float) -> None:
        link.sendall(line(["at", part]))

    try:
        return ["done", account(replay(Path(trace), Path(other) if other else None, told))]
    except SheetsError as error:
        return ["failed", pack_error(error)]
    except OSError as error:
        return ["failed", pack_error(SheetsError(f"It cannot be read ({error.strerror}).", "Look at its folder."))]
    except MemoryError:
        return ["memory", None]


if __name__ == "__main__":
    main()
