"""Who refers to the rows that an edit moves: formulas elsewhere, names, charts, pivot tables, buttons, drop-downs."""

from __future__ import annotations

import html
import re
from collections.abc import Iterator

from rrp_sheets.errors import SheetsError
from rrp_sheets.model.cells import column_letters
from rrp_sheets.workbook.edits import RowEdit
from rrp_sheets.workbook.patch.blocks import block_of
from rrp_sheets.workbook.patch.markup import as_utf8, find, inner_text
from rrp_sheets.workbook.patch.package_edit import PackageEdit
from rrp_sheets.workbook.patch.range_growth import LISTS, follows
from rrp_sheets.workbook.patch.references import Moves, ReferenceConflict, adapted, check, references
from rrp_sheets.workbook.patch.shared import formulas
from rrp_sheets.workbook.patch.sheet_xml import SheetXml

_STAYING = ("_xlnm.print_area", "_xlnm.print_titles", "_xlnm._filterdatabase")
_ANY_FORMULA = re.compile(rb"<(?:\w+:)?f(?:ormula[12]?)?[\s>/]")
_LINKED = re.compile(rb"""\b(?:textlink|fmlaLink|fmlaRange|fmlaTxbx)\s*=\s*"([^"]*)"|<x:Fmla\w*>([^<]*)</x:Fmla""")


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
    sheet, ignored = package.sheet(index), ignored_columns(package, index)
    for row, where, formula in _formulas(sheet, ignored):
        if edit.mapped(row) is None:
            continue
        try:
            adapted(formula, name, edit, moves)
        except ReferenceConflict as harm:
            raise _refused(name, f"the formula in {name}!{where}", harm) from None


def _refused(name: str, where: str, harm: ReferenceConflict) -> SheetsError:
    rows = f"row {harm.top}" if harm.top == harm.bottom else f"the rows {harm.top} to {harm.bottom}"
    where = where[0].upper() + where[1:]
    return SheetsError(
        f"{where} refers to {rows} of “{name}” and would then mean something else.",
        "Do this in Excel or LibreOffice, which change such references too.",
    )


def _formulas(sheet: SheetXml, ignored: frozenset[int]) -> Iterator[tuple[int, str, str]]:
    for row, column, _, text in formulas(sheet):
        if column not in ignored:
            yield row.number, f"{column_letters(column)}{row.number}", text


def _outside(package: PackageEdit, index: int) -> Iterator[tuple[str, str, str, bool, bool]]:
    """Formulas outside of the sheet's own cells.

    Each as text, own sheet, where it stands, whether only `$` rows count, and whether it grows with the table.
    """
    names = package.book.names
    for i, name in enumerate(names):
        if i != index and not package.has_formulas(i, _ANY_FORMULA):
            continue
        sheet = package.sheet(i)
        for e in sheet.all("formula", "formula1", "formula2", "f"):
            if "sparkline" not in e.path:
                yield (
                    inner_text(sheet.data, e),
                    name,
                    f"a drop-down list or a conditional format in “{name}”",
                    True,
                    True,
                )
        if i != index:
            found = _formulas(sheet, ignored_columns(package, i))
            yield from ((text, name, f"the formula in {name}!{at}", False, False) for _, at, text in found)
    data = as_utf8(package.read(package.book.part))
    for e in find(data, lambda path: path[-1] == "definedName"):
        title = e.attributes.get("name", "")
        if title.casefold() not in _STAYING:
            yield inner_text(data, e), "", f"the name “{title}”", False, title.startswith(LISTS)
    yield from ((*found, False) for found in _in_parts(package))


def _in_parts(package: PackageEdit) -> Iterator[tuple[str, str, str, bool]]:
    for part in package.package.parts:
        if "/charts/" in part and part.endswith(".xml") and "_rels" not in part:
            data = as_utf8(package.read(part))
            yield from ((inner_text(data, e), "", "a chart", False) for e in find(data, lambda p: p[-1] == "f"))
        elif "/pivotcache/" in part and "definition" in part and part.endswith(".xml"):
            data = as_utf8(package.read(part))
            for e in find(data, lambda path: path[-1] == "worksheetSource"):
                block, sheet = block_of(e.attributes.get("ref", "")), e.attributes.get("sheet", "")
                if block and sheet:
                    quoted = sheet.replace("'", "''")
                    yield f"'{quoted}'!A{block.top}:A{block.bottom}", "", "a pivot table", False
        elif "/drawings/" in part or "/ctrlprops/" in part:
            for match in _LINKED.finditer(package.read(part)):
                text = html.unescape((match[1] or match[2]).decode("utf-8", "replace"))
                yield text, "", "a shape or a button", False
