"""Elements taken out of a part's lists and put in again, so that a list that nobody else has changed is as it was."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

from rrp_sheets.workbook.patch.markup import Element, as_utf8, find, splice, with_attributes
from rrp_sheets.workbook.patch.package_edit import PackageEdit

Path = tuple[str, ...]
SHEETS: Path = ("workbook", "sheets")
NAMES: Path = ("workbook", "definedNames")
RELATIONS: Path = ("Relationships",)
TYPES: Path = ("Types",)


@dataclass(frozen=True, slots=True)
class Piece:
    """An element of a list with the white space before it: the part, the list's path, its place there."""

    part: str
    path: Path
    place: int
    raw: str

    @property
    def attributes(self) -> Mapping[str, str]:
        """The element's attributes."""
        return self._element().attributes

    def with_attributes(self, changes: Mapping[str, str | None]) -> Piece:
        """The same element with other attributes; it stays as it is where they are the same."""
        e, raw = self._element(), self.raw.encode()
        named = {name: new for name, new in changes.items() if e.attributes.get(name) != new}
        tag = with_attributes(raw[e.start : e.inner], named)
        return replace(self, raw=splice(raw, [(e.start, e.inner, tag)]).decode())

    def at(self, place: int) -> Piece:
        """The same element at another place."""
        return replace(self, place=place)

    def _element(self) -> Element:
        return find(self.raw.encode(), lambda path: len(path) == 1)[0]


def children(data: bytes, path: Path) -> list[Element]:
    """The elements of a list."""
    return find(data, lambda at: tuple(at[:-1]) == path)


def cut(package: PackageEdit, part: str, path: Path, wanted: Callable[[Element], bool]) -> list[Piece]:
    """Take elements out of a list; the pieces, in their order."""
    data = as_utf8(package.read(part))
    found = children(data, path)
    gone = [i for i, e in enumerate(found) if wanted(e)]
    if not gone:
        return []
    (box,) = find(data, lambda at: tuple(at) == path)
    begins = [box.inner, *(e.end for e in found)]
    pieces = [Piece(part, path, i, data[begins[i] : found[i].end].decode()) for i in gone]
    package.write(part, splice(data, [(begins[i], found[i].end, b"") for i in gone]))
    return pieces


def paste(package: PackageEdit, piece: Piece) -> None:
    """Put a piece into its list, at its place or at the end."""
    data = as_utf8(package.read(piece.part))
    (box,) = find(data, lambda at: tuple(at) == piece.path)
    raw = piece.raw.encode()
    if box.inner == box.end:  # `<sheets/>`
        tag = data[box.start : box.inner].removesuffix(b"/>").rstrip() + b">"
        new = splice(data, [(box.start, box.end, tag + raw + f"</{box.name}>".encode())])
    else:
        found = children(data, piece.path)
        at = found[min(piece.place, len(found)) - 1].end if piece.place and found else box.inner
        new = splice(data, [(at, at, raw)])
    package.write(piece.part, new)


def change(package: PackageEdit, part: str, path: Path, changed: Callable[[Element], Mapping[str, str | None]]) -> None:
    """Change attributes of elements of a list."""
    data = as_utf8(package.read(part))
    changes = [
        (e.start, e.inner, with_attributes(data[e.start : e.inner], named))
        for e in find(data, lambda at: tuple(at[:-1]) == path)
        if (named := changed(e))
    ]
    if changes:
        package.write(part, splice(data, changes))
