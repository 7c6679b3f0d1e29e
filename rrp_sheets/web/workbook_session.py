"""Sessions of the open workbooks: edits, checks and tests, notices to their pages, and limits of event streams."""

from __future__ import annotations

import hashlib
import json
import sqlite3
import threading
import time
import weakref
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from rrp_sheets.documents import Changed, Document, Refused
from rrp_sheets.documents.grid import SheetChange
from rrp_sheets.documents.journal import Answers, Journal, made_for
from rrp_sheets.documents.workfile import write_block_reason
from rrp_sheets.errors import SheetsError
from rrp_sheets.runs.check_worker import CheckWorker
from rrp_sheets.texts import N_
from rrp_sheets.web.analysis import Analysis, analyse, no_analysis
from rrp_sheets.web.collab.broadcaster import Broadcaster, EventStream, Place, message
from rrp_sheets.web.completions import vocabulary
from rrp_sheets.web.models import said
from rrp_sheets.web.row_renderer import RowRenderer
from rrp_sheets.web.statics import build_id
from rrp_sheets.web.workbook_tests import Tester, WorkbookTests

MOST_LISTENERS = 32  # event streams at once, for all workbooks
MOST_HERE = 24  # of them, of those who have the address of this computer
MOST_OF_ONE = 8  # of them, of one who has logged in
POLL_EVERY = 1.0  # seconds between two looks for changes by another program


