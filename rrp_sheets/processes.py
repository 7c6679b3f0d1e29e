"""Starting and supervising worker processes, of a run or of a server: each runs a module of this package.

A process has a connection to its starter, on which both send lines of JSON, and may have a heartbeat: whole numbers in
memory that both see. Whether it still works is judged by its processor time, not by the clock on the wall: on a busy
machine a healthy process may be late.
"""

from __future__ import annotations

import json
import mmap
import os
import select
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import IO, Any

_BYTES = 8
LONGEST_LOOK = 0.5
"""Seconds (wall clock) that count between two looks at a process: when the whole machine stood still, nothing died."""


class ChildProcess:
    """A started process of ours, with the connection to it, and how it ended.

    Args:
        module: what it runs; its first argument is the number of its end of the connection.
        shared: further open files that it inherits; their numbers are its further arguments.
        scratch: the folder for what it keeps for a moment; by default where this process does.

    Attributes:
        link: our end of the connection; the process ends when it closes.
    """

    def __init__(self, module: str, *shared: int, scratch: str = "") -> None:
        self.link, theirs = socket.socketpair()
        self._log: IO[bytes] = tempfile.TemporaryFile()  # noqa: SIM115  # lives as long as the process
        scratch = scratch or tempfile.gettempdir()
        environment = {**os.environ, "TMPDIR": scratch, "TEMP": scratch, "TMP": scratch}
        package = str(Path(__file__).parent.parent)
        environment["PYTHONPATH"] = os.pathsep.join(p for p in (package, environment.get("PYTHONPATH")) if p)
        with theirs:
            inherited = (theirs.fileno(), *shared)
            # -P: a file of the user's in the current folder must not be taken for a library's.
            # A group of its own: Ctrl-C is for the program, which then brings the robot to its rest.
            self._process: subprocess.Popen[Any] = subprocess.Popen(
                [sys.executable, "-P", "-m", module, *map(str, inherited)], pass_fds=inherited, env=environment,
                stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=self._log, process_group=0,
            )  # fmt: skip

    @property
    def pid(self) -> int:
        """The process's number."""
        return self._process.pid

    @property
    def ended(self) -> bool:
        """True when the process has ended."""
        return self._process.poll() is not None

    def say(self, *message: Any) -> bool:
        """Send a message without waiting; return whether it was taken: not by one that has ended, or reads nothing."""
        data = line(list(message))
        try:
            return self.link.send(data, socket.MSG_DONTWAIT) == len(data)
        except OSError:
            return False

    def kill(self) -> None:
        """End it at once."""
        self._process.kill()
        self._process.wait()

    def close(self, within: float) -> None:
        """Let it end by itself within some seconds, which it does when the connection closes; else end it."""
        self.link.close()
        try:
            self._process.wait(within)
        except subprocess.TimeoutExpired:
            self.kill()
        self._log.close()

    def exit_summary(self) -> str:
        """Return its exit code and the last line it wrote; empty while it goes on."""
        try:
            code = self._process.wait(2.0)
        except subprocess.TimeoutExpired:
            return ""
        self._log.seek(0)
        lines = self._log.read().decode(errors="replace").strip().splitlines()
        if code < 0:  # killed from outside: it had no last words, only what it printed at its start
            return f" (signal {-code})"
        return f" (exit code {code}: {lines[-1][:200]})" if lines else f" (exit code {code})"


# ---- what the two sides say
def line(message: list[Any]) -> bytes:
    """Return a message as a line; letters beyond ASCII are escaped, those of undecodable file names too."""
    return json.dumps(message, separators=(",", ":")).encode("ascii") + b"\n"


class Lines:
    """Puts what arrives on a socket together into messages."""

    def __init__(self, link: socket.socket) -> None:
        self._link = link
        self._rest = b""

    def receive(self, flags: int = 0) -> list[list[Any]] | None:
        """Return the messages of the next chunk, waiting for it; None when the other side has gone.

        Args:
            flags: of `recv`; with MSG_DONTWAIT it does not wait, and an empty list means that nothing has come.
        """
        try:
            chunk = self._link.recv(1 << 18, flags)
        except BlockingIOError:
            return []
        except OSError:
            return None
        if not chunk:
            return None
        *whole, self._rest = (self._rest + chunk).split(b"\n")
        return [json.loads(w) for w in whole]

    def __iter__(self) -> Iterator[list[Any]]:
        """Message by message, to the end."""
        while (found := self.receive()) is not None:
            yield from found


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


# ---- whether a process still works
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


# ---- no process outlives its starter
def end_with_starter(link: socket.socket, grace: float = 0.0, still: float | None = None) -> None:
    """Have this process killed when its starter has gone, even while native code holds the interpreter.

    A guard does it: a copy of this process that only waits for the end of the connection. Call this first, before any
    thread is started. Where the system cannot fork, nothing happens.

    Args:
        link: the connection to the starter.
        grace: seconds of processor time that this process may then still use, to come to its own end.
        still: seconds of the wall clock that it may then use none; as many when None.
    """
    if not hasattr(os, "fork"):
        return
    mine = os.getpid()
    alive, _held = os.pipe()  # `_held` stays open in this process: its end is the end of the guard
    if os.fork():
        os.close(alive)
        return
    try:
        _guard(link.fileno(), alive, mine, grace, grace if still is None else still)
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
