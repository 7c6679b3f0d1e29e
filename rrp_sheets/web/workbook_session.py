"""Sessions of open workbooks: edits, checks and tests, the event streams of their pages, and cell locks."""

from __future__ import annotations

import hashlib
import os
import secrets
import sqlite3
import threading
import time
import weakref
from collections import OrderedDict, deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Future
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

from rrp_sheets.checks.renaming import Renaming
from rrp_sheets.documents import Changed, Document, Refused
from rrp_sheets.documents.document import Journal, made_for, write_block_reason
from rrp_sheets.documents.grid import HEADER, setting_columns
from rrp_sheets.documents.sheet_edits import language_of_sheets
from rrp_sheets.errors import SheetsError
from rrp_sheets.model.workbook import column_letters
from rrp_sheets.page_texts import Versions, json_in
from rrp_sheets.runs.check_worker import CheckWorker
from rrp_sheets.texts import LANGUAGES, N_
from rrp_sheets.web.analysis import Analysis, analyse, no_analysis
from rrp_sheets.web.completions import vocabulary
from rrp_sheets.web.models import error_text
from rrp_sheets.web.row_renderer import RowRenderer
from rrp_sheets.web.statics import build_id
from rrp_sheets.web.workbook_tests import Tester, WorkbookTests

LOCK_SECONDS = 120.0  # a cell is given free when its editor was silent for so long
_KEEP_ALIVE = 5.0  # seconds of silence after which a comment is sent, which shows whether the page is still there
_LASTING = frozenset({"grid", "sheets", "checked", "tested", "reload", "trouble"})  # events that are numbered and kept
_KEPT = 300  # of them: who was away for more must load the page again
_WAITING = 200  # messages that a slow browser may lag behind before it must load the page again
_PICTURE_WAITS = 0.1  # seconds until a picture is offered again to a browser that has not taken all that was sent
_MOST_LIVE = 20  # those of a run's values: whoever lags behind more gets the newest instead
_ANSWERS = 500  # that are kept for pages that ask again
MOST_LISTENERS = 32  # event streams at once, for all workbooks
MOST_HERE = 24  # of them, of those who have the address of this computer
MOST_OF_LOGIN = 8  # of them, of one who has logged in
POLL_EVERY = 1.0  # seconds between two looks for changes by another program
Place = tuple[str, str, int]
"""Sheet, row's id, column."""
Answer = dict[str, Any]
"""Changes that a page is told of, as JSON."""
Event = tuple[str, dict[str, Any]]
"""Name and data of an event."""
Edit = Callable[[Document], Changed | None]


