"""Workbooks of one folder: listed, read and checked when their files have changed; the sessions of open ones."""

from __future__ import annotations

import sqlite3
import threading
import weakref
from collections import OrderedDict
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from rrp_sheets import api
from rrp_sheets.documents import Document
from rrp_sheets.documents.document import Journal, stamp_of
from rrp_sheets.errors import SheetsError, UnreadableFile
from rrp_sheets.runs.check_worker import CheckWorker
from rrp_sheets.texts import N_
from rrp_sheets.web.analysis import Analysis, analyse
from rrp_sheets.web.models import said
from rrp_sheets.web.workbook_session import EventStream, WorkbookSession
from rrp_sheets.web.workbook_tests import Tester
from rrp_sheets.workbook import Reading
from rrp_sheets.workbook.atomic import Stamp
from rrp_sheets.workbook.reading import WORKBOOK_SUFFIXES

MOST_FILES = 200
NO_SHEETS = "FILE017"
_KEPT = 64
MOST_LISTENERS = 32  # event streams at once, for all workbooks
MOST_HERE = 24  # of them, of those who have the address of this computer
MOST_OF_LOGIN = 8  # of them, of one who has logged in
POLL_EVERY = 1.0  # seconds between two looks for changes by another program


@dataclass(frozen=True)
class CheckedWorkbook:
    """Workbook that was read and checked; the file was last written when it `changed`."""

    name: str
    path: Path
    changed: datetime
    reading: Reading
    analysis: Analysis

    @property
    def title(self) -> str:
        """Title from the Protocol, or the file's name without its ending."""
        return self.analysis.workbook.protocol.text("Title") or Path(self.name).stem


class WorkbookRepository:
    """Workbooks directly in a folder, which `worker` checks. Safe to use from several threads."""

    def __init__(self, folder: Path, worker: CheckWorker) -> None:
        self.folder = folder
        self.worker = worker
        self._lock = threading.Lock()
        self._kept: OrderedDict[tuple[str, Stamp], CheckedWorkbook | SheetsError] = OrderedDict()
        self._prose: dict[str, tuple[Stamp, bool]] = {}

    def names(self) -> list[str]:
        """Return the sorted names of the files that may be workbooks; raises SheetsError for an unreadable folder."""
        try:
            files = self.folder.iterdir()
            found = [p.name for p in files if p.suffix.casefold() in WORKBOOK_SUFFIXES and p.name[0] not in ".~"]
        except OSError as error:
            why = error.strerror or N_("the system refuses it")
            raise SheetsError(
                N_("The folder {folder} cannot be read: {why}.", folder=str(self.folder), why=why),
                N_("Start again with another."),
            ) from error
        return sorted(found, key=lambda name: (name.casefold(), name))

    def has(self, name: str) -> bool:
        """Return whether the folder lists such a file; only these can be opened, so no name leads out of it."""
        return name in self.names()

    def workbooks(self) -> list[str]:
        """Return the names of workbooks that an address can hold; prose in Markdown, such as a README, is none."""
        return [name for name in self.names() if addressable(name) and not self.is_text(name)]

    def is_text(self, name: str) -> bool:
        """Return whether a file is readable Markdown prose, such as a README, and not a workbook."""
        path = self.folder / name
        stamp = None if path.suffix.casefold() == ".xlsx" else stamp_of(path)
        if stamp is None or not path.resolve().is_relative_to(self.folder.resolve()):
            return False
        known = self._prose.get(name)
        if known is None or known[0] != stamp:
            known = self._prose[name] = stamp, _is_text(path)
        return known[1]

    def path(self, name: str) -> Path:
        """Return the path of a file of the folder; raises SheetsError when its name leads out of the folder."""
        path = self.folder / name
        if not self.has(name) or not path.resolve().is_relative_to(self.folder.resolve()):
            raise SheetsError(
                N_("{name} is not a file of this folder.", name=printable(name)),
                N_("Put the workbook itself there; links that lead elsewhere are not followed."),
            )
        return path

    def open(self, name: str) -> CheckedWorkbook:
        """Read and check a workbook; raises SheetsError when it cannot be read, or its name leads out of the folder."""
        path = self.path(name)
        stamp = stamp_of(path)
        with self._lock:
            found = self._kept.get((name, stamp)) if stamp else None
        if found is None:
            found = _read(name, path, self.worker)
            if stamp:
                with self._lock:
                    self._kept[name, stamp] = found
                    while len(self._kept) > _KEPT:
                        self._kept.popitem(last=False)
        if isinstance(found, SheetsError):
            raise found
        return found


def _read(name: str, path: Path, worker: CheckWorker) -> CheckedWorkbook | SheetsError:
    try:
        reading = api.read(path)
        changed = datetime.fromtimestamp(path.stat().st_mtime)
        return CheckedWorkbook(name, path, changed, reading, analyse(path, reading, worker))
    except UnreadableFile as error:
        return error
    except OSError as error:
        message = N_("{name} has just gone: {why}.", name=printable(name), why=error.strerror)
        return SheetsError(message, N_("Go back and look again."))


def refuse_text(repository: WorkbookRepository, name: str) -> None:
    """Raise SheetsError for a file that is prose: it has nothing to edit, run, compare or print."""
    if repository.is_text(name):
        raise SheetsError(
            N_("“{name}” is not a workbook but a text for people.", name=printable(name)),
            N_("A workbook needs another name." if _is_readme(name) else "Choose a workbook from the shelf."),
        )


