"""Inserting, deleting and moving rows of a sheet, with all that belongs to them; refused where it would harm."""

from __future__ import annotations

import html
import re
from collections.abc import Iterator
from copy import deepcopy
from dataclasses import replace

from lxml import etree

from rrp_sheets.errors import SheetsError
from rrp_sheets.model.workbook import column_letters
from rrp_sheets.texts import N_, capital
from rrp_sheets.workbook.edits import InsertRows, MoveRows, RowEdit
from rrp_sheets.workbook.patch import package_edit as xml
from rrp_sheets.workbook.patch.package_edit import PackageEdit, sheet_tables
from rrp_sheets.workbook.patch.references import Moves, ReferenceConflict, adapted, check, follows, grow, references
from rrp_sheets.workbook.raw import Range
from rrp_sheets.workbook.schema import LIST_PREFIX
from rrp_sheets.workbook.sheet_names import header_row
from rrp_sheets.workbook.xlsx import LAST_ROW, block_of, place

_MOST = 100_000
_ELSEWHERE = N_("Do it in Excel or LibreOffice.")
SHAPE = re.compile(rb"<v:shape\b.*?</v:shape>", re.DOTALL)
_NOTE = re.compile(rb"""ObjectType\s*=\s*["']Note["']""")
_ROW = re.compile(rb"(<x:Row>\s*)(\d+)(\s*</x:Row>)")
_ANCHOR = re.compile(rb"(<x:Anchor>)([^<]*)(</x:Anchor>)")
_STAYING = ("_xlnm.print_area", "_xlnm.print_titles", "_xlnm._filterdatabase")


def change_rows(package: PackageEdit, edit: RowEdit) -> None:
    """Insert, delete or move rows: values, formats, heights, comments and links go with them.

    Raises SheetsError where merged cells, tables, array formulas, or references from elsewhere would be torn.
    """
    before = edit.before if isinstance(edit, MoveRows) else edit.start
    if edit.start < 1 or edit.count < 1 or max(edit.start, before) > LAST_ROW + 1 or edit.count > _MOST:
        raise SheetsError(N_("There are no such rows."), N_("Rows count from 1; name at least one."))
    index = package.index(edit.sheet)
    sheet, name, recognised = package.sheet(index), package.book.names[index], package.recognised(index)
    edit = replace(edit, sheet=name)
    if recognised.kind is not None and edit.start <= recognised.row:
        raise header_row(name, recognised.row)
    if isinstance(edit, MoveRows) and not edit.moves:
        return
    if isinstance(edit, InsertRows) and sheet.last and sheet.last + edit.count > LAST_ROW:
        message = N_("The last row of “{sheet}” is in use, so no row fits in.", sheet=name)
        raise SheetsError(message, N_("Delete rows at the end first."))
    _refuse_torn(sheet, name, edit)
    tables = sheet_tables(package, index)
    for table in tables:
        if not table.fits(edit):
            message = N_("Rows cannot be changed across the edge of the Excel table “{table}” ({cells} in “{sheet}”).",
                         table=table.name, cells=xml.block_text(table.block), sheet=name)  # fmt: skip
            raise SheetsError(message, _ELSEWHERE)
    sheet.write_out()
    package.note_end(index)
    filled = (n for block in sheet.walk(edit.start) for n, row in block.rows.items() if xml.is_filled(row))
    moves = [(n, new) for n in filled if (new := edit.mapped(n)) != n]
    guard_references(package, index, edit, moves)
    _rebuild(package, index, edit, moves)
    for table in tables:
        table.follow(edit)
    move_comments(package, index, edit)
    grow(package, index)


def _refuse_torn(sheet: xml.SheetXml, name: str, edit: RowEdit) -> None:
    """Refuse where blocks of cells that belong together would be moved or torn apart."""
    unmerge = N_("Unmerge them in Excel first.")
    blocks: list[tuple[Range, str, str]] = [(b, N_("the merged cells"), unmerge) for b in sheet.merged() if b.area > 1]
    blocks += [(b, what, _ELSEWHERE) for b, what in sheet.ranges if b.top != b.bottom or what == xml.DATA_TABLE]
    for block, what, remedy in blocks:
        if any(edit.mapped(row) != row for row in (block.top, block.bottom)) or block.top < edit.start <= block.bottom:
            message = N_("These rows of “{sheet}” cannot be changed: {what} {cells} would be torn or moved.",
                         sheet=name, what=what, cells=xml.block_text(block))  # fmt: skip
            raise SheetsError(message, remedy)
    filtered = xml.child(sheet.root, "autoFilter")
    head = block_of(filtered.get("ref", "")) if filtered is not None else None
    if head and edit.mapped(head.top) != head.top:
        message = N_("Row {row} of “{sheet}” is the head of a filter.", row=head.top, sheet=name)
        raise SheetsError(message, N_("Remove the filter in Excel first (Data, Filter)."))


