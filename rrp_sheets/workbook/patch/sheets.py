"""Edits of the list of sheets of a package: new sheets with its styles; deleted ones come back byte for byte."""

from __future__ import annotations

import base64
import hashlib
import io
import json
import zipfile
import zlib
from collections.abc import Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import replace
from typing import Any

from lxml import etree

from rrp_sheets.errors import SheetsError
from rrp_sheets.model.workbook import column_letters
from rrp_sheets.texts import N_
from rrp_sheets.workbook.edits import AddSheet, BringSheet, DeleteSheet, MoveSheet, RenameSheet, SheetEdit
from rrp_sheets.workbook.maker import packed
from rrp_sheets.workbook.patch import package_edit as xml
from rrp_sheets.workbook.patch import sheet_list as listed
from rrp_sheets.workbook.patch.package_edit import TYPES_PART, PackageEdit, XmlPart
from rrp_sheets.workbook.patch.references import (
    GONE,
    formula_parts,
    keep_titles,
    put_back,
    quoted,
    renamed,
    rewrite,
    sheets_named,
    titles_part,
    without,
)
from rrp_sheets.workbook.patch.sheet_list import NAMES, RELATIONS, SHEETS, TYPES, VIEWS, Piece, change, cut, paste
from rrp_sheets.workbook.raw import text_sheet
from rrp_sheets.workbook.schema import DEVICES, LIST_PREFIX, list_name, list_titles, recognise
from rrp_sheets.workbook.sheet_names import refuse_more, sheet_name
from rrp_sheets.workbook.xlsx import number, rels_of

_BORROWED = {"fontId": "fonts", "fillId": "fills", "borderId": "borders"}
_STYLED = ("c", "row", "col")
_STYLES = ("numFmts", "fonts", "fills", "borders", "cellXfs", "dxfs")


