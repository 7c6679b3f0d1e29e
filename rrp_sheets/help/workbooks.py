"""Small workbooks that help pages show, checked from their text without a file."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from rrp_sheets.help.layout import grid

if TYPE_CHECKING:
    from rrp_sheets.checks import Checked


def checked(markdown: str) -> Checked:
    """A Markdown workbook, read and checked."""
    from rrp_sheets.checks import check_workbook
    from rrp_sheets.workbook.reading import Reader
    from rrp_sheets.workbook.text_books import read_markdown

    reader = Reader(read_markdown(markdown.encode(), "help"), "help")
    return check_workbook(reader.workbook, reader.report)


def grids(markdown: str) -> Iterator[str]:
    """Every sheet of a Markdown workbook as a grid."""
    from rrp_sheets.workbook.raw import Extent
    from rrp_sheets.workbook.text_books import read_markdown

    book = read_markdown(markdown.encode(), "help")
    for index, name in enumerate(book.names):
        cells = book.sheet(index, Extent.WHOLE).cells
        bottom, right = max(row for row, _ in cells), max(column for _, column in cells)
        texts = {at: cell.text for at, cell in cells.items()}
        yield grid(name, [[texts.get((r, c), "") for c in range(1, right + 1)] for r in range(1, bottom + 1)])
