"""Workbook under edit by several people: edits are queued, checked, journalled and stored, and can be undone.

A killed server loses nothing that it had accepted: its journal has it before the file. The ids of rows and of the
requests of pages are kept there too: a page that got no answer sends a request again, with the same id, and its edit
must not be made twice.
"""

from __future__ import annotations

import contextlib
import json
import sqlite3
import stat
import threading
from collections import deque
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, closing, contextmanager
from contextvars import ContextVar
from dataclasses import asdict, dataclass, field, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, get_args

from rrp_sheets.documents.grid import (
    HEADER,
    AddRows,
    Batch,
    CellText,
    Changed,
    Grid,
    PlaceRows,
    PutHeader,
    PutLooks,
    PutTexts,
    PutThread,
    Refused,
    RemoveRows,
    RowStep,
    SheetChange,
    SheetMissing,
    blocks,
    bring,
    cell_edits,
    make_grid,
    must_have,
    put_header,
    put_looks,
    put_texts,
    put_thread,
    remove,
    shift,
)
from rrp_sheets.documents.sheet_edits import SheetEdits, Sheets, SheetStep, make_sheet_step
from rrp_sheets.errors import SheetsError
from rrp_sheets.model.names import key
from rrp_sheets.private import close_to_others, opener, private_folder
from rrp_sheets.texts import N_
from rrp_sheets.workbook import Reading, read
from rrp_sheets.workbook.comments import Thread, Threads, read_threads
from rrp_sheets.workbook.edits import AddSheet, Edit, RenameSheet, SetCell
from rrp_sheets.workbook.files import Stamp, clean_up, edit, open_book, refuse_open_file, stamp_of, write_atomically
from rrp_sheets.workbook.looks import SheetLooks, read_looks, style_looks
from rrp_sheets.workbook.raw import Extent, RawSheet
from rrp_sheets.workbook.schema import recognise
from rrp_sheets.workbook.xlsx import XlsxBook

Step = RowStep | Batch | SheetStep
MOST_BACK = 500  # steps that a person can undo


class Steps:
    """Steps of each person that can be undone, and those that were undone and can be made again."""

    def __init__(self) -> None:
        self._back: dict[str, list[Step]] = {}
        self._redo: dict[str, list[Step]] = {}

    def did(self, author: str, step: Step) -> None:
        """Note a new step; what was undone before it cannot be made again."""
        self.put(author, step, redo=False)
        self._redo.pop(author, None)

    def put(self, author: str, step: Step, *, redo: bool) -> None:
        """Put the newest step to undo, or to make again."""
        pile = (self._redo if redo else self._back).setdefault(author, [])
        pile.append(step)
        del pile[:-MOST_BACK]

    def let_wait(self, author: str, waits: Callable[[Step], bool], *, redo: bool) -> None:
        """Move steps that cannot be made at present below all others, in their order, so that the others come first."""
        (self._redo if redo else self._back)[author].sort(key=lambda step: not waits(step))

    def take(self, author: str, *, redo: bool) -> Step | None:
        """Remove and return the newest step to undo, or to make again; None when there is none."""
        pile = (self._redo if redo else self._back).get(author)
        return pile.pop() if pile else None


