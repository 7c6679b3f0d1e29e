"""The file behind a document, and the journal of its folder with accepted edits and named versions.

So a killed server loses nothing that it had accepted. The ids of rows and of the requests of pages are kept here too:
a page that got no answer sends a request again, with the same id, and its edit must not be made twice.
"""

from __future__ import annotations

import contextlib
import json
import sqlite3
import stat
import threading
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from contextvars import ContextVar
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, get_args

from rrp_sheets.documents.grid import Changed, Grid, Refused, SheetChange, make_grid
from rrp_sheets.errors import SheetsError
from rrp_sheets.model.names import key
from rrp_sheets.private import close_to_others, opener, private_folder
from rrp_sheets.texts import N_
from rrp_sheets.workbook import Reading, read
from rrp_sheets.workbook.atomic import Stamp, refuse_open_file, write_atomically
from rrp_sheets.workbook.atomic import stamp_of as file_stamp
from rrp_sheets.workbook.editing import clean_up, edit
from rrp_sheets.workbook.edits import AddSheet, Edit, RenameSheet
from rrp_sheets.workbook.raw import Extent, RawSheet
from rrp_sheets.workbook.reading import open_book
from rrp_sheets.workbook.schema import recognise

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
class Version:
    """A named version of a workbook."""

    id: int
    name: str
    author: str
    at: str
    digest: str


class Journal:
    """The journal of the workbooks of a folder, in its `.rrp-sheets`. Safe to use from several threads.

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
            why = str(getattr(error, "strerror", None) or error)
            message = N_("Nothing can be kept in {place}: {why}.", place=str(place), why=why)
            raise SheetsError(message, N_("Workbooks can be edited only in a folder you may write to.")) from error

    def close(self) -> None:
        """Let go of the file."""
        with self._lock:
            self._marks.close()
            self._db.close()

    def add(self, book: str, author: str, edits: Sequence[Edit], before: str, requests: Sequence[str] = ()) -> int:
        """Put an edit on disk, with the ids of the requests for which it is made; return its number.

        When there is no room for it, it raises Refused, and nothing is changed.
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

    def keep_rows(self, book: str, digest: str, rows: Mapping[str, Sequence[str]]) -> None:
        """Keep the ids of a workbook's rows, by sheet: pages still mean the same ones after a restart of the server."""
        ((newest,),) = self._all("select coalesce(max(seq), 0) from edits where book = ?", book)
        row = (book, newest, digest, json.dumps(rows, ensure_ascii=False))
        with self._lock, contextlib.suppress(sqlite3.Error):  # no room: the rows get other ids after a restart
            self._marks.execute("insert or replace into identities (book, seq, digest, rows) values (?, ?, ?, ?)", row)

    def kept_rows(self, book: str, *digests: str) -> tuple[dict[str, list[str]], list[Edit]]:
        """Return the ids of a workbook's rows, if its file had one of these digests then, and the edits made since."""
        for seq, digest, rows in self._all("select seq, digest, rows from identities where book = ?", book):
            if digest in digests:
                since = self._all("select edits from edits where book = ? and seq > ? order by seq", book, seq)
                return json.loads(rows), [edit for (text,) in since for edit in _edits(text)]
        return {}, []

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

    def waiting(self, book: str) -> list[tuple[int, tuple[Edit, ...], str]]:
        """Return the number of each entry that a killed server left, its edits, and the file's digest before them.

        These edits may not be in the file.
        """
        rows = self._all("select seq, edits, before from edits where book = ? and not stored order by seq", book)
        return [(seq, _edits(text), before) for seq, text, before in rows]

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
            message = N_("This was not stored: nothing can be kept beside the workbook now ({why}).", why=str(error))
            raise Refused(message, N_("Free some space on the disk, and make the change again.")) from error

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


_NOW: ContextVar[tuple[str, ...]] = ContextVar("requests", default=())


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