class Broadcaster:
    """Event streams of the pages that show the same workbook, and their cell locks; thread-safe.

    Attributes:
        languages: those of its pages so far, in which they are told what happens.
    """

    def __init__(self) -> None:
        self.languages = frozenset(("en",))
        self.listeners: list[EventStream] = []
        self.locks = CellLocks()
        self._lock = threading.RLock()
        self.backlog = EventBacklog()

    def _enter(self, listener: EventStream, had: str) -> None:
        """Register an event stream; if `had` is the number of an event, first send those after it."""
        with self._lock:
            for told in self.backlog.missed(listener.client, had) if had else ():
                listener.tell(told.text(listener.language))
            listener.welcome = f"id: {self.backlog.number}\n\n"
            self.listeners.append(listener)

    def is_of(self, client: str, login_key: str) -> bool:
        """Return whether no stream of a page, earlier loads of it included, belongs to another login."""
        mine = page_of(client)
        with self._lock:
            return all(one.login_key == login_key for one in self.listeners if page_of(one.client) == mine)

    def part(self, client: str) -> None:
        """Remove the streams of a page that reports that it is being closed."""
        with self._lock:
            listeners = [li for li in self.listeners if li.client == client]
        for listener in listeners:
            self.leave(listener)

    def end_streams(self, client: str) -> None:
        """End the older streams of a page that opens a new one; its cells stay locked when their threads `leave`."""
        with self._lock:
            older = [li for li in self.listeners if client and li.client == client]
            self.listeners = [li for li in self.listeners if li not in older]
        for listener in older:
            listener.leave()

    def leave(self, listener: EventStream) -> list[Place]:
        """End an event stream; unless a newer one has replaced it, release the page's cells and return them."""
        listener.leave()
        places: list[Place] = []
        with self._lock:
            if listener in self.listeners:
                self.listeners.remove(listener)
                places = self.locks.leave(listener.client)
        self.tell_people()
        return places

    def stand(self, client: str, name: str, place: Place) -> None:
        """Update the cell on which a page's cursor is, and its user's name if one is given."""
        with self._lock:
            for listener in self.listeners:
                if listener.client == client:
                    listener.place, listener.name = place, name or listener.name
        self.tell_people()

    # ---- events that they are sent

    def tell_people(self) -> None:
        """Send every page the list of the users present."""
        with self._lock:
            people = [{"client": li.client, "name": li.name, "place": li.place} for li in self.listeners]
        self.tell("people", {"people": people})

    def tell(self, event: str, data: dict[str, Any], but: str = "") -> None:
        """Send an event to every page except `but`."""
        with self._lock:  # also while it is handed over: what is numbered comes in its order
            told = self.backlog.add(event, data, but, self.languages)
            for listener in self.listeners:
                if listener.client != but:
                    listener.tell(told.text(listener.language))

    def tell_live(self, events: Sequence[Event]) -> None:
        """Send every page the newest values of a run, which a slow page may skip."""
        told = Versions(self.languages, lambda language: "".join(message(*event, language) for event in events))
        with self._lock:
            listeners = list(self.listeners)
        for listener in listeners:
            listener.tell_live(told.text(listener.language))

    def look(self, client: str, wanted: bool, picture: str) -> None:
        """Note whether a page shows the robot's eye, and send it the newest picture if it does from now on."""
        with self._lock:
            listeners = [one for one in self.listeners if one.client == client]
        for listener in listeners:
            listener.looks = wanted
            listener.tell_picture(picture if wanted else "")

    @property
    def is_looked(self) -> bool:
        """True while a page shows the robot's eye."""
        with self._lock:
            return any(one.looks for one in self.listeners)

    def tell_picture(self, picture: str) -> None:
        """Send a picture of the robot's eye to the pages that show it."""
        with self._lock:
            listeners = [one for one in self.listeners if one.looks]
        for listener in listeners:
            listener.tell_picture(picture)


def page_of(client: str) -> str:
    """Return the part of a page's name that survives a reload: all before its last dot.

    >>> page_of("4f1c.2")
    '4f1c'
    """
    return client.rpartition(".")[0] or client


class CellLocks:
    """Cells that are locked for editing; not thread-safe, the owner holds its own lock."""

    def __init__(self) -> None:
        self._locked: dict[Place, tuple[str, str, float]] = {}

    def holders(self, sheet: str = "") -> dict[Place, tuple[str, str]]:
        """Return the page and the name of the editor of each locked cell, of one sheet or of all."""
        found = {p: held for p, held in self._locked.items() if sheet in ("", p[0])}
        return {p: (page, name) for p, (page, name, since) in found.items() if not _is_old(since)}

    def expire(self) -> list[Place]:
        """Unlock the cells that were locked too long ago, and return them."""
        return self._free(lambda page, since: _is_old(since))

    def lock(self, client: str, name: str, place: Place) -> str:
        """Lock a cell; return the name of the holder if another page has it, else an empty text."""
        holder = self.holders().get(place)
        if holder is not None and page_of(holder[0]) != page_of(client):
            return holder[1]
        self._locked[place] = (client, name, time.monotonic())
        return ""

    def unlock(self, client: str, place: Place) -> None:
        """Unlock a cell, if this page has locked it."""
        if place in self._locked and self._locked[place][0] == client:
            del self._locked[place]

    def leave(self, client: str) -> list[Place]:
        """Unlock the cells of a page that was closed, and return them."""
        return self._free(lambda page, since: page == client)

    def leave_earlier(self, client: str) -> list[Place]:
        """Unlock the cells that a page locked before it was reloaded, and return them."""
        return self._free(lambda page, since: page != client and page_of(page) == page_of(client))

    def _free(self, which: Callable[[str, float], bool]) -> list[Place]:
        places = [p for p, (page, _, since) in self._locked.items() if which(page, since)]
        for place in places:
            del self._locked[place]
        return places

    def rename(self, old: str, new: str) -> None:
        """Carry the locks of a renamed sheet over to its new name."""
        self._locked = {(new if p[0] == old else p[0], *p[1:]): held for p, held in self._locked.items()}

    def others(self, client: str, sheet: str) -> list[str]:
        """Return the names of those who are editing a cell of a sheet on other pages."""
        return sorted({name for page, name in self.holders(sheet).values() if page_of(page) != page_of(client)})


