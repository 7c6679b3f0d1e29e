"""Workbook under edit by several people: edits are queued, checked, journalled and stored, and can be undone."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path

from rrp_sheets.documents.grid import (
    Batch,
    Cells,
    CellText,
    Changed,
    Grid,
    Moved,
    Refused,
    RemoveRows,
    RestoreRows,
    RowStep,
    SheetChange,
    blocks,
    bring,
    cell_edits,
    must_have,
    put_texts,
    remove,
    shift,
)
from rrp_sheets.documents.sheet_edits import SheetEdits, SheetIn, Sheets, SheetStep, make_sheet_step
from rrp_sheets.documents.workfile import Journal, WorkFile, made_for, requests_now, take_over
from rrp_sheets.errors import SheetsError
from rrp_sheets.texts import N_
from rrp_sheets.workbook import Reading
from rrp_sheets.workbook.edits import Edit, SetCell
from rrp_sheets.workbook.schema import recognise

Step = RowStep | Batch | SheetStep
MOST_BACK = 500  # steps that a person can undo


class Steps:
    """Steps of each person that can be undone, and those that were undone and can be made again."""

    def __init__(self) -> None:
        self._back: dict[str, list[Step]] = {}
        self._again: dict[str, list[Step]] = {}

    def did(self, author: str, step: Step) -> None:
        """Note a new step; what was undone before it cannot be made again."""
        self.put(author, step, again=False)
        self._again.pop(author, None)

    def put(self, author: str, step: Step, *, again: bool) -> None:
        """Put the newest step to undo, or to make again."""
        pile = (self._again if again else self._back).setdefault(author, [])
        pile.append(step)
        del pile[:-MOST_BACK]

    def take(self, author: str, *, again: bool) -> Step | None:
        """Remove and return the newest step to undo, or to make again; None when there is none."""
        pile = (self._again if again else self._back).get(author)
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

    def together(self, author: str, steps: Sequence[Cells | RestoreRows]) -> Changed:
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
            return self._new(author, RestoreRows(sheet, made, before))

    def delete(self, author: str, sheet: str, rows: Sequence[str]) -> Changed:
        """Delete rows with everything in them."""
        return self._new(author, RemoveRows(sheet, tuple(rows)))

    def move(self, author: str, sheet: str, rows: Sequence[str], before: str | None) -> Changed:
        """Move rows before another one; None: to the end."""
        return self._new(author, Moved(sheet, tuple(rows), before))

    def current(self, sheet: str) -> str:
        """The name that a sheet has now, which may be another one than a page still shows."""
        for _ in range(len(self._named)):
            if sheet in self._named:
                sheet = self._named[sheet]
        return sheet

    def undo(self, author: str, *, again: bool = False) -> Changed | None:
        """Take back one's own newest edit (or make it again); None when there is nothing to take back."""
        with self._changing():
            step = self._steps.take(author, again=again)
            if step is None:
                return None
            try:
                changed, inverse = self._make(author, step)
            except Refused:  # it can be tried again when the reason is gone
                self._steps.put(author, step, again=again)
                raise
            self._steps.put(author, inverse, again=not again)
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
        if isinstance(step, Cells):
            self._store(author, cell_edits(grid, step.back, {}))
            return put_texts(author, grid, step.back)
        if isinstance(step, RestoreRows):
            return bring(self._store, author, grid, step)
        must_have(grid, step.rows)
        parts = blocks(grid, step)
        if len(parts) > 1:  # others have inserted rows between them
            return self._each(author, Batch(step.sheet, tuple(parts)))
        if isinstance(parts[0], RemoveRows):
            return remove(self._store, author, grid, parts[0])
        return shift(self._store, author, grid, parts[0])

    def _make_sheet(self, author: str, step: SheetStep) -> tuple[Changed, Step]:
        if not isinstance(step, SheetIn):
            step = replace(step, sheet=self.current(step.sheet))
        changed, inverse = make_sheet_step(self._sheets(), author, step)
        change = changed.change
        if change is not None and change.was:
            self._named[change.was] = change.name
        if change is not None and change.what != "deleted":  # whoever says that name means this sheet from now on
            self._named.pop(change.name, None)
        return changed, inverse

    def _sheets(self) -> Sheets:
        self._synchronise()
        return Sheets(self.grids, self.reading, self._store, self._renew)

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
        self.version += 1
        self._outside += self._take_over()

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
        return changes

    def _renew(self, grids: Mapping[str, Grid]) -> Mapping[str, Grid]:
        self._added = self.file.added()
        self.grids, stored = dict(grids), self.file.digest
        changes = self._take_over()
        if self.file.digest != stored:  # another program has written it since
            self._outside += changes
        return self.grids

    def _grid(self, sheet: str) -> Grid:
        grid = self.grids.get(self.current(sheet))
        if grid is None:
            raise Refused(N_("There is no sheet “{sheet}” any more.", sheet=sheet), N_("Reload the page."))
        return grid


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