class Document:
    """One workbook. Safe to use from several threads.

    Args:
        path: of the file.
        journal: of its folder; what a killed server left there is stored first. None: it can only be looked at.
        why: why it can only be looked at.

    Attributes:
        grids: its sheets by name, in the order of the file.
        own: the names of the user's own sheets, which are left alone.
        version: grows with every change.

    Raises:
        UnreadableFile: when the file cannot be read.
    """

    def __init__(self, path: Path, journal: Journal | None, why: str = "") -> None:
        self.path = path
        self.why = why
        self._lock = threading.RLock()
        self._steps = Steps()
        self.file = WorkFile(path, journal, why)
        self.grids: dict[str, Grid] = {}
        self.own: tuple[str, ...] = ()
        self.version = 0
        self._named: dict[str, str] = {}
        self._outside: list[Changed] = []
        self._added = self.file.added()
        self.sheets = SheetEdits(self._lock, self._new, self._sheets, path)
        self._queue = Queue(self._lock, self._fulfil)
        self._kept_rows: dict[str, list[str]] = {}
        self._open()
        rows, since = self.file.kept_rows()
        for name, grid in self.grids.items():
            if name in rows:
                grid.adopt(rows[name], since)
        self._take_marks()
        self._keep_rows()

    @property
    def reading(self) -> Reading:
        """The workbook as its file said it when it was last read: its rows may be newer than those of the grids."""
        with self._lock:
            return self.file.reading

    # ---- editing

    def set_cells(self, author: str, sheet: str, cells: Sequence[CellText]) -> Changed:
        """Change cells of a sheet, all or none; raise Refused when one was changed meanwhile, or is not taken."""
        return self._queue.ask(EditRequest(author, sheet, tuple(cells)))

    def together(self, author: str, steps: Sequence[PutTexts | AddRows | RemoveRows | PutHeader]) -> Changed:
        """Make several edits, of one sheet or of several, as one edit, which is undone as one."""
        return self._new(author, Batch(steps[0].sheet, tuple(steps)))

    def insert(
        self, author: str, sheet: str, before: str | None, rows: int | Sequence[tuple[str, Mapping[int, str]]]
    ) -> Changed:
        """Insert rows before a row; None: blank ones at the end, which changes nothing in the file.

        `rows` says how many blank ones, or their ids, which are new, and texts.
        """
        with self._changing():
            grid = self._grid(sheet)
            given = [(grid.new_id(), {}) for _ in range(rows)] if isinstance(rows, int) else rows
            made = tuple((row, dict(texts)) for row, texts in given)
            columns = {c.number for c in grid.columns}
            if any(column not in columns for _, texts in made for column in texts):
                raise Refused(N_("There is no such column."), N_("Reload the page."))
            if any(grid.knows(row) for row, _ in made):
                raise Refused(N_("These rows are there already."), N_("Reload the page."))
            if before is None and not any(texts for _, texts in made):
                added = grid.add_blank(0, [row for row, _ in made])
                return Changed(sheet, inserted=tuple((row, None) for row in added))
            if before is not None and not grid.knows(before):
                must_have(grid, [before])
            return self._new(author, AddRows(sheet, made, before))

    def delete(self, author: str, sheet: str, rows: Sequence[str]) -> Changed:
        """Delete rows with everything in them."""
        return self._new(author, RemoveRows(sheet, tuple(rows)))

    def move(self, author: str, sheet: str, rows: Sequence[str], before: str | None) -> Changed:
        """Move rows before another one; None: to the end."""
        return self._new(author, PlaceRows(sheet, tuple(rows), before))

    def comment(self, author: str, sheet: str, row: str, column: int, change: Callable[[Thread], Thread]) -> Changed:
        """Change the comments of a cell: `change` returns them from those that are there, or raises SheetsError."""
        with self._changing():
            self._synchronise()
            grid = self._grid(sheet)
            _must_have_column(grid, [column])
            now = grid.marks.thread(row, column)
            return self._new(author, PutThread(grid.name, row, column, now, change(now)))

    def paste(
        self, author: str, sheet: str, cells: Sequence[CellText],
        carried: Sequence[tuple[tuple[str, int], tuple[str, int]]],
    ) -> Changed:  # fmt: skip
        """Change cells, and let comments go from one cell to another, unless there are some already."""
        with self._changing():
            self._synchronise()
            grid = self._grid(sheet)
            _must_have_column(grid, [to[1] for _, to in carried])
            steps: list[RowStep] = [PutTexts(grid.name, tuple(cells))] if cells else []
            for source, target in carried:
                thread = grid.marks.thread(*source)
                if thread and grid.has(target[0]) and not grid.marks.thread(*target):
                    steps += [PutThread(grid.name, *source, thread, ()), PutThread(grid.name, *target, (), thread)]
            return self._new(author, Batch(grid.name, tuple(steps))) if steps else Changed(grid.name)

    def set_looks(
        self, author: str, sheet: str, cells: Sequence[tuple[str, int]], change: Mapping[str, Any]
    ) -> Changed:
        """Change looks of cells; `change` has what becomes another one: `bold`, `fill`, `wrap`."""
        with self._changing():
            self._synchronise()
            grid = self._grid(sheet)
            _must_have_column(grid, [column for _, column in cells])
            was = [(row, column, grid.marks.look(row, column)) for row, column in cells]
            return self._new(author, PutLooks(grid.name, tuple((*c, replace(c[2], **change)) for c in was)))

    def comments(self) -> list[tuple[str, int, int, str, Thread]]:
        """Return all comments of the workbook: sheet, row number, column, row's id if a grid has the cell, thread."""
        with self._lock:
            self._synchronise()
            found = []
            for name, (threads, _) in self.file.marks().items():
                grid = self.grids.get(name)
                rows = _rows_by_number(grid) if grid else {}
                columns = {c.number for c in grid.columns} if grid else set[int]()
                for (number, column), thread in sorted(threads.items()):
                    found.append((name, number, column, rows.get(number, "") if column in columns else "", thread))
            return found

    def marks_of(self, sheet: str) -> tuple[Threads, SheetLooks]:
        """Return the comments and looks in a sheet that no grid has, by row and column."""
        with self._lock:
            return self.file.marks().get(sheet, ({}, SheetLooks()))

    def current(self, sheet: str) -> str:
        """The name that a sheet has now, which may be another one than a page still shows."""
        for _ in range(len(self._named)):
            if sheet in self._named:
                sheet = self._named[sheet]
        return sheet

    def undo(self, author: str, *, redo: bool = False) -> Changed | None:
        """Take back one's own newest edit (or make it again); None when there is nothing to take back."""
        with self._changing():
            self._synchronise()
            step = self._steps.take(author, redo=redo)
            if step is None:
                return None
            version = self.version
            try:
                changed, inverse = self._make(author, step)
            except SheetMissing as missing:
                gone = missing.sheet
                self._steps.put(author, step, redo=redo)
                self._steps.let_wait(author, lambda s: s is step or self.current(s.sheet) == gone, redo=redo)
                remedy = N_("It waits until somebody restores the sheet. Once more continues with the step before it.")
                raise Refused(missing.message, remedy) from missing
            except Exception as error:  # it can be tried again when the reason is gone
                if isinstance(error, Refused) or self.version == version:  # else it is in the file already
                    self._steps.put(author, step, redo=redo)
                raise
            self._steps.put(author, inverse, redo=not redo)
            return changed

    # ---- the file

    def poll(self) -> list[Changed]:
        """Take over what another program has written into the file; what changed by that since the last time."""
        with self._changing():
            self._synchronise()
            return self.outside()

    def outside(self) -> list[Changed]:
        """Return the changes by other programs that were taken over already and not asked for yet."""
        with self._lock:
            changes, self._outside = self._outside, []
            return changes

    def keep_version(self, author: str, name: str) -> None:
        """Keep the workbook as it is now under a name."""
        with self._lock:
            self._synchronise()
            self.file.keep_version(author, name)

    def restore(self, author: str, version: int) -> list[Changed]:
        """Make the file what it was in a version; see `WorkFile.restore`."""
        with self._changing():
            self._synchronise()
            self.file.restore(author, version)
            return self.poll()

    @contextmanager
    def _changing(self) -> Iterator[None]:
        """Let nobody else change the workbook within this context; after it the rows' ids are kept."""
        with self._lock:
            try:
                yield
            finally:
                self._keep_rows()

    def _keep_rows(self) -> None:
        """Keep the rows' ids, if there are others, so that pages mean the same rows after a restart of the server."""
        rows = {name: list(grid.rows) for name, grid in self.grids.items()}
        if rows != self._kept_rows:
            self.file.keep_rows(rows)
            self._kept_rows = rows

    def _new(self, author: str, step: Step) -> Changed:
        with self._changing():
            changed, inverse = self._make(author, step)
            self._steps.did(author, inverse)
            return changed

    def _make(self, author: str, step: Step) -> tuple[Changed, Step]:
        self._synchronise()
        if isinstance(step, SheetStep):
            return self._make_sheet(author, step)
        if isinstance(step, Batch):
            return self._each(author, step)
        grid = self._grid(step.sheet)
        changed, inverse = self._make_rows(author, grid, step)
        return replace(changed, grown=tuple(grid.fill_up())), inverse

    def _make_rows(self, author: str, grid: Grid, step: RowStep) -> tuple[Changed, Step]:
        if isinstance(step, PutTexts):
            self._store(author, cell_edits(grid, step.cells, {}))
            return put_texts(author, grid, step.cells)
        if isinstance(step, AddRows):
            return bring(self._store, author, grid, step)
        if isinstance(step, PutThread):
            return put_thread(self._store, author, grid, step)
        if isinstance(step, PutHeader):
            return put_header(self._store, author, grid, step)
        if isinstance(step, PutLooks):
            return put_looks(self._store, author, grid, step)
        must_have(grid, step.rows)
        parts = blocks(grid, step)
        if len(parts) > 1:  # others have inserted rows between them
            return self._each(author, Batch(step.sheet, tuple(parts)))
        if isinstance(parts[0], RemoveRows):
            return remove(self._store, author, grid, parts[0])
        return shift(self._store, author, grid, parts[0])

    def _make_sheet(self, author: str, step: SheetStep) -> tuple[Changed, Step]:
        changed, inverse = make_sheet_step(self._sheets(), author, step)
        change = changed.change
        if change is not None and change.was:
            self._named[change.was] = change.name
        if change is not None and change.what != "deleted":  # whoever says that name means this sheet from now on
            self._named.pop(change.name, None)
        return changed, inverse

    def _sheets(self) -> Sheets:
        self._synchronise()
        return Sheets(self.grids, self.reading, self._store, self._renew, self.current)

    def _each(self, author: str, together: Batch) -> tuple[Changed, Step]:
        """One step after the other; when one is refused, those before it are taken back."""
        changes: list[Changed] = []
        back: list[RowStep] = []
        try:
            for step in together.steps:
                changed, inverse = self._make(author, step)
                assert not isinstance(inverse, SheetStep)
                changes.append(changed)
                back[:0] = inverse.steps if isinstance(inverse, Batch) else [inverse]
        except Refused:
            for inverse in back:
                self._make(author, inverse)
            raise
        return replace(changes[0], then=tuple(changes[1:])), Batch(together.sheet, tuple(back))

    def _fulfil(self, requests: Sequence[EditRequest]) -> None:
        """Carry out requests of several people with one patch of the file; those that do not fit together, alone."""
        before: dict[tuple[str, str, int], str] = {}
        fine: list[tuple[EditRequest, list[SetCell]]] = []
        try:
            self._synchronise()
        except SheetsError as error:
            for request in requests:
                request.error = error
            return
        for request in requests:
            try:
                fine.append((request, cell_edits(self._grid(request.sheet), request.cells, before)))
            except Refused as refused:
                request.error = refused
                continue
            before.update({(self.current(request.sheet), c.row, c.column): c.text for c in request.cells})
        self._fulfil_all(fine)

    def _fulfil_all(self, fine: Sequence[tuple[EditRequest, list[SetCell]]]) -> None:
        if not fine:
            return
        try:
            with made_for(*(ident for request, _ in fine for ident in request.requests)):
                authors = ", ".join(dict.fromkeys(r.author for r, _ in fine))
                self._store(authors, [e for _, edits in fine for e in edits])
        except SheetsError as refused:
            if len(fine) == 1:
                fine[0][0].error = refused
                return
            for one in fine:
                self._fulfil([one[0]])
            return
        for request, _ in fine:
            grid = self._grid(request.sheet)
            changed, inverse = put_texts(request.author, grid, request.cells)
            request.changed = replace(changed, grown=tuple(grid.fill_up()))
            self._steps.did(request.author, inverse)
        self._keep_rows()

    def _store(self, author: str, edits: Sequence[Edit]) -> tuple[str, ...]:
        kept = self.file.store(author, edits)
        self.version += 1
        return kept

    def _synchronise(self) -> None:
        if not self.file.has_changed():
            return
        self._outside += self._take_over()
        self.version += 1
        self._kept_rows = {}  # they are of the file before
        self._keep_rows()

    def _open(self) -> None:
        """Make the grids from the sheets in the file; the whole is understood only if one is of no known kind."""
        sheets = self.file.sheets()
        if sheets and all(recognise(sheet).kind for sheet in sheets):
            self.grids, _ = take_over({}, sheets, ())
        else:
            self._take_over()

    def _take_over(self) -> list[Changed]:
        """Bring the grids up to what the file says; rows that are the same keep their ids."""
        reading = self.reading
        tables = {*reading.workbook.tables, *self._added}
        self.grids, changes = take_over(self.grids, self.file.whole(tables), tables)
        own = tuple(name for name in reading.workbook.sheets if name not in self.grids)
        changes += [Changed(n, change=SheetChange("added", n)) for n in own if n not in self.own]
        changes += [Changed(n, change=SheetChange("deleted", n)) for n in self.own if n not in reading.workbook.sheets]
        self.own = own
        self.file.accept()
        return changes + self._take_marks()

    def _take_marks(self) -> list[Changed]:
        """Take over the comments and looks in the file; the rows that have others now."""
        changes = []
        for name, (threads, looks) in self.file.marks().items():
            grid = self.grids.get(name)
            rows = grid.marks.load(_rows_by_number(grid), threads, looks) if grid else []
            if grid and rows:
                changes.append(Changed(grid.name, touched=tuple(rows)))
        return changes

    def _renew(self, grids: Mapping[str, Grid]) -> Mapping[str, Grid]:
        self._added = self.file.added()
        self.grids, stored = dict(grids), self.file.digest
        changes = self._take_over()
        if self.file.digest != stored:  # another program has written it since
            self._outside += changes
            self._kept_rows = {}
        return self.grids

    def _grid(self, sheet: str) -> Grid:
        grid = self.grids.get(self.current(sheet))
        if grid is None:
            raise SheetMissing(self.current(sheet))
        return grid


