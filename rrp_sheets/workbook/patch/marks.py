"""Comments and looks of cells in a package.

Comments are notes with their boxes, and the threads and persons of newer spreadsheet programs. For a look a cell style
is added where there is none like it.
"""

from __future__ import annotations

import posixpath
import re
from collections.abc import Sequence
from copy import deepcopy
from xml.sax.saxutils import escape, quoteattr

from lxml import etree

from rrp_sheets.errors import SheetsError
from rrp_sheets.model.workbook import column_letters
from rrp_sheets.texts import N_
from rrp_sheets.workbook import comments, limits
from rrp_sheets.workbook.comments import NOTE, Comment, Thread
from rrp_sheets.workbook.edits import SetComments, SetLook
from rrp_sheets.workbook.patch import package_edit as xml
from rrp_sheets.workbook.patch.package_edit import TYPES_PART, PackageEdit, XmlPart
from rrp_sheets.workbook.patch.row_edits import SHAPE, is_note_box
from rrp_sheets.workbook.patch.sheet_list import RELATIONS, TYPES, put_new
from rrp_sheets.workbook.patch.sheets import place_style
from rrp_sheets.workbook.xlsx import escape_literal, number, rels_of, unescape

_OFFICE = "http://schemas.openxmlformats.org/officeDocument/2006/relationships"
_MAIN = "http://schemas.openxmlformats.org/spreadsheetml/2006/main"
_THREADED = "http://schemas.microsoft.com/office/spreadsheetml/2018/threadedcomments"
_NEWER = "http://schemas.microsoft.com/office/2017/10/relationships"
_REVISION = "http://schemas.microsoft.com/office/spreadsheetml/2014/revision"
_PACKAGE = "http://schemas.openxmlformats.org/package/2006/relationships"
_SPACE = "{http://www.w3.org/XML/1998/namespace}space"
_VML = "application/vnd.openxmlformats-officedocument.vmlDrawing"
_TYPE = {
    "comments": "application/vnd.openxmlformats-officedocument.spreadsheetml.comments+xml",
    "threadedComment": "application/vnd.ms-excel.threadedcomments+xml",
    "person": "application/vnd.ms-excel.person+xml",
}
_DECLARED = '<?xml version="1.0" encoding="UTF-8" standalone="yes"?>\n'
_EMPTY = {
    "comments": f'{_DECLARED}<comments xmlns="{_MAIN}"><authors/><commentList/></comments>',
    "threadedComment": f'{_DECLARED}<ThreadedComments xmlns="{_THREADED}" xmlns:x="{_MAIN}"/>',
    "person": f'{_DECLARED}<personList xmlns="{_THREADED}" xmlns:x="{_MAIN}"/>',
}
_BOX_TYPE = (
    '<v:shapetype id="_x0000_t202" coordsize="21600,21600" o:spt="202" path="m,l,21600r21600,l21600,xe">'
    '<v:stroke joinstyle="miter"/><v:path gradientshapeok="t" o:connecttype="rect"/></v:shapetype>'
)
_BOX_NUMBER = re.compile(rb"_x0000_s(\d{1,9})")
_PLACE = (re.compile(rb"<x:Row>\s*(\d+)\s*</x:Row>"), re.compile(rb"<x:Column>\s*(\d+)\s*</x:Column>"))
_AFTER_BOXES = frozenset({
    "legacyDrawingHF", "drawingHF", "picture", "oleObjects", "controls", "webPublishItems", "tableParts", "extLst",
})  # fmt: skip
_END = re.compile(rb"</xml>\s*\Z")

_BEFORE_BOLD = frozenset({"name", "charset", "family"})  # openpyxl writes them first, and keeps a font's order


