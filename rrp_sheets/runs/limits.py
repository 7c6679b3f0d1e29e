"""How much memory a process may have, and where it tells what it is doing."""

from __future__ import annotations

import mmap
import os
import tempfile
from typing import cast

from rrp_sheets.runtime.progress import NO_ROW, PLACES, RANK, Cell

try:
    import resource
except ImportError:  # Windows has no such limit: there only the watchdog holds a process in check
    resource = None  # type: ignore[assignment]

MOST_MEMORY = 3 << 29
"""Bytes of address space for a process that evaluates formulas: some five times what the largest workbooks need."""
_BYTES = 8


def limit_memory(most: int = MOST_MEMORY) -> None:
    """Let this process, and those that it starts, have no more memory than this; asking for more is a MemoryError.

    On a Mac the system takes note and does not hold to it.
    """
    if resource is not None:
        hard = resource.getrlimit(resource.RLIMIT_AS)[1]
        resource.setrlimit(resource.RLIMIT_AS, (most if hard < 0 else min(most, hard), hard))


def lift_limit() -> None:
    """Let this process have all memory again: no formula is evaluated any more."""
    if resource is not None:
        hard = resource.getrlimit(resource.RLIMIT_AS)[1]
        resource.setrlimit(resource.RLIMIT_AS, (hard, hard))


class SharedCell:
    """A cell of a watched process: its numbers lie in memory that both processes see.

    Attributes:
        fd: of the memory, to be inherited.
        numbers: by place (see `runtime.progress`).
    """

    def __init__(self, fd: int | None = None) -> None:
        mine = fd is None
        if fd is None:
            fd = _memory()
            os.ftruncate(fd, PLACES * _BYTES)
        self.fd = fd
        self._map = mmap.mmap(fd, PLACES * _BYTES)
        self.numbers = cast(Cell, memoryview(self._map).cast("q"))
        if mine:
            self.numbers[RANK] = NO_ROW

    def close(self) -> None:
        """Let the memory go."""
        cast("memoryview[int]", self.numbers).release()
        self._map.close()
        os.close(self.fd)


def _memory() -> int:
    if hasattr(os, "memfd_create"):
        return os.memfd_create("rrp-sheets")
    with tempfile.TemporaryFile() as file:
        return os.dup(file.fileno())
