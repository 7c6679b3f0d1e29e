"""Setting a cell of a sheet, and refusing where that would break something else in it."""

from __future__ import annotations

from dataclasses import replace

from rrp_sheets.errors import SheetsError
from rrp_sheets.model.cells import column_letters
from rrp_sheets.workbook.edits import SetCell, Value
from rrp_sheets.workbook.patch.blocks import block_text
from rrp_sheets.workbook.patch.package_edit import PackageEdit
from rrp_sheets.workbook.patch.range_growth import note
from rrp_sheets.workbook.patch.shared import write_out
from rrp_sheets.workbook.patch.tables import SheetTable, sheet_tables
from rrp_sheets.workbook.patch.values import check_value, shown
from rrp_sheets.workbook.raw import Range

LAST_ROW, LAST_COLUMN = 1_048_576, 16_384


def set_cell(package: PackageEdit, edit: SetCell) -> None:
    """Set a cell.

    Raises:
        SheetsError: where the cell does not exist, cannot hold the value, or belongs to something that would break.
    """
    index = package.index(edit.sheet)
    edit = replace(edit, sheet=package.book.names[index])
    place = edit.place
    if not (1 <= edit.row <= LAST_ROW and 1 <= edit.column <= LAST_COLUMN):
        raise SheetsError(f"There is no cell {place}.", "A sheet has 1,048,576 rows and the columns A to XFD.")
    value = check_value(edit.value, place)
    sheet = package.sheet(index)
    _refuse_merged(sheet.merged(), edit)
    for formula in sheet.ranges:
        if _covers(formula.block, edit) and formula.block.area > 1:
            block = block_text(formula.block)
            raise SheetsError(
                f"{place} belongs to {formula.what} that fills {block}.",
                f"In Excel, select {block}, press Delete, and then set the cell.",
            )
    tables = sheet_tables(package, index)
    for table in tables:
        _refuse_table_edges(table, edit)
    cell = sheet.cell(edit.row, edit.column)
    if cell is not None and cell.formula is not None:
        if cell.formula.get("t") == "shared":
            write_out(sheet)
            sheet = package.renew(index)
        package.formulas_moved = True
    note(package, index)
    style = sheet.style(edit.row, edit.column)
    was_blank = not any(
        c.element.end > c.element.inner for c in (sheet.rows[edit.row].cells() if edit.row in sheet.rows else ())
    )
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
                f"{edit.place} is hidden under {first}: the cells {block_text(block)} are merged.",
                f"Set {first} instead, or unmerge the cells in Excel.",
            )


def _refuse_table_edges(table: SheetTable, edit: SetCell) -> None:
    if not _covers(table.block, edit):
        return
    for row, what in ((table.header, "the header"), (table.totals, "the totals row")):
        if edit.row == row:
            raise SheetsError(
                f"{edit.place} is in {what} of the Excel table “{table.name}”, which would be damaged.",
                "Change it in Excel or LibreOffice.",
            )
