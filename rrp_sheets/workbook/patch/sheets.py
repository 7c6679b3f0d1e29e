"""Adding, renaming, moving and deleting sheets of a package, and bringing a deleted one back; all else stays."""

from __future__ import annotations

from rrp_sheets.errors import SheetsError
from rrp_sheets.workbook import limits
from rrp_sheets.workbook.edits import AddSheet, BringSheet, DeleteSheet, MoveSheet, RenameSheet, SheetEdit
from rrp_sheets.workbook.patch import sheet_list as listed
from rrp_sheets.workbook.patch.naming import GONE, formula_parts, quoted, renamed, rewrite
from rrp_sheets.workbook.patch.new_sheet import list_name, lists_of, new_sheet
from rrp_sheets.workbook.patch.package_edit import PackageEdit
from rrp_sheets.workbook.patch.sheet_restore import bring_sheet, delete_sheet
from rrp_sheets.workbook.patch.titles import keep_titles
from rrp_sheets.workbook.patch.xml_lists import RELATIONS, SHEETS, TYPES, change, cut, paste
from rrp_sheets.workbook.sheet_names import sheet_name

_SHEET_TYPE = "application/vnd.openxmlformats-officedocument.spreadsheetml.worksheet+xml"
_SHEET_RELATION = "http://schemas.openxmlformats.org/officeDocument/2006/relationships/worksheet"


def change_sheets(package: PackageEdit, edit: SheetEdit) -> str:
    """Carry out an edit of the list of sheets.

    Returns:
        Of a deletion, what brings the sheet back; else an empty text.

    Raises:
        SheetsError: there is no such sheet, it cannot have that name, or it cannot go.
    """
    listed.refuse_protected(package)
    match edit:
        case AddSheet():
            _add(package, edit)
        case RenameSheet():
            _rename(package, edit)
        case MoveSheet():
            _move(package, edit)
        case DeleteSheet():
            return delete_sheet(package, edit)
        case BringSheet():
            bring_sheet(package, edit)
    return ""


def _add(package: PackageEdit, edit: AddSheet) -> None:
    before = listed.names(package)
    name = sheet_name(edit.sheet, before)
    if len(before) >= limits.SHEETS:
        raise SheetsError(
            f"A workbook has at most {limits.SHEETS} sheets.", "Delete one first, or begin another workbook."
        )
    place = listed.place(package, edit.before) if edit.before else len(before)
    known = listed.defined_names(package)
    made = new_sheet(package, name, edit.rows, lists_of([*known]))
    part = listed.free_part(package)
    package.added[part] = made.xml
    relation = listed.free_relation(package)
    rels, target = listed.relations_part(package), listed.target(package, part)
    types = {"PartName": f"/{part}", "ContentType": _SHEET_TYPE}
    paste(package, listed.piece(package, listed.TYPES_PART, TYPES, "Override", types))
    related = {"Id": relation, "Type": _SHEET_RELATION, "Target": target}
    paste(package, listed.piece(package, rels, RELATIONS, "Relationship", related))
    listed.renumber(package, lambda n: n + (n >= place))
    sheet = {"name": name, "sheetId": str(listed.free_number(package)), listed.id_name(package): relation}
    paste(package, listed.piece(package, package.book.part, SHEETS, "sheet", sheet, place))
    titles = []
    if made.titles:
        listed.define(package, "_xlnm.Print_Titles", f"{quoted(name)}!{made.titles}", place)
        titles = [f"{quoted(name)}!Print_Titles"]
    streams = list_name("Streams")
    if made.streams and any(n.startswith("List_") for n in known) and GONE in known.get(streams, GONE):
        listed.define(package, streams, f"{quoted(name)}!{made.streams}")
    keep_titles(package, listed.worksheets(package, before), added=titles)


def _rename(package: PackageEdit, edit: RenameSheet) -> None:
    before = listed.names(package)
    old = package.book.names[package.index(edit.sheet)]
    new = sheet_name(edit.name, [n for n in before if n != old])
    if new == old:
        return
    book = package.book.part
    change(package, book, SHEETS, lambda e: {"name": new} if e.attributes.get("name") == old else {})
    for part in formula_parts(package):
        rewrite(package, part, lambda formula: renamed(formula, old, new))
    listed.rewrite_names(package, lambda formula: renamed(formula, old, new))
    for part in package.package.parts:
        if "/pivotcache/" in part and "definition" in part and part.endswith(".xml"):
            source = ("pivotCacheDefinition", "cacheSource")
            change(package, part, source, lambda e: {"sheet": new} if e.attributes.get("sheet") == old else {})
    keep_titles(package, listed.worksheets(package, before), lambda title: renamed(title, old, new))


def _move(package: PackageEdit, edit: MoveSheet) -> None:
    before = listed.names(package)
    at = listed.place(package, edit.sheet)
    to = listed.place(package, edit.before) if edit.before else len(before)
    if to in (at, at + 1):
        return
    order = [n for n in range(len(before)) if n != at]
    order.insert(order.index(to) if to < len(before) else len(order), at)
    book = package.book.part
    (piece,) = cut(package, book, SHEETS, lambda e: e.attributes.get("name") == before[at])
    paste(package, piece.at(order.index(at)))
    listed.renumber(package, lambda n: order.index(n) if n in order else n)
    keep_titles(package, listed.worksheets(package, before))
