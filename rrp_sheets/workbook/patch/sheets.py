"""Edits of the list of sheets of a package, and new sheets with the package's styles; all else stays."""

from __future__ import annotations

import io
import re
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from rrp_sheets.errors import SheetsError
from rrp_sheets.model.names import key
from rrp_sheets.workbook import limits, style
from rrp_sheets.workbook.edits import AddSheet, BringSheet, DeleteSheet, MoveSheet, RenameSheet, SheetEdit
from rrp_sheets.workbook.headers import recognise
from rrp_sheets.workbook.patch import sheet_list as listed
from rrp_sheets.workbook.patch.markup import Element, as_utf8, find, splice, with_attributes
from rrp_sheets.workbook.patch.naming import GONE, formula_parts, keep_titles, quoted, renamed, rewrite
from rrp_sheets.workbook.patch.package_edit import PackageEdit
from rrp_sheets.workbook.patch.sheet_restore import bring_sheet, delete_sheet
from rrp_sheets.workbook.patch.xml_lists import RELATIONS, SHEETS, TYPES, change, children, cut, paste
from rrp_sheets.workbook.raw import RawCell, RawSheet
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


_MAIN = "http://schemas.openxmlformats.org/spreadsheetml/2006/main"
_SHARED = ("fonts", "fills", "borders")
_BORROWED = {"fontId": "fonts", "fillId": "fills", "borderId": "borders"}
_STYLE = re.compile(rb'(<(?:c|row|col)\b[^<>]*?\s)(s|style)="(\d+)"')
_MARK = re.compile(rb'(<cfRule\b[^<>]*?\sdxfId=")(\d+)(")')
_SELECTED = re.compile(rb' tabSelected="(?:1|true)"')
_RULES = re.compile(rb"<conditionalFormatting\b.*?</conditionalFormatting>", re.DOTALL)


@dataclass(frozen=True, slots=True)
class NewSheet:
    """A made sheet: its part, and the rows that are repeated on every printed page (`$1:$1`)."""

    xml: bytes
    titles: str
    streams: str


def lists_of(names: Sequence[str]) -> dict[str, str]:
    """The lists for drop-downs that a workbook has, by the title that the looks of a column know them by."""
    titles = {c.offers for columns in style.COLUMNS.values() for c in columns.values() if c.offers}
    titles |= {"Sensors", "Actuators"}
    by_name = {list_name(title): title for title in titles}
    return {title: name for name, title in by_name.items() if name in names}


def list_name(title: str) -> str:
    """The defined name of a list."""
    return "List_" + re.sub(r"\W", "_", key(title))


def new_sheet(package: PackageEdit, name: str, rows: Sequence[Sequence[str]], lists: Mapping[str, str]) -> NewSheet:
    """Make a sheet; the package's styles get what they lack for it."""
    from openpyxl import Workbook

    from rrp_sheets.workbook.package import packed
    from rrp_sheets.workbook.sheet_maker import SheetMaker

    texts = [[str(text) for text in row] for row in rows]
    cells = {(r, c): RawCell(t) for r, row in enumerate(texts, 1) for c, t in enumerate(row, 1) if t}
    what = recognise(RawSheet(name, cells))
    book = Workbook()
    book.remove(book.worksheets[0])
    maker = SheetMaker(book.create_sheet(name), texts, what, lists)
    maker.make()
    with zipfile.ZipFile(io.BytesIO(packed(book))) as made:
        xml, styles = made.read("xl/worksheets/sheet1.xml"), made.read("xl/styles.xml")
    header = what.row or maker.header
    streams = ""
    if what.kind and what.kind.name == "devices":
        from rrp_sheets.model.cells import column_letters

        letter = column_letters(what.columns["Stream"])
        streams = f"${letter}${header + 1}:${letter}${maker.last}"
    titles = "" if maker.prose else f"${header}:${header}"
    return NewSheet(_dressed(package, _SELECTED.sub(b"", xml), styles), titles, streams)


