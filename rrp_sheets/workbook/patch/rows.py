"""Inserting, deleting and moving rows of a sheet, with all that belongs to them; refused where it would harm."""

from __future__ import annotations

from dataclasses import replace

from rrp_sheets.errors import SheetsError
from rrp_sheets.model.cells import column_letters
from rrp_sheets.workbook.edits import InsertRows, MoveRows, RowEdit
from rrp_sheets.workbook.patch.blocks import block_of, block_text
from rrp_sheets.workbook.patch.comments import move_comments
from rrp_sheets.workbook.patch.guard import guard_references, ignored_columns
from rrp_sheets.workbook.patch.markup import find, splice, text_xml, with_attributes
from rrp_sheets.workbook.patch.package_edit import PackageEdit
from rrp_sheets.workbook.patch.range_growth import grow, note
from rrp_sheets.workbook.patch.references import Moves, adapted
from rrp_sheets.workbook.patch.row_xml import RowXml
from rrp_sheets.workbook.patch.shared import formula_elements, formula_text, write_out
from rrp_sheets.workbook.patch.sheet_xml import DATA_TABLE, SheetXml
from rrp_sheets.workbook.patch.tables import sheet_tables
from rrp_sheets.workbook.raw import Range

_LAST_ROW = 1_048_576
_MOST = 100_000


def change_rows(package: PackageEdit, edit: RowEdit) -> None:
    """Insert, delete or move rows: values, formats, heights, comments and links go with them.

    Raises:
        SheetsError: where merged cells, tables, array formulas, or references from elsewhere would be torn.
    """
    _refuse_impossible(edit)
    index = package.index(edit.sheet)
    sheet = package.sheet(index)
    name = package.book.names[index]
    edit = replace(edit, sheet=name)
    _refuse_header(package, index, edit)
    if isinstance(edit, MoveRows) and not edit.moves:
        return
    if sheet.rows and max(sheet.rows) + edit.count > _LAST_ROW and isinstance(edit, InsertRows):
        raise SheetsError(f"The last row of “{name}” is in use, so no row fits in.", "Delete rows at the end first.")
    _refuse_torn(sheet, name, edit)
    tables = sheet_tables(package, index)
    for table in tables:
        if not table.fits(edit):
            raise SheetsError(
                f"Rows cannot be changed across the edge of the Excel table “{table.name}” "
                f"({block_text(table.block)} in “{name}”).",
                "Do it in Excel or LibreOffice.",
            )
    write_out(sheet)
    note(package, index)
    moves = [(n, new) for n, row in sheet.rows.items() if row.filled and (new := edit.mapped(n)) != n]
    guard_references(package, index, edit, moves)
    _rebuild(package, index, edit, moves)
    for table in tables:
        table.follow(edit)
    move_comments(package, index, edit)
    grow(package, index)
    package.renew(index)


def _refuse_impossible(edit: RowEdit) -> None:
    before = edit.before if isinstance(edit, MoveRows) else edit.start
    if edit.start < 1 or edit.count < 1 or max(edit.start, before) > _LAST_ROW + 1 or edit.count > _MOST:
        raise SheetsError("There are no such rows.", "Rows count from 1; name at least one.")


def _refuse_header(package: PackageEdit, index: int, edit: RowEdit) -> None:
    recognised = package.recognised(index)
    if recognised.kind is not None and edit.start <= recognised.row:
        raise SheetsError(
            f"Row {recognised.row} of “{package.book.names[index]}” holds the headers; they and what is above them "
            "stay where they are.",
            f"Choose rows from {recognised.row + 1} on.",
        )


