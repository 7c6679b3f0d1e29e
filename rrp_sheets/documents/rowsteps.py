"""Inserting, deleting and moving rows: in the file first, then in the grid; each gives the step that takes it back."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import groupby

from rrp_sheets.documents.changes import Changed, Refused
from rrp_sheets.documents.grid import Grid
from rrp_sheets.documents.undo import Added, Gone, Moved, Step
from rrp_sheets.workbook.edits import DeleteRows, Edit, InsertRows, MoveRows, SetCell
from rrp_sheets.workbook.patch.values import typed

Store = Callable[[str, Sequence[Edit]], object]
"""Puts an author's edits into the file; raises Refused when it does not take them."""


def bring(store: Store, author: str, grid: Grid, step: Gone) -> tuple[Changed, Step]:
    """Insert rows, with their texts when they were deleted before."""
    place = grid.rows.index(step.before) if step.before and grid.has(step.before) else len(grid.rows)
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
    return Changed(grid.name, inserted=tuple((row, step.before) for row in ids)), Added(grid.name, tuple(ids))


def remove(store: Store, author: str, grid: Grid, step: Added) -> tuple[Changed, Step]:
    """Delete rows."""
    blocks = _blocks(sorted(grid.number(row) for row in step.rows))
    if len(blocks) > 1:
        raise Refused("Only rows that follow each other can be deleted at once.", "Delete them one block at a time.")
    first, count = blocks[0]
    place = first - grid.first
    gone = tuple((row, dict(grid.texts[row])) for row in grid.rows[place : place + count])
    removal = DeleteRows(grid.name, first, count)
    store(author, [removal])
    grid.carry_out(removal)
    removed = tuple(row for row, _ in gone)
    return Changed(grid.name, removed=removed), Gone(grid.name, gone, grid.before(place))


def shift(store: Store, author: str, grid: Grid, step: Moved) -> tuple[Changed, Step]:
    """Move rows."""
    blocks = _blocks(sorted(grid.number(row) for row in step.rows))
    if len(blocks) > 1:
        raise Refused("Only rows that follow each other can be moved at once.", "Move them one block at a time.")
    first, count = blocks[0]
    after = grid.before(first - grid.first + count)
    target = grid.number(step.before) if step.before and grid.has(step.before) else grid.first + len(grid.rows)
    move = MoveRows(grid.name, first, count, target)
    if move.moves:
        store(author, [move])
        grid.carry_out(move)
    return Changed(grid.name, moved=tuple((row, step.before) for row in step.rows)), Moved(grid.name, step.rows, after)


def _blocks(numbers: list[int]) -> list[tuple[int, int]]:
    """Consecutive numbers as (first, count).

    >>> _blocks([2, 3, 5])
    [(2, 2), (5, 1)]
    """
    blocks = []
    for _, group in groupby(enumerate(numbers), lambda pair: pair[1] - pair[0]):
        members = [n for _, n in group]
        blocks.append((members[0], len(members)))
    return blocks