class WorkFile:
    """A workbook's file. Its document keeps the threads apart.

    What a killed server left in the journal is stored first. Without journal the file can only be looked at.
    """

    def __init__(self, path: Path, journal: Journal | None, why: str) -> None:
        self.path = path
        self.why = why
        self._kept = journal
        self._stamp: Stamp | None = None
        self.digest = ""  # of the contents whose rows the document has: edits are based on them
        self._recovered = ""  # the digest before what a killed server had accepted
        self._reading: Reading | None = None
        self._read_stamp: Stamp | None = None  # of the file when it was read
        if journal is not None:
            self._recover(journal)

    @property
    def journal(self) -> Journal:
        """The journal; raises Refused when the file can only be looked at."""
        if self._kept is None:
            raise Refused(N_("This workbook can only be looked at here."), self.why)
        return self._kept

    @property
    def read_only(self) -> bool:
        """True when the file can only be looked at; `why` says why."""
        return self._kept is None

    @property
    def reading(self) -> Reading:
        """The workbook as its file said it when it was last read: its rows may be newer than those of the document."""
        if self._reading is None:
            self._read_stamp = stamp_of(self.path)
            self._reading = read(self.path)
            if self._reading.digest != self.digest:
                self._stamp = None  # another program wrote it at the moment when it was stored
        return self._reading

    def accept(self) -> None:
        """Take note that the document has the rows of `reading`, so that edits may be based on them."""
        self.digest, self._stamp = self.reading.digest, self._read_stamp

    def sheets(self) -> tuple[RawSheet, ...]:
        """The sheets as they stand there, without understanding them."""
        stamp = stamp_of(self.path)
        sheets, self.digest = raw_sheets(self.path)
        self._stamp = stamp
        return tuple(sheets)

    def whole(self, tables: Collection[str]) -> tuple[RawSheet, ...]:
        """The sheets as they were understood, those of the user's own with these keys to their ends too."""
        sheets = self.reading.sheets
        if all(recognise(s).kind or key(s.name) not in tables for s in sheets):
            return sheets
        found = {s.name: s for s in raw_sheets(self.path)[0]}
        return tuple(s if recognise(s).kind or key(s.name) not in tables else found.get(s.name, s) for s in sheets)

    def has_changed(self) -> bool:
        """Return whether another program has written other contents into it; `reading` is then the new one."""
        if stamp_of(self.path) == self._stamp:
            return False
        self._reading = None
        if self.reading.digest != self.digest:
            return True
        self._stamp = self._read_stamp
        return False

    def store(self, author: str, edits: Sequence[Edit]) -> tuple[str, ...]:
        """Write edits to the journal and then to the file; return what brings back the sheets that were deleted.

        When the file does not take them, they are taken out of the journal again, and Refused is raised.
        """
        seq = self.journal.add(self.path.name, author, edits, self.digest, requests_now())
        try:
            edited = edit(self.path, edits, expected_digest=self.digest)
        except SheetsError as error:
            self.journal.drop(seq)
            self._stamp = None  # another program may have changed it since the last look: the next one reads it
            raise Refused(error.message, error.remedy) from error
        self.journal.stored(seq, self.path.name, edited.digest)
        self.digest, self._stamp, self._reading = edited.digest, stamp_of(self.path), None
        return edited.kept

    def made(self, request: str) -> bool:
        """Return whether the edit of a page's request was made, also before a restart."""
        return self._kept is not None and self._kept.made(request)

    def keep_rows(self, rows: dict[str, list[str]]) -> None:
        """Keep the ids of the rows, by sheet, for after a restart."""
        if self._kept is not None:
            self._kept.keep_rows(self.path.name, self.digest, rows)

    def kept_rows(self) -> tuple[dict[str, list[str]], list[Edit]]:
        """Return the ids of the rows, by sheet, as they were kept, and the edits made since.

        There are none when another program has changed the file while no server was running.
        """
        return self._kept.kept_rows(self.path.name, self.digest, self._recovered) if self._kept else ({}, [])

    def added(self) -> set[str]:
        """The keys of the sheets that were added here."""
        return self._kept.added(self.path.name) if self._kept else set()

    def keep_version(self, author: str, name: str) -> None:
        """Keep the file as it is now under a name; raise Refused when it is no file any more."""
        if not self.path.is_file():  # of a pipe the end would be waited for
            raise Refused(N_("“{name}” is no file any more.", name=self.path.name), N_("Put the workbook there again."))
        self.journal.keep_version(self.path.name, name, author, self.digest, self.path.read_bytes())

    def versions(self) -> list[Version]:
        """The named versions, the newest first."""
        return self._kept.versions(self.path.name) if self._kept else []

    def version_content(self, version: int) -> bytes | None:
        """The bytes of a version; None when there is no such version."""
        return self._kept.content(self.path.name, version) if self._kept else None

    def restore(self, author: str, version: int) -> None:
        """Make the file what it was in a version; what it is now is kept as a version too, unless it is one already.

        Raises:
            Refused: when there is no such version, or the file does not allow it.
        """
        content = self.version_content(version)
        name = next((v.name for v in self.versions() if v.id == version), "")
        if content is None:
            raise Refused(N_("There is no such version any more."), N_("Look at the list again."))
        try:
            refuse_open_file(self.path)
            stamp = file_stamp(self.path)
            if all(v.digest != self.digest for v in self.versions()):
                self.keep_version(author, f"Before {name} came back")
            write_atomically(self.path, content, unchanged=stamp)
        except SheetsError as error:
            raise Refused(error.message, error.remedy) from error

    def _recover(self, journal: Journal) -> None:
        """Store what a killed server had accepted and not stored."""
        clean_up(self.path)
        waiting = journal.waiting(self.path.name)
        self._recovered = next((before for _, _, before in waiting), "")
        for seq, edits, before in waiting:
            if read(self.path).digest == before:
                edit(self.path, edits, expected_digest=before)
            journal.stored(seq)