def _is_old(since: float) -> bool:
    return time.monotonic() - since > LOCK_SECONDS


@dataclass
class EventStream:
    """Event stream of one browser page.

    Attributes:
        login_key: the key of the login; empty for a browser on this computer.
        behind: it could not keep up with a run's values, and gets all of them again.
        looks: the page shows the robot's eye.
        picture: the newest picture of it that was not sent yet.
        unsent: returns how many bytes of what was sent the browser has not taken yet.
    """

    client: str
    name: str
    login_key: str = ""
    language: str = "en"
    ready: threading.Condition = field(default_factory=threading.Condition)
    messages: deque[str] = field(default_factory=deque)
    lives: deque[str] = field(default_factory=deque)
    gone: bool = False
    behind: bool = False
    looks: bool = False
    picture: str = ""
    unsent: Callable[[], int] = int
    place: Place | None = None
    welcome: str = ": welcome\n\n"

    def tell(self, text: str) -> None:
        """Queue a message; a browser that lags too far behind is made to reload instead."""
        with self.ready:
            if len(self.messages) >= _WAITING:
                self.messages.clear()
                text = message("reload", {})
            self.messages.append(text)
            self.ready.notify()

    def tell_event(self, event: str, data: dict[str, Any]) -> None:
        """Queue an event for this page alone."""
        self.tell(message(event, data, self.language))

    def tell_live(self, text: str) -> None:
        """Queue a message with a run's values, which may be dropped when newer ones follow."""
        with self.ready:
            if len(self.lives) >= _MOST_LIVE:
                self.lives.clear()
                self.behind = True
            if not self.behind:
                self.lives.append(text)
            self.ready.notify()

    def tell_picture(self, text: str) -> None:
        """Put a picture in the place of one that was not sent yet."""
        with self.ready:
            self.picture = text
            self.ready.notify()

    def leave(self) -> None:
        """End the stream."""
        with self.ready:
            self.gone = True
            self.ready.notify()

    def take(self, anew: Callable[[], Sequence[Event]]) -> str:
        """Wait for messages and return them; `anew` returns a run's state for a page that has lagged behind."""
        with self.ready:
            if not (self.messages or self.lives or self.picture or self.behind or self.gone):
                self.ready.wait(_KEEP_ALIVE)
            texts = [*self.messages, *self.lives]
            if self.picture and self.unsent():  # it waits for the next time, and for a newer one
                if not (texts or self.behind or self.gone):
                    self.ready.wait(_PICTURE_WAITS)
            else:
                texts.append(self.picture)
                self.picture = ""
            behind, self.behind = self.behind, False
            self.messages.clear()
            self.lives.clear()
        if behind:
            texts += [message(event, data, self.language) for event, data in anew()]
        return "".join(texts) or ("" if self.picture else ": still here\n\n")


