"""List of sheets in the workbook part, with its names, tabs and relations, and free names for new sheets' parts."""

from __future__ import annotations

import posixpath
from collections.abc import Callable, Mapping
from html import escape
from typing import Any

from rrp_sheets.errors import SheetsError
from rrp_sheets.workbook.patch.markup import Element, as_utf8, find, inner_text, splice, text_xml
from rrp_sheets.workbook.patch.package_edit import PackageEdit
from rrp_sheets.workbook.patch.xml_lists import NAMES, RELATIONS, SHEETS, Path, Piece, change, children, paste
from rrp_sheets.workbook.xlsx_parts import number, truth

TYPES_PART = "[Content_Types].xml"
VIEWS = ("workbook", "bookViews")
TABS = ("activeTab", "firstSheet")
_BEFORE_NAMES = ("sheets", "functionGroups", "externalReferences")
_LAST = 1_000_000


def entries(package: PackageEdit) -> list[Element]:
    """The sheets, those with a chart only too."""
    return children(as_utf8(package.read(package.book.part)), SHEETS)


def refuse_protected(package: PackageEdit) -> None:
    """Raise SheetsError when somebody has locked which sheets there are."""
    for e in children(as_utf8(package.read(package.book.part)), ("workbook",)):
        if e.local == "workbookProtection" and truth(e.attributes.get("lockStructure")):
            raise SheetsError(
                "The workbook's structure is protected: its sheets stay as they are.",
                "Take the protection off in Excel (Review, Protect Workbook).",
            )


def names(package: PackageEdit) -> list[str]:
    """Their names, in their order."""
    return [e.attributes.get("name", "") for e in entries(package)]


def worksheets(package: PackageEdit, before: list[str]) -> list[str]:
    """The names of the sheets with cells as they are now; `before` are all names that there were."""
    charts = set(before) - set(package.book.names)
    return [name for name in names(package) if name not in charts]


def place(package: PackageEdit, sheet: str) -> int:
    """The place of a sheet in the list; raises SheetsError when there is none of that name."""
    return names(package).index(package.book.names[package.index(sheet)])


def renumber(package: PackageEdit, new: Callable[[int], int]) -> None:
    """Let names that belong to one sheet, and the tab in front, count the sheets anew."""

    def local(e: Element) -> dict[str, str | None]:
        old = e.attributes.get("localSheetId")
        return {} if old is None or new(number(old)) == number(old) else {"localSheetId": str(new(number(old)))}

    def tabs(e: Element) -> dict[str, str | None]:
        old = {a: number(e.attributes[a]) for a in TABS if a in e.attributes}
        return {a: str(new(n)) for a, n in old.items() if new(n) != n}

    change(package, package.book.part, NAMES, local)
    change(package, package.book.part, VIEWS, tabs)


def views(package: PackageEdit) -> list[dict[str, str | None]]:
    """The tabs in front, of each window."""
    found = children(as_utf8(package.read(package.book.part)), VIEWS)
    return [{a: e.attributes.get(a) for a in TABS} for e in found]


def set_views(package: PackageEdit, tabs: list[dict[str, str | None]]) -> None:
    """Restore the tabs in front, of each window."""
    left = iter(tabs)
    change(package, package.book.part, VIEWS, lambda e: next(left, {}))


# ---- names


def defined_names(package: PackageEdit) -> dict[str, str]:
    """The names of the whole workbook with what they mean."""
    data = as_utf8(package.read(package.book.part))
    found = [e for e in children(data, NAMES) if "localSheetId" not in e.attributes]
    return {e.attributes.get("name", ""): inner_text(data, e) if e.inner < e.inner_end else "" for e in found}


def define(package: PackageEdit, name: str, formula: str, local: int | None = None) -> None:
    """Give a name its meaning; `local` is the place of the only sheet that it is for."""
    book = package.book.part
    data = as_utf8(package.read(book))
    own = None if local is None else str(local)
    same = [
        e
        for e in children(data, NAMES)
        if e.attributes.get("name") == name and e.attributes.get("localSheetId") == own and e.inner < e.end
    ]
    if same:
        package.write(book, splice(data, [(same[0].inner, same[0].inner_end, text_xml(formula))]))
        return
    ensure_names(package)
    named = {"name": name} | ({"localSheetId": own} if own is not None else {})
    paste(package, piece(package, book, NAMES, "definedName", named, text=formula))