def _refuse_torn(sheet: SheetXml, name: str, edit: RowEdit) -> None:
    """Refuse where blocks of cells that belong together would be moved or torn apart."""
    blocks = [(b, "the merged cells", "Unmerge them in Excel first.") for b in sheet.merged() if b.area > 1]
    blocks += [
        (r.block, r.what, "Do it in Excel or LibreOffice.")
        for r in sheet.ranges
        if r.block.top != r.block.bottom or r.what == DATA_TABLE
    ]
    for block, what, remedy in blocks:
        if any(edit.mapped(row) != row for row in (block.top, block.bottom)) or block.top < edit.start <= block.bottom:
            raise SheetsError(
                f"These rows of “{name}” cannot be changed: {what} {block_text(block)} would be torn or moved.", remedy
            )
    filtered = sheet.element("autoFilter")
    head = block_of(filtered.attributes.get("ref", "")) if filtered else None
    if head and edit.mapped(head.top) != head.top:
        raise SheetsError(
            f"Row {head.top} of “{name}” is the head of a filter.", "Remove the filter in Excel first (Data, Filter)."
        )


def _rebuild(package: PackageEdit, index: int, edit: RowEdit, moves: Moves) -> None:
    sheet = package.sheet(index)
    if isinstance(edit, InsertRows):
        pattern = _pattern(package, index, edit.before)
    ignored = ignored_columns(package, index)
    rows: dict[int, RowXml] = {}
    for number, row in sheet.rows.items():
        new = edit.mapped(number)
        if row.formulas:
            if new is not None:
                _adapt(row, edit, moves, ignored)
            package.formulas_moved = package.formulas_moved or new != number
        if new is not None:
            rows[new] = row if new == number else row.renumbered(new)
    if isinstance(edit, InsertRows) and pattern is not None:
        for number in range(edit.before, edit.before + edit.count):
            rows[number] = pattern.renumbered(number)
    sheet.take(rows)
    _move_links(sheet, edit)


def _adapt(row: RowXml, edit: RowEdit, moves: Moves, ignored: frozenset[int]) -> None:
    """Let the formulas of a row follow the rows that they refer to."""
    changes = []
    for column, f in formula_elements(row):
        text = formula_text(row, f)
        new = text if column in ignored else adapted(text, edit.sheet, edit, moves)
        if new != text:
            changes.append((f.inner, f.inner_end, text_xml(new)))
        block = block_of(f.attributes.get("ref", ""))
        number = edit.mapped(row.number)
        if block and number is not None and number != row.number:  # an array formula within its row
            ref = block_text(Range(number, block.left, number, block.right))
            changes.append((f.start, f.inner, with_attributes(row.raw[f.start : f.inner], {"ref": ref})))
    row.raw = splice(row.raw, changes)


def _pattern(package: PackageEdit, index: int, before: int) -> RowXml | None:
    """A blank row that looks like the one above the place, or below it where that is the header."""
    sheet, header = package.sheet(index), package.recognised(index).row
    source = sheet.rows.get(before - 1) if before - 1 > header else sheet.rows.get(before)
    if source is None:
        return None
    tag = source.tag
    named = {"hidden": None, "collapsed": None, "spans": None}
    if tag.attributes.get("customHeight") not in ("1", "true"):
        named["ht"] = None
    out = [with_attributes(source.raw[: tag.inner], named).removesuffix(b">").removesuffix(b"/") + b">"]
    for cell in source.cells():
        if style := cell.element.attributes.get("s"):
            out.append(f'<{cell.element.name} r="{column_letters(cell.column)}{source.number}" s="{style}"/>'.encode())
    raw = b"".join([*out, f"</{tag.name}>".encode()])
    return RowXml(source.number, raw, b"", bool(find(raw, lambda path: len(path) == 2)))


def _move_links(sheet: SheetXml, edit: RowEdit) -> None:
    """Hyperlinks stay with their cells; those of deleted rows go."""
    links = sheet.all("hyperlink")
    gone = []
    for link in links:
        block = block_of(link.attributes.get("ref", ""))
        if block is None or block.top != block.bottom:
            continue
        new = edit.mapped(block.top)
        if new is None:
            gone.append(link)
        elif new != block.top:
            sheet.retag(link, {"ref": block_text(Range(new, block.left, new, block.right))})
    holder = sheet.element("hyperlinks")
    if gone and len(gone) == len(links) and holder is not None:
        sheet.replace(holder, b"")  # an empty list is not allowed
    else:
        for link in gone:
            sheet.replace(link, b"")