def message(event: str, data: dict[str, Any], language: str = "en", number: str = "") -> str:
    """Format an event in a language; a browser that reconnects sends the last `number` it got."""
    begin = f"id: {number}\n" if number else ""
    return f"{begin}event: {event}\ndata: {json_in(data, language)}\n\n"


def _reload(**why: str) -> Versions:
    return Versions(LANGUAGES, lambda language: message("reload", why, language))


class EventBacklog:
    """Numbered events that a page in the background must not miss; not thread-safe, its owner locks it."""

    def __init__(self) -> None:
        self._opened = secrets.token_hex(4)  # of this session, not of one of an earlier start
        self._count = 0
        self.number = f"{self._opened}.0"  # of the newest event; set at once, so it may be read without the lock
        self._kept: deque[tuple[int, str, Versions]] = deque(maxlen=_KEPT)  # number, whom not to tell, what

    def add(self, event: str, data: dict[str, Any], but: str, languages: Iterable[str]) -> Versions:
        """Format an event; number and keep it if it is of a lasting kind."""
        if event not in _LASTING:
            return Versions(languages, lambda language: message(event, data, language))
        self._count += 1
        self.number = f"{self._opened}.{self._count}"
        told = Versions(languages, lambda language: message(event, data, language, self.number))
        self._kept.append((self._count, but, told))
        return told

    def missed(self, client: str, had: str) -> list[Versions]:
        """Return the events after the last one that a page got, or a reload if that is too long ago."""
        opened, _, number = had.partition(".")
        last = int(number) if number.isascii() and number.isdigit() and len(number) < 12 else -1
        oldest = self._kept[0][0] if self._kept else self._count + 1
        if opened != self._opened:
            return [_reload(why=N_("The server was restarted."))]
        if not oldest - 1 <= last <= self._count:
            return [_reload()]
        return [told for count, but, told in self._kept if count > last and but != client]


def stream(
    listener: EventStream, anew: Callable[[], Sequence[Event]], leave: Callable[[EventStream], object]
) -> Iterator[str]:
    """Yield the messages for one page until it is closed; then call `leave`."""
    try:
        yield listener.welcome
        while not listener.gone:
            yield listener.take(anew)
    finally:
        leave(listener)


