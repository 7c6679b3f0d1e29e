"""Signs of life of a worker process, by which its starter judges whether it still works.

A process may have a heartbeat: whole numbers in memory that both see. It is judged by its processor time, not by the
clock on the wall: on a busy machine a healthy process may be late.
"""

from __future__ import annotations

import mmap
import os
import tempfile
import time
from collections.abc import Callable
from contextlib import suppress

_BYTES = 8
LONGEST_LOOK = 0.5
"""Seconds (wall clock) that count between two looks at a process: when the whole machine stood still, nothing died."""


class SharedCell:
    """Whole numbers in memory that a process and its starter both see.

    Args:
        places: how many numbers; all are 0 at first.
        fd: of the memory that the starter has made; None makes one.

    Attributes:
        fd: of the memory, to be inherited.
        numbers: by place.
    """

    def __init__(self, places: int, fd: int | None = None) -> None:
        if fd is None:
            fd = _memory()
            os.ftruncate(fd, places * _BYTES)
        self.fd = fd
        self._map = mmap.mmap(fd, places * _BYTES)
        self.numbers = memoryview(self._map).cast("q")

    def close(self) -> None:
        """Let the memory go."""
        self.numbers.release()
        self._map.close()
        os.close(self.fd)


def _memory() -> int:
    if hasattr(os, "memfd_create"):
        return os.memfd_create("rrp-sheets")
    with tempfile.TemporaryFile() as file:
        return os.dup(file.fileno())


def cpu_clock(pid: int) -> Callable[[], float]:
    """Return a clock of the processor time (s) that a process has used; it stands still when the process has ended."""
    import psutil

    used = 0.0
    process: psutil.Process | None = None
    with suppress(psutil.Error):
        process = psutil.Process(pid)

    def read() -> float:
        nonlocal used
        if process is not None:
            with suppress(psutil.Error):
                times = process.cpu_times()
                used = times.user + times.system
        return used

    return read


class Liveness:
    """Measures for how long a process has made no progress.

    Args:
        cpu: the process's processor time in seconds, see `cpu_clock`.
        now: the wall clock in seconds.

    Attributes:
        computing: seconds of processor time since its last progress.
        still: seconds of the wall clock in which it had work, made no progress and used no processor time.
    """

    def __init__(self, cpu: Callable[[], float], now: Callable[[], float] = time.monotonic) -> None:
        self._cpu, self._now = cpu, now
        self._used, self._looked = cpu(), now()
        self._progress: object = None
        self.computing = self.still = 0.0

    def look(self, progress: object, *, has_work: bool) -> tuple[float, float]:
        """Look at it, some ten times a second; return the processor and wall time (s) that count since the last look.

        Args:
            progress: anything that differs when it has made progress.
            has_work: whether it is its turn: one that waits for somebody else may stand still.
        """
        used, now = self._cpu(), self._now()
        computed, passed = max(used - self._used, 0.0), min(now - self._looked, LONGEST_LOOK)
        self._used, self._looked = used, now
        went_on = progress != self._progress
        self._progress = progress
        self.computing = 0.0 if went_on else self.computing + computed
        self.still = 0.0 if went_on or computed or not has_work else self.still + passed
        return computed, passed
