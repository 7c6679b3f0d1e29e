"""Lists of elements: of sheets, names, tabs, relations and parts; what is taken out can be put in as it was."""

from __future__ import annotations

import posixpath
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from itertools import count

from lxml import etree

from rrp_sheets.errors import SheetsError
from rrp_sheets.texts import N_
from rrp_sheets.workbook.patch import package_edit as xml
from rrp_sheets.workbook.patch.package_edit import TYPES_PART, PackageEdit
from rrp_sheets.workbook.xlsx import number, rels_of, truth

_SHEET_TYPE = "application/vnd.openxmlformats-officedocument.spreadsheetml.worksheet+xml"
_RELATIONS_SPACE = "http://schemas.openxmlformats.org/officeDocument/2006/relationships"
VIEWS = ("workbook", "bookViews")
TABS = ("activeTab", "firstSheet")
_BEFORE_NAMES = ("sheets", "functionGroups", "externalReferences")
_LAST = 1_000_000
Path = tuple[str, ...]
SHEETS: Path = ("workbook", "sheets")
NAMES: Path = ("workbook", "definedNames")
RELATIONS: Path = ("Relationships",)
TYPES: Path = ("Types",)


@dataclass(frozen=True, slots=True)
class Piece:
    """An element of a list with the white space after it: the part, the list's path, its place there."""

    part: str
    path: Path
    place: int
    raw: str

    @property
    def element(self) -> etree._Element:
        """The element itself."""
        inside = list(xml.parse(f"<piece>{self.raw}</piece>".encode()).iterchildren("*"))
        if not inside:
            raise xml.broken()
        return inside[0]

    def with_attributes(self, changes: Mapping[str, str | None]) -> Piece:
        """The same element with other attributes."""
        element = self.element
        xml.set_attributes(element, changes)
        return replace(self, raw=etree.tostring(element, encoding="unicode"))


def cut(package: PackageEdit, part: str, path: Path, wanted: Callable[[etree._Element], bool]) -> list[Piece]:
    """Take elements out of a list; the pieces, in their order."""
    pieces = []
    for i, element in enumerate(package.part(part).children(*path)):
        if wanted(element):
            pieces.append(Piece(part, path, i, etree.tostring(element, encoding="unicode")))
            xml.remove(element)
            package.part(part).touch()
    return pieces


def paste(package: PackageEdit, piece: Piece) -> None:
    """Put a piece into its list, at its place or at the end."""
    put(package, piece.part, piece.path, piece.element, piece.place)


def put(package: PackageEdit, part: str, path: Path, element: etree._Element, place: int) -> None:
    """Put an element into a list, at a place or at the end."""
    container, there = package.part(part).container(*path), package.part(part).children(*path)
    if container is None:
        raise xml.broken()
    if place < len(there):
        container.insert(container.index(there[place]), element)
    elif there:
        container.insert(container.index(there[-1]) + 1, element)
    else:
        container.append(element)
    package.part(part).touch()


def change(
    package: PackageEdit, part: str, path: Path, changed: Callable[[etree._Element], Mapping[str, str | None]]
) -> None:
    """Change attributes of elements of a list."""
    for element in package.part(part).children(*path):
        if xml.set_attributes(element, changed(element)):
            package.part(part).touch()


def entries(package: PackageEdit) -> list[etree._Element]:
    """The sheets, those with a chart only too."""
    return package.workbook.children(*SHEETS)


def refuse_protected(package: PackageEdit) -> None:
    """Raise SheetsError when somebody has locked which sheets there are."""
    for e in package.workbook.root.iterchildren("{*}workbookProtection"):
        if truth(e.get("lockStructure")):
            message = N_("The workbook's structure is protected: its sheets stay as they are.")
            raise SheetsError(message, N_("Take the protection off in Excel (Review, Protect Workbook)."))


def names(package: PackageEdit) -> list[str]:
    """The sheets' names, in their order."""
    return [e.get("name", "") for e in entries(package)]


def worksheets(package: PackageEdit, before: list[str]) -> list[str]:
    """The names of the sheets with cells as they are now; `before` are all names that there were."""
    charts = set(before) - set(package.book.names)
    return [name for name in names(package) if name not in charts]


def place(package: PackageEdit, sheet: str) -> int:
    """The place of a sheet in the list; raises SheetsError when there is none of that name."""
    return names(package).index(package.book.names[package.index(sheet)])


def renumber(package: PackageEdit, new: Callable[[int], int]) -> None:
    """Let names that belong to one sheet, and the tab in front, count the sheets anew."""

    def own(e: etree._Element) -> dict[str, str | None]:
        old = e.get("localSheetId")
        return {} if old is None or new(number(old)) == number(old) else {"localSheetId": str(new(number(old)))}

    def tabs(e: etree._Element) -> dict[str, str | None]:
        old = {a: number(e.get(a)) for a in TABS if e.get(a) is not None}
        return {a: str(new(n)) for a, n in old.items() if new(n) != n}

    change(package, package.book.part, NAMES, own)
    change(package, package.book.part, VIEWS, tabs)


