"""Worker processes from the side of the program that starts them: start, messages, time limits, restarts."""

from __future__ import annotations

import errno
import json
import math
import os
import selectors
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any, ClassVar

from rrp_sheets.errors import SheetsError
from rrp_sheets.texts import N_
from rrp_sheets.workers.codec import unpack
from rrp_sheets.workers.transport import MOST_REQUEST, MessageReader, encode, ready

_TELL_EVERY = 0.25  # s
_FORK_WITHIN = 20.0  # s, for the fork server to import its modules and fork a process
_CODE_WITHIN = 2.0  # s, for the fork server to tell the exit code of a process that has ended
_LOOK_EVERY = 0.25  # s, while the end of a forked process is waited for
_UNKNOWN_CODE = 256  # of a process whose fork server has not told its exit code; exit codes are lower


@dataclass(frozen=True)
class Task:
    """Task of a worker process.

    Attributes:
        name: the dotted name of a function that takes the connection, and the numbers of the files that are shared.
        grace: seconds of processor time that the process may still use when its starter has gone, to come to its end.
        still: seconds of the wall clock in which it may then use none.
        memory: whether it may take all memory; else it has the limit of what evaluates formulas.
    """

    name: str
    grace: float = 0.0
    still: float = 0.0
    memory: bool = False

    @property
    def limits(self) -> tuple[float, float, bool]:
        """All but the name, as the process gets it."""
        return self.grace, self.still, self.memory


ANSWERS = Task("rrp_sheets.workers.worker_loop.answer_requests")


class WorkerError(SheetsError):
    """Error of a process that gave no answer.

    Attributes:
        why: what became of it, in words that follow “it” or “they”.
        gone: it has ended by itself, or something else has ended it: another time it may answer.
    """

    def __init__(self, why: str, *, gone: bool = False, message: str = "", remedy: str = "") -> None:
        super().__init__(message or N_("It {why}.", why=why), remedy)
        self.why = why
        self.gone = gone


class WorkerClosed(SheetsError):
    """Error of a request to a worker that the program has closed, since it ends itself."""

    def __init__(self) -> None:
        super().__init__(N_("The program is being ended."))


class WorkerProcess:
    """A worker process that was started, with the connection to it, and how it ended.

    Args:
        task: what it does; by default it answers requests, see `answer_requests`.
        shared: further open files that it inherits.
        scratch: whether it has a temporary folder of its own, which is removed with it.

    Attributes:
        link: our end of the connection; the process ends when it closes.
        fork_server: from which processes are forked; None starts each with an interpreter of its own.
    """

    fork_server: ClassVar[ForkServer | None] = None

    def __init__(self, task: Task = ANSWERS, *shared: int, scratch: bool = False) -> None:
        prefix = "rrp-sheets-"
        self._scratch = tempfile.TemporaryDirectory(prefix=prefix, ignore_cleanup_errors=True) if scratch else None
        self._log: IO[bytes] = tempfile.TemporaryFile()  # noqa: SIM115  # lives as long as the process
        self.link, theirs = socket.socketpair()
        self._reader = MessageReader(self.link)
        folder = self._scratch.name if self._scratch else tempfile.gettempdir()
        environment = {**os.environ, "TMPDIR": folder, "TEMP": folder, "TMP": folder}
        with theirs:
            given = task, environment, self._log, (theirs.fileno(), *shared)
            try:
                self._process = _fork_process(*given) or _start_process(*given)
            except OSError:
                self._release()
                raise

    @property
    def pid(self) -> int:
        """Process ID of the worker."""
        return self._process.pid

    @property
    def ended(self) -> bool:
        """True when the process has ended."""
        return self._process.poll() is not None

    def fileno(self) -> int:
        """Return the number of the connection, to wait for messages."""
        return self.link.fileno()

    def say(self, *message: Any) -> bool:
        """Send a message without waiting; return whether it was taken: not by one that has ended, or reads nothing."""
        data = encode(message)
        try:
            return self.link.send(data, socket.MSG_DONTWAIT) == len(data)
        except OSError:
            return False

    def send(self, *message: Any, within: float | None = None) -> bool:
        """Send a message; return whether it was taken within some seconds: if not, nothing more can be sent.

        That the process has ended is noticed only when messages are received.
        """
        link = self.link
        data = memoryview(encode(message))
        until = math.inf if within is None else time.monotonic() + within
        try:
            while data:
                with suppress(BlockingIOError):
                    data = data[link.send(data, socket.MSG_DONTWAIT) :]
                    continue
                left = until - time.monotonic()
                if left <= 0 or not ready(self.fileno(), None if within is None else left, selectors.EVENT_WRITE):
                    return False
        except OSError:
            return True
        return True

    def receive(self, within: float) -> list[list[Any]] | None:
        """Return the messages that have arrived, waiting some seconds for them; None when the process has ended."""
        if self.fileno() < 0:  # closed here
            return None
        return self._reader.receive() if ready(self.fileno(), within) else []

    def ask(self, request: Sequence[Any], within: float, told: Callable[[float | None], None] | None = None) -> Any:
        """Send a request to one that answers requests, and return the answer.

        Args:
            request: the dotted name of a function, and its arguments.
            within: seconds for all of it; then the process is ended.
            told: called with the progress, from 0 to 1, and with None now and then while there is none.

        Raises:
            WorkerError: when it has ended, was ended, or needed too much memory.
            SheetsError: the error that it answers.
        """
        deadline = time.monotonic() + within
        self.send(*request, within=max(within, 0.001))  # a process that hangs does not take what is sent
        while (left := deadline - time.monotonic()) > 0:
            messages = self.receive(min(left, _TELL_EVERY) if told else left)
            if messages is None:
                raise WorkerError(N_("ended unexpectedly{how}", how=self.exit_summary()), gone=True)
            for kind, *words in messages:
                if kind == "done":
                    return words[0]
                if kind == "failed":
                    raise unpack(SheetsError, words[0])
                if kind == "memory":
                    raise WorkerError(N_("needed more memory than is allowed"))
                if told:
                    told(float(words[0]))
            if told and not messages:
                told(None)
        self.kill()
        raise WorkerError(N_("did not end within {n:g} s", n=within))

    def kill(self) -> None:
        """End the process at once."""
        self._process.kill()
        self._process.wait()

    def close(self, within: float = 2.0) -> None:
        """Close the connection, so that the process ends within some seconds, or is ended, and release everything."""
        self.link.close()
        try:
            self._process.wait(within)
        except subprocess.TimeoutExpired:
            self.kill()
        self._release()

    def _release(self) -> None:
        self.link.close()
        self._log.close()
        if self._scratch is not None:
            self._scratch.cleanup()

    def exit_summary(self) -> str:
        """Return its exit code and the last line it wrote, as far as they are known; empty while it goes on."""
        try:
            code = self._process.wait(2.0)
        except subprocess.TimeoutExpired:
            return ""
        self._log.seek(0)
        lines = self._log.read().decode(errors="replace").strip().splitlines()
        if code < 0:  # killed from outside: it had no last words, only what it printed at its start
            return N_(" (signal {number})", number=-code)
        if code == _UNKNOWN_CODE:
            return N_(" (last line: {line})", line=lines[-1][:200]) if lines else ""
        if lines:
            return N_(" (exit code {code}: {line})", code=code, line=lines[-1][:200])
        return N_(" (exit code {code})", code=code)


