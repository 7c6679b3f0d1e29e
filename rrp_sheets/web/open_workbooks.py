"""Workbooks that are open in the browser, and the limits of their event streams."""

from __future__ import annotations

import sqlite3
import threading
import weakref
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from rrp_sheets.documents import Document
from rrp_sheets.documents.journal import Journal
from rrp_sheets.errors import SheetsError
from rrp_sheets.runs.worker_process import CheckWorker
from rrp_sheets.web.sse import EventStream
from rrp_sheets.web.testing.results import Tester
from rrp_sheets.web.workbook_session import WorkbookSession

MOST_LISTENERS = 32  # event streams at once, for all workbooks
MOST_HERE = 24  # of them, of those who have the address of this computer
MOST_OF_ONE = 8  # of them, of one who has logged in
POLL_EVERY = 1.0  # seconds


class OpenWorkbooks:
    """Sessions of all open workbooks of a folder; `worker` checks them.

    Attributes:
        opened: called with each session when it is opened.
        leaving: called with a session that is to be closed; raises SheetsError when that cannot be done now.
    """

    opened: Callable[[WorkbookSession], None]
    leaving: Callable[[WorkbookSession], None]

    def __init__(self, folder: Path, worker: CheckWorker) -> None:
        self.folder = folder
        self._worker = worker
        self._tester = Tester()
        self._rooms: dict[str, WorkbookSession] = {}
        self._journal: Journal | None = None
        self._lock = threading.RLock()
        self._joining = threading.Lock()
        self._closed = threading.Event()
        self.opened = self.leaving = lambda room: None
        threading.Thread(target=_watch, args=(weakref.ref(self), self._closed), daemon=True).start()

    def close(self) -> None:
        """Stop polling the files for changes, and end the tester's process."""
        self._closed.set()
        self._tester.close()

    def has(self, name: str) -> bool:
        """Return whether a workbook is open."""
        return name in self._rooms

    @contextmanager
    def without(self, name: str) -> Iterator[None]:
        """Close a workbook while its file is moved or renamed in the `with` block; its pages reload afterwards.

        During the block it cannot be opened, and no run of it begins.

        Raises:
            SheetsError: when it cannot be closed now.
        """
        with self._lock:
            room = self._rooms.get(name)
            if room is not None:
                self.leaving(room)
                del self._rooms[name]
            try:
                yield
            finally:
                if room is not None:
                    room.tell("reload", {})

    @contextmanager
    def staying(self, room: WorkbookSession) -> Iterator[None]:
        """Keep a workbook open during the `with` block.

        Raises:
            SheetsError: when it has been closed.
        """
        with self._lock:
            if room not in self._rooms.values():
                raise SheetsError("This workbook was renamed or moved meanwhile.", "Go to the shelf.")
            yield

    def renamed(self, before: str, name: str) -> None:
        """Carry the journal of a renamed workbook over to its new name."""
        with self._lock, suppress(SheetsError):  # where nothing can be kept, nothing is lost
            if self._journal is None:
                self._journal = Journal(self.folder)
            self._journal.rename(before, name)

    def room(self, path: Path) -> WorkbookSession:
        """Return the session of a workbook of the folder; it is opened if necessary.

        Raises:
            SheetsError: when the workbook cannot be read, or nothing can be written beside it.
        """
        with self._lock:
            if path.name not in self._rooms:
                self._rooms[path.name] = WorkbookSession(self._open(path), self._worker, self._tester)
                self.opened(self._rooms[path.name])
            return self._rooms[path.name]

    def _open(self, path: Path) -> Document:
        try:
            if self._journal is None:
                self._journal = Journal(self.folder)
        except SheetsError as error:
            return Document(path, None, f"{error.message} {error.remedy}")
        return Document(path, self._journal)

    def rooms(self) -> list[WorkbookSession]:
        """Return the sessions of all open workbooks."""
        with self._lock:
            return list(self._rooms.values())

    def listen(
        self, room: WorkbookSession, client: str, person: str, join: Callable[[], EventStream]
    ) -> EventStream | str:
        """Open a page's event stream; return the reason instead if there are too many.

        Pages that ask at the same moment are handled one after the other. A page has one event stream: an older one
        of the same page ends.

        Args:
            room: the session of the page's workbook.
            client: the unique name of the page.
            person: the key of the login, whose streams are limited; empty for a browser on this computer.
            join: creates the event stream.
        """
        with self._joining:
            room.end_streams(client)
            return self._crowded(person) or join()

    def _crowded(self, person: str) -> str:
        with self._lock:
            listeners = [one for room in self._rooms.values() for one in room.listeners]
        mine = sum(one.person == person for one in listeners)
        if mine >= (MOST_OF_ONE if person else MOST_HERE):
            return f"You have {mine} pages open here. Close one; this page then goes on by itself."
        if len(listeners) >= MOST_LISTENERS:
            return (
                f"{len(listeners)} pages are open on this server, {mine} of them yours, and it cannot tell more of "
                "them what happens. When one is closed, this page goes on by itself."
            )
        return ""

    def poll(self) -> None:
        """Check whether another program has changed a workbook that is shown on a page."""
        for room in self.rooms():
            if room.listeners:
                with suppress(OSError, sqlite3.Error):  # told when somebody edits; and the next second is another
                    room.poll()


def _watch(open_workbooks: weakref.ref[OpenWorkbooks], closed: threading.Event) -> None:
    """Poll until the server closes the workbooks, or the object is garbage-collected."""
    while not closed.wait(POLL_EVERY) and (found := open_workbooks()) is not None:
        found.poll()
        del found
