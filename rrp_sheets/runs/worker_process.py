"""Worker processes from the side of the program that starts them: requests, time limits, restarts, checks."""

from __future__ import annotations

import math
import selectors
import socket
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rrp_sheets.diagnostics import Diagnostic, Report
from rrp_sheets.diagnostics.phrase import Phrase
from rrp_sheets.diagnostics.report import UnreadableWorkbook
from rrp_sheets.engine.clock import NO_ROW, PLACES, RANK
from rrp_sheets.errors import SheetsError
from rrp_sheets.processes import ChildProcess, Lines, SharedCell, cpu_clock, line
from rrp_sheets.runs.wire import unpack_error, unpack_finding


class WorkerError(SheetsError):
    """Error of a process that gave no answer.

    Attributes:
        why: what became of it, in words that follow “it” or “they”.
        gone: it has ended by itself, or something else has ended it: another time it may answer.
    """

    def __init__(self, why: str, *, gone: bool = False, message: str = "", remedy: str = "") -> None:
        super().__init__(message or f"It {why}.", remedy)
        self.why = why
        self.gone = gone


class WorkerProcess:
    """A worker process that was started, with the connection to it.

    Args:
        module: what it runs.
        shared: further open files that it inherits.
        scratch: whether it has a temporary folder of its own, which is removed with it.
    """

    def __init__(self, module: str, *shared: int, scratch: bool = False) -> None:
        prefix = "rrp-sheets-"
        self._scratch = tempfile.TemporaryDirectory(prefix=prefix, ignore_cleanup_errors=True) if scratch else None
        self._child = ChildProcess(module, *shared, scratch=self._scratch.name if self._scratch else "")
        self._lines = Lines(self._child.link)

    @property
    def pid(self) -> int:
        """Process ID of the worker."""
        return self._child.pid

    @property
    def ended(self) -> bool:
        """True when the process has ended."""
        return self._child.ended

    def fileno(self) -> int:
        """Return the number of the connection, to wait for messages."""
        return self._child.link.fileno()

    def say(self, *message: Any) -> bool:
        """Send a short message without waiting; return whether it was taken."""
        return self._child.say(*message)

    def send(self, *message: Any, within: float | None = None) -> bool:
        """Send a message; that the process has ended is noticed only when messages are received.

        Args:
            message: what is sent.
            within: seconds for it to be taken; None waits.

        Returns:
            Whether it was taken in time; if not, nothing more can be sent.
        """
        link = self._child.link
        data = memoryview(line(list(message)))
        until = math.inf if within is None else time.monotonic() + within
        try:
            while data:
                with suppress(BlockingIOError):
                    data = data[link.send(data, socket.MSG_DONTWAIT) :]
                    continue
                left = until - time.monotonic()
                if left <= 0 or not _writable(link.fileno(), None if within is None else left):
                    return False
        except OSError:
            return True
        return True

    def receive(self, within: float) -> list[list[Any]] | None:
        """Return the messages that have arrived, waiting some seconds for them; None when the process has ended."""
        return self._lines.receive() if readable(self._child.link.fileno(), within) else []

    def answers(self, request: Sequence[Any], within: float, every: float = math.inf) -> Iterator[list[Any] | None]:
        """Send a request, and yield the answers to it, message by message.

        Args:
            request: the message that is sent.
            within: seconds for all of it; then the process is ended.
            every: seconds without a message after which a None is yielded.

        Raises:
            WorkerError: when it has ended, or was ended.
        """
        deadline = time.monotonic() + within
        self.send(*request, within=max(within, 0.001))  # a process that hangs does not take what is sent
        while (left := deadline - time.monotonic()) > 0:
            messages = self.receive(min(left, every))
            if messages is None:
                raise WorkerError(f"ended unexpectedly{self.last_words()}", gone=True)
            yield from messages
            if not messages and every < math.inf:
                yield None
        self.kill()
        raise WorkerError(Phrase("did not come to an end within {n:g} s", n=within))

    def kill(self) -> None:
        """End the process at once."""
        self._child.kill()

    def close(self, within: float = 2.0) -> None:
        """Close the connection, so that the process ends within some seconds, and release everything."""
        self._child.close(within)
        if self._scratch is not None:
            self._scratch.cleanup()

    def last_words(self) -> str:
        """Describe the end of the process: its exit code and the last line it wrote."""
        return self._child.exit_summary()


