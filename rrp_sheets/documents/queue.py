"""Edits that wait for each other are stored together: one patch of the file, however many people type at once."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from rrp_sheets.documents.changes import CellText, Changed
from rrp_sheets.documents.requests import requests_now
from rrp_sheets.errors import SheetsError

MOST = 500  # edits that are stored at once


@dataclass
class EditRequest:
    """Cells that somebody wants to change, and what became of that."""

    author: str
    sheet: str
    cells: tuple[CellText, ...]
    requests: tuple[str, ...] = field(default_factory=requests_now)
    done: threading.Event = field(default_factory=threading.Event)
    changed: Changed | None = None
    error: SheetsError | None = None


class Queue:
    """Wishes that wait. Whoever comes first carries out all that have come by then; the others only wait.

    Args:
        lock: held while wishes are carried out.
        carry_out: does it, and says in each wish what became of it.
    """

    def __init__(self, lock: threading.RLock, carry_out: Callable[[Sequence[EditRequest]], None]) -> None:  # type: ignore[valid-type,unused-ignore]
        self._lock = lock
        self._carry_out = carry_out
        self._waiting: deque[EditRequest] = deque()

    def ask(self, wish: EditRequest) -> Changed:
        """Wait until the wish is fulfilled; raises the error that kept it from being."""
        self._waiting.append(wish)
        with self._lock:
            while not wish.done.is_set():
                some = [self._waiting.popleft() for _ in range(min(MOST, len(self._waiting)))]
                try:
                    self._carry_out(some)
                finally:  # whatever happens, nobody waits for ever
                    for one in some:
                        one.done.set()
        if wish.error is not None:
            raise wish.error
        assert wish.changed is not None, "a wish ended without an answer"
        return wish.changed
