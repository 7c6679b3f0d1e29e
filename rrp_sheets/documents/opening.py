"""The sheets of a file as grids, before anything is understood: so that a page is there at once."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path

from rrp_sheets.documents.grid import Grid, make_grid
from rrp_sheets.documents.row_changes import Changed, SheetChange
from rrp_sheets.model.names import key
from rrp_sheets.workbook.headers import recognise
from rrp_sheets.workbook.raw import Book, Extent, RawSheet
from rrp_sheets.workbook.reading import open_book

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