def _rebuild(package: PackageEdit, index: int, edit: RowEdit, moves: Moves) -> None:
    sheet = package.sheet(index)
    pattern = _pattern(package, index, edit.before) if isinstance(edit, InsertRows) else None
    ignored = ignored_columns(package, index)
    elsewhere: dict[int, etree._Element] = {}
    for block in sheet.walk():
        if block.has_formulas:
            for number, row in block.rows.items():
                if next(row.iter("{*}f"), None) is not None:
                    package.formulas_moved = package.formulas_moved or edit.mapped(number) != number
                    if _adapt(row, number, edit, moves, ignored):
                        block.touch()
        if block is not sheet.blocks[-1] and sheet.blocks[sheet.blocks.index(block) + 1].first <= edit.start:
            continue
        stay = {}
        for number, row in block.rows.items():
            if isinstance(edit, MoveRows) and edit.first <= number < edit.first + edit.count:
                elsewhere[number] = row
            elif (new := edit.mapped(number)) is not None:
                stay[new] = row
        counting = any(row.get("r") is None for row in block.rows.values())  # on from rows that may now be others
        if counting or list(stay) != list(block.rows) or list(stay.values()) != list(block.rows.values()):
            block.take(stay)
    if isinstance(edit, InsertRows) and pattern is not None:
        places = range(edit.before, edit.before + edit.count)
        sheet.insert(edit.before, (xml.renumber(deepcopy(pattern), number) for number in places))
    if isinstance(edit, MoveRows) and elsewhere:
        placed = {new: row for n, row in elsewhere.items() if (new := edit.mapped(n)) is not None}
        sheet.insert(min(placed), (xml.renumber(row, n) for n, row in placed.items()))
    sheet.rows_changed()
    _move_links(sheet, edit)


def _pattern(package: PackageEdit, index: int, before: int) -> etree._Element | None:
    """A blank row that looks like the one above the place, or below it where that is the header."""
    sheet, header = package.sheet(index), package.recognised(index).row
    source = sheet.row(before - 1 if before - 1 > header else before)
    return None if source is None else xml.blank_like(source)


def _adapt(row: etree._Element, number: int, edit: RowEdit, moves: Moves, ignored: frozenset[int]) -> bool:
    """Let the formulas of a row follow the rows that they refer to; False where none changes."""
    new_number, changed = edit.mapped(number), False
    for column, cell in xml.cells(row) if new_number is not None else ():
        f = xml.child(cell, "f")
        if f is None:
            continue
        text = xml.text_of(f)
        new = text if column in ignored else adapted(text, edit.sheet, edit, moves)
        if new != text:
            xml.set_text(f, new)
            changed = True
        block = block_of(f.get("ref", ""))
        if block and new_number is not None and new_number != number:  # an array formula within its row
            f.set("ref", xml.block_text(Range(new_number, block.left, new_number, block.right)))
            changed = True
    return changed


def _move_links(sheet: xml.SheetXml, edit: RowEdit) -> None:
    """Hyperlinks stay with their cells; those of deleted rows go."""
    for link in sheet.elements("hyperlink"):
        block = block_of(link.get("ref", ""))
        if block is None or block.top != block.bottom:
            continue
        new = edit.mapped(block.top)
        if new is None:
            xml.remove(link)
        elif new != block.top:
            link.set("ref", xml.block_text(Range(new, block.left, new, block.right)))
    holder = xml.child(sheet.root, "hyperlinks")
    if holder is not None and not len(holder):
        sheet.root.remove(holder)  # an empty list is not allowed


def move_comments(package: PackageEdit, index: int, edit: RowEdit) -> None:
    """Let all comments of a sheet go where their rows go; those of deleted rows go away."""
    part = package.book.entries[index].part
    for kind, local in (("comments", "comment"), ("threadedcomment", "threadedComment")):
        for target in package.related(part, kind):
            for holder, e in package.part(target).find(local):
                at = place(e.get("ref", ""))
                if not at or (new := edit.mapped(at[0])) == at[0]:
                    continue
                if new is None:
                    xml.remove(e)
                else:
                    e.set("ref", f"{column_letters(at[1])}{new}")
                holder.touch()
    for target in package.related(part, "vmldrawing"):
        old = package.read(target)
        if (moved := SHAPE.sub(lambda shape: _moved_box(shape[0], edit), old)) != old:
            package.write(target, moved)


def _moved_box(shape: bytes, edit: RowEdit) -> bytes:
    """The box of a comment, moved by as many rows as its cell; other shapes (buttons, say) stay."""
    row = _ROW.search(shape)
    if row is None or not is_note_box(shape):
        return shape
    new = edit.mapped(int(row[2]) + 1)
    if new is None:
        return b""
    by = new - 1 - int(row[2])
    return _ANCHOR.sub(lambda m: m[1] + _shifted(m[2], by) + m[3], _ROW.sub(rb"\g<1>%d\g<3>" % (new - 1), shape))


