"""Journal of a folder: accepted edits, stored before they are in the workbook's file, and the named versions.

So a killed server loses nothing that it had accepted. The ids of rows and of the requests of pages are kept here too:
a page that got no answer sends a request again, with the same id, and its edit must not be made twice.
"""

from __future__ import annotations

import contextlib
import json
import sqlite3
import threading
from collections import OrderedDict
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future
from contextlib import closing, contextmanager
from contextvars import ContextVar
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from pathlib import Path
from threading import Lock
from typing import Any, Generic, TypeVar, get_args

from rrp_sheets.errors import SheetsError
from rrp_sheets.model.names import key
from rrp_sheets.private import close_to_others, opener, private_folder
from rrp_sheets.texts import N_
from rrp_sheets.workbook.edits import AddSheet, Edit, RenameSheet

FOLDER = ".rrp-sheets"
_KINDS: dict[str, type[Edit]] = {kind.__name__: kind for kind in get_args(Edit)}
_TABLES = """
create table if not exists edits (
  seq integer primary key, book text not null, author text not null, at text not null,
  edits text not null, before text not null, stored integer not null default 0);
create index if not exists waiting on edits (book) where not stored;
create table if not exists versions (
  id integer primary key, book text not null, name text not null, author text not null, at text not null,
  digest text not null, content blob not null);
create table if not exists requests (id text primary key, seq integer not null);
create table if not exists identities (
  book text primary key, seq integer not null, digest text not null, rows text not null);
"""


@dataclass(frozen=True, slots=True)
class JournalEntry:
    """An edit that is in the journal and perhaps not in the file, and the digest of the file before it."""

    seq: int
    edits: tuple[Edit, ...]
    before: str


@dataclass(frozen=True, slots=True)
class Identities:
    """The ids of a workbook's rows, by sheet; the newest edit and the digest of the file when they were so."""

    seq: int
    digest: str
    rows: dict[str, list[str]]


@dataclass(frozen=True, slots=True)
class Version:
    """A named version of a workbook."""

    id: int
    name: str
    author: str
    at: str
    digest: str


