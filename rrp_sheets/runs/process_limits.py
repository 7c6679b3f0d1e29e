"""Memory limit of processes that evaluate formulas."""

from __future__ import annotations

try:
    import resource
except ImportError:  # Windows has no such limit: there only the watchdog holds a process in check
    resource = None  # type: ignore[assignment]

MOST_MEMORY = 3 << 29
"""Bytes of address space for a process that evaluates formulas: some five times what the largest workbooks need."""


def limit_memory(most: int = MOST_MEMORY) -> None:
    """Limit the memory of this process and of those that it starts; exceeding it raises a MemoryError.

    macOS accepts the limit but does not enforce it.
    """
    if resource is not None:
        hard = resource.getrlimit(resource.RLIMIT_AS)[1]
        resource.setrlimit(resource.RLIMIT_AS, (most if hard < 0 else min(most, hard), hard))


def lift_limit() -> None:
    """Remove the memory limit of this process, when it evaluates no more formulas."""
    if resource is not None:
        hard = resource.getrlimit(resource.RLIMIT_AS)[1]
        resource.setrlimit(resource.RLIMIT_AS, (hard, hard))
