"""Worker process of a replay: `python -m rrp_sheets.runs.replay.child LINK`, started by `apart` only.

Untrusted formulas are evaluated here, with a memory limit. It does one replay, reports its progress, and ends; also
when the connection closes.
"""

from __future__ import annotations

import os
from functools import partial
from pathlib import Path

from rrp_sheets.processes import Lines, line
from rrp_sheets.runs.replay.output import account
from rrp_sheets.runs.replay.replaying import replay
from rrp_sheets.runs.worker_loop import answer, begin

_NICE = 5  # a run that somebody watches comes first


def main() -> None:
    """Answer one request."""
    link = begin()
    if hasattr(os, "nice"):
        os.nice(_NICE)

    def told(part: float) -> None:
        link.sendall(line(["at", part]))

    for trace, other in Lines(link):
        replayed = partial(replay, Path(trace), Path(other) if other else None, told)
        link.sendall(line(answer(lambda: account(replayed()))))  # noqa: B023  # made at once
        return


if __name__ == "__main__":
    main()