def add_parts(package: PackageEdit, edit: SetComments) -> bool:
    """Add the parts that a cell's comments need; True when there are new ones: the package is to be opened again.

    Their names have the number of the first comment, so that a deleted sheet's own ones are free when it comes back.
    """
    if not edit.thread:
        return False
    index = package.index(edit.sheet)
    sheet = package.book.entries[index].part
    mark = re.sub(r"[^0-9A-Za-z]", "", edit.thread[0].id)[:12]
    wanted = {"comments": f"xl/comments{mark}.xml"}
    is_note = edit.thread[0].id == NOTE
    if not is_note:
        wanted["threadedComment"] = f"xl/threadedComments/threadedComment{mark}.xml"
        if not package.related(package.book.part, "person"):
            _add_part(package, "person", "xl/persons/person.xml")
            _relate(package, package.book.part, [(f"{_NEWER}/person", "xl/persons/person.xml")])
    relations = []
    for kind, part in wanted.items():
        if not package.related(sheet, kind.casefold()):
            free = _free(package, part)
            _add_part(package, kind, free)
            relations.append((f"{_OFFICE if kind == 'comments' else _NEWER}/{kind}", free))
    boxes = "" if _boxes(package, index) else _free(package, f"xl/drawings/vmlDrawing{mark}.vml")
    if boxes:
        package.added[boxes] = _new_boxes(index).encode()
        if not any(e.get("Extension", "").casefold() == "vml" for e in package.part(TYPES_PART).children(*TYPES)):
            put_new(package, TYPES_PART, TYPES, "Default", {"Extension": "vml", "ContentType": _VML}, 0)
        relations.append((f"{_OFFICE}/vmlDrawing", boxes))
    ids = _relate(package, sheet, relations)
    if boxes:
        _refer_to_boxes(package, index, ids[-1])
    return bool(package.added)


def set_comments(package: PackageEdit, edit: SetComments) -> None:
    """Give a cell a thread of comments; an empty one takes away what is there.

    Comments that stay are left as they are in the file. Raises SheetsError where a part cannot be understood.
    """
    index = package.index(edit.sheet)
    part, ref = package.book.entries[index].part, f"{column_letters(edit.column)}{edit.row}"
    notes = [
        (holder, e)
        for holder in map(package.part, package.related(part, "comments"))
        for e in holder.children("comments", "commentList")
        if e.get("ref") == ref
    ]
    threaded = [
        (holder, e)
        for holder in map(package.part, package.related(part, "threadedcomment"))
        for e in holder.children("ThreadedComments")
        if e.get("ref") == ref
    ]
    is_thread = bool(edit.thread) and edit.thread[0].id != NOTE
    kept = {c.id for c in edit.thread} if is_thread else set()
    for holder, e in [
        *(notes[1:] if edit.thread else notes),
        *((h, e) for h, e in threaded if e.get("id") not in kept),
    ]:
        xml.remove(e)
        holder.touch()
    if is_thread:
        _set_thread(package, part, ref, edit.thread, {e.get("id", ""): (holder, e) for holder, e in threaded})
    if edit.thread:
        _set_note(package, part, ref, edit.thread, notes[0] if notes else None)
    _set_box(package, index, edit.row, edit.column, wanted=bool(edit.thread))


def _set_thread(
    package: PackageEdit, part: str, ref: str, thread: Thread, there: dict[str, tuple[XmlPart, etree._Element]]
) -> None:
    holder = package.part(package.related(part, "threadedcomment")[0])
    before: etree._Element | None = None
    for i, comment in enumerate(thread):
        found = there.get(comment.id)
        if found is None:
            attributes = {"ref": ref, **({"dT": comment.at.removesuffix("Z")} if comment.at else {}),
                          "personId": _person(package, comment.author), "id": comment.id}  # fmt: skip
            e = xml.new_element(holder.root, "threadedComment", attributes)
            xml.add(e, "text", {}, comment.text)
            if before is None:
                holder.root.append(e)
            else:
                before.addnext(e)
            holder.touch()
        else:
            e = found[1]
            _rewrite(*found, comment)
        about = {"parentId": thread[0].id} if i else {"parentId": None, "done": "1" if comment.done else None}
        if e.get("done") == "0" and not comment.done:
            about.pop("done", None)
        if xml.set_attributes(e, about):
            (found[0] if found else holder).touch()
        before = e


