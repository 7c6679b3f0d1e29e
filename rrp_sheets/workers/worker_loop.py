"""Worker processes from their own side: set-up, memory limit, guard, and the loop that answers requests."""

from __future__ import annotations

import inspect
import os
import select
import signal
import socket
from collections.abc import Callable, Sequence
from importlib import import_module
from typing import Any

from rrp_sheets.errors import SheetsError
from rrp_sheets.texts import N_
from rrp_sheets.workers.codec import pack
from rrp_sheets.workers.liveness import Liveness, cpu_clock
from rrp_sheets.workers.transport import MessageReader, encode

try:
    import resource
except ImportError:  # Windows has no such limit: there only the watchdog holds a process in check
    resource = None  # type: ignore[assignment]

MOST_MEMORY = 3 << 29
"""Bytes of address space for a process that evaluates formulas: some five times what the largest workbooks need."""


def begin(link: int, grace: float, still: float, memory: bool) -> socket.socket:
    """Set up a process that has just been started; return its connection, which has the number `link`. See `Task`."""
    connection = socket.socket(fileno=link)
    end_with_starter(connection, grace, still)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the program
    if memory:
        lift_limit()
    else:
        limit_memory()
    return connection


def named(name: str) -> Callable[..., Any]:
    """Import a function of this program by its dotted name, which only the program itself ever says."""
    module, _, function = name.rpartition(".")
    found: Callable[..., Any] = getattr(import_module(module), function)
    return found


def answer(make: Callable[[], Any]) -> bytes:
    r"""Call `make`, and return its result or its error as a message.

    >>> answer(lambda: 3)
    b'["done",3]\n'
    """
    try:
        return encode(["done", pack(make())])
    except SheetsError as error:
        return encode(["failed", pack(error)])
    except OSError as error:
        why = N_("It cannot be read ({reason}).", reason=error.strerror)
        return encode(["failed", pack(SheetsError(why, N_("Look at its folder.")))])
    except MemoryError:
        return encode(["memory"])


def answer_requests(link: socket.socket) -> None:
    """Answer requests until the connection closes: each is the dotted name of a function, and its arguments.

    A function that has a parameter `report_progress` gets there what sends its progress, from 0 to 1.
    """

    def report(part: float) -> None:
        link.sendall(encode(["at", part]))

    for name, *arguments in MessageReader(link):
        link.sendall(answer(lambda: _call(name, arguments, report)))  # noqa: B023  # made at once


def _call(name: str, arguments: Sequence[Any], report: Callable[[float], None]) -> Any:
    function = named(name)
    progress = {"report_progress": report} if "report_progress" in inspect.signature(function).parameters else {}
    return function(*arguments, **progress)


def limit_memory() -> None:
    """Limit the memory of this process and of those that it starts; exceeding it raises a MemoryError.

    macOS accepts the limit but does not enforce it.
    """
    if resource is not None:
        hard = resource.getrlimit(resource.RLIMIT_AS)[1]
        resource.setrlimit(resource.RLIMIT_AS, (MOST_MEMORY if hard < 0 else min(MOST_MEMORY, hard), hard))


def lift_limit() -> None:
    """Remove the memory limit of this process, when it evaluates no more formulas."""
    if resource is not None:
        hard = resource.getrlimit(resource.RLIMIT_AS)[1]
        resource.setrlimit(resource.RLIMIT_AS, (hard, hard))


# ---- no process outlives its starter
def end_with_starter(link: socket.socket, grace: float, still: float) -> None:
    """Have this process killed when its starter has gone, even while native code holds the interpreter.

    A guard does it: a copy of this process that only waits for the end of the connection. Call this first, before any
    thread is started. Where the system cannot fork, nothing happens.

    Args:
        link: the connection to the starter.
        grace: seconds of processor time that this process may then still use, to come to its own end.
        still: seconds of the wall clock that it may then use none.
    """
    if not hasattr(os, "fork"):
        return
    mine = os.getpid()
    alive, _held = os.pipe()  # `_held` stays open in this process: its end is the end of the guard
    if os.fork():
        os.close(alive)
        return
    try:
        _guard(link.fileno(), alive, mine, grace, still)
    finally:
        os._exit(0)


def _guard(link: int, alive: int, pid: int, grace: float, still: float) -> None:
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    low, high = sorted((link, alive))
    os.closerange(0, low)
    os.closerange(low + 1, high)
    os.closerange(high + 1, os.sysconf("SC_OPEN_MAX"))
    ends = select.poll()
    ends.register(alive, 0)
    ends.register(link, 0)  # only its end: what is said on it is not for the guard
    if any(number == alive for number, _ in ends.poll()):
        return
    ends.unregister(link)
    if grace:
        life = Liveness(cpu_clock(pid))
        while life.computing < grace and life.still < still:
            if ends.poll(100):
                return
            life.look(None, has_work=True)
    if os.getppid() == pid:
        os.kill(pid, signal.SIGKILL)
