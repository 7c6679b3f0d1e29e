"""Deleting a sheet, which is kept with all that belongs to it; bringing it back byte for byte; what refers to it."""

from __future__ import annotations

import base64
import hashlib
import json
import posixpath
import zlib
from collections.abc import Iterator
from typing import Any

from lxml import etree

from rrp_sheets.errors import SheetsError
from rrp_sheets.model.workbook import column_letters
from rrp_sheets.texts import N_
from rrp_sheets.workbook.edits import BringSheet, DeleteSheet
from rrp_sheets.workbook.patch import sheet_list as listed
from rrp_sheets.workbook.patch.package_edit import TYPES_PART, PackageEdit
from rrp_sheets.workbook.patch.references import (
    formula_parts,
    keep_titles,
    put_back,
    rewrite,
    sheets_named,
    titles_part,
    without,
)
from rrp_sheets.workbook.patch.sheet_list import NAMES, RELATIONS, SHEETS, TYPES, Piece, cut, paste
from rrp_sheets.workbook.patch.xml_part import canonical, text_of
from rrp_sheets.workbook.schema import LIST_PREFIX
from rrp_sheets.workbook.sheet_names import sheet_name
from rrp_sheets.workbook.xlsx_parts import number

_STYLES = ("numFmts", "fonts", "fills", "borders", "cellXfs", "dxfs")


def delete_sheet(package: PackageEdit, edit: DeleteSheet) -> str:
    """Delete a sheet; what brings it back.

    Raises:
        SheetsError: it is the last that can be seen, or a formula takes several sheets together.
    """
    entry = package.book.entries[package.index(edit.sheet)]
    name, before = entry.name, listed.names(package)
    at = listed.place(package, name)
    seen = [e.name for e in package.book.entries if not e.hidden]
    if len(before) < 2 or seen == [name] or len(package.book.entries) < 2:
        raise SheetsError(N_("“{sheet}” is the only sheet to be seen.", sheet=name), N_("Add another one first."))
    package.formulas_moved = package.formulas_moved or package.has_formulas(package.index(name))
    gone = own_parts(package, entry.part)
    titles, views = titles_part(package), listed.views(package)
    old_titles = package.read(titles) if titles else b""
    kept: dict[str, Any] = {
        "sheet": name, "place": at, "part": package.package.parts[entry.part.casefold()].filename,
        "ground": _style_digest(package, counts := _counts(package)),
        "counts": counts, "parts": {spelt: _packed(package.read(spelt)) for spelt in gone},
        "formulas": {
            part: old for part in formula_parts(package)
            if part not in {g.casefold() for g in gone} and (old := rewrite(package, part, lambda f: without(f, name)))
        },
    }  # fmt: skip
    own = cut(package, package.book.part, NAMES, lambda e: e.get("localSheetId") == str(at))
    listed.drop_empty_names(package)
    kept["names"] = listed.rewrite_names(package, lambda f: without(f, name))
    relation = next(i for i, (_, t) in package.package.relations(package.book.part).items() if t == entry.part)
    removed = {f"/{spelt}".casefold() for spelt in gone}
    found = [
        *cut(package, TYPES_PART, TYPES, lambda e: e.get("PartName", "").casefold() in removed),
        *cut(package, listed.relations_part(package), RELATIONS, lambda e: e.get("Id") == relation),
        *cut(package, package.book.part, SHEETS, lambda e: e.get("name") == name), *own,
    ]  # fmt: skip
    front = _in_front(listed.entries(package), at)
    listed.renumber(package, lambda n: front if n == at else n - (n > at))
    keep_titles(package, listed.worksheets(package, before), lambda t: "" if name.casefold() in sheets_named(t) else t)
    kept["pieces"] = [[p.part, list(p.path), p.place, p.raw] for p in found]
    kept["views"] = [views, listed.views(package)]
    kept["titles"] = [_digest(package.read(titles)), _packed(old_titles)] if titles else []
    package.dropped |= {spelt.casefold() for spelt in gone}
    return base64.b64encode(zlib.compress(json.dumps(kept).encode(), 6)).decode()


def bring_sheet(package: PackageEdit, edit: BringSheet) -> None:
    """Bring a deleted sheet back.

    Raises:
        SheetsError: its name is taken by now, or another program has saved the workbook anew.
    """
    kept = json.loads(zlib.decompress(base64.b64decode(edit.kept)))
    before = listed.names(package)
    sheet_name(kept["sheet"], before)  # it may be taken by now
    new_part = _part_for(package, kept)
    place = min(kept["place"], len(before))
    as_left = listed.views(package) == kept["views"][1]
    listed.renumber(package, lambda n: n + (n >= place))
    if as_left:
        listed.set_views(package, kept["views"][0])
    for spelt, content in kept["parts"].items():
        package.added[_moved(spelt, kept["part"], new_part)] = zlib.decompress(base64.b64decode(content))
    relation, sheet_number = _numbers(package, kept)
    for part, path, at, raw in kept["pieces"]:
        piece = Piece(part, tuple(path), at, raw)
        if piece.path == TYPES:
            spelt = piece.element.get("PartName", "").removeprefix("/")
            piece = piece.with_attributes({"PartName": f"/{_moved(spelt, kept['part'], new_part)}"})
        elif piece.path == RELATIONS:
            target = {"Target": listed.target(package, new_part)} if new_part != kept["part"] else {}
            piece = piece.with_attributes({"Id": relation, **target})
        elif piece.path == SHEETS:
            named = {listed.id_name(package): relation, "sheetId": str(sheet_number)}
            piece = piece.at(place).with_attributes(named)
        else:
            listed.ensure_names(package)
            piece = piece.with_attributes({"localSheetId": str(place)})
        paste(package, piece)
    listed.put_names_back(package, kept["names"])
    for part, old in kept["formulas"].items():
        if part in package.package:
            put_back(package, part, old)
    titles = titles_part(package)
    if titles and kept["titles"] and _digest(package.read(titles)) == kept["titles"][0]:
        package.write(titles, zlib.decompress(base64.b64decode(kept["titles"][1])))
    else:
        keep_titles(package, listed.worksheets(package, before))