def _rows_by_number(grid: Grid) -> dict[int, str]:
    return {grid.number(HEADER): HEADER, **{number: row for row, number in grid.numbers().items()}}


def _must_have_column(grid: Grid, columns: Sequence[int]) -> None:
    if not {c.number for c in grid.columns} >= set(columns):
        raise Refused(N_("There is no such column."), N_("Reload the page."))


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


MOST = 500  # edits that are stored at once


@dataclass
class EditRequest:
    """Cells that somebody wants to change, and the result."""

    author: str
    sheet: str
    cells: tuple[CellText, ...]
    requests: tuple[str, ...] = field(default_factory=requests_now)
    done: threading.Event = field(default_factory=threading.Event)
    changed: Changed | None = None
    error: SheetsError | None = None


class Queue:
    """Queue of edit requests. The first caller carries out all that wait by then; the others only wait."""

    def __init__(self, lock: AbstractContextManager[bool], carry_out: Callable[[Sequence[EditRequest]], None]) -> None:
        self._lock, self._carry_out = lock, carry_out
        self._waiting: deque[EditRequest] = deque()

    def ask(self, request: EditRequest) -> Changed:
        """Wait until the request is carried out; raises the error that prevented it."""
        self._waiting.append(request)
        with self._lock:
            while not request.done.is_set():
                some = [self._waiting.popleft() for _ in range(min(MOST, len(self._waiting)))]
                try:
                    self._carry_out(some)
                finally:  # whatever happens, nobody waits for ever
                    for one in some:
                        one.done.set()
        if request.error is not None:
            raise request.error
        assert request.changed is not None, "a request ended without an answer"
        return request.changed


