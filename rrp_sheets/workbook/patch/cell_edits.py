"""Values put into cells, and Excel's own tables (a block of cells with a header, a name and a filter) around them."""

from __future__ import annotations

from dataclasses import replace

from rrp_sheets.errors import SheetsError
from rrp_sheets.model.workbook import column_letters
from rrp_sheets.texts import N_
from rrp_sheets.workbook.edits import DeleteRows, InsertRows, RowEdit, SetCell, Value, check_value, shown
from rrp_sheets.workbook.patch.package_edit import PackageEdit
from rrp_sheets.workbook.patch.references import note
from rrp_sheets.workbook.patch.sheet_xml import block_of, block_text, is_filled
from rrp_sheets.workbook.patch.xml_part import XmlPart, child, local
from rrp_sheets.workbook.raw import Range
from rrp_sheets.workbook.xlsx import LAST_COLUMN, LAST_ROW, number


def set_cell(package: PackageEdit, edit: SetCell) -> None:
    """Write a text, number or truth value to one place of a sheet.

    Raises:
        SheetsError: where the cell does not exist, cannot hold the value, or belongs to something that would break.
    """
    index = package.index(edit.sheet)
    edit = replace(edit, sheet=package.book.names[index])
    place = edit.place
    if not (1 <= edit.row <= LAST_ROW and 1 <= edit.column <= LAST_COLUMN):
        raise SheetsError(
            N_("There is no cell {cell}.", cell=place), N_("A sheet has 1,048,576 rows and the columns A to XFD.")
        )
    value = check_value(edit.value, place)
    sheet = package.sheet(index)
    _refuse_merged(sheet.merged(), edit)
    for filled in sheet.ranges:
        if _covers(filled.block, edit) and filled.block.area > 1:
            block = block_text(filled.block)
            raise SheetsError(
                N_("{cell} belongs to {what} that fills {cells}.", cell=place, what=filled.what, cells=block),
                N_("In Excel, select {cells}, press Delete, and then set the cell.", cells=block),
            )
    tables = sheet_tables(package, index)
    for table in tables:
        _refuse_table_edges(table, edit)
    cell = sheet.cell(edit.row, edit.column)
    formula = child(cell, "f") if cell is not None else None
    if formula is not None:
        if formula.get("t") == "shared":
            sheet.write_out()
        package.formulas_moved = True
    note(package, index)
    style = sheet.style(edit.row, edit.column)
    row = sheet.row(edit.row)
    was_blank = row is None or not is_filled(row)
    sheet.set_cell(edit.row, edit.column, _fitting(package, style, value), style)
    if was_blank and value not in (None, ""):
        for table in tables:
            table.append(edit.row, edit.column)


def _fitting(package: PackageEdit, style: int, value: Value) -> Value:
    """A number goes as text into a cell that shows numbers as text, or as dates."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return value
    styles = package.book.styles
    return shown(value) if styles.is_text(style) or styles.kind(style) else value


def _covers(block: Range, edit: SetCell) -> bool:
    return block.top <= edit.row <= block.bottom and block.left <= edit.column <= block.right


def _refuse_merged(blocks: list[Range], edit: SetCell) -> None:
    for block in blocks:
        if _covers(block, edit) and (edit.row, edit.column) != (block.top, block.left):
            first = f"{column_letters(block.left)}{block.top}"
            raise SheetsError(
                N_("{cell} is hidden under {first}: the cells {cells} are merged.",
                   cell=edit.place, first=first, cells=block_text(block)),
                N_("Set {first} instead, or unmerge the cells in Excel.", first=first),
            )  # fmt: skip


def _refuse_table_edges(table: SheetTable, edit: SetCell) -> None:
    if not _covers(table.block, edit):
        return
    for row, message in (
        (table.header, N_("{cell} is in the header of the Excel table “{table}”, which would be damaged.")),
        (table.totals, N_("{cell} is in the totals row of the Excel table “{table}”, which would be damaged.")),
    ):
        if edit.row == row:
            raise SheetsError(N_(message, cell=edit.place, table=table.name), N_("Change it in Excel or LibreOffice."))


class SheetTable:
    """An Excel table (list object): its part of the package and its range.

    Attributes:
        name: as the user sees it.
        block: the cells it covers, with header and totals.
        header: the row of its header; 0 where it has none.
        totals: the row of its totals; 0 where it has none.
    """

    def __init__(self, part: XmlPart, block: Range) -> None:
        self._part = part
        attributes = part.root.attrib
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
        old = block_text(self.block)
        self.block = Range(self.block.top, self.block.left, bottom, self.block.right)
        for element in (self._part.root, child(self._part.root, "autoFilter")):
            if element is not None and element.get("ref") == old:
                element.set("ref", block_text(self.block))
                self._part.touch()


def sheet_tables(package: PackageEdit, index: int) -> list[SheetTable]:
    """The tables of a sheet as they are now."""
    parts = map(package.part, package.related(package.book.entries[index].part, "table"))
    found = ((part, block_of(part.root.get("ref", ""))) for part in parts if local(part.root) == "table")
    return [SheetTable(part, block) for part, block in found if block]