def _dressed(package: PackageEdit, xml: bytes, styles: bytes) -> bytes:
    """The sheet with the numbers that its styles have in the package."""
    parts = package.related(package.book.part, "styles")
    if not parts:  # a workbook without looks
        return _RULES.sub(b"", _STYLE.sub(rb"\1", xml))
    wardrobe = _Wardrobe(as_utf8(package.read(parts[0])), styles)
    xml = _STYLE.sub(lambda m: m[1] + m[2] + b'="%d"' % wardrobe.style(int(m[3])), xml)
    if wardrobe.has_marks:
        xml = _MARK.sub(lambda m: m[1] + b"%d" % wardrobe.mark(int(m[2])) + m[3], xml)
    else:
        xml = _RULES.sub(b"", xml)
    new = wardrobe.data()
    if new is not None:
        package.write(parts[0], new)
    return xml


class _Wardrobe:
    """The styles of a package, and those of the made sheet that are looked for in them or added.

    Args:
        here: the package's style part.
        made: the made sheet's.
    """

    def __init__(self, here: bytes, made: bytes) -> None:
        self._here = here
        self._boxes = {e.local: e for e in find(here, lambda path: len(path) == 2)}
        self._mine = {n: _raw(here, n) for n in (*_SHARED, "cellXfs", "dxfs")}
        self._made = {n: _raw(made, n) for n in (*_SHARED, "cellXfs", "dxfs")}
        self._counts = {n: len(found) for n, found in self._mine.items()}
        self._numbers: dict[tuple[str, int], int] = {}

    @property
    def has_marks(self) -> bool:
        """True when there is a list for the looks of conditional formats."""
        return "dxfs" in self._boxes

    def style(self, number: int) -> int:
        """The number here of a cell's style."""
        if ("cellXfs", number) not in self._numbers:
            raw = self._made["cellXfs"][number]
            (tag,) = find(raw, lambda path: len(path) == 1)
            named: dict[str, str | None] = {
                a: str(self._number(box, int(tag.attributes[a]))) for a, box in _BORROWED.items() if a in tag.attributes
            }
            new = with_attributes(raw[: tag.inner], {**named, "xfId": "0"}) + raw[tag.inner :]
            self._numbers["cellXfs", number] = self._place("cellXfs", new)
        return self._numbers["cellXfs", number]

    def mark(self, number: int) -> int:
        """The number here of a conditional format's looks."""
        return self._number("dxfs", number)

    def _number(self, box: str, number: int) -> int:
        if (box, number) not in self._numbers:
            self._numbers[box, number] = self._place(box, self._made[box][number])
        return self._numbers[box, number]

    def _place(self, box: str, raw: bytes) -> int:
        """The place of an element, which is added where there is none like it."""
        if box not in self._boxes:
            return 0
        if self._boxes[box].prefix:
            name_end = re.match(rb"<[\w:]+", raw)
            assert name_end is not None
            raw = raw[: name_end.end()] + f' xmlns="{_MAIN}"'.encode() + raw[name_end.end() :]
        if raw not in self._mine[box]:
            self._mine[box].append(raw)
        return self._mine[box].index(raw)

    def data(self) -> bytes | None:
        """The style part with what was added; None when nothing was."""
        changes: list[tuple[int, int, bytes]] = []
        for name, found in self._mine.items():
            new = found[self._counts[name] :]
            if new:
                changes += _added(self._here, self._boxes[name], len(found), b"".join(new))
        return splice(self._here, changes) if changes else None


def _added(data: bytes, box: Element, count: int, new: bytes) -> list[tuple[int, int, bytes]]:
    tag = with_attributes(data[box.start : box.inner], {"count": str(count)})
    if box.inner == box.end:  # `<dxfs count="0"/>`
        return [(box.start, box.end, tag.removesuffix(b"/>").rstrip() + b">" + new + f"</{box.name}>".encode())]
    return [(box.start, box.inner, tag), (box.inner_end, box.inner_end, new)]


def _raw(data: bytes, box: str) -> list[bytes]:
    """The elements of one list of a style part."""
    return [data[e.start : e.end] for e in children(data, ("styleSheet", box))]