def _rewrite(holder: XmlPart, e: etree._Element, comment: Comment) -> None:
    """Give a comment that is there another text; who was mentioned in the old one is not in the new one."""
    text = xml.child(e, "text")
    if text is None:
        text = xml.add(e, "text", {}, at=0)
    was = xml.text_of(text)
    if was[: limits.CELL_CHARACTERS] == comment.text:  # as much as is read of a longer one
        return
    xml.set_text(text, comment.text)
    for mention in e.findall("{*}mentions"):
        xml.remove(mention)
    holder.touch()


def _person(package: PackageEdit, name: str) -> str:
    """The id of a person, who is added where there is none of that name."""
    holder = package.part(package.related(package.book.part, "person")[0])
    for e in holder.children("personList"):
        if e.get("displayName") == name and e.get("id"):
            return str(e.get("id"))
    id = comments.new_id()
    named = {"displayName": name, "id": id, "userId": name, "providerId": "None"}
    holder.root.append(xml.new_element(holder.root, "person", named))
    holder.touch()
    return id


def _set_note(
    package: PackageEdit, part: str, ref: str, thread: Thread, there: tuple[XmlPart, etree._Element] | None
) -> None:
    """Give a cell its note: of a thread, its texts as Excel writes them."""
    is_note = thread[0].id == NOTE
    author = thread[0].author if is_note else f"tc={thread[0].id}"
    text = thread[0].text if is_note else comments.fallback(thread)
    if there is None:
        holder = package.part(package.related(part, "comments")[0])
        container = holder.container("comments", "commentList")
        if container is None:
            raise xml.broken()
        e = xml.add(container, "comment", {"ref": ref, "authorId": "0", "shapeId": "0"})
    else:
        holder, e = there
        was = "".join(xml.text_of(t) for t in e.iter("{*}t") if next(t.iterancestors("{*}rPh"), None) is None)
        if is_note and comments.note_thread(_author(holder, e), was, ref) == thread:
            return
        if unescape(was) == text and _author(holder, e) == author:
            return
    e.set("authorId", str(_author_number(holder, author)))
    id_name = f"{{{_REVISION}}}uid"
    if not is_note and (there is None or e.get(id_name)):
        e.set(id_name, thread[0].id)
    for old in e.findall("{*}text"):
        xml.remove(old)
    inside = xml.add(xml.add(e, "text", {}, at=0), "t", {}, escape_literal(text))
    inside.set(_SPACE, "preserve")
    holder.touch()


def _author(holder: XmlPart, e: etree._Element) -> str:
    authors = holder.children("comments", "authors")
    at = number(e.get("authorId"), len(authors))
    return unescape(xml.text_of(authors[at])) if at < len(authors) else ""


def _author_number(holder: XmlPart, author: str) -> int:
    container = holder.container("comments", "authors")
    if container is None:
        container = xml.add(holder.root, "authors", {}, at=0)
    names = [unescape(xml.text_of(e)) for e in container.iterchildren("*")]
    if author not in names:
        xml.add(container, "author", {}, escape_literal(author))
        names.append(author)
    return names.index(author)


# ---- boxes of notes


def _boxes(package: PackageEdit, index: int) -> str:
    """The part with the boxes of a sheet's notes; empty where there is none."""
    part = package.book.entries[index].part
    relations = package.book.relations(part)
    for e in package.sheet(index).elements("legacyDrawing"):
        kind, target = relations.get(
            next((str(v) for a, v in e.attrib.items() if str(a).endswith("}id")), ""), ("", "")
        )
        if kind == "vmldrawing" and target in package.book:
            return target
    return ""


