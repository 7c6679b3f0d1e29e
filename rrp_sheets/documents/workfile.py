"""The file behind a document: opened as grids, edited through the journal, with its named versions."""

from __future__ import annotations

import stat
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path

from rrp_sheets.documents.grid import Changed, Grid, Refused, SheetChange, make_grid
from rrp_sheets.documents.journal import Identities, Journal, Version, requests_now
from rrp_sheets.errors import SheetsError
from rrp_sheets.model.names import key
from rrp_sheets.texts import N_
from rrp_sheets.workbook import Reading, read
from rrp_sheets.workbook.atomic import refuse_open_file, write_atomically
from rrp_sheets.workbook.atomic import stamp_of as file_stamp
from rrp_sheets.workbook.editing import clean_up, edit
from rrp_sheets.workbook.edits import Edit
from rrp_sheets.workbook.raw import Book, Extent, RawSheet
from rrp_sheets.workbook.reading import open_book
from rrp_sheets.workbook.schema import recognise


class WorkFile:
    """A workbook's file. Its document keeps the threads apart.

    What a killed server left in the journal is stored first. Without journal the file can only be looked at.
    """

    def __init__(self, path: Path, journal: Journal | None, why: str) -> None:
        self.path = path
        self.why = why
        self._kept = journal
        self._stamp = (0, 0)
        self._digest = ""
        self._recovered = ""  # the digest before what a killed server had accepted
        self._reading: Reading | None = None
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
        """The workbook as its file says it now; read again only when it has changed."""
        if self._reading is None:
            self._stamp = stamp_of(self.path)
            self._reading = read(self.path)
            self._digest = self._reading.digest
        return self._reading

    def sheets(self) -> tuple[RawSheet, ...]:
        """The sheets as they stand there, without understanding them."""
        stamp = stamp_of(self.path)
        sheets, self._digest = raw_sheets(self.path)
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
        before, self._reading = self._digest, None
        return self.reading.digest != before

    def store(self, author: str, edits: Sequence[Edit]) -> tuple[str, ...]:
        """Write edits to the journal and then to the file; out of the journal again when the file does not take them.

        Returns:
            What brings back the sheets that were deleted.

        Raises:
            Refused: the file does not take it, and why.
        """
        seq = self.journal.add(self.path.name, author, edits, self._digest, requests_now())
        try:
            edited = edit(self.path, edits, expected_digest=self._digest)
        except SheetsError as error:
            self.journal.drop(seq)
            raise Refused(error.message, error.remedy) from error
        self.journal.stored(seq, self.path.name, edited.digest)
        self._digest, self._stamp, self._reading = edited.digest, stamp_of(self.path), None
        return edited.kept

    def made(self, request: str) -> bool:
        """Return whether the edit of a page's request was made, also before a restart."""
        return self._kept is not None and self._kept.made(request)

    def keep_rows(self, rows: dict[str, list[str]]) -> None:
        """Keep the ids of the rows, by sheet, for after a restart."""
        if self._kept is not None:
            seq = self._kept.newest(self.path.name)
            self._kept.keep_rows(self.path.name, Identities(seq, self._digest, rows))

    def kept_rows(self) -> tuple[dict[str, list[str]], list[Edit]]:
        """The ids of the rows as they were kept, by sheet, and the edits made since; none when they do not fit.

        They do not when another program has changed it while no server was running.
        """
        kept = self._kept.kept_rows(self.path.name) if self._kept else None
        if self._kept is None or kept is None or kept.digest not in (self._digest, self._recovered):
            return {}, []
        return kept.rows, self._kept.since(self.path.name, kept.seq)

    def added(self) -> set[str]:
        """The keys of the sheets that were added here."""
        return self._kept.added(self.path.name) if self._kept else set()

    def keep_version(self, author: str, name: str) -> None:
        """Keep the file as it is now under a name.

        Raises:
            Refused: it is no file any more.
        """
        if not self.path.is_file():  # of a pipe the end would be waited for
            raise Refused(N_("“{name}” is no file any more.", name=self.path.name), N_("Put the workbook there again."))
        self.journal.keep_version(self.path.name, name, author, self._digest, self.path.read_bytes())

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
            if all(v.digest != self._digest for v in self.versions()):
                self.keep_version(author, f"Before {name} came back")
            write_atomically(self.path, content, unchanged=stamp)
        except SheetsError as error:
            raise Refused(error.message, error.remedy) from error

    def _recover(self, journal: Journal) -> None:
        """Store what a killed server had accepted and not stored."""
        clean_up(self.path)
        waiting = journal.waiting(self.path.name)
        self._recovered = waiting[0].before if waiting else ""
        for entry in waiting:
            if read(self.path).digest == entry.before:
                edit(self.path, entry.edits, expected_digest=entry.before)
            journal.stored(entry.seq)


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


Stamp = tuple[int, int]


def raw_sheets(path: Path) -> tuple[tuple[RawSheet, ...], str]:
    """The sheets as they stand in the file, ours to their last row, and its digest; raises UnreadableFile."""
    book, digest = open_book(path)
    return tuple(_raw_sheet(book, index) for index in range(len(book.names))), digest


def _raw_sheet(book: Book, index: int) -> RawSheet:
    ours = recognise(book.sheet(index, Extent.HEAD)).kind is not None
    return book.sheet(index, Extent.WHOLE if ours else Extent.TABLE)


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


def stamp_of(path: Path) -> Stamp:
    """Return the time and size of a file, by which a change of it is noticed; zeros when it is not there."""
    try:
        status = path.stat()
    except OSError:
        return (0, 0)
    return (status.st_mtime_ns, status.st_size)
