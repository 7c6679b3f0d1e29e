"""Worker processes from their own side: set-up, memory limit, guard, the loop that answers requests, forking."""

from __future__ import annotations

import gc
import inspect
import json
import os
import select
import signal
import socket
import tempfile
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial
from importlib import import_module
from typing import Any

from rrp_sheets.errors import SheetsError
from rrp_sheets.texts import N_, os_reason
from rrp_sheets.workers.codec import pack
from rrp_sheets.workers.transport import MOST_REQUEST, Liveness, MessageReader, cpu_clock, encode

try:
    import resource
except ImportError:  # Windows has no such limit: there only the watchdog holds a process in check
    resource = None  # type: ignore[assignment]

MOST_MEMORY = 3 << 29
"""Bytes of address space for a process that evaluates formulas: some five times what the largest workbooks need."""


def do_task(task: str, limits: Sequence[Any], link: int, *shared: int) -> None:
    """Set this process up, do its task until the connection, which has the number `link`, closes, and end it."""
    with suppress(OSError), open("/proc/self/comm", "w") as name:  # as `ps` and `top` show it; on Linux
        name.write(task.split(".")[-2])
    connection = begin(link, *limits)  # before the task's libraries start threads
    named(task)(connection, *shared)
    os._exit(0)  # an orderly exit takes down all that is imported, which takes longer than many a task


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
        why = N_("It cannot be read ({reason}).", reason=os_reason(error))
        return encode(["failed", pack(SheetsError(why, N_("Look at its folder.")))])
    except MemoryError:
        return encode(["memory"])


def answer_requests(link: socket.socket) -> None:
    """Answer requests until the connection closes: each is the dotted name of a function, and its arguments.

    A function that has a parameter `report_progress` gets there what sends its progress, from 0 to 1.
    """

    def report(part: float) -> None:
        link.sendall(encode(["at", part]))

    def call(name: str, *arguments: Any) -> Any:
        function = named(name)
        progress = {"report_progress": report} if "report_progress" in inspect.signature(function).parameters else {}
        return function(*arguments, **progress)

    for request in MessageReader(link):
        link.sendall(answer(partial(call, *request)))


def limit_memory() -> None:
    """Limit the memory of this process and of those that it starts; exceeding it raises a MemoryError.

    Libraries that a forked process has from its fork server do not count. macOS accepts the limit but does not enforce
    it.
    """
    if resource is not None:
        most = MOST_MEMORY
        with suppress(OSError), open("/proc/self/statm") as file:  # the address space that is taken already; on Linux
            most += int(file.read().split()[0]) * resource.getpagesize()
        hard = resource.getrlimit(resource.RLIMIT_AS)[1]
        resource.setrlimit(resource.RLIMIT_AS, (most if hard < 0 else min(most, hard), hard))


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
    _close_files({link, alive})
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


def _close_files(kept: set[int]) -> None:
    last = -1
    for number in (*sorted(kept), os.sysconf("SC_OPEN_MAX")):
        if number > last + 1:  # `closerange(0, 0)` would close all
            os.closerange(last + 1, number)
        last = number


# ---- a process from which the others are forked
_LIBRARIES = ("OMP", "OPENBLAS", "MKL")


def limit_threads() -> None:
    """Have numeric libraries that are imported from now on use one thread, so that results do not depend on cores."""
    os.environ.update({f"{library}_NUM_THREADS": "1" for library in _LIBRARIES})


def serve_forks(link: socket.socket, requests: int) -> None:
    """Fork a worker process for each request, until the connection closes; see `ForkServer`.

    The first request names modules to import. Each other one comes with the files of its process: where its ID with a
    pidfd and later its exit code are told, its folder, its standard error, its connection, and those that it shares. A
    request that cannot be granted gets no answer but the end of the first file.
    """
    channel = socket.socket(fileno=requests)
    limit_threads()
    for module in json.loads(channel.recv(MOST_REQUEST)):
        with suppress(ImportError):  # the simulator's libraries may be missing: who needs them says so
            import_module(module)
    gc.freeze()  # what is not looked through for garbage stays in memory that the forked processes share
    poll = select.poll()
    poll.register(channel, select.POLLIN)
    running: dict[int, tuple[int, socket.socket]] = {}  # IDs, and where their exit codes are told, by pidfd
    while True:
        for number, _ in poll.poll():
            if number in running:
                pid, status = running.pop(number)
                poll.unregister(number)
                os.close(number)
                with status, suppress(OSError):  # its starter may have gone
                    status.send(str(os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])).encode())
                continue
            request, files, _, _ = socket.recv_fds(channel, MOST_REQUEST, 16)
            if not request:
                return
            status = socket.socket(fileno=files[0])
            try:
                os.fchdir(files[1])
                if pid := os.fork():
                    pidfd = _open_pidfd(pid)
                    running[pidfd] = pid, status
                    poll.register(pidfd, select.POLLIN)
                    socket.send_fds(status, [str(pid).encode()], [pidfd])
            except OSError:
                pid = -1  # nothing was forked, or it was ended
                status.close()
            if not pid:
                for each in (channel, link, status, *(s for _, s in running.values())):
                    each.detach()  # their numbers will be those of other files
                _run_forked(json.loads(request), files[2:])
            for file in files[1:]:
                os.close(file)


def _open_pidfd(pid: int) -> int:
    """Open the pidfd of a child; one that cannot be watched is ended."""
    try:
        return os.pidfd_open(pid)
    except OSError:
        os.kill(pid, signal.SIGKILL)
        os.waitpid(pid, 0)
        raise


def _run_forked(request: dict[str, Any], files: list[int]) -> None:
    """Do the task of a forked process, as `__main__` does that of one that was started, and end it."""
    log, *rest = files
    _close_files({0, 1, 2, *files})
    os.dup2(log, 2)
    os.close(log)
    os.setpgid(0, 0)
    os.environ.clear()
    os.environ.update(request["environment"])
    tempfile.tempdir = None
    do_task(request["task"], request["limits"], *rest)
