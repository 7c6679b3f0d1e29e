"""How much memory a process that evaluates formulas may have."""

from __future__ import annotations

try:
    import resource
except ImportError:  # Windows has no such limit: there only the watchdog holds a process in check
    resource = None  # type: ignore[assignment]

MOST_MEMORY = 3 << 29
"""Bytes of address space for a process that evaluates formulas: some five times what the largest workbooks need."""


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