def _part_for(package: PackageEdit, kept: dict[str, Any]) -> str:
    """The name of the sheet's part: its own, or a free one where that is taken; raises where it would not fit."""
    there = package.package.parts
    rels = _rels(kept["part"])
    taken = [p for p in kept["parts"] if p.casefold() in there and p not in (kept["part"], rels)]
    if taken or _style_digest(package, kept["counts"]) != kept["ground"]:
        raise SheetsError(
            N_("“{sheet}” cannot come back as it was: another program has saved the workbook since.",
               sheet=kept["sheet"]),
            N_("Take it from a version that was kept before (Versions)."),
        )  # fmt: skip
    return kept["part"] if kept["part"].casefold() not in there else listed.free_part(package)


def _numbers(package: PackageEdit, kept: dict[str, Any]) -> tuple[str, int]:
    """The sheet's relation and number, or new ones where another sheet has them by now."""
    pieces = {tuple(path): Piece(part, tuple(path), at, raw) for part, path, at, raw in kept["pieces"]}
    relation = pieces[RELATIONS].element.get("Id", "")
    own = number(pieces[SHEETS].element.get("sheetId"))
    rels = package.part(listed.relations_part(package)).children(*RELATIONS)
    if any(e.get("Id") == relation for e in rels):
        relation = listed.free_relation(package)
    if any(number(e.get("sheetId")) == own for e in listed.entries(package)):
        own = listed.free_number(package)
    return relation, own


def _in_front(left: list[etree._Element], at: int) -> int:
    """The sheet that is seen instead of the one that is gone: the next one, or the one before."""
    seen = [i for i, e in enumerate(left) if e.get("state", "visible") == "visible"]
    return min(seen, key=lambda i: (i < at, abs(i - at)), default=0)


def own_parts(package: PackageEdit, sheet: str) -> list[str]:
    """The sheet's part and those that only it leads to (comments, drawings, tables), as they are spelt."""
    parts = package.package.parts

    def reached(leave_out: str) -> set[str]:
        found: set[str] = set()
        waiting = [""]
        while waiting:
            part = waiting.pop()
            for _, target in package.package.relations(part).values():
                spelt = target.casefold()
                if spelt in parts and spelt not in found and spelt != leave_out:
                    found.add(spelt)
                    waiting.append(parts[spelt].filename)
        return found

    own = (reached("") - reached(sheet.casefold())) | {sheet.casefold()}
    rels = [_rels(parts[spelt].filename).casefold() for spelt in own]
    return [parts[spelt].filename for spelt in sorted({*own, *(r for r in rels if r in parts)})]


def _rels(part: str) -> str:
    folder, leaf = posixpath.split(part)
    return posixpath.join(folder, "_rels", f"{leaf}.rels")


def _moved(part: str, old: str, new: str) -> str:
    """The name of a kept part when the sheet's has another one."""
    return {old: new, _rels(old): _rels(new)}.get(part, part)


def _counts(package: PackageEdit) -> list[int]:
    """Return the number of styles of each kind."""
    parts = package.related(package.book.part, "styles")
    return [len(package.part(parts[0]).children("styleSheet", name)) if parts else 0 for name in _STYLES]


def _style_digest(package: PackageEdit, counts: list[int]) -> str:
    """Return a digest that changes when numbers of styles or shared texts get other meanings; new styles do no harm."""
    total = hashlib.sha256()
    for part in package.related(package.book.part, "sharedstrings"):
        total.update(package.read(part))
    for part in package.related(package.book.part, "styles"):
        for name, count in zip(_STYLES, counts, strict=True):
            for e in package.part(part).children("styleSheet", name)[:count]:
                total.update(canonical(e))
    return total.hexdigest()


def _digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


def _packed(data: bytes) -> str:
    return base64.b64encode(zlib.compress(data, 6)).decode()


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
                yield N_("the formula in {cell}", cell=f"{other}!{column_letters(f.column)}{f.row}")
    for defined, text in listed.defined_names(package).items():
        if wanted in sheets_named(text):
            is_list = defined.startswith(LIST_PREFIX)
            yield N_("drop-down lists in Excel") if is_list else N_("the name “{name}”", name=defined)
    own = {part.casefold() for part in own_parts(package, package.book.entries[package.index(sheet)].part)}
    for part in formula_parts(package):
        texts = (text_of(f) for _, f in package.part(part).find("f")) if "/charts/" in part and part not in own else ()
        if any(wanted in sheets_named(text) for text in texts):
            yield N_("a chart")
