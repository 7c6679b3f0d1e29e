"""A record that is being written is held by its run, so that others can tell that the run goes on.

The system lets go of it when the process ends, however it ends.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import IO


def hold(file: IO[str]) -> None:
    """Hold an open file until it is closed. Where the system or its disk cannot do that, nothing happens."""
    if sys.platform == "win32":
        return
    import fcntl

    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:  # a disk in the network, say
        return


def is_held(path: Path) -> bool:
    """Whether somebody holds a file."""
    if sys.platform == "win32":
        return False
    import fcntl

    try:
        with path.open("rb") as file:
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:
        return False
    return False
