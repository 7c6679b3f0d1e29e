"""Changing cells: looked at before it is stored, and put into the grid after."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rrp_sheets.documents.changes import CellText, Changed, Clash, Refused
from rrp_sheets.documents.grid import Grid
from rrp_sheets.documents.refusals import clash, must_have
from rrp_sheets.documents.undo import Cells
from rrp_sheets.workbook.edits import SetCell
from rrp_sheets.workbook.patch.values import typed


def cell_edits(grid: Grid, cells: Sequence[CellText], before: Mapping[tuple[str, str, int], str]) -> list[SetCell]:
    """What the cells are in the file; `before`: texts that come before them and are not in the grid yet.

    Raises:
        Refused: when someone has changed one of them meanwhile, or it is gone.
    """
    must_have(grid, [c.row for c in cells])
    columns = {c.number for c in grid.columns}
    if any(c.column not in columns for c in cells):
        raise Refused("There is no such column.", "Reload the page.")
    clashes = []
    for c in cells:
        now = before.get((grid.name, c.row, c.column), grid.text(c.row, c.column))
        if c.was is not None and now not in (c.was, c.text):
            clashes.append(Clash(c.row, c.column, c.text, now, grid.authors.get((c.row, c.column), "")))
    if clashes:
        raise clash(grid, clashes)
    numbers = grid.numbers()
    return [SetCell(grid.name, numbers[c.row], c.column, typed(c.text)) for c in cells]


def put_texts(author: str, grid: Grid, cells: Sequence[CellText]) -> tuple[Changed, Cells]:
    """Texts that are in the file already into the grid; and the step back."""
    back = tuple(CellText(c.row, c.column, grid.text(c.row, c.column), c.text) for c in cells)
    for c in cells:
        grid.put(c.row, c.column, c.text)
        grid.authors[c.row, c.column] = author
    rows, places = dict.fromkeys(c.row for c in cells), tuple((c.row, c.column) for c in cells)
    return Changed(grid.name, touched=tuple(rows), cells=places), Cells(grid.name, back)