class Answers:
    """The newest answers by their requests' ids. Safe to use from several threads."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._kept: OrderedDict[str, Future[Answer]] = OrderedDict()

    def once(self, request: str, make: Callable[[], Answer]) -> Answer:
        """Return the answer to a request, which `make` makes once per id (always without); concurrent calls wait."""
        if not request:
            return make()
        with self._lock:
            earlier, mine = self._kept.get(request), Future[Answer]()
            if earlier is None:
                self._kept[request] = mine
                while len(self._kept) > _ANSWERS:
                    self._kept.popitem(last=False)
        if earlier is not None:
            return earlier.result()
        try:
            answer = make()
        except BaseException as error:
            with self._lock:
                self._kept.pop(request, None)
            mine.set_exception(error)
            raise
        mine.set_result(answer)
        return answer


class WorkbookSession(Broadcaster):
    """Session of one open workbook: its document, its check and tests, and the pages that show it."""

    def __init__(self, document: Document, worker: CheckWorker, tester: Tester) -> None:
        super().__init__()
        self.document = document
        self._worker = worker
        self._again = threading.Event()
        self._analysis = no_analysis()
        self._words: dict[str, tuple[Analysis, str, str]] = {}
        self._renderers: dict[str, RowRenderer] = {}
        self._checker: threading.Thread | None = None
        self._answers = Answers()
        self._troubles: dict[str, str] = {}  # what is wrong with the file and with its check, in words
        self._write_block = ""
        self.author = ""  # of the newest edit
        self._made = time.time_ns() // 1_000_000  # grows with each version of a row: a page keeps the later one of two
        self.about_run: Callable[[], Sequence[Event]] = tuple  # the run that goes on, for a page that joins
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

    def renaming(self, old: str, new: str, near: str) -> Renaming:
        """Return the edits that give a stream or a helper another name; see `renaming.rename`, also for errors."""
        return self._worker.rename(self.document.path, old, new, near)

    def renaming_column(self, sheet: str, old: str, new: str) -> Renaming:
        """Return the edits outside of a table that give one of its columns another name; as `renaming`."""
        headers = [c.header for c in self.document.grids[sheet].columns]
        return self._worker.rename_column(self.document.path, sheet, old, new, headers)

    def words(self, language: str) -> tuple[str, str]:
        """Return the words that are suggested, as JSON in a language, and a digest of them; made once a check."""
        analysis = self.analysis()
        with self._lock:
            kept = self._words.get(language)
        if kept is None or kept[0] is not analysis:
            devices = next((grid for grid in self.document.grids.values() if grid.kind == "devices"), None)
            columns = list(setting_columns(devices)) if devices is not None and not self.document.why else None
            grids = list(self.document.grids.values())
            text = json_in(vocabulary(analysis, columns, language_of_sheets(grids), grids), language)
            kept = analysis, text, hashlib.sha256(text.encode()).hexdigest()[:16]
            with self._lock:
                self._words[language] = kept
        return kept[1], kept[2]

    def renderer(self, sheet: str) -> RowRenderer:
        """Return the renderer of a sheet's rows, updated with the newest check, locks and test results."""
        with self._lock:
            grid = self.document.grids[sheet]
            renderer = self._renderers.get(sheet)
            if renderer is None or renderer.grid is not grid:
                renderer = self._renderers[sheet] = RowRenderer(grid)
            renderer.update(self.analysis(), self.locks.holders(sheet), self.tests.marks(sheet))
            return renderer

    # ---- editing

    def change(self, client: str, author: str, tag: str, make: Edit, request: str = "") -> Answer:
        """Make an edit, notify all pages but `client`, and return the answer to it.

        `tag` is a text from it that is sent along with the rows. An edit with the id `request` is made only once.
        """
        return self._answers.once(request, lambda: self._change(client, author, tag, make, request))

    def _change(self, client: str, author: str, tag: str, make: Edit, request: str) -> Answer:
        if request and self.document.file.made(request):  # before a restart of the server: the page loads again, too
            return {"rows": []}
        try:
            with made_for(request):
                changed = make(self.document)
        except Refused as refused:
            rows = {c.row for c in refused.clashes}
            found = {name: tuple(filter(grid.has, rows)) for name, grid in self.document.grids.items()}
            fresh = [self._rows(Changed(name, touched=mine)) for name, mine in found.items() if mine]
            return {"message": error_text(refused), "clashes": [asdict(c) for c in refused.clashes], "rows": fresh}
        except SheetsError as error:  # the file itself: gone, or no workbook any more
            return {"message": error_text(error)}
        if changed is None:
            return {"message": ""}
        self.author = author
        self.after_edit()
        self._tell_changes(self.document.outside())  # what another program did, if it is found before `poll` does
        answer: Answer = {"rows": [self._rows(one) for one in (changed, *changed.then)]}
        for one in answer["rows"]:
            self.tell("grid", {**one, "tag": tag}, but=client)
        reshaped = [one.sheet for one in (changed, *changed.then) if one.change and one.change.what == "reshaped"]
        for sheet in reshaped:
            self.tell("reload", {"why": N_("This sheet has other columns now."), "sheet": sheet})
        if (change := changed.change) and not reshaped:  # a sheet was added, removed, renamed or moved
            if change.was:
                with self._lock:
                    self.locks.rename(change.was, change.name)
                    self._renderers.pop(change.was, None)
            answer["sheets"] = {**asdict(change), "by": author}
            self.tell("sheets", answer["sheets"], but=client)
        self.check_soon()
        return answer

    def _rows(self, changed: Changed) -> Answer:
        if changed.sheet not in self.document.grids:
            return {"sheet": changed.sheet}
        with self._lock:
            if changed.heads or changed.change:
                self._renderers.pop(changed.sheet, None)
            renderer = self.renderer(changed.sheet)
            entry = {**self._now(changed.sheet), "devices": list(changed.devices)}
            if changed.heads:
                entry["heads"] = [list(head) for head in changed.heads]
            if changed.cursor and renderer.grid.has(changed.cursor[0]):
                row, column = changed.cursor
                entry["cursor"] = [row, f"{column_letters(column)}{renderer.grid.number(row)}"]
            if changed.touched:
                made = renderer.html(changed.touched, self.languages)
                entry["replace"] = [{"id": row, "html": html} for row, html in made.items()]
            if HEADER in changed.touched:
                entry["headers"] = renderer.header_comments()
            if changed.cells:
                entry["cells"] = [list(place) for place in changed.cells[:1000]]
                entry["about"] = changed.about
            if changed.inserted:
                made = renderer.html((row for row, _ in changed.inserted), self.languages)
                entry["insert"] = [{"before": at, "html": made[row]} for row, at in changed.inserted if row in made]
            if changed.removed:
                entry["remove"] = list(changed.removed)
            if changed.moved:
                entry["move"] = [{"id": row, "before": before} for row, before in changed.moved]
            if changed.grown:
                entry["grown"] = list(renderer.html(changed.grown, self.languages).values())
            if changed.inserted or changed.removed or changed.moved or changed.grown:
                version = renderer.grid.version  # before the rows, which are of that version or of a later one
                entry["order"] = {"version": version, "rows": renderer.grid.rows}
            return entry

    def piece(self, sheet: str, first: int, count: int, language: str) -> Answer:
        """Return rows of a long sheet from a place on, as several table bodies, with their serial number."""
        with self._lock:
            return {**self._now(sheet), "html": self.renderer(sheet).rows(first, count, language)}

    def _now(self, sheet: str) -> Answer:
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
                self._trouble("check", error_text(error), again=True)  # what was edited since is unchecked, too
                with self._lock:
                    self._analysis = replace(self._analysis, checked=True)
                self.tell("checked", self._checked())
                continue
            self._trouble("check", "")
            with self._lock:
                self._analysis = analysis
            for name in list(self.document.grids):
                self._tell_rows(name)
            self.tell("checked", self._checked())
            self.after_check()
            self.tests.soon()

    def _tell_rows(self, sheet: str) -> None:
        with self._lock:
            replaced = self.renderer(sheet).changed(self.languages)
            about = self._now(sheet)
        if replaced:
            self.tell("grid", about | {"replace": [{"id": r, "html": h} for r, h in replaced]})

    def _tell_tests(self, news: str) -> None:
        for name in self.tests.sheets:
            self._tell_rows(name)
        self.tell("tested", {"news": news})

    def _checked(self) -> Answer:
        words = Versions(self.languages, lambda language: self.words(language)[1])
        return {"version": self.document.version, "errors": self.analysis().errors, "words": words}

    # ---- pages and their users

    def join(self, client: str, name: str, *, language: str = "en", had: str = "", login_key: str = "") -> EventStream:
        """Open the event stream of a page that was loaded or has reconnected, in the page's language.

        The events after `had`, the number of the last one that it got, follow.
        """
        with self._lock:
            left = self.locks.leave_earlier(client)
        self._tell_cells(left, but=client)
        listener = EventStream(client, name, login_key, language)
        listener.tell_event("program", {"version": build_id()})
        self._enter(listener, had)
        with self._lock:
            for trouble in filter(None, self._troubles.values()):
                listener.tell_event("trouble", {"message": trouble, "over": trouble})
        for event, data in self.about_run():
            listener.tell_event(event, data)
        self.tell_people()
        self.tests.join()
        return listener

    def leave(self, listener: EventStream) -> list[Place]:
        """End a page's event stream, unlock its cells and notify the other pages."""
        places = super().leave(listener)
        self._tell_cells(places, but=listener.client)
        return places

    def lock(self, client: str, name: str, place: Place) -> str:
        """Lock a cell for editing; return the name of the holder if another page has it, else an empty text."""
        with self._lock:
            holder = self.locks.lock(client, name, place)
        if not holder:
            self._tell_cells([place], but=client)
        return holder

    def unlock(self, client: str, place: Place) -> None:
        """Unlock a cell, and notify the other pages."""
        with self._lock:
            self.locks.unlock(client, place)
        self._tell_cells([place], but=client)

    def _tell_cells(self, places: Sequence[Place], but: str) -> None:
        for sheet, row, _ in places:
            grid = self.document.grids.get(sheet)
            if grid is not None and grid.has(row):
                self.tell("grid", self._rows(Changed(sheet, touched=(row,))), but=but)

    def poll(self) -> None:
        """Check whether another program has changed the file, and unlock cells that were locked too long ago."""
        with self._lock:
            expired = self.locks.expire()
        self._tell_cells(expired, but="")
        reason = write_block_reason(self.document.path)
        if reason != self._write_block:
            self._write_block = reason
            self.tell("notice", {"text": reason})
        try:
            changes = self.document.poll()
        except SheetsError as error:
            self._trouble("file", error_text(error))
            return
        if self._trouble("file", ""):
            self.check_soon()  # what was checked and tested meanwhile was not the whole file
        self._tell_changes(changes)

    def _trouble(self, about: str, now: str, *, again: bool = False) -> bool:
        """Tell the pages what is wrong, or that it is over when `now` is empty; return whether that is new.

        With `again` they are told even if they were told before.
        """
        with self._lock:
            before, self._troubles[about] = self._troubles.get(about, ""), now
            if now != before or again:
                self.tell("trouble", {"message": now, "over": before})
        return now != before

    def _tell_changes(self, changes: Sequence[Changed]) -> None:
        """Send the rows that another program has changed, and make pages of reshaped sheets reload."""
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

    def find(self, name: str) -> WorkbookSession | None:
        """Return the session of a workbook that is open and whose file is in the folder still."""
        with self._lock:
            session, path = self._sessions.get(name), self.folder / name
        there = os.path.lexists(path) and path.resolve().is_relative_to(self.folder.resolve())
        return session if there else None

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
                raise SheetsError(N_("This workbook was renamed or moved."), N_("Go to Workbooks."))
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
                    why = error_text(error)
                document = Document(path, self._journal, why)
                self._sessions[path.name] = WorkbookSession(document, self._worker, self._tester)
                self.opened(self._sessions[path.name])
            return self._sessions[path.name]

    def sessions(self) -> list[WorkbookSession]:
        """Return the sessions of all open workbooks."""
        with self._lock:
            return list(self._sessions.values())

    def listen(
        self, session: WorkbookSession, client: str, login_key: str, join: Callable[[], EventStream]
    ) -> EventStream | str:
        """Open a page's event stream, instead of an older one; return the reason if there are too many.

        Pages that ask at the same moment are handled one after the other. `login_key` is the key of the login, whose
        streams are limited; empty for a browser on this computer.
        """
        with self._joining:
            session.end_streams(client)
            return self._crowded(login_key) or join()

    def _crowded(self, login_key: str) -> str:
        with self._lock:
            listeners = [one for session in self._sessions.values() for one in session.listeners]
        mine = sum(one.login_key == login_key for one in listeners)
        if mine >= (MOST_OF_LOGIN if login_key else MOST_HERE):
            return N_("You have {n} pages open here. Close one; this page then continues by itself.", n=mine)
        if len(listeners) >= MOST_LISTENERS:
            return N_("{n} pages are open on this server, {mine} of them yours. It cannot update more of them. When "
                      "one is closed, this page continues by itself.", n=len(listeners), mine=mine)  # fmt: skip
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