def _set_box(package: PackageEdit, index: int, row: int, column: int, *, wanted: bool) -> None:
    """Have a box for a note of a cell, or none."""
    part = _boxes(package, index)
    if not part:
        return
    old = package.read(part)

    def is_here(shape: bytes) -> bool:
        places = [pattern.search(shape) for pattern in _PLACE]
        return is_note_box(shape) and [m and int(m[1]) for m in places] == [row - 1, column - 1]

    new, here = old, [shape[0] for shape in SHAPE.finditer(old) if is_here(shape[0])]
    if not wanted:
        for shape in here:
            new = new.replace(shape, b"", 1)
    elif not here:
        end = _END.search(old)
        if end is None:
            raise xml.broken()
        numbers = [int(n) for n in _BOX_NUMBER.findall(old)]
        box = _box(max([1024 * (index + 1), *numbers]) + 1, row, column)
        about = "" if b"_x0000_t202" in old else _BOX_TYPE
        new = old[: end.start()] + (about + box).encode() + old[end.start() :]
    if new != old:
        package.write(part, new)


def _new_boxes(index: int) -> str:
    return (
        '<xml xmlns:v="urn:schemas-microsoft-com:vml" xmlns:o="urn:schemas-microsoft-com:office:office" '
        'xmlns:x="urn:schemas-microsoft-com:office:excel"><o:shapelayout v:ext="edit">'
        f'<o:idmap v:ext="edit" data="{index + 1}"/></o:shapelayout>{_BOX_TYPE}</xml>'
    )


def _box(shape: int, row: int, column: int) -> str:
    top = max(row - 2, 0)
    return (
        f'<v:shape id="_x0000_s{shape}" type="#_x0000_t202" style="position:absolute;margin-left:60pt;margin-top:2pt;'
        'width:144pt;height:79pt;z-index:1;visibility:hidden" fillcolor="#ffffe1" o:insetmode="auto">'
        '<v:fill color2="#ffffe1"/><v:shadow on="t" color="black" obscured="t"/><v:path o:connecttype="none"/>'
        '<v:textbox style="mso-direction-alt:auto"><div style="text-align:left"></div></v:textbox>'
        '<x:ClientData ObjectType="Note"><x:MoveWithCells/><x:SizeWithCells/>'
        f"<x:Anchor>{column}, 15, {top}, 2, {column + 2}, 31, {top + 4}, 1</x:Anchor><x:AutoFill>False</x:AutoFill>"
        f"<x:Row>{row - 1}</x:Row><x:Column>{column - 1}</x:Column></x:ClientData></v:shape>"
    )


def _refer_to_boxes(package: PackageEdit, index: int, relation: str) -> None:
    """Let a sheet name the part with the boxes of its notes."""
    sheet = package.sheet(index)
    name = f"{{{_OFFICE}}}id"
    found = xml.child(sheet.root, "legacyDrawing")
    if found is None:
        found = etree.Element(xml.named_like(sheet.root, "legacyDrawing"), {}, {"r": _OFFICE})
        later = next((e for e in sheet.root.iterchildren("*") if xml.local(e) in _AFTER_BOXES), None)
        if later is None:
            sheet.root.append(found)
        else:
            later.addprevious(found)
    found.attrib.clear()
    found.set(name, relation)
    sheet.touch()


# ---- parts


def _free(package: PackageEdit, part: str) -> str:
    stem, suffix = posixpath.splitext(part)
    taken = {*package.book.parts, *(p.casefold() for p in package.added)}
    return next(name for n in range(len(taken) + 1) if (name := f"{stem}{n or ''}{suffix}").casefold() not in taken)


def _add_part(package: PackageEdit, kind: str, part: str) -> None:
    package.added[part] = _EMPTY[kind].encode()
    put_new(package, TYPES_PART, TYPES, "Override", {"PartName": f"/{part}", "ContentType": _TYPE[kind]})


