"""The user's own sheets, which the robot does not read: shown as they are, to be read only."""

from __future__ import annotations

from dataclasses import replace

from rrp_sheets.documents import Document
from rrp_sheets.documents.grid import Column, Grid
from rrp_sheets.web.pages import GridPage, Panels
from rrp_sheets.web.row_renderer import RowRenderer
from rrp_sheets.web.sheet_tabs import strip_of

MOST_ROWS, MOST_COLUMNS = 2_000, 60


def own_page(page: GridPage, panels: Panels, document: Document, name: str) -> GridPage:
    """The page of a sheet of the user's own; `page` is that of another sheet of the workbook."""
    grid = own_grid(document, name)
    maker = RowRenderer(grid)
    return replace(
        page, panels=panels, sheet=name, kind="own", first=1, heads=tuple(maker.heads()), examples=False,
        count=len(grid.rows), rows=maker.rows(0, MOST_ROWS),
        strip=strip_of(document, page.name, name),
    )  # fmt: skip


def own_grid(document: Document, name: str) -> Grid:
    """The texts of a sheet of the user's own, from its first cell on."""
    sheet = next(s for s in document.reading.sheets if s.name == name)
    width = min(max((column for _, column in sheet.cells), default=1), MOST_COLUMNS)
    grid = Grid(name, "own", 1, tuple(Column(number, "") for number in range(1, width + 1)))
    grid.load(sheet)
    del grid.rows[MOST_ROWS:]
    return grid
