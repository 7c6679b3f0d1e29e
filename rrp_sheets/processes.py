"""Starting the processes that a run consists of: each is a module of this package, with a connection to its starter."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import IO, Any


class Child:
    """A started process of ours, and how it ended.

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
        """Whether it has ended."""
        return self._process.poll() is not None

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

    def last_words(self) -> str:
        """How it ended: its exit code and the last line it wrote; empty while it goes on."""
        try:
            code = self._process.wait(2.0)
        except subprocess.TimeoutExpired:
            return ""
        self._log.seek(0)
        lines = self._log.read().decode(errors="replace").strip().splitlines()
        if code < 0:  # killed from outside: it had no last words, only what it printed at its start
            return f" (signal {-code})"
        return f" (exit code {code}: {lines[-1][:200]})" if lines else f" (exit code {code})"
