"""Edits of the list of sheets of a package, and new sheets with the package's styles; all else stays."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass

from lxml import etree

from rrp_sheets.workbook.edits import AddSheet, BringSheet, DeleteSheet, MoveSheet, RenameSheet, SheetEdit
from rrp_sheets.workbook.headers import recognise
from rrp_sheets.workbook.patch import sheet_list as listed
from rrp_sheets.workbook.patch.package_edit import PackageEdit
from rrp_sheets.workbook.patch.references import GONE, formula_parts, keep_titles, quoted, renamed, rewrite
from rrp_sheets.workbook.patch.sheet_list import SHEETS, change, cut, paste
from rrp_sheets.workbook.patch.sheet_restore import bring_sheet, delete_sheet
from rrp_sheets.workbook.patch.xml_part import XmlPart, canonical, local, named_like, remove, set_attributes
from rrp_sheets.workbook.raw import RawCell, RawSheet
from rrp_sheets.workbook.schema import DEVICES, LIST_PREFIX, list_name, list_titles
from rrp_sheets.workbook.sheet_names import refuse_more, sheet_name

_BORROWED = {"fontId": "fonts", "fillId": "fills", "borderId": "borders"}
_STYLED = ("c", "row", "col")


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
    refuse_more(before)
    place = listed.place(package, edit.before) if edit.before else len(before)
    known = listed.defined_names(package)
    made = new_sheet(package, name, edit.rows, lists_of([*known]))
    part = listed.free_part(package)
    package.added[part] = made.xml
    relation = listed.free_relation(package)
    listed.put_part(package, part, relation)
    listed.renumber(package, lambda n: n + (n >= place))
    sheet = {"name": name, "sheetId": str(listed.free_number(package)), listed.id_name(package): relation}
    listed.put_new(package, package.book.part, SHEETS, "sheet", sheet, place)
    titles = []
    if made.titles:
        listed.define(package, "_xlnm.Print_Titles", f"{quoted(name)}!{made.titles}", place)
        titles = [f"{quoted(name)}!Print_Titles"]
    streams = list_name("Streams")
    if made.streams and any(n.startswith(LIST_PREFIX) for n in known) and GONE in known.get(streams, GONE):
        listed.define(package, streams, f"{quoted(name)}!{made.streams}")
    keep_titles(package, listed.worksheets(package, before), added=titles)


def _rename(package: PackageEdit, edit: RenameSheet) -> None:
    before = listed.names(package)
    old = package.book.names[package.index(edit.sheet)]
    new = sheet_name(edit.name, [n for n in before if n != old])
    if new == old:
        return
    book = package.book.part
    change(package, book, SHEETS, lambda e: {"name": new} if e.get("name") == old else {})
    for part in formula_parts(package):
        rewrite(package, part, lambda formula: renamed(formula, old, new))
    listed.rewrite_names(package, lambda formula: renamed(formula, old, new))
    for part in package.package.parts:
        if "/pivotcache/" in part and "definition" in part and part.endswith(".xml"):
            source = ("pivotCacheDefinition", "cacheSource")
            change(package, part, source, lambda e: {"sheet": new} if e.get("sheet") == old else {})
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
    (piece,) = cut(package, book, SHEETS, lambda e: e.get("name") == before[at])
    paste(package, piece.at(order.index(at)))
    listed.renumber(package, lambda n: order.index(n) if n in order else n)
    keep_titles(package, listed.worksheets(package, before))


@dataclass(frozen=True, slots=True)
class NewSheet:
    """A made sheet: its part, and the rows that are repeated on every printed page (`$1:$1`)."""

    xml: bytes
    titles: str
    streams: str


def lists_of(names: Sequence[str]) -> dict[str, str]:
    """The lists for drop-downs that a workbook has, by the title that a column of the schema has them under."""
    by_name = {list_name(title): title for title in list_titles()}
    return {title: name for name, title in by_name.items() if name in names}


def new_sheet(package: PackageEdit, name: str, rows: Sequence[Sequence[str]], lists: Mapping[str, str]) -> NewSheet:
    """Make a sheet; the package's styles get what they lack for it."""
    from openpyxl import Workbook

    from rrp_sheets.workbook.maker import SheetMaker
    from rrp_sheets.workbook.package import packed

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
    if what.kind is DEVICES:
        from rrp_sheets.model.workbook import column_letters

        letter = column_letters(what.columns["Stream"])
        streams = f"${letter}${header + 1}:${letter}${maker.last}"
    titles = "" if maker.prose else f"${header}:${header}"
    return NewSheet(with_package_styles(package, XmlPart(xml), XmlPart(styles)), titles, streams)


def with_package_styles(package: PackageEdit, sheet: XmlPart, styles: XmlPart) -> bytes:
    """The sheet with the numbers that its styles have in the package."""
    parts = package.related(package.book.part, "styles")
    merger = StyleMerger(package.part(parts[0]), styles) if parts else None  # none: a workbook without styles
    for _, e in sheet.find(*_STYLED):
        name = "style" if local(e) == "col" else "s"
        if (old := e.get(name)) is not None and merger:
            e.set(name, str(merger.style(int(old))))
        elif old is not None:
            del e.attrib[name]
    for _, e in sheet.find("cfRule"):
        if merger and merger.has_marks and (old := e.get("dxfId")) is not None:
            e.set("dxfId", str(merger.number("dxfs", int(old))))
    for _, e in sheet.find("sheetView", "conditionalFormatting"):
        if local(e) == "sheetView":
            set_attributes(e, {"tabSelected": None})
        elif not (merger and merger.has_marks):
            remove(e)
    return sheet.to_bytes()


class StyleMerger:
    """Merger of a made sheet's styles into those of a package: each is looked for there, or added.

    Args:
        here: the package's style part.
        made: the made sheet's.
    """

    def __init__(self, here: XmlPart, made: XmlPart) -> None:
        self._here, self._made = here, made
        self._mine: dict[str, list[bytes]] = {}
        self._numbers: dict[tuple[str, int], int] = {}

    @property
    def has_marks(self) -> bool:
        """True when there is a list for the styles of conditional formats."""
        return self._here.container("styleSheet", "dxfs") is not None

    def style(self, number: int) -> int:
        """The number here of a cell's style."""
        return self.number("cellXfs", number)

    def number(self, group: str, number: int) -> int:
        """The number here of a made element of a list, which is added where there is none like it."""
        if (group, number) not in self._numbers:
            new = deepcopy(self._made.children("styleSheet", group)[number])
            if group == "cellXfs":
                for name, borrowed in _BORROWED.items():
                    if (old := new.get(name)) is not None:
                        new.set(name, str(self.number(borrowed, int(old))))
                new.set("xfId", "0")
            self._numbers[group, number] = place_style(self._here, group, new, self._mine)
        return self._numbers[group, number]


def place_style(styles: XmlPart, group: str, new: etree._Element, known: dict[str, list[bytes]]) -> int:
    """The place of an element in a list of a style part, which is added where there is none like it.

    Args:
        styles: the part.
        group: the name of the list.
        new: the element.
        known: of every list the canonical forms of its elements, filled here.
    """
    holder = styles.container("styleSheet", group)
    if holder is None:
        return 0
    forms = known.setdefault(group, [canonical(e) for e in holder.iterchildren("*")])
    for e in new.iter("*"):
        e.tag = named_like(holder, local(e))
    new.tail = None
    holder.append(new)
    form = canonical(new)
    if form in forms:
        holder.remove(new)
    else:
        forms.append(form)
        holder.set("count", str(len(forms)))
        styles.touch()
    return forms.index(form)