def change_sheets(package: PackageEdit, edit: SheetEdit) -> str:
    """Carry out an edit of the list of sheets; of a deletion, what brings the sheet back, else an empty text.

    Raises SheetsError when there is no such sheet, it cannot have that name, or it cannot go.
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
    lists = {title: defined for title in list_titles() if (defined := list_name(title)) in known}
    data, repeated, cells = new_sheet(package, name, edit.rows, lists)
    part = listed.free_part(package)
    package.added[part] = data
    listed.renumber(package, lambda n: n + (n >= place))
    listed.put_sheet(package, part, name, place)
    titles = []
    if repeated:
        listed.define(package, "_xlnm.Print_Titles", f"{quoted(name)}!{repeated}", place)
        titles = [f"{quoted(name)}!Print_Titles"]
    streams = list_name("Streams")
    if cells and any(n.startswith(LIST_PREFIX) for n in known) and GONE in known.get(streams, GONE):
        listed.define(package, streams, f"{quoted(name)}!{cells}")
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
    for part in package.book.parts:
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
    paste(package, replace(piece, place=order.index(at)))
    listed.renumber(package, lambda n: order.index(n) if n in order else n)
    keep_titles(package, listed.worksheets(package, before))


def new_sheet(
    package: PackageEdit, name: str, rows: Sequence[Sequence[str]], lists: Mapping[str, str]
) -> tuple[bytes, str, str]:
    """Make a sheet: its part, the rows repeated on every printed page (`$1:$1`), and the cells with names of streams.

    The package's styles get what they lack for it. `lists` are the workbook's defined names by the titles of columns.
    """
    from openpyxl import Workbook

    from rrp_sheets.workbook.maker import SheetMaker

    texts = [[str(text) for text in row] for row in rows]
    what = recognise(text_sheet(name, texts))
    book = Workbook()
    book.remove(book.worksheets[0])
    maker = SheetMaker(book.create_sheet(name), texts, what, lists)
    maker.make()
    with zipfile.ZipFile(io.BytesIO(packed(book))) as made:
        sheet, styles = made.read("xl/worksheets/sheet1.xml"), made.read("xl/styles.xml")
    header = what.row or maker.header
    streams = ""
    if what.kind is DEVICES:
        letter = column_letters(what.columns["Stream"])
        streams = f"${letter}${header + 1}:${letter}${maker.last}"
    titles = "" if maker.prose else f"${header}:${header}"
    return with_package_styles(package, XmlPart(sheet), XmlPart(styles)), titles, streams


def with_package_styles(package: PackageEdit, sheet: XmlPart, styles: XmlPart) -> bytes:
    """The sheet with the numbers that its styles have in the package."""
    parts = package.related(package.book.part, "styles")
    merger = StyleMerger(package.part(parts[0]), styles) if parts else None  # none: a workbook without styles
    for _, e in sheet.find(*_STYLED):
        name = "style" if xml.local(e) == "col" else "s"
        if (old := e.get(name)) is not None and merger:
            e.set(name, str(merger.number("cellXfs", int(old))))
        elif old is not None:
            del e.attrib[name]
    for _, e in sheet.find("cfRule"):
        if merger and merger.has_marks and (old := e.get("dxfId")) is not None:
            e.set("dxfId", str(merger.number("dxfs", int(old))))
    for _, e in sheet.find("sheetView", "conditionalFormatting"):
        if xml.local(e) == "sheetView":
            xml.set_attributes(e, {"tabSelected": None})
        elif not (merger and merger.has_marks):
            xml.remove(e)
    return sheet.to_bytes()


class StyleMerger:
    """Merger of a made sheet's styles into those of a package: each is looked for there, or added."""

    def __init__(self, here: XmlPart, made: XmlPart) -> None:
        self._here, self._made = here, made
        self._mine: dict[str, list[bytes]] = {}
        self._numbers: dict[tuple[str, int], int] = {}

    @property
    def has_marks(self) -> bool:
        """True when there is a list for the styles of conditional formats."""
        return self._here.container("styleSheet", "dxfs") is not None

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

    `known` gets the canonical forms of every list's elements.
    """
    holder = styles.container("styleSheet", group)
    if holder is None:
        return 0
    forms = known.setdefault(group, [xml.canonical(e) for e in holder.iterchildren("*")])
    for e in new.iter("*"):
        e.tag = xml.named_like(holder, xml.local(e))
    new.tail = None
    holder.append(new)
    form = xml.canonical(new)
    if form in forms:
        holder.remove(new)
    else:
        forms.append(form)
        holder.set("count", str(len(forms)))
        styles.touch()
    return forms.index(form)


def delete_sheet(package: PackageEdit, edit: DeleteSheet) -> str:
    """Delete a sheet; what brings it back.

    Raises SheetsError when it is the last that can be seen, or a formula takes several sheets together.
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
        "sheet": name, "place": at, "part": package.book.parts[entry.part.casefold()].filename,
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
    relation = next(i for i, (_, t) in package.book.relations(package.book.part).items() if t == entry.part)
    removed = {f"/{spelt}".casefold() for spelt in gone}
    found = [
        *cut(package, TYPES_PART, TYPES, lambda e: e.get("PartName", "").casefold() in removed),
        *cut(package, rels_of(package.book.part), RELATIONS, lambda e: e.get("Id") == relation),
        *cut(package, package.book.part, SHEETS, lambda e: e.get("name") == name), *own,
    ]  # fmt: skip
    front = _in_front(listed.entries(package), at)
    listed.renumber(package, lambda n: front if n == at else n - (n > at))
    keep_titles(package, listed.worksheets(package, before), lambda t: "" if name.casefold() in sheets_named(t) else t)
    kept["pieces"] = [[p.part, list(p.path), p.place, p.raw] for p in found]
    kept["views"] = [views, listed.views(package)]
    kept["titles"] = [_digest(package.read(titles)), _packed(old_titles)] if titles else []
    package.dropped |= {spelt.casefold() for spelt in gone}
    return _packed(json.dumps(kept).encode())


