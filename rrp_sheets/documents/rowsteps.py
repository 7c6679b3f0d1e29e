"""Inserting, deleting and moving rows: in the file first, then in the grid; each gives the step that takes it back."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import groupby

from rrp_sheets.documents.changes import Changed, Refused
from rrp_sheets.documents.grid import Grid
from rrp_sheets.documents.undo import Moved, RemoveRows, RestoreRows, Step
from rrp_sheets.workbook.edits import DeleteRows, Edit, InsertRows, MoveRows, SetCell
from rrp_sheets.workbook.patch.values import typed

Store = Callable[[str, Sequence[Edit]], object]
"""Puts an author's edits into the file; raises Refused when it does not take them."""


def bring(store: Store, author: str, grid: Grid, step: RestoreRows) -> tuple[Changed, Step]:
    """Insert rows, with their texts when they were deleted before."""
    place = grid.place(step.before)
    number = grid.first + place
    ids = [row for row, _ in step.rows]
    insert = InsertRows(grid.name, number, len(ids))
    texts = [
        SetCell(grid.name, number + i, column, typed(text))
        for i, (_, cells) in enumerate(step.rows)
        for column, text in cells.items()
    ]
    store(author, [insert, *texts])
    grid.carry_out(insert, ids)
    for row, cells in step.rows:
        for column, text in cells.items():
            grid.put(row, column, text)
    back = RemoveRows(grid.name, tuple(ids), tuple(cells for _, cells in step.rows))
    return Changed(grid.name, inserted=tuple((row, step.before) for row in ids)), back


def remove(store: Store, author: str, grid: Grid, step: RemoveRows) -> tuple[Changed, Step]:
    """Delete rows that follow each other.

    Raises:
        Refused: when somebody has changed one of them since it came.
    """
    _unchanged(author, grid, step)
    place, count = grid.place(step.rows[0]), len(step.rows)
    first = grid.first + place
    gone = tuple((row, dict(grid.texts[row])) for row in grid.rows[place : place + count])
    removal = DeleteRows(grid.name, first, count)
    store(author, [removal])
    grid.carry_out(removal)
    removed = tuple(row for row, _ in gone)
    return Changed(grid.name, removed=removed), RestoreRows(grid.name, gone, grid.before(place))


def shift(store: Store, author: str, grid: Grid, step: Moved) -> tuple[Changed, Step]:
    """Move rows that follow each other."""
    place, count = grid.place(step.rows[0]), len(step.rows)
    first, after = grid.first + place, grid.before(place + count)
    target = grid.first + grid.place(step.before)
    move = MoveRows(grid.name, first, count, target)
    if move.moves:
        store(author, [move])
        grid.carry_out(move)
    return Changed(grid.name, moved=tuple((row, step.before) for row in step.rows)), Moved(grid.name, step.rows, after)


def blocks(grid: Grid, step: RemoveRows | Moved) -> list[RemoveRows] | list[Moved]:
    """A step of rows as one step for each of those that follow each other: others may have come between them."""
    places = sorted({grid.place(row) for row in step.rows})
    groups = [list(group) for _, group in groupby(enumerate(places), lambda pair: pair[1] - pair[0])]
    parts = [tuple(grid.rows[place] for _, place in group) for group in groups]
    if isinstance(step, Moved):
        return [replace(step, rows=rows) for rows in parts]
    if step.texts is None:
        return [replace(step, rows=rows) for rows in parts]
    texts = dict(zip(step.rows, step.texts, strict=True))
    return [replace(step, rows=rows, texts=tuple(texts[row] for row in rows)) for rows in parts]


def _unchanged(author: str, grid: Grid, step: RemoveRows) -> None:
    for row, texts in zip(step.rows, step.texts or (), strict=False):
        now = grid.texts[row]
        others = (grid.authors.get((row, c)) for c in {*now, *texts} if now.get(c, "") != texts.get(c, ""))
        by = next((who for who in others if who != author), author)
        if by != author:
            who = by or "Another program"
            raise Refused(f"{who} has changed row {grid.number(row)} since, so it stays.", "Delete it if it is to go.")