def _relate(package: PackageEdit, source: str, relations: Sequence[tuple[str, str]]) -> list[str]:
    """Let a part refer to others, each with the type of the relation; their ids."""
    if not relations:
        return []
    rels = rels_of(source)
    there = package.part(rels).children(*RELATIONS) if rels in package.book else []
    taken = {e.get("Id", "") for e in there}
    free = (id for n in range(1, len(taken) + len(relations) + 1) if (id := f"rId{n}") not in taken)
    ids = [next(free) for _ in relations]
    made = [{"Id": id, "Type": kind, "Target": f"/{part}"} for id, (kind, part) in zip(ids, relations, strict=True)]
    if rels in package.book:
        for attributes in made:
            put_new(package, rels, RELATIONS, "Relationship", attributes)
    else:
        lines = (" ".join(f"{n}={quoteattr(v)}" for n, v in one.items()) for one in made)
        body = "".join(f"<Relationship {line}/>" for line in lines)
        package.added[rels] = f'{_DECLARED}<Relationships xmlns="{escape(_PACKAGE)}">{body}</Relationships>'.encode()
    return ids


# ---- looks


def set_look(package: PackageEdit, edit: SetLook) -> None:
    """Give a cell another look; raises SheetsError when the file has no styles."""
    parts = package.related(package.book.part, "styles")
    styles = package.part(parts[0]) if parts else None
    if styles is None:
        raise _no_styles()
    sheet = package.sheet(package.index(edit.sheet))

    def changed(style: int) -> int:
        wanted = (style, edit.bold, edit.fill, edit.wrap)
        if wanted not in package.styled:
            package.styled[wanted] = _styled(styles, style, edit)
        return package.styled[wanted]

    sheet.change_style(edit.row, edit.column, changed)


def _no_styles() -> SheetsError:
    return SheetsError(N_("This file has no formats of cells."), N_("Save it in Excel or LibreOffice once."))


def _styled(styles: XmlPart, style: int, edit: SetLook) -> int:
    """The number of a cell style like another one, with what the edit changes of it."""
    if not all(styles.children("styleSheet", name) for name in ("fonts", "fills", "cellXfs")):
        raise _no_styles()
    there = styles.children("styleSheet", "cellXfs")
    xf = deepcopy(there[style] if style < len(there) else there[0])
    if edit.bold is not None:
        _set_bold(styles, xf, edit.bold)
    if edit.fill is not None:
        _set_fill(styles, xf, edit.fill)
    if edit.wrap is not None:
        alignment = xml.child(xf, "alignment")
        if alignment is None:
            alignment = xml.add(xf, "alignment", {}, at=0)
        xml.set_attributes(alignment, {"wrapText": "1" if edit.wrap else "0"})
        xf.set("applyAlignment", "1")
    return place_style(styles, "cellXfs", xf, {})


def _set_bold(styles: XmlPart, xf: etree._Element, bold: bool) -> None:
    fonts = styles.children("styleSheet", "fonts")
    at = number(xf.get("fontId"))
    font = deepcopy(fonts[at] if at < len(fonts) else fonts[0])
    for mark in font.findall("{*}b"):
        font.remove(mark)
    if bold:
        xml.add(font, "b", {}, at=sum(xml.local(e) in _BEFORE_BOLD for e in list(font)[:3]))
    xf.set("fontId", str(place_style(styles, "fonts", font, {})))
    xf.set("applyFont", "1")


def _set_fill(styles: XmlPart, xf: etree._Element, fill: str) -> None:
    at = 0
    if fill:
        new = xml.new_element(styles.children("styleSheet", "fills")[0], "fill", {})
        pattern = xml.add(new, "patternFill", {"patternType": "solid"})
        xml.add(pattern, "fgColor", {"rgb": f"FF{fill}"})
        xml.add(pattern, "bgColor", {"indexed": "64"})
        at = place_style(styles, "fills", new, {})
    xf.set("fillId", str(at))
    xf.set("applyFill", "1")