def ensure_names(package: PackageEdit) -> None:
    """Have a list of names."""
    data = as_utf8(package.read(package.book.part))
    if not find(data, lambda path: tuple(path) == NAMES):
        last = [e for e in find(data, lambda path: len(path) == 2) if e.local in _BEFORE_NAMES][-1]
        new = f"<{last.prefix}definedNames></{last.prefix}definedNames>".encode()
        package.write(package.book.part, splice(data, [(last.end, last.end, new)]))


def drop_empty_names(package: PackageEdit) -> None:
    """Have no list of names without names."""
    data = as_utf8(package.read(package.book.part))
    boxes = find(data, lambda path: tuple(path) == NAMES)
    if boxes and not children(data, NAMES):
        package.write(package.book.part, splice(data, [(boxes[0].start, boxes[0].end, b"")]))


def rewrite_names(package: PackageEdit, changed: Callable[[str], str]) -> dict[str, list[str]]:
    """Change what names mean; the new and the old texts by name, as they stand in the XML."""
    data = as_utf8(package.read(package.book.part))
    changes, old = [], {}
    for e in children(data, NAMES):
        text = inner_text(data, e) if e.inner < e.inner_end else ""
        if text and (new := changed(text)) != text:
            changes.append((e.inner, e.inner_end, text_xml(new)))
            old[e.attributes.get("name", "")] = [text_xml(new).decode(), data[e.inner : e.inner_end].decode()]
    if changes:
        package.write(package.book.part, splice(data, changes))
    return old


def put_names_back(package: PackageEdit, old: Mapping[str, list[str]]) -> None:
    """Take `rewrite_names` back where its texts still stand."""
    data = as_utf8(package.read(package.book.part))
    changes = []
    for e in children(data, NAMES):
        new, was = old.get(e.attributes.get("name", ""), ("", ""))
        if new and data[e.inner : e.inner_end].decode() == new:
            changes.append((e.inner, e.inner_end, was.encode()))
    if changes:
        package.write(package.book.part, splice(data, changes))


# ---- the parts behind the list


def piece(
    package: PackageEdit,
    part: str,
    path: Path,
    local: str,
    attributes: Mapping[str, str],
    at: int = _LAST,
    text: str = "",
) -> Piece:
    """A new element for a list."""
    (box,) = find(as_utf8(package.read(part)), lambda found: tuple(found) == path)
    name = f"{box.prefix}{local}"
    named = "".join(f' {a}="{escape(value)}"' for a, value in attributes.items())
    end = f">{escape(text, quote=False)}</{name}>" if text else "/>"
    return Piece(part, path, at, f"<{name}{named}{end}")


def relations_part(package: PackageEdit) -> str:
    """The part with the workbook part's relations."""
    folder, leaf = posixpath.split(package.book.part)
    return posixpath.join(folder, "_rels", f"{leaf}.rels")


def target(package: PackageEdit, part: str) -> str:
    """A part as the workbook part's relations name it."""
    folder = posixpath.dirname(package.book.part)
    return part.removeprefix(f"{folder}/") if folder and part.startswith(f"{folder}/") else f"/{part}"


def free_part(package: PackageEdit) -> str:
    """The name of a new sheet's part."""
    folder = posixpath.dirname(package.book.entries[0].part)
    taken = {*package.package.parts, *(p.casefold() for p in package.added)}
    n = 1
    while f"{folder}/sheet{n}.xml".casefold() in taken:
        n += 1
    return f"{folder}/sheet{n}.xml"


def free_relation(package: PackageEdit) -> str:
    """An id for a relation of the workbook part."""
    taken = {e.attributes.get("Id", "") for e in children(as_utf8(package.read(relations_part(package))), RELATIONS)}
    n = len(taken) + 1
    while f"rId{n}" in taken:
        n += 1
    return f"rId{n}"


def free_number(package: PackageEdit) -> int:
    """A sheet's number (`sheetId`), which stays when the sheet is moved."""
    return max((number(e.attributes.get("sheetId")) for e in entries(package)), default=0) + 1


def id_name(package: PackageEdit) -> str:
    """Return the name of the attribute with a sheet's relation as it is written here: `r:id`."""
    named: dict[str, Any] = dict(entries(package)[0].attributes)
    return next((a for a in named if a.rpartition(":")[2] == "id"), "r:id")
