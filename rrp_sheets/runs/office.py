"""A process of ours, from the side of the program that starts it: its link, its cell, and how it ended."""

from __future__ import annotations

import selectors
from typing import Any

from rrp_sheets.processes import Child
from rrp_sheets.runs.limits import SharedCell
from rrp_sheets.runs.wire import Lines, line


class Office:
    """A started process that evaluates formulas."""

    def __init__(self) -> None:
        self._cell = SharedCell()
        self.cell = self._cell.numbers
        self._child = Child("rrp_sheets.runs.child", self._cell.fd)
        self._lines = Lines(self._child.link)

    @property
    def pid(self) -> int:
        """The process's number."""
        return self._child.pid

    def send(self, *message: Any) -> None:
        """Send a message; one that has ended hears nothing, and is found out when it is listened to."""
        try:
            self._child.link.sendall(line(list(message)))
        except OSError:
            return

    def receive(self, within: float) -> list[list[Any]] | None:
        """What it has said, waiting some seconds for it; None when it has ended."""
        return self._lines.receive() if readable(self._child.link.fileno(), within) else []

    def kill(self) -> None:
        """End it at once."""
        self._child.kill()

    def close(self) -> None:
        """Let it end, which it does when the connection closes, and let everything go."""
        self._child.close(2.0)
        self._cell.close()

    def last_words(self) -> str:
        """How it ended: its exit code and the last line it wrote."""
        return self._child.last_words()


def readable(fd: int, within: float) -> bool:
    """Whether something can be read, waiting some seconds for it; `select` alone cannot do a busy server's numbers."""
    with selectors.DefaultSelector() as selector:
        selector.register(fd, selectors.EVENT_READ)
        return bool(selector.select(within))