class Journal:
    """The journal of the workbooks of a folder. Safe to use from several threads.

    Args:
        folder: of the workbooks; the journal is in its folder `.rrp-sheets`.

    Raises:
        SheetsError: when it cannot be written there.
    """

    def __init__(self, folder: Path) -> None:
        self._lock = threading.Lock()
        self._dropped: list[int] = []
        place = folder / FOLDER
        try:
            private_folder(place)
            with open(place / "journal.sqlite", "ab", opener=opener):  # what the database makes beside it is as private
                pass
            for path in (place, *place.glob("journal.sqlite*")):
                close_to_others(path)
            self._db = sqlite3.connect(place / "journal.sqlite", check_same_thread=False, isolation_level=None)
            self._db.execute("pragma journal_mode = wal")
            self._db.execute("pragma synchronous = full")
            self._db.executescript(_TABLES)
            # that an edit is in the file as well may be forgotten in a crash: it shows in the file's digest
            self._marks = sqlite3.connect(place / "journal.sqlite", check_same_thread=False, isolation_level=None)
            self._marks.execute("pragma synchronous = off")
        except (OSError, sqlite3.Error) as error:
            why = getattr(error, "strerror", None) or error
            raise SheetsError(
                N_("Nothing can be kept in {place}: {why}.", place=str(place), why=str(why)),
                N_("Workbooks can be edited only in a folder you may write to."),
            ) from error

    def close(self) -> None:
        """Let go of the file."""
        with self._lock:
            self._marks.close()
            self._db.close()

    def add(self, book: str, author: str, edits: Sequence[Edit], before: str, requests: Sequence[str] = ()) -> int:
        """Put an edit on disk, together with the ids of the requests for which it is made; its number.

        Raises:
            SheetsError: there is no room for it; nothing was changed.
        """
        self._drop_all()
        text = json.dumps([[type(e).__name__, asdict(e)] for e in edits], ensure_ascii=False)
        cursor = self._do(
            "insert into edits (book, author, at, edits, before) values (?, ?, ?, ?, ?)",
            (book, author, _now(), text, before),
            *(("insert or ignore into requests values (?, (select max(seq) from edits))", (one,)) for one in requests),
        )
        assert cursor.lastrowid is not None
        return cursor.lastrowid

    def made(self, request: str) -> bool:
        """Return whether the edit of a request was accepted."""
        return bool(self._all("select 1 from requests where id = ?", request))

    def stored(self, seq: int, book: str = "", digest: str = "") -> None:
        """The edit is in the workbook's file, which has another digest now."""
        with self._lock, contextlib.suppress(sqlite3.Error):  # no room: it shows in the file's digest
            self._marks.execute("begin immediate")
            try:
                self._marks.execute("update edits set stored = 1 where seq = ?", (seq,))
                self._marks.execute("update identities set digest = ? where book = ?", (digest, book))
            finally:
                self._marks.execute("commit")

    def keep_rows(self, book: str, kept: Identities) -> None:
        """Keep the ids of a workbook's rows, so that pages still mean the same rows after a restart of the server."""
        row = (book, kept.seq, kept.digest, json.dumps(kept.rows, ensure_ascii=False))
        with self._lock, contextlib.suppress(sqlite3.Error):  # no room: the rows get other ids after a restart
            self._marks.execute("insert or replace into identities (book, seq, digest, rows) values (?, ?, ?, ?)", row)

    def kept_rows(self, book: str) -> Identities | None:
        """The ids of a workbook's rows as they were kept last."""
        found = self._all("select seq, digest, rows from identities where book = ?", book)
        return Identities(found[0][0], found[0][1], json.loads(found[0][2])) if found else None

    def since(self, book: str, seq: int) -> list[Edit]:
        """Return the edits after an entry."""
        rows = self._all("select edits from edits where book = ? and seq > ? order by seq", book, seq)
        return [edit for (text,) in rows for edit in _edits(text)]

    def newest(self, book: str) -> int:
        """The number of the newest entry of a workbook; 0 when there is none."""
        return int(self._all("select coalesce(max(seq), 0) from edits where book = ?", book)[0][0])

    def drop(self, seq: int) -> None:
        """Remove an edit that could not be stored; when there is no room for that, it is done later."""
        self._dropped.append(seq)
        self._drop_all()

    def _drop_all(self) -> None:
        with contextlib.suppress(SheetsError):
            while self._dropped:
                seq = (self._dropped[-1],)
                self._do("delete from edits where seq = ?", seq, ("delete from requests where seq = ?", seq))
                self._dropped.pop()

    def waiting(self, book: str) -> list[JournalEntry]:
        """Return the edits that may not be in the file, in their order: a killed server has left them."""
        rows = self._all("select seq, edits, before from edits where book = ? and not stored order by seq", book)
        return [JournalEntry(seq, _edits(text), before) for seq, text, before in rows]

    def added(self, book: str) -> set[str]:
        """The keys of the sheets that were added here, by their names of now."""
        rows = self._all("select edits from edits where book = ? and edits like '%Sheet\"%' order by seq", book)
        names: set[str] = set()
        for (text,) in rows:
            for one in _edits(text):
                if isinstance(one, AddSheet):
                    names.add(key(one.sheet))
                elif isinstance(one, RenameSheet) and key(one.sheet) in names:
                    names = (names - {key(one.sheet)}) | {key(one.name)}
        return names

    def keep_version(self, book: str, name: str, author: str, digest: str, content: bytes) -> None:
        """Keep the workbook as it is now under a name."""
        self._do(
            "insert into versions (book, name, author, at, digest, content) values (?, ?, ?, ?, ?, ?)",
            (book, name, author, _now(), digest, content),
        )

    def rename(self, book: str, name: str) -> None:
        """The workbook's file has another name now; its versions go with it."""
        self._do("update versions set book = ? where book = ?", (name, book))
        self._do("delete from identities where book in (?, ?)", (name, book))

    def versions(self, book: str) -> list[Version]:
        """The named versions of a workbook, the newest first."""
        rows = self._all("select id, name, author, at, digest from versions where book = ? order by id desc", book)
        return [Version(*row) for row in rows]

    def content(self, book: str, version: int) -> bytes | None:
        """The bytes of a version."""
        found = self._all("select content from versions where book = ? and id = ?", book, version)
        return bytes(found[0][0]) if found else None

    def _do(self, statement: str, values: tuple[Any, ...], *more: tuple[str, tuple[Any, ...]]) -> sqlite3.Cursor:
        """Execute statements, together or not at all; the cursor of the first."""
        try:
            with self._lock:
                try:
                    return self._at_once(statement, values, more)
                except sqlite3.OperationalError:  # perhaps no room; what was written ahead can be written over
                    self._db.execute("pragma wal_checkpoint(restart)").close()
                    return self._at_once(statement, values, more)
        except sqlite3.Error as error:
            raise SheetsError(
                N_("This was not stored: nothing can be kept beside the workbook now ({why}).", why=str(error)),
                N_("Free some space on the disk, and make the change again."),
            ) from error

    def _at_once(
        self, statement: str, values: tuple[Any, ...], more: Sequence[tuple[str, tuple[Any, ...]]]
    ) -> sqlite3.Cursor:
        if not more:
            return self._db.execute(statement, values)
        self._db.execute("begin immediate")
        with self._db:  # commits, or rolls back
            cursor = self._db.execute(statement, values)
            for one, its in more:
                self._db.execute(one, its)
        return cursor

    def _all(self, statement: str, *values: Any) -> list[Any]:
        with self._lock, closing(self._db.execute(statement, values)) as cursor:
            return cursor.fetchall()


def _edits(text: str) -> tuple[Edit, ...]:
    return tuple(_KINDS[name](**values) for name, values in json.loads(text))


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="milliseconds")


_ANSWERS = 500  # that are kept for pages that ask again
_NOW: ContextVar[tuple[str, ...]] = ContextVar("requests", default=())

Answer = TypeVar("Answer")


@contextmanager
def made_for(*requests: str) -> Iterator[None]:
    """Within, the edits of this thread are made for these requests."""
    before = _NOW.set(tuple(request for request in requests if request))
    try:
        yield
    finally:
        _NOW.reset(before)


def requests_now() -> tuple[str, ...]:
    """The ids of the requests for which this thread makes edits now."""
    return _NOW.get()


class Answers(Generic[Answer]):
    """The newest answers by their requests' ids. Safe to use from several threads."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._kept: OrderedDict[str, Future[Answer]] = OrderedDict()

    def once(self, request: str, make: Callable[[], Answer]) -> Answer:
        """The answer to a request, which is made the first time; who asks meanwhile waits for the same.

        A request without id is never sent again.
        """
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