class RunWorkerProcess(WorkerProcess):
    """A process that checks and runs workbooks.

    Args:
        simulator: the number of the connection to the simulator that it runs them on; it inherits it.

    Attributes:
        cell: its heartbeat.
        cpu: its processor time in seconds.
    """

    def __init__(self, simulator: int | None = None) -> None:
        self._shared = SharedCell(PLACES)
        self.cell = self._shared.numbers
        self.cell[RANK] = NO_ROW
        inherited = [self._shared.fd] if simulator is None else [self._shared.fd, simulator]
        super().__init__("rrp_sheets.runs.engine_child", *inherited)
        self.cpu = cpu_clock(self.pid)

    def close(self, within: float = 2.0) -> None:
        """End the process, and release everything."""
        super().close(within)
        self._shared.close()


class RestartingWorker:
    """Worker process that is kept and used again; from any thread, one request at a time. Close it at the end.

    It starts at the first request, and again when it has ended, or needed too much memory or time.

    Args:
        start: starts the process.
    """

    def __init__(self, start: Callable[[], WorkerProcess]) -> None:
        self._start = start
        self._lock = threading.Lock()
        self._closed = False
        self._worker: WorkerProcess | None = None

    @property
    def pid(self) -> int | None:
        """Process ID of the worker; None while there is none."""
        worker = self._worker
        return worker.pid if worker is not None else None

    def ask(self, request: Sequence[Any], within: float, start: float = 0.0) -> list[Any]:
        """Return the answer to a request, without the word that marks it as one.

        Args:
            request: the message that is sent.
            within: seconds for the answer.
            start: seconds more when the process has to be started first.

        Raises:
            WorkerError: when it has ended, or was ended.
            SheetsError: the error that it answers, or when this was closed.
        """
        with self._lock:
            if self._worker is not None and self._worker.ended:  # meanwhile: this request is not to blame
                self._drop()
            if self._worker is None and not self._closed:
                self._worker, within = self._start(), within + start
            if self._closed or self._worker is None:  # asked after it was made: `close` sees it, or this sees `close`
                raise _closed()
            try:
                kind, *answer = next(m for m in self._worker.answers(request, within) if m is not None)
                if kind == "memory":
                    raise WorkerError("needed more memory than it may have")
            except WorkerError:
                self._drop()
                if self._closed:
                    raise _closed() from None
                raise
        if kind == "failed":
            raise unpack_error(answer[0])
        return answer

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


def _closed() -> SheetsError:
    return SheetsError("The program is being ended.")


def _writable(fd: int, within: float | None) -> bool:
    with selectors.DefaultSelector() as selector:
        selector.register(fd, selectors.EVENT_WRITE)
        return bool(selector.select(within))


def readable(fd: int, within: float) -> bool:
    """Return whether something can be read, waiting some seconds; `select` fails for a busy server's file numbers."""
    with selectors.DefaultSelector() as selector:
        selector.register(fd, selectors.EVENT_READ)
        return bool(selector.select(within))


CHECK_WITHIN = 20.0
"""Seconds for one check, the start of the process included; usually some hundredths."""


@dataclass(frozen=True)
class Findings:
    """Findings of a check, with examples of the rows' values.

    Attributes:
        diagnostics: in the order of the sheets and cells.
        examples: an example of what each row gives, as shown, by the row's ref; missing where none is known.
    """

    diagnostics: tuple[Diagnostic, ...] = ()
    examples: Mapping[str, str] = field(default_factory=dict)


class CheckWorker:
    """Checker of workbooks in a kept process; from any thread, one at a time. Close it at the end.

    Args:
        within: seconds for one check.
    """

    def __init__(self, within: float = CHECK_WITHIN) -> None:
        self._within = within
        self._worker = RestartingWorker(RunWorkerProcess)

    def __enter__(self) -> CheckWorker:
        return self

    def __exit__(self, *ignored: object) -> None:
        self.close()

    def check(self, path: Path) -> Findings:
        """Read and check a workbook. A file that cannot be read, or a check that had to be ended, is one finding."""
        try:
            findings, examples = self._worker.ask(["check", str(path.absolute())], self._within)
        except WorkerError as none:
            report = Report()
            report.add("FILE018", None, name=path.name, why=Phrase("it {why}", why=none.why))
            return Findings(tuple(report))
        except UnreadableWorkbook as error:
            return Findings((error.finding,))
        return Findings(tuple(map(unpack_finding, findings)), examples)

    def close(self) -> None:
        """End the process."""
        self._worker.close()
