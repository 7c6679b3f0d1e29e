"""References to a sheet within an .xlsx: formulas, names, drop-downs, charts; in words, before it is deleted."""

from __future__ import annotations

from collections.abc import Iterator

from rrp_sheets.model.cells import column_letters
from rrp_sheets.workbook.patch import sheet_list as listed
from rrp_sheets.workbook.patch.naming import formula_parts, sheets_named
from rrp_sheets.workbook.patch.package_edit import PackageEdit
from rrp_sheets.workbook.patch.sheet_restore import own_parts
from rrp_sheets.workbook.patch.xml_part import text_of

_LISTS = "List_"


def referring(data: bytes, name: str, sheet: str) -> list[str]:
    """Return the references to a sheet, in words.

    Args:
        data: the file's bytes.
        name: the file's name, for messages.
        sheet: the sheet's name.
    """
    package = PackageEdit(data, name)
    return list(dict.fromkeys(_found(package, package.book.names[package.index(sheet)])))


def _found(package: PackageEdit, sheet: str) -> Iterator[str]:
    wanted = sheet.casefold()
    for index, other in enumerate(package.book.names):
        if other == sheet or not package.has_formulas(index):
            continue
        for f in package.sheet(index).formulas():
            if wanted in sheets_named(f.text):
                yield f"the formula in {other}!{column_letters(f.column)}{f.row}"
    for defined, text in listed.defined_names(package).items():
        if wanted in sheets_named(text):
            yield "drop-down lists in Excel" if defined.startswith(_LISTS) else f"the name “{defined}”"
    own = {part.casefold() for part in own_parts(package, package.book.entries[package.index(sheet)].part)}
    for part in formula_parts(package):
        texts = (text_of(f) for _, f in package.part(part).find("f")) if "/charts/" in part and part not in own else ()
        if any(wanted in sheets_named(text) for text in texts):
            yield "a chart"
