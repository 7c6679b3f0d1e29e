"""Comments follow their rows: their list, the boxes in which they are drawn, and threaded comments."""

from __future__ import annotations

import re

from rrp_sheets.model.cells import column_letters
from rrp_sheets.workbook.edits import RowEdit
from rrp_sheets.workbook.patch.markup import as_utf8, find, splice, with_attributes
from rrp_sheets.workbook.patch.package_edit import PackageEdit
from rrp_sheets.workbook.xlsx_sheet import place

_SHAPE = re.compile(rb"<v:shape\b.*?</v:shape>", re.DOTALL)
_NOTE = re.compile(rb"""ObjectType\s*=\s*["']Note["']""")
_ROW = re.compile(rb"(<x:Row>\s*)(\d+)(\s*</x:Row>)")
_ANCHOR = re.compile(rb"(<x:Anchor>)([^<]*)(</x:Anchor>)")


def move_comments(package: PackageEdit, index: int, edit: RowEdit) -> None:
    """Let all comments of a sheet go where their rows go; those of deleted rows go away."""
    part = package.book.entries[index].part
    for kind, local in (("comments", "comment"), ("threadedcomment", "threadedComment")):
        for target in package.related(part, kind):
            _move_references(package, target, local, edit)
    for target in package.related(part, "vmldrawing"):
        old = package.read(target)
        new = _SHAPE.sub(lambda shape: _moved_box(shape[0], edit), old)
        if new != old:
            package.write(target, new)


def _move_references(package: PackageEdit, part: str, local: str, edit: RowEdit) -> None:
    data = as_utf8(package.read(part))
    changes = []
    for e in find(data, lambda path: path[-1] == local):
        at = place(e.attributes.get("ref", ""))
        new = edit.mapped(at[0]) if at else None
        if at and new is None:
            changes.append((e.start, e.end, b""))
        elif at and new != at[0]:
            named = {"ref": f"{column_letters(at[1])}{new}"}
            changes.append((e.start, e.inner, with_attributes(data[e.start : e.inner], named)))
    if changes:
        package.write(part, splice(data, changes))


def _moved_box(shape: bytes, edit: RowEdit) -> bytes:
    """The box of a comment, moved by as many rows as its cell; other shapes (buttons, say) stay."""
    row = _ROW.search(shape)
    if row is None or not _NOTE.search(shape):
        return shape
    old = int(row[2])
    new = edit.mapped(old + 1)
    if new is None:
        return b""
    by = new - 1 - old
    return _ANCHOR.sub(lambda m: m[1] + _shifted(m[2], by) + m[3], _ROW.sub(rb"\g<1>%d\g<3>" % (new - 1), shape))


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