def write_block_reason(path: Path) -> str:
    """Return why edits of a workbook would be refused just now; empty when they would not."""
    try:
        refuse_open_file(path)
        mode = path.stat().st_mode
    except SheetsError as error:
        return N_(
            "{message} It can be looked at here, but not changed, so that nothing is lost. {remedy}",
            message=error.message, remedy=error.remedy,
        )  # fmt: skip
    except OSError:
        return N_(
            "“{name}” is not there any more: it was deleted, renamed or moved. What is shown here cannot be "
            "changed. Put it back, or go to the shelf.",
            name=path.name,
        )
    if not path.is_dir() and not mode & stat.S_IWUSR:
        return N_(
            "“{name}” is write-protected: it can be looked at here, but not changed. "
            "Take the protection off in the file's properties, or change a copy.",
            name=path.name,
        )
    return ""


def raw_sheets(path: Path) -> tuple[tuple[RawSheet, ...], str]:
    """The sheets as they stand in the file, ours to their last row, and its digest; raises UnreadableFile."""
    book, digest = open_book(path)
    sheets = []
    for index in range(len(book.names)):
        ours = recognise(book.sheet(index, Extent.HEAD)).kind is not None
        sheets.append(book.sheet(index, Extent.WHOLE if ours else Extent.TABLE))
    return tuple(sheets), digest


def take_over(
    grids: Mapping[str, Grid], sheets: Sequence[RawSheet], tables: Collection[str]
) -> tuple[dict[str, Grid], list[Changed]]:
    """The grids as the file says them now, and what is new; rows that are the same keep their ids."""
    found: dict[str, Grid] = {}
    changes = []
    for sheet in sheets:
        recognised = recognise(sheet)
        kind = recognised.kind.name if recognised.kind else "table" if key(sheet.name) in tables else ""
        if not kind:
            continue
        fresh = make_grid(sheet, recognised, kind)
        old = grids.get(sheet.name)
        if old is None or (old.kind, old.first, old.columns) != (fresh.kind, fresh.first, fresh.columns):
            found[sheet.name] = fresh
            what = "added" if old is None else "reshaped"
            changes.append(Changed(sheet.name, change=SheetChange(what, sheet.name, fresh.kind)))
            continue
        found[sheet.name] = old
        changed = old.load(sheet)
        if changed is not None:
            changes.append(changed)
    gone = (name for name in grids if name not in found)
    changes += [Changed(name, change=SheetChange("deleted", name)) for name in gone]
    return found, changes


def stamp_of(path: Path) -> Stamp | None:
    """Return the stamp of a file, by which a change of it is noticed; None when it is not there."""
    try:
        return file_stamp(path)
    except OSError:
        return None