def views(package: PackageEdit) -> list[dict[str, str | None]]:
    """The tabs in front, of each window."""
    return [{a: e.get(a) for a in TABS} for e in package.workbook.children(*VIEWS)]


def defined_names(package: PackageEdit) -> dict[str, str]:
    """The names of the whole workbook with what they mean."""
    found = package.workbook.children(*NAMES)
    return {e.get("name", ""): xml.text_of(e) for e in found if e.get("localSheetId") is None}


def define(package: PackageEdit, name: str, formula: str, local: int | None = None) -> None:
    """Give a name its meaning; `local` is the place of the only sheet that it is for."""
    book = package.workbook
    own = None if local is None else str(local)
    for e in book.children(*NAMES):
        if e.get("name") == name and e.get("localSheetId") == own:
            xml.set_text(e, formula)
            book.touch()
            return
    ensure_names(package)
    named = {"name": name} | ({"localSheetId": own} if own is not None else {})
    put_new(package, package.book.part, NAMES, "definedName", named, text=formula)


def ensure_names(package: PackageEdit) -> None:
    """Have a list of names."""
    book = package.workbook
    if book.container(*NAMES) is None:
        last = [e for e in book.root.iterchildren("*") if xml.local(e) in _BEFORE_NAMES][-1]
        xml.add(book.root, "definedNames", {}, at=book.root.index(last) + 1)
        book.touch()


def drop_empty_names(package: PackageEdit) -> None:
    """Have no list of names without names."""
    book = package.workbook
    container = book.container(*NAMES)
    if container is not None and xml.child(container, "definedName") is None:
        book.root.remove(container)
        book.touch()


def rewrite_names(package: PackageEdit, changed: Callable[[str], str]) -> dict[str, list[str]]:
    """Change what names mean; the new and the old texts by name."""
    old = {}
    for e in package.workbook.children(*NAMES):
        text = xml.text_of(e)
        new = changed(text) if text else ""
        if xml.change_text(package.workbook, e, new):
            old[e.get("name", "")] = [new, text]
    return old


def put_names_back(package: PackageEdit, old: Mapping[str, list[str]]) -> None:
    """Take `rewrite_names` back where its texts still stand."""
    for e in package.workbook.children(*NAMES):
        new, was = old.get(e.get("name", ""), ("", ""))
        if new and xml.text_of(e) == new:
            xml.change_text(package.workbook, e, was)


def put_new(
    package: PackageEdit, part: str, path: Path, name: str, attributes: Mapping[str, str], at: int = _LAST,
    text: str = "",
) -> None:  # fmt: skip
    """Put a new element into a list, at a place or at the end."""
    container = package.part(part).container(*path)
    assert container is not None
    element = xml.new_element(container, name, attributes)
    element.text = text or None
    put(package, part, path, element, at)


def put_sheet(package: PackageEdit, part: str, name: str, at: int = _LAST) -> None:
    """List a new sheet, and its part among the package's parts and those that the workbook part refers to."""
    relation = free_relation(package)
    put_new(package, TYPES_PART, TYPES, "Override", {"PartName": f"/{part}", "ContentType": _SHEET_TYPE})
    related = {"Id": relation, "Type": f"{_RELATIONS_SPACE}/worksheet", "Target": target(package, part)}
    put_new(package, rels_of(package.book.part), RELATIONS, "Relationship", related)
    sheet = {"name": name, "sheetId": str(free_number(package)), id_name(package): relation}
    put_new(package, package.book.part, SHEETS, "sheet", sheet, at)


def target(package: PackageEdit, part: str) -> str:
    """A part as the workbook part's relations name it."""
    folder = posixpath.dirname(package.book.part)
    return part.removeprefix(f"{folder}/") if folder and part.startswith(f"{folder}/") else f"/{part}"


def free_part(package: PackageEdit) -> str:
    """The name of a new sheet's part."""
    folder = posixpath.dirname(package.book.entries[0].part)
    taken = {*package.book.parts, *(p.casefold() for p in package.added)}
    return next(part for n in count(1) if (part := f"{folder}/sheet{n}.xml").casefold() not in taken)


def free_relation(package: PackageEdit) -> str:
    """An id for a relation of the workbook part."""
    taken = {e.get("Id", "") for e in package.part(rels_of(package.book.part)).children(*RELATIONS)}
    return next(id for n in count(len(taken) + 1) if (id := f"rId{n}") not in taken)


def free_number(package: PackageEdit) -> int:
    """A sheet's number (`sheetId`), which stays when the sheet is moved."""
    return max((number(e.get("sheetId")) for e in entries(package)), default=0) + 1


def id_name(package: PackageEdit) -> str:
    """Return the name of the attribute with a sheet's relation, with its namespace."""
    named = (str(a) for e in entries(package) for a in e.attrib)
    return next((a for a in named if a.endswith("}id")), f"{{{_RELATIONS_SPACE}}}id")