class WorkbookSession(Broadcaster):
    """Session of one open workbook: its document, its check and tests, and the pages that show it."""

    def __init__(self, document: Document, worker: CheckWorker, tester: Tester) -> None:
        super().__init__()
        self.document = document
        self._worker = worker
        self._again = threading.Event()
        self._analysis = no_analysis()
        self._words: tuple[Analysis, str, str] | None = None
        self._renderers: dict[str, RowRenderer] = {}
        self._checker: threading.Thread | None = None
        self._answers: Answers[dict[str, Any]] = Answers()
        self._trouble = ""
        self._write_block = ""
        self.author = ""  # of the newest edit
        self._made = time.time_ns() // 1_000_000  # grows with each version of a row: a page keeps the later one of two
        self.about_run: Callable[[], str] = str  # the run that goes on, as it is sent to a page that joins
        self.after_check: Callable[[], None] = lambda: None
        self.after_edit: Callable[[], None] = lambda: None
        self.tests = WorkbookTests(document, tester, self._tell_tests, lambda: bool(self.listeners))

    # ---- state of the workbook

    def analysis(self) -> Analysis:
        """Return the newest analysis; an empty one until the first check, which this starts, has ended."""
        with self._lock:
            analysis = self._analysis
        if not analysis.checked:
            self.check_soon(only_first=True)
        return analysis

    def words(self) -> tuple[str, str]:
        """Return the words that are suggested, as JSON, and a digest of them; made once for each check."""
        analysis = self.analysis()
        with self._lock:
            kept = self._words
        if kept is None or kept[0] is not analysis:
            text = json.dumps(vocabulary(analysis), separators=(",", ":"))
            kept = analysis, text, hashlib.sha256(text.encode()).hexdigest()[:16]
            with self._lock:
                self._words = kept
        return kept[1], kept[2]

    def renderer(self, sheet: str) -> RowRenderer:
        """Return the renderer of a sheet's rows, updated with the newest check, locks and test results."""
        with self._lock:
            grid = self.document.grids[sheet]
            renderer = self._renderers.get(sheet)
            if renderer is None or renderer.grid is not grid:
                renderer = self._renderers[sheet] = RowRenderer(grid)
            renderer.take(self.analysis(), self.locks.holders(sheet), self.tests.marks(sheet))
            return renderer

    # ---- editing

    def change(
        self, client: str, author: str, tag: str, make: Callable[[Document], Changed | None], request: str = ""
    ) -> dict[str, Any]:
        """Make an edit, notify the other pages, and return the answer to its author.

        The author's page, `client`, gets no event; `tag` is a text from it that is sent along with the rows. An edit
        that is requested again, with the id `request`, is made only once.
        """
        return self._answers.once(request, lambda: self._change(client, author, tag, make, request))

    def _change(
        self, client: str, author: str, tag: str, make: Callable[[Document], Changed | None], request: str
    ) -> dict[str, Any]:
        if request and self.document.made(request):  # before the server was started again: the page loads again, too
            return {"rows": []}
        try:
            with made_for(request):
                changed = make(self.document)
        except Refused as refused:
            clashes = [asdict(c) for c in refused.clashes]
            fresh = self._fresh({c.row for c in refused.clashes}) if clashes else []
            return {"message": said(refused), "clashes": clashes, "rows": fresh}
        except SheetsError as error:  # the file itself: gone, or no workbook any more
            return {"message": said(error)}
        if changed is None:
            return {"message": ""}
        self.author = author
        self.after_edit()
        self._tell_changes(self.document.outside())  # what another program did, if it is found before `poll` does
        rows = [self._rows(one) for one in (changed, *changed.then)]
        for one in rows:
            self.tell("grid", {**one, "tag": tag}, but=client)
        sheets = {"sheets": self._sheets_changed(changed.change, author, client)} if changed.change else {}
        self.check_soon()
        return {"rows": rows, **sheets}

    def _sheets_changed(self, change: SheetChange, author: str, client: str) -> dict[str, Any]:
        """Notify the pages that a sheet was added, removed, renamed or moved, so that they update their tabs."""
        if change.was:
            with self._lock:
                self.locks.rename(change.was, change.name)
                self._renderers.pop(change.was, None)
        self.tell("sheets", news := {**asdict(change), "by": author}, but=client)
        return news

    def _fresh(self, rows: set[str]) -> list[dict[str, Any]]:
        found = ((name, tuple(row for row in rows if grid.has(row))) for name, grid in self.document.grids.items())
        return [self._rows(Changed(name, touched=mine)) for name, mine in found if mine]

    def _rows(self, changed: Changed) -> dict[str, Any]:
        if changed.sheet not in self.document.grids:
            return {"sheet": changed.sheet}
        with self._lock:
            return self._row_changes(changed, self.renderer(changed.sheet))

    def _row_changes(self, changed: Changed, renderer: RowRenderer) -> dict[str, Any]:
        entry = self._now(changed.sheet)
        if changed.touched:
            entry["replace"] = [{"id": row, "html": html} for row, html in renderer.html(changed.touched).items()]
        if changed.cells:
            entry["cells"] = [list(place) for place in changed.cells[:1000]]
        if changed.inserted:
            made = renderer.html(row for row, _ in changed.inserted)
            entry["insert"] = [{"before": before, "html": made[row]} for row, before in changed.inserted if row in made]
        if changed.removed:
            entry["remove"] = list(changed.removed)
        if changed.moved:
            entry["move"] = [{"id": row, "before": before} for row, before in changed.moved]
        if changed.grown:
            entry["grown"] = list(renderer.html(changed.grown).values())
        if changed.inserted or changed.removed or changed.moved or changed.grown:
            version = renderer.grid.version  # before the rows, which are of that version or of a later one
            entry["order"] = {"version": version, "rows": renderer.grid.rows}
        return entry

    def _now(self, sheet: str) -> dict[str, Any]:
        """Return the sheet and a new serial number, for an event with rows rendered now; call under the lock."""
        self._made += 1
        return {"sheet": sheet, "made": self._made}

    # ---- the check, in a thread of its own

    def check_soon(self, *, only_first: bool = False) -> None:
        """Schedule a check, which covers all edits until then; with `only_first`, unless one is under way."""
        with self._lock:
            if only_first and self._checker is not None and self._checker.is_alive():
                return
            self._again.set()
            if self._checker is None or not self._checker.is_alive():
                self._checker = threading.Thread(target=self._keep_checking, daemon=True)
                self._checker.start()

    def _keep_checking(self) -> None:
        while True:
            with self._lock:
                if not self._again.is_set():
                    self._checker = None
                    return
                self._again.clear()
            try:
                analysis = analyse(self.document.path, self.document.reading, self._worker)
            except SheetsError as error:
                self.tell("trouble", {"message": said(error)})
                with self._lock:
                    self._analysis = replace(self._analysis, checked=True)
                continue
            with self._lock:
                self._analysis = analysis
            self._tell_check()

    def _tell_check(self) -> None:
        for name in list(self.document.grids):
            self._tell_rows(name)
        self.tell("checked", self._checked())
        self.after_check()
        self.tests.soon()

    def _tell_rows(self, sheet: str) -> None:
        """Notify all pages of the rows of a sheet that look different now."""
        with self._lock:
            replaced = self.renderer(sheet).changed()
            about = self._now(sheet)
        if replaced:
            self.tell("grid", {**about, "replace": [{"id": r, "html": h} for r, h in replaced]})

    def _tell_tests(self, news: str) -> None:
        for name in self.tests.sheets:
            self._tell_rows(name)
        self.tell("tested", {"news": news})

    def _checked(self) -> dict[str, Any]:
        """Return the result of the check apart from the rows: the version and the number of errors."""
        return {"version": self.document.version, "errors": self.analysis().errors, "words": self.words()[1]}

    # ---- pages and their users

    def join(self, client: str, name: str, *, knows: bool = True, had: str = "", person: str = "") -> EventStream:
        """Open the event stream of a page that was loaded or has reconnected.

        Args:
            client: the unique name of the page.
            name: of its user.
            knows: the page was rendered after the first check.
            had: the number of the last event that it got; those missed since then follow.
            person: the key of the login.
        """
        with self._lock:
            left = self.locks.again(client)
        for place in left:
            self._tell_row(place, but=client)
        listener = EventStream(client, name, person)
        listener.tell(message("program", {"version": build_id()}))
        if not knows and self.analysis().checked:  # the check has ended between the page and its event stream
            for sheet in list(self.document.grids):
                with self._lock:
                    about = self._now(sheet) | self.renderer(sheet).known(sheet)
                listener.tell(message("grid", about))
            listener.tell(message("checked", self._checked()))
        self._enter(listener, had)
        run = self.about_run()
        if run:
            listener.tell(run)
        self.tell_people()
        self.tests.join()
        return listener

    def leave(self, listener: EventStream) -> list[Place]:
        """End a page's event stream, release its cells and notify the other pages."""
        places = super().leave(listener)
        for place in places:
            self._tell_row(place, but=listener.client)
        return places

    def take(self, client: str, name: str, place: tuple[str, str, int]) -> str:
        """Lock a cell for editing; return the name of the holder if another page has it, else an empty text."""
        with self._lock:
            holder = self.locks.take(client, name, place)
        if holder:
            return holder
        self._tell_row(place, but=client)
        return ""

    def release(self, client: str, place: tuple[str, str, int]) -> None:
        """Release a cell, and notify the other pages."""
        with self._lock:
            self.locks.release(client, place)
        self._tell_row(place, but=client)

    def _tell_row(self, place: tuple[str, str, int], but: str) -> None:
        sheet, row, _ = place
        grid = self.document.grids.get(sheet)
        if grid is not None and grid.has(row):
            self.tell("grid", self._rows(Changed(sheet, touched=(row,))), but=but)

    def poll(self) -> None:
        """Check whether another program has changed the file, and release cells that were locked too long ago."""
        with self._lock:
            expired = self.locks.expire()
        for place in expired:
            self._tell_row(place, but="")
        reason = write_block_reason(self.document.path)
        if reason != self._write_block:
            self._write_block = reason
            self.tell("notice", {"text": reason})
        try:
            changes = self.document.poll()
        except SheetsError as error:
            trouble = said(error)
            if trouble != self._trouble:  # once, not every second
                self._trouble = trouble
                self.tell("trouble", {"message": trouble})
            return
        self._trouble = ""
        self._tell_changes(changes)

    def _tell_changes(self, changes: Sequence[Changed]) -> None:
        """Notify all pages of changes by another program: send the rows, or make pages of reshaped sheets reload."""
        anew = dict.fromkeys(one.sheet for one in changes if one.change and one.change.what == "reshaped")
        for sheet in (*anew, *self.document.own) if changes else ():
            self.tell("reload", {"why": N_("The file was changed by another program."), "sheet": sheet})
        for one in changes:
            if one.change is None:
                self.tell("grid", self._rows(one))
            elif one.sheet not in anew:
                self.tell("sheets", {**asdict(one.change), "by": N_("Another program")})
        if changes:
            self.check_soon()


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
        self._sessions: dict[str, WorkbookSession] = {}
        self._journal: Journal | None = None
        self._lock = threading.RLock()
        self._joining = threading.Lock()
        self._closed = threading.Event()
        self.opened = self.leaving = lambda session: None
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
        """Close a workbook while its file is moved or renamed in the `with` block; its pages reload afterwards.

        During the block it cannot be opened, and no run of it begins.

        Raises:
            SheetsError: when it cannot be closed now.
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
        """Keep a workbook open during the `with` block.

        Raises:
            SheetsError: when it has been closed.
        """
        with self._lock:
            if session not in self._sessions.values():
                raise SheetsError(N_("This workbook was renamed or moved meanwhile."), N_("Go to the shelf."))
            yield

    def renamed(self, before: str, name: str) -> None:
        """Carry the journal of a renamed workbook over to its new name."""
        with self._lock, suppress(SheetsError):  # where nothing can be kept, nothing is lost
            if self._journal is None:
                self._journal = Journal(self.folder)
            self._journal.rename(before, name)

    def session(self, path: Path) -> WorkbookSession:
        """Return the session of a workbook of the folder; it is opened if necessary.

        Raises:
            SheetsError: when the workbook cannot be read, or nothing can be written beside it.
        """
        with self._lock:
            if path.name not in self._sessions:
                self._sessions[path.name] = WorkbookSession(self._open(path), self._worker, self._tester)
                self.opened(self._sessions[path.name])
            return self._sessions[path.name]

    def _open(self, path: Path) -> Document:
        try:
            if self._journal is None:
                self._journal = Journal(self.folder)
        except SheetsError as error:
            return Document(path, None, said(error))
        return Document(path, self._journal)

    def sessions(self) -> list[WorkbookSession]:
        """Return the sessions of all open workbooks."""
        with self._lock:
            return list(self._sessions.values())

    def listen(
        self, session: WorkbookSession, client: str, person: str, join: Callable[[], EventStream]
    ) -> EventStream | str:
        """Open a page's event stream; return the reason instead if there are too many.

        Pages that ask at the same moment are handled one after the other. A page has one event stream: an older one
        of the same page ends. `person` is the key of the login, whose streams are limited; empty for a browser on this
        computer.
        """
        with self._joining:
            session.end_streams(client)
            return self._crowded(person) or join()

    def _crowded(self, person: str) -> str:
        with self._lock:
            listeners = [one for session in self._sessions.values() for one in session.listeners]
        mine = sum(one.person == person for one in listeners)
        if mine >= (MOST_OF_ONE if person else MOST_HERE):
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
