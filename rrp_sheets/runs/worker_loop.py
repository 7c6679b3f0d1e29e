"""Request loop and memory limit of a worker process, which answers errors too.

It ends when its connection closes. The other side is `worker_process`.
"""

from __future__ import annotations

import signal
import socket
import sys
from collections.abc import Callable, Mapping
from typing import Any

from rrp_sheets.errors import SheetsError
from rrp_sheets.processes import Lines, end_with_starter, line
from rrp_sheets.runs.wire import pack_error


def begin(grace: float = 0.0, still: float | None = None) -> socket.socket:
    """Set up a process that has just been started; return its connection, whose number is its first argument.

    Args:
        grace: seconds of processor time that the process may still use when the program that started it has gone.
        still: seconds of the wall clock that it may then use none; as many when None.
    """
    link = socket.socket(fileno=int(sys.argv[1]))
    end_with_starter(link, grace, still)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the program
    limit_memory()
    return link


def answer(make: Callable[[], Any]) -> list[Any]:
    """Call `make`, and return its result or its error as an answer.

    >>> answer(lambda: 3)
    ['done', 3]
    """
    try:
        return ["done", make()]
    except SheetsError as error:
        return ["failed", pack_error(error)]
    except OSError as error:
        return ["failed", pack_error(SheetsError(f"It cannot be read ({error.strerror}).", "Look at its folder."))]
    except MemoryError:
        return ["memory", None]


def serve(do: Mapping[str, Callable[..., Any]]) -> None:
    """Answer requests until the connection closes; `do` has the functions by the names of the requests."""
    link = begin()
    for name, *arguments in Lines(link):
        link.sendall(line(answer(lambda: do[name](*arguments))))  # noqa: B023  # made at once


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