class WorkFile:
    """A workbook's file. Its document keeps the threads apart.

    What a killed server left in the journal is stored first. Without journal the file can only be looked at.
    """

    def __init__(self, path: Path, journal: Journal | None, why: str) -> None:
        self.path = path
        self.why = why
        self._journal = journal
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
        if self._journal is None:
            raise Refused(N_("You cannot change this workbook here."), self.why)
        return self._journal

    @property
    def read_only(self) -> bool:
        """True when the file can only be looked at; `why` says why."""
        return self._journal is None

    @property
    def reading(self) -> Reading:
        """The workbook as its file said it when it was last read: its rows may be newer than those of the document."""
        if self._reading is None:
            self._read_stamp = stamp_if_there(self.path)
            self._reading = read(self.path)
            if self._reading.digest != self.digest:
                self._stamp = None  # another program wrote it at the moment when it was stored
        return self._reading

    def accept(self) -> None:
        """Take note that the document has the rows of `reading`, so that edits may be based on them."""
        self.digest, self._stamp = self.reading.digest, self._read_stamp

    def sheets(self) -> tuple[RawSheet, ...]:
        """The sheets as they stand there, without understanding them."""
        stamp = stamp_if_there(self.path)
        sheets, self.digest = raw_sheets(self.path)
        self._stamp = stamp
        return tuple(sheets)

    def whole(self, tables: Collection[str]) -> tuple[RawSheet, ...]:
        """Return the sheets of `reading`; a user's own one whose key is in `tables` is read again, to its last row."""
        sheets = self.reading.sheets
        if all(recognise(s).kind or key(s.name) not in tables for s in sheets):
            return sheets
        found = {s.name: s for s in raw_sheets(self.path)[0]}
        return tuple(s if recognise(s).kind or key(s.name) not in tables else found.get(s.name, s) for s in sheets)

    def marks(self) -> dict[str, tuple[Threads, SheetLooks]]:
        """Read the comments and the looks of cells, by sheet; there are none in texts."""
        book, _ = open_book(self.path)
        if not isinstance(book, XlsxBook):
            return {}
        styles = style_looks(book)
        return {n: (read_threads(book, i), read_looks(book, i, styles)) for i, n in enumerate(book.names)}

    def has_changed(self) -> bool:
        """Return whether another program has written other contents into it; `reading` is then the new one."""
        if stamp_if_there(self.path) == self._stamp:
            return False
        self._reading = None
        if self.reading.digest != self.digest:
            return True
        self._stamp = self._read_stamp
        return False

    def store(self, author: str, edits: Sequence[Edit]) -> tuple[str, ...]:
        """Write edits to the journal and then to the file; return what brings back deleted sheets.

        When the file does not take them, they are taken out of the journal again, and Refused is raised.
        """
        seq = self.journal.add(self.path.name, author, edits, self.digest, requests_now())
        try:
            edited = edit(self.path, edits, expected_digest=self.digest)
        except Exception as error:
            self.journal.drop(seq)
            self._stamp = None  # another program may have changed it since the last look: the next one reads it
            if isinstance(error, SheetsError):
                raise Refused(error.message, error.remedy) from error
            raise
        self.journal.stored(seq, self.path.name, edited.digest)
        self.digest, self._stamp, self._reading = edited.digest, stamp_if_there(self.path), None
        return edited.kept

    def made(self, request: str) -> bool:
        """Return whether the edit of a page's request was made, also before a restart."""
        return self._journal is not None and self._journal.made(request)

    def keep_rows(self, rows: dict[str, list[str]]) -> None:
        """Keep the ids of the rows, by sheet, for after a restart."""
        if self._journal is not None:
            self._journal.keep_rows(self.path.name, self.digest, rows)

    def kept_rows(self) -> tuple[dict[str, list[str]], list[Edit]]:
        """Return the ids of the rows, by sheet, as they were kept, and the edits made since.

        There are none when another program has changed the file while no server was running.
        """
        return self._journal.kept_rows(self.path.name, self.digest, self._recovered) if self._journal else ({}, [])

    def added(self) -> set[str]:
        """The keys of the sheets that were added here."""
        return self._journal.added(self.path.name) if self._journal else set()

    def keep_version(self, author: str, name: str) -> None:
        """Keep the file as it is now under a name; raise Refused when it is no file any more."""
        if not self.path.is_file():  # of a pipe the end would be waited for
            raise Refused(
                N_("“{name}” is not a file any more.", name=self.path.name), N_("Put the workbook there again.")
            )
        self.journal.keep_version(self.path.name, name, author, self.digest, self.path.read_bytes())

    def versions(self) -> list[Version]:
        """The named versions, the newest first."""
        return self._journal.versions(self.path.name) if self._journal else []

    def version_content(self, version: int) -> bytes | None:
        """The bytes of a version; None when there is no such version."""
        return self._journal.content(self.path.name, version) if self._journal else None

    def restore(self, author: str, version: int) -> None:
        """Make the file what it was in a version; what it is now is kept as a version too, unless it is one already.

        Raises:
            Refused: when there is no such version, or the file does not allow it.
        """
        content = self.version_content(version)
        name = next((v.name for v in self.versions() if v.id == version), "")
        if content is None:
            raise Refused(N_("This version no longer exists."), N_("Look at the list again."))
        try:
            refuse_open_file(self.path)
            stamp = stamp_of(self.path)
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


