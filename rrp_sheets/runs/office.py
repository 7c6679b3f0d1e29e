"""A process of ours, from the side of the program that starts it: its link, its cell, and how it ended."""

from __future__ import annotations

import os
import selectors
import socket
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import rrp_sheets
from rrp_sheets.runs.limits import SharedCell
from rrp_sheets.runs.wire import Lines, line


class Office:
    """A started process that evaluates formulas."""

    def __init__(self) -> None:
        ours, theirs = socket.socketpair()
        self._cell = SharedCell()
        self.cell = self._cell.numbers
        self._log = tempfile.TemporaryFile()  # noqa: SIM115  # lives as long as the process
        environment = dict(os.environ)
        package = str(Path(rrp_sheets.__file__).parent.parent)
        environment["PYTHONPATH"] = os.pathsep.join(p for p in (package, environment.get("PYTHONPATH")) if p)
        with theirs:
            # -P: a file of the user's in the current folder must not be taken for a library's.
            # A group of its own: Ctrl-C is for the program, which then asks for a stop.
            self._child = subprocess.Popen(
                [sys.executable, "-P", "-m", "rrp_sheets.runs.child", str(theirs.fileno()), str(self._cell.fd)],
                pass_fds=(theirs.fileno(), self._cell.fd), env=environment, stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL, stderr=self._log, process_group=0,
            )  # fmt: skip
        self._link = ours
        self._lines = Lines(ours)

    @property
    def pid(self) -> int:
        """The process's number."""
        return self._child.pid

    def send(self, *message: Any) -> None:
        """Send a message; one that has ended hears nothing, and is found out when it is listened to."""
        try:
            self._link.sendall(line(list(message)))
        except OSError:
            return

    def receive(self, within: float) -> list[list[Any]] | None:
        """What it has said, waiting some seconds for it; None when it has ended."""
        return self._lines.receive() if readable(self._link.fileno(), within) else []

    def kill(self) -> None:
        """End it at once."""
        self._child.kill()
        self._child.wait()

    def close(self) -> None:
        """Let it end, which it does when the connection closes, and let everything go."""
        self._link.close()
        try:
            self._child.wait(2.0)
        except subprocess.TimeoutExpired:
            self.kill()
        self._cell.close()
        self._log.close()

    def last_words(self) -> str:
        """How it ended: its exit code and the last line it wrote."""
        try:
            code = self._child.wait(2.0)
        except subprocess.TimeoutExpired:
            return ""
        self._log.seek(0)
        lines = self._log.read().decode(errors="replace").strip().splitlines()
        if code < 0:
            return f" (signal {-code})"
        return f" (exit code {code}: {lines[-1][:200]})" if lines else f" (exit code {code})"


def readable(fd: int, within: float) -> bool:
    """Whether something can be read, waiting some seconds for it; `select` alone cannot do a busy server's numbers."""
    with selectors.DefaultSelector() as selector:
        selector.register(fd, selectors.EVENT_READ)
        return bool(selector.select(within))