def bring_sheet(package: PackageEdit, edit: BringSheet) -> None:
    """Bring a deleted sheet back; raises SheetsError if its name is taken or another program has saved the file."""
    kept = json.loads(zlib.decompress(base64.b64decode(edit.kept)))
    before = listed.names(package)
    sheet_name(kept["sheet"], before)  # it may be taken by now
    new_part = _part_for(package, kept)
    place = min(kept["place"], len(before))
    as_left = listed.views(package) == kept["views"][1]
    listed.renumber(package, lambda n: n + (n >= place))
    if as_left:
        tabs = iter(kept["views"][0])
        change(package, package.book.part, VIEWS, lambda e: next(tabs, {}))
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
            piece = replace(piece, place=place).with_attributes(named)
        else:
            listed.ensure_names(package)
            piece = piece.with_attributes({"localSheetId": str(place)})
        paste(package, piece)
    listed.put_names_back(package, kept["names"])
    for part, old in kept["formulas"].items():
        if part in package.book:
            put_back(package, part, old)
    titles = titles_part(package)
    if titles and kept["titles"] and _digest(package.read(titles)) == kept["titles"][0]:
        package.write(titles, zlib.decompress(base64.b64decode(kept["titles"][1])))
    else:
        keep_titles(package, listed.worksheets(package, before))


def _part_for(package: PackageEdit, kept: dict[str, Any]) -> str:
    """The name of the sheet's part: its own, or a free one where that is taken; raises where it would not fit."""
    there = package.book.parts
    taken = [p for p in kept["parts"] if p.casefold() in there and p not in (kept["part"], rels_of(kept["part"]))]
    if taken or _style_digest(package, kept["counts"]) != kept["ground"]:
        name = kept["sheet"]
        message = N_("“{sheet}” cannot come back as it was: another program has saved the workbook since.", sheet=name)
        raise SheetsError(message, N_("Take it from a version that was saved before (Versions)."))
    return kept["part"] if kept["part"].casefold() not in there else listed.free_part(package)


def _numbers(package: PackageEdit, kept: dict[str, Any]) -> tuple[str, int]:
    """The sheet's relation and number, or new ones where another sheet has them by now."""
    pieces = {tuple(path): Piece(part, tuple(path), at, raw) for part, path, at, raw in kept["pieces"]}
    relation = pieces[RELATIONS].element.get("Id", "")
    own = number(pieces[SHEETS].element.get("sheetId"))
    rels = package.part(rels_of(package.book.part)).children(*RELATIONS)
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
    parts = package.book.parts

    def reached(leave_out: str) -> set[str]:
        found, waiting = set[str](), [""]
        while waiting:
            part = waiting.pop()
            for _, target in package.book.relations(part).values():
                spelt = target.casefold()
                if spelt in parts and spelt not in found and spelt != leave_out:
                    found.add(spelt)
                    waiting.append(parts[spelt].filename)
        return found

    own = (reached("") - reached(sheet.casefold())) | {sheet.casefold()}
    rels = [rels_of(parts[spelt].filename).casefold() for spelt in own]
    return [parts[spelt].filename for spelt in sorted({*own, *(r for r in rels if r in parts)})]


def _moved(part: str, old: str, new: str) -> str:
    """The name of a kept part when the sheet's has another one."""
    return {old: new, rels_of(old): rels_of(new)}.get(part, part)


def _counts(package: PackageEdit) -> list[int]:
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
                total.update(xml.canonical(e))
    return total.hexdigest()


def _digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


def _packed(data: bytes) -> str:
    return base64.b64encode(zlib.compress(data, 6)).decode()


def referring(data: bytes, name: str, sheet: str) -> list[str]:
    """Return the references to a sheet, in words."""
    package = PackageEdit(data, name)
    return list(dict.fromkeys(_found(package, package.book.names[package.index(sheet)])))


def _found(package: PackageEdit, sheet: str) -> Iterator[str]:
    wanted = sheet.casefold()
    for index, other in enumerate(package.book.names):
        if other == sheet or not package.has_formulas(index):
            continue
        for f in package.sheet(index).formulas():
            if wanted in sheets_named(f.text):
                yield N_("the formula in {cell}", cell=f"{other}!{f.place}")
    for defined, text in listed.defined_names(package).items():
        if wanted in sheets_named(text):
            is_list = defined.startswith(LIST_PREFIX)
            yield N_("drop-down lists in Excel") if is_list else N_("the name “{name}”", name=defined)
    own = {part.casefold() for part in own_parts(package, package.book.entries[package.index(sheet)].part)}
    for part in formula_parts(package):
        formulas = package.part(part).find("f") if "/charts/" in part and part not in own else ()
        if any(wanted in sheets_named(xml.text_of(f)) for _, f in formulas):
            yield N_("a chart")