def is_note_box(shape: bytes) -> bool:
    """Return whether a shape is the box of a note; others are buttons, say."""
    return _NOTE.search(shape) is not None


def _shifted(anchor: bytes, by: int) -> bytes:
    """An anchor (column, offset, row, offset of two corners) some rows further down."""
    parts = anchor.split(b",")
    if len(parts) != 8 or not by:
        return anchor
    for i in (2, 6):
        number = parts[i].strip()
        if number.isdigit():
            parts[i] = parts[i].replace(number, b"%d" % max(int(number) + by, 0))
    return b",".join(parts)


def ignored_columns(package: PackageEdit, index: int) -> frozenset[int]:
    """The columns of our sheets with formulas of ours: what looks like a cell there (`a5`) is the name of a stream."""
    recognised = package.recognised(index)
    return frozenset({recognised.columns["Formula"]} if recognised.kind and "Formula" in recognised.columns else ())


def guard_references(package: PackageEdit, index: int, edit: RowEdit, moves: Moves) -> None:
    """Raise SheetsError when a reference would mean other contents afterwards, and cannot follow."""
    if not moves:
        return
    name = package.book.names[index]
    seen: set[tuple[int, int, bool, bool]] = set()
    for formula, own, where, absolute_only, grows in _outside(package, index):
        for ref in references(formula):
            spot = (ref.top, ref.bottom, absolute_only, grows)
            if not ref.on(name, own) or spot in seen or (absolute_only and not ref.absolute):
                continue
            seen.add(spot)
            if grows and follows(package, index, ref, edit):
                continue
            try:
                check(ref.top, ref.bottom, moves)
            except ReferenceConflict as harm:
                raise _refused(name, where, harm) from None
    ignored = ignored_columns(package, index)
    for f in package.sheet(index).formulas():
        if f.column in ignored or edit.mapped(f.row) is None:
            continue
        try:
            adapted(f.text, name, edit, moves)
        except ReferenceConflict as harm:
            raise _refused(name, N_("the formula in {cell}", cell=f"{name}!{f.place}"), harm) from None


def _refused(name: str, where: str, harm: ReferenceConflict) -> SheetsError:
    one, several = N_("row {n}", n=harm.top), N_("the rows {first} to {last}", first=harm.top, last=harm.bottom)
    rows, where = one if harm.top == harm.bottom else several, capital(where)
    return SheetsError(
        N_("{where} refers to {rows} of “{sheet}” and would then mean something else.",
           where=where, rows=rows, sheet=name),
        N_("Do this in Excel or LibreOffice, which change such references too."),
    )  # fmt: skip


def _outside(package: PackageEdit, index: int) -> Iterator[tuple[str, str, str, bool, bool]]:
    """Formulas outside of the sheet's own cells.

    Each as text, own sheet, where it stands, whether only `$` rows count, and whether it grows with the table.
    """
    for i, name in enumerate(package.book.names):
        if i != index and not xml.may_refer(package.book.read(package.book.entries[i].part)):
            continue
        sheet, where = package.sheet(i), N_("a drop-down list or a conditional format in “{sheet}”", sheet=name)
        yield from ((xml.text_of(e), name, where, True, True) for e in sheet.rules())
        if i != index:
            ignored = ignored_columns(package, i)
            for f in sheet.formulas():
                if f.column not in ignored:
                    yield f.text, name, N_("the formula in {cell}", cell=f"{name}!{f.place}"), False, False
    for _, e in package.workbook.find("definedName"):
        title = e.get("name", "")
        if title.casefold() not in _STAYING:
            yield xml.text_of(e), "", N_("the name “{name}”", name=title), False, title.startswith(LIST_PREFIX)
    yield from ((text, "", where, False, False) for text, where in _in_parts(package))


def _in_parts(package: PackageEdit) -> Iterator[tuple[str, str]]:
    """Formulas outside of all sheets, with where they stand."""
    for part in package.book.parts:
        if "/charts/" in part and part.endswith(".xml") and "_rels" not in part:
            yield from ((xml.text_of(e), N_("a chart")) for _, e in package.part(part).find("f"))
        elif "/pivotcache/" in part and "definition" in part and part.endswith(".xml"):
            for _, e in package.part(part).find("worksheetSource"):
                block, sheet = block_of(e.get("ref", "")), e.get("sheet", "")
                if block and sheet:
                    quoted = sheet.replace("'", "''")
                    yield f"'{quoted}'!A{block.top}:A{block.bottom}", N_("a pivot table")
        elif "/drawings/" in part or "/ctrlprops/" in part:
            for match in xml.LINKED.finditer(package.read(part)):
                text = html.unescape((match[2] or match[5] or b"").decode("utf-8", "replace"))
                yield text, N_("a shape or a button")
