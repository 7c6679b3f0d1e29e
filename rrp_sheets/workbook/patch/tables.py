"""Excel's own tables (a block of cells with a header, a name and a filter): what they cover, and how they grow."""

from __future__ import annotations

from collections.abc import Mapping

from rrp_sheets.workbook.edits import DeleteRows, InsertRows, RowEdit
from rrp_sheets.workbook.patch.blocks import block_of, block_text
from rrp_sheets.workbook.patch.markup import as_utf8, find, splice, with_attributes
from rrp_sheets.workbook.patch.package_edit import PackageEdit
from rrp_sheets.workbook.raw import Range
from rrp_sheets.workbook.xlsx_parts import number


class SheetTable:
    """An Excel table (list object): its part of the package and its range.

    Attributes:
        name: as the user sees it.
        block: the cells it covers, with header and totals.
        header: the row of its header; 0 where it has none.
        totals: the row of its totals; 0 where it has none.
    """

    def __init__(self, package: PackageEdit, part: str, attributes: Mapping[str, str], block: Range) -> None:
        self._package, self._part = package, part
        self.name = attributes.get("displayName") or attributes.get("name", "")
        self.block = block
        self.header = block.top if number(attributes.get("headerRowCount"), 1) else 0
        self.totals = block.bottom if number(attributes.get("totalsRowCount")) else 0

    def append(self, row: int, column: int) -> None:
        """Take in the row directly below, as Excel does when one types there."""
        if not self.totals and row == self.block.bottom + 1 and self.block.left <= column <= self.block.right:
            self._resize(row)

    def fits(self, edit: RowEdit) -> bool:
        """Return whether an edit of rows leaves the table whole: header and totals in place, its rows inside."""
        top = self.block.top + (1 if self.header else 0)
        bottom = self.block.bottom - (1 if self.totals else 0)
        if isinstance(edit, InsertRows):
            return edit.before > self.block.bottom or (top <= edit.before <= bottom and not self.totals)
        if isinstance(edit, DeleteRows):
            last = edit.first + edit.count - 1
            inside = top <= edit.first and last <= bottom and edit.count < bottom - top + 1 and not self.totals
            return edit.first > self.block.bottom or inside
        rows = [r for r in range(self.block.top, self.block.bottom + 1) if edit.mapped(r) != r]
        low, high = edit.start, max(edit.before - 1, edit.first + edit.count - 1)
        return not rows or (top <= low and high <= bottom)

    def follow(self, edit: RowEdit) -> None:
        """Grow or shrink with rows that are inserted or deleted inside."""
        if isinstance(edit, InsertRows) and edit.before <= self.block.bottom:
            self._resize(self.block.bottom + edit.count)
        if isinstance(edit, DeleteRows) and edit.first <= self.block.bottom:
            self._resize(self.block.bottom - edit.count)

    def _resize(self, bottom: int) -> None:
        data = as_utf8(self._package.read(self._part))
        old = block_text(self.block)
        self.block = Range(self.block.top, self.block.left, bottom, self.block.right)
        changes = [
            (e.start, e.inner, with_attributes(data[e.start : e.inner], {"ref": block_text(self.block)}))
            for e in find(data, lambda path: path in (["table"], ["table", "autoFilter"]))
            if e.attributes.get("ref") == old
        ]
        self._package.write(self._part, splice(data, changes))


def sheet_tables(package: PackageEdit, index: int) -> list[SheetTable]:
    """The tables of a sheet as they are now."""
    tables = []
    for part in package.related(package.book.entries[index].part, "table"):
        for e in find(as_utf8(package.read(part)), lambda path: path == ["table"]):
            block = block_of(e.attributes.get("ref", ""))
            if block:
                tables.append(SheetTable(package, part, e.attributes, block))
    return tables