def stamp_if_there(path: Path) -> Stamp | None:
    """Return the stamp of a file, by which a change of it is noticed; None when it is not there."""
    try:
        return stamp_of(path)
    except OSError:
        return None


def write_block_reason(path: Path) -> str:
    """Return why edits of a workbook would be refused just now; empty when they would not."""
    try:
        refuse_open_file(path)
        mode = path.stat().st_mode
    except SheetsError as error:
        return N_(
            "{message} You can view it here, but not change it, so that nothing is lost. {remedy}",
            message=error.message, remedy=error.remedy,
        )  # fmt: skip
    except OSError:
        return N_("“{name}” no longer exists: it was deleted, renamed or moved. What is shown here cannot be "
                  "changed. Put it back, or go to Workbooks.", name=path.name)  # fmt: skip
    if not path.is_dir() and not mode & stat.S_IWUSR:
        return N_("“{name}” is write-protected: you can view it here, but not change it. Take the protection off in "
                  "the file's properties, or change a copy.", name=path.name)  # fmt: skip
    return ""


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
            # a mark that is lost in a crash does no harm: the file's digest tells whether the edit is in the file
            self._marks = sqlite3.connect(place / "journal.sqlite", check_same_thread=False, isolation_level=None)
            self._marks.execute("pragma synchronous = off")
        except (OSError, sqlite3.Error) as error:
            why = str(getattr(error, "strerror", None) or error)
            message = N_("Nothing can be saved in {place}: {why}.", place=str(place), why=why)
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
            message = N_("This was not saved: nothing can be saved next to the workbook now ({why}).", why=str(error))
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