def _is_readme(name: str) -> bool:
    return Path(name).stem.casefold() == "readme"


def _is_text(path: Path) -> bool:
    if _is_readme(path.name):  # also when it shows a table of rows as an example
        return True
    try:
        reading = api.read(path)
    except UnreadableFile as error:
        return error.code == NO_SHEETS
    except (SheetsError, OSError):
        return False
    book = reading.workbook
    sheets = (book.behaviours, book.protocol.fields, book.scene, book.tests, book.devices, book.helpers, book.gestures)
    near = any(d.code.startswith("SHEET") and d.code != "SHEET001" for d in reading.report)  # nearly a known sheet
    return reading.format == "markdown" and not near and not any(sheets)


def printable(name: str) -> str:
    r"""Return a file's name as it can be shown: undecodable bytes become question marks.

    >>> printable("caf\udce9.xlsx")
    'caf?.xlsx'
    """
    return name.encode("utf-8", "replace").decode()


def addressable(name: str) -> bool:
    """Return whether a name can be used in a URL, which names with undecodable bytes cannot."""
    return printable(name) == name


class OpenWorkbooks:
    """Sessions of all open workbooks of a folder; `worker` checks them.

    Attributes:
        opened: called with each session when it is opened.
        leaving: called with a session that is to be closed; raises SheetsError when that cannot be done now.
    """

    def __init__(self, folder: Path, worker: CheckWorker) -> None:
        self.folder = folder
        self._worker = worker
        self._tester = Tester()
        self._sessions: dict[str, WorkbookSession] = {}
        self._journal: Journal | None = None
        self._lock = threading.RLock()
        self._joining = threading.Lock()
        self._closed = threading.Event()
        self.opened: Callable[[WorkbookSession], None] = lambda session: None
        self.leaving = self.opened
        threading.Thread(target=_watch, args=(weakref.ref(self), self._closed), daemon=True).start()

    def close(self) -> None:
        """Stop polling the files for changes, and end the tester's process."""
        self._closed.set()
        self._tester.close()

    def has(self, name: str) -> bool:
        """Return whether a workbook is open."""
        return name in self._sessions

    @contextmanager
    def without(self, name: str) -> Iterator[None]:
        """Close a workbook while the `with` block moves its file; its pages reload afterwards.

        During the block it cannot be opened, and no run of it begins. Raises SheetsError when it cannot be closed now.
        """
        with self._lock:
            session = self._sessions.get(name)
            if session is not None:
                self.leaving(session)
                del self._sessions[name]
            try:
                yield
            finally:
                if session is not None:
                    session.tell("reload", {})

    @contextmanager
    def staying(self, session: WorkbookSession) -> Iterator[None]:
        """Keep a workbook open during the `with` block; raises SheetsError when it has been closed."""
        with self._lock:
            if session not in self._sessions.values():
                raise SheetsError(N_("This workbook was renamed or moved meanwhile."), N_("Go to the shelf."))
            yield

    def renamed(self, before: str, name: str) -> None:
        """Carry the journal of a renamed workbook over to its new name."""
        with self._lock, suppress(SheetsError):  # where nothing can be kept, nothing is lost
            self._journal = self._journal or Journal(self.folder)
            self._journal.rename(before, name)

    def session(self, path: Path) -> WorkbookSession:
        """Return the session of a workbook; raises SheetsError when it cannot be read, or nothing written beside it."""
        with self._lock:
            if path.name not in self._sessions:
                why = ""
                try:
                    self._journal = self._journal or Journal(self.folder)
                except SheetsError as error:
                    why = said(error)
                document = Document(path, self._journal, why)
                self._sessions[path.name] = WorkbookSession(document, self._worker, self._tester)
                self.opened(self._sessions[path.name])
            return self._sessions[path.name]

    def sessions(self) -> list[WorkbookSession]:
        """Return the sessions of all open workbooks."""
        with self._lock:
            return list(self._sessions.values())

    def listen(
        self, session: WorkbookSession, client: str, person: str, join: Callable[[], EventStream]
    ) -> EventStream | str:
        """Open a page's event stream, instead of an older one; return the reason if there are too many.

        Pages that ask at the same moment are handled one after the other. `person` is the key of the login, whose
        streams are limited; empty for a browser on this computer.
        """
        with self._joining:
            session.end_streams(client)
            return self._crowded(person) or join()

    def _crowded(self, person: str) -> str:
        with self._lock:
            listeners = [one for session in self._sessions.values() for one in session.listeners]
        mine = sum(one.person == person for one in listeners)
        if mine >= (MOST_OF_LOGIN if person else MOST_HERE):
            return N_("You have {n} pages open here. Close one; this page then goes on by itself.", n=mine)
        if len(listeners) >= MOST_LISTENERS:
            return N_(
                "{n} pages are open on this server, {mine} of them yours, and it cannot tell more of them what "
                "happens. When one is closed, this page goes on by itself.",
                n=len(listeners),
                mine=mine,
            )
        return ""

    def poll(self) -> None:
        """Check whether another program has changed a workbook that is shown on a page."""
        for session in self.sessions():
            if session.listeners:
                with suppress(OSError, sqlite3.Error):  # told when somebody edits; and the next second is another
                    session.poll()


def _watch(open_workbooks: weakref.ref[OpenWorkbooks], closed: threading.Event) -> None:
    """Poll until the server closes the workbooks, or the object is garbage-collected."""
    while not closed.wait(POLL_EVERY) and (found := open_workbooks()) is not None:
        found.poll()
        del found
