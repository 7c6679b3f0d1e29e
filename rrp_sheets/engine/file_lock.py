"""File locks of runs: a record that is being written is locked, so that others can tell that its run goes on.

The folder is locked too, from when it is made until its last file is there: a run that begins says only in its record
whose it is, and tables and pictures are made after the record is closed. The system releases both when the process
ends, however it ends.
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

if sys.platform != "win32":
    import fcntl

_TRIES, _PAUSE = 5, 0.002  # s: who asks whether it is held holds it for that moment


def lock(file: IO[str]) -> None:
    """Lock an open file until it is closed. Where the system or its disk cannot do that, nothing happens."""
    _lock(file.fileno())


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Lock a folder within the context, where that can be done."""
    number = lock_folder(folder)
    try:
        yield
    finally:
        unlock(number)


def lock_folder(folder: Path) -> int | None:
    """Lock a folder until `unlock` is called with the result; None where that cannot be done."""
    if sys.platform == "win32":
        return None
    try:
        number = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    except OSError:
        return None
    if _lock(number):
        return number
    os.close(number)
    return None


def _lock(number: int) -> bool:
    if sys.platform == "win32":
        return False
    for left in reversed(range(_TRIES)):
        try:
            fcntl.flock(number, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            if left:
                time.sleep(_PAUSE)
        except OSError:  # a disk in the network, say
            return False
        else:
            return True
    return False


def unlock(number: int | None) -> None:
    """Release the lock of a folder; nothing happens for None."""
    if number is not None:
        os.close(number)


def is_locked(path: Path) -> bool:
    """Return whether a file or a folder is locked by a process."""
    if sys.platform == "win32":
        return False
    try:
        number = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    except OSError:
        return False
    try:
        fcntl.flock(number, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:
        return False
    finally:
        os.close(number)
    return False