def _start_process(
    task: Task, environment: dict[str, str], log: IO[bytes], files: Sequence[int]
) -> subprocess.Popen[bytes]:
    package = str(Path(__file__).parents[2])
    environment["PYTHONPATH"] = os.pathsep.join(p for p in (package, environment.get("PYTHONPATH")) if p)
    # -P: a file of the user's in the current folder must not be taken for a library's.
    # A group of its own: Ctrl-C is for the program, which then brings the robot to its rest.
    return subprocess.Popen(
        [sys.executable, "-P", "-m", __package__, task.name, json.dumps(task.limits), *map(str, files)],
        pass_fds=files, env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=log,
        process_group=0,
    )  # fmt: skip


class ForkServer:
    """Process with imported modules (dotted names), from which this program forks its workers: they begin at once."""

    def __init__(self, modules: Sequence[str]) -> None:
        self._requests, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._lock = threading.Lock()
        self.interpreter = _interpreter(os.environ)
        with theirs:
            self._process = WorkerProcess(FORK_SERVER, theirs.fileno())
        self._requests.send(json.dumps(modules).encode())

    @property
    def pid(self) -> int:
        """Process ID of the fork server."""
        return self._process.pid

    @property
    def ended(self) -> bool:
        """True when the fork server has ended, or was ended."""
        return self._process.ended

    def fork(self, request: bytes, files: Sequence[int]) -> ForkedProcess | None:
        """Fork a process that inherits files; None when it is refused. Raises OSError when too many are open here."""
        status, theirs = socket.socketpair()
        with theirs, suppress(OSError), self._lock:
            socket.send_fds(self._requests, [request], [theirs.fileno(), *files])
        if not ready(status.fileno(), _FORK_WITHIN):
            self._process.kill()  # so that the process does not begin later, beside one that is started instead
        try:
            pid, pidfds, _, _ = socket.recv_fds(status, 16, 1)
        except OSError:  # the fork server was killed
            pid, pidfds = b"", []
        if pidfds:
            return ForkedProcess(int(pid), pidfds[0], status)
        status.close()
        if pid:  # it has begun, but its pidfd does not fit beside the files that are open here
            raise OSError(errno.EMFILE, os.strerror(errno.EMFILE))
        return None

    def close(self) -> None:
        """End the fork server; the processes that it has forked go on until their connections close."""
        self._requests.close()
        self._process.close()


