"""Elements taken out of a part's lists and put in again, so that a list that nobody else has changed is as it was."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

from lxml import etree

from rrp_sheets.workbook.patch.package_edit import PackageEdit
from rrp_sheets.workbook.patch.xml_part import broken, parse, remove, set_attributes

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
        inside = list(parse(f"<piece>{self.raw}</piece>".encode()).iterchildren("*"))
        if not inside:
            raise broken()
        return inside[0]

    def with_attributes(self, changes: Mapping[str, str | None]) -> Piece:
        """The same element with other attributes."""
        element = self.element
        set_attributes(element, changes)
        return replace(self, raw=etree.tostring(element, encoding="unicode"))

    def at(self, place: int) -> Piece:
        """The same element at another place."""
        return replace(self, place=place)


def cut(package: PackageEdit, part: str, path: Path, wanted: Callable[[etree._Element], bool]) -> list[Piece]:
    """Take elements out of a list; the pieces, in their order."""
    found = list(enumerate(package.part(part).children(*path)))
    pieces = []
    for i, element in found:
        if wanted(element):
            pieces.append(Piece(part, path, i, etree.tostring(element, encoding="unicode")))
            remove(element)
            package.part(part).touch()
    return pieces


def paste(package: PackageEdit, piece: Piece) -> None:
    """Put a piece into its list, at its place or at the end."""
    put(package, piece.part, piece.path, piece.element, piece.place)


def put(package: PackageEdit, part: str, path: Path, element: etree._Element, place: int) -> None:
    """Put an element into a list, at a place or at the end."""
    box, there = package.part(part).box(*path), package.part(part).children(*path)
    if box is None:
        raise broken()
    if place < len(there):
        box.insert(box.index(there[place]), element)
    elif there:
        box.insert(box.index(there[-1]) + 1, element)
    else:
        box.append(element)
    package.part(part).touch()


def change(
    package: PackageEdit, part: str, path: Path, changed: Callable[[etree._Element], Mapping[str, str | None]]
) -> None:
    """Change attributes of elements of a list."""
    for element in package.part(part).children(*path):
        if set_attributes(element, changed(element)):
            package.part(part).touch()
