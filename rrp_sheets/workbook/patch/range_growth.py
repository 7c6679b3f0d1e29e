"""Drop-downs, colours and lists that cover one of our tables grow with it, as they do in an Excel table."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from rrp_sheets.workbook.edits import InsertRows, RowEdit
from rrp_sheets.workbook.patch.blocks import block_of, block_text
from rrp_sheets.workbook.patch.markup import as_utf8, find, inner_text, splice, text_xml
from rrp_sheets.workbook.patch.package_edit import PackageEdit
from rrp_sheets.workbook.patch.references import Reference, references

SPARE = 50
"""Blank rows below the last filled one that are covered too when something grows."""
LISTS = "List_"
"""What the names of our lists begin with; the user's own names stay as they are."""
_FORMULAS = ("formula", "formula1", "formula2", "f")


def note(package: PackageEdit, index: int) -> None:
    """Remember how far a sheet's table reaches, before it is changed."""
    if index not in package.reached:
        package.reached[index] = _last(package, index)


def grow(package: PackageEdit, index: int) -> None:
    """Let everything that covered a sheet's table before cover it again, where it has become longer since `note`."""
    before, now = package.reached[index], _last(package, index)
    package.reached[index] = now
    if now <= before or not package.recognised(index).kind:
        return
    top = package.recognised(index).row + 1
    last = now + SPARE

    def longer(first: int, bottom: int) -> int:
        return last if first == top and first < bottom and before <= bottom < now else bottom

    _grow_rules(package, index, longer)
    _grow_names(package, index, longer)


def follows(package: PackageEdit, index: int, ref: Reference, edit: RowEdit) -> bool:
    """Whether a reference covers the whole table of a sheet, so that it grows when rows are inserted."""
    known = package.recognised(index)
    whole = known.kind and ref.top == known.row + 1 and ref.top < ref.bottom
    return isinstance(edit, InsertRows) and bool(whole) and ref.bottom >= _last(package, index)


def _last(package: PackageEdit, index: int) -> int:
    return max((n for n, row in package.sheet(index).rows.items() if row.filled), default=0)


def _grow_rules(package: PackageEdit, index: int, longer: Callable[[int, int], int]) -> None:
    """Where the rules of the sheet hold, and what the rules of all sheets refer to."""
    name = package.book.names[index]
    sheet = package.sheet(index)
    for e in sheet.all("conditionalFormatting", "dataValidation"):
        old = e.attributes.get("sqref", "")
        if old and (new := _grown(old, longer)) != old:
            sheet.retag(e, {"sqref": new})
    for e in sheet.all("sqref"):  # of the rules that newer programs keep elsewhere
        old = inner_text(sheet.data, e)
        if (new := _grown(old, longer)) != old:
            sheet.rewrite(e, text_xml(new))
    for i, own in enumerate(package.book.names):
        if i != index and not package.mentions(i, name):
            continue
        other = package.sheet(i)
        for e in other.all(*_FORMULAS):
            old = inner_text(other.data, e)
            if "sparkline" not in e.path and (new := _referring(old, name, own, longer)) != old:
                other.rewrite(e, text_xml(new))


def _grow_names(package: PackageEdit, index: int, longer: Callable[[int, int], int]) -> None:
    """The lists behind the drop-downs."""
    data = as_utf8(package.read(package.book.part))
    changes = []
    for e in find(data, lambda path: path[-1] == "definedName"):
        old = inner_text(data, e)
        if e.attributes.get("name", "").startswith(LISTS):
            new = _referring(old, package.book.names[index], "", longer)
            changes += [(e.inner, e.inner_end, text_xml(new))] if new != old else []
    if changes:
        package.write(package.book.part, splice(data, changes))


def _grown(blocks: str, longer: Callable[[int, int], int]) -> str:
    """The blocks of cells where a rule holds."""
    found = []
    for text in blocks.split():
        block = block_of(text)
        bottom = longer(block.top, block.bottom) if block else 0
        found.append(block_text(replace(block, bottom=bottom)) if block and bottom != block.bottom else text)
    return " ".join(found)


def _referring(formula: str, sheet: str, own: str, longer: Callable[[int, int], int]) -> str:
    """A formula whose references to a whole table of the sheet reach its new end."""
    out, at = [], 0
    for ref in references(formula):
        if ref.absolute and ref.on(sheet, own) and (bottom := longer(ref.top, ref.bottom)) != ref.bottom:
            start, end = ref.spans[1]
            out += [formula[at:start], str(bottom)]
            at = end
    return "".join([*out, formula[at:]])