class ForkedProcess:
    """A process of the fork server, with what a `subprocess.Popen` has.

    Args:
        pid: its ID.
        pidfd: its file, which can be read when the process has ended, and never means another one.
        status: where the fork server reports its exit code.
    """

    def __init__(self, pid: int, pidfd: int, status: socket.socket) -> None:
        self.pid = pid
        self.returncode: int | None = None
        self._pidfd = pidfd
        self._status = status
        self._lock = threading.Lock()

    def poll(self) -> int | None:
        """Return the exit code; None while the process goes on."""
        with self._lock:
            if self.returncode is None and ready(self._pidfd, 0):
                code = b""
                with suppress(OSError):
                    code = self._status.recv(16) if ready(self._status.fileno(), _CODE_WITHIN) else b""
                self.returncode = int(code) if code else _UNKNOWN_CODE
                self._status.close()
                os.close(self._pidfd)
            return self.returncode

    def wait(self, timeout: float | None = None) -> int:
        """Return the exit code when the process has ended; raises `subprocess.TimeoutExpired` after some seconds."""
        until = math.inf if timeout is None else time.monotonic() + timeout
        while (code := self.poll()) is None:
            left = until - time.monotonic()
            if left <= 0:
                raise subprocess.TimeoutExpired("worker", timeout or 0.0)
            with suppress(OSError, ValueError):  # another thread has seen the end
                ready(self._pidfd, min(left, _LOOK_EVERY))
        return code

    def kill(self) -> None:
        """End the process at once."""
        with self._lock:
            if self.returncode is None:
                with suppress(ProcessLookupError):
                    signal.pidfd_send_signal(self._pidfd, signal.SIGKILL)


def _interpreter(environment: Mapping[str, str]) -> dict[str, str]:
    """Return what an interpreter reads of its environment when it starts."""
    return {name: value for name, value in environment.items() if name.startswith("PYTHON")}


FORK_SERVER = Task("rrp_sheets.workers.worker_loop.serve_forks", memory=True)


def fork_workers(modules: Sequence[str]) -> None:
    """Have this program fork its workers from a process that has these modules imported, where that can be done.

    That is on Linux: macOS forks unsafely, and only Linux has pidfds. Without a fork server, and when it has ended,
    workers are started.
    """
    if WorkerProcess.fork_server is None and sys.platform == "linux" and hasattr(os, "pidfd_open"):
        with suppress(OSError):  # an old kernel, or one that refuses pidfds; or no process can be started now
            os.close(os.pidfd_open(os.getpid()))
            WorkerProcess.fork_server = ForkServer(modules)


def _fork_process(
    task: Task, environment: dict[str, str], log: IO[bytes], files: Sequence[int]
) -> ForkedProcess | None:
    """Fork a process from the fork server; return None when the caller must start the process instead."""
    server = WorkerProcess.fork_server
    if server is None or task is FORK_SERVER or server.interpreter != _interpreter(environment):
        return None
    request = json.dumps({"task": task.name, "limits": task.limits, "environment": environment}).encode()
    try:
        folder = os.open(".", os.O_PATH)
    except OSError:
        return None
    try:
        fits = len(request) <= MOST_REQUEST
        process = server.fork(request, [folder, log.fileno(), *files]) if fits else None
    finally:
        os.close(folder)
    if server.ended:
        WorkerProcess.fork_server = None
        server.close()
    return process


class RestartingWorker:
    """Worker process that is kept and used again; from any thread, one request at a time. Close it at the end.

    It starts at the first request, and again when it has ended, or needed too much memory or time.
    """

    def __init__(self, start: Callable[[], WorkerProcess] = WorkerProcess) -> None:
        self._start = start
        self._lock = threading.Lock()
        self._closed = False
        self._worker: WorkerProcess | None = None

    @property
    def pid(self) -> int | None:
        """Process ID of the worker; None while there is none."""
        worker = self._worker
        return worker.pid if worker is not None else None

    def ask(self, request: Sequence[Any], within: float, start: float = 0.0) -> Any:
        """Return the answer to a request; see `WorkerProcess.ask`. Raises WorkerClosed when this was closed.

        Args:
            request: the dotted name of a function, and its arguments.
            within: seconds for the answer.
            start: seconds more when the process has to be started first.
        """
        with self._lock:
            if self._worker is not None and self._worker.ended:  # meanwhile: this request is not to blame
                self._drop()
            if self._worker is None and not self._closed:
                self._worker, within = self._start(), within + start
            if self._closed or self._worker is None:  # asked after it was made: `close` sees it, or this sees `close`
                raise WorkerClosed
            try:
                return self._worker.ask(request, within)
            except WorkerError:
                self._drop()
                if self._closed:
                    raise WorkerClosed from None
                raise

    def close(self) -> None:
        """End the process, whatever it is doing, and start no other."""
        self._closed = True
        worker = self._worker
        if worker is not None:
            worker.kill()
        with self._lock:
            self._drop()

    def _drop(self) -> None:
        worker, self._worker = self._worker, None
        if worker is not None:
            worker.close()
