"""An .xlsx file being changed: its parts as XML, values put into cells, and the new package.

lxml edits the parts; prefixes, comments, attribute order and encoding are preserved. The rows of a sheet are kept as
bytes in blocks, of which only those that are looked at are parsed. Excel's own tables (a block of cells with a header,
a name and a filter) are kept whole.
"""

from __future__ import annotations

import codecs
import io
import re
import zipfile
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import islice
from xml.sax.saxutils import escape

from lxml import etree

from rrp_sheets.errors import SheetsError
from rrp_sheets.model.workbook import column_letters
from rrp_sheets.texts import N_
from rrp_sheets.workbook import limits
from rrp_sheets.workbook.edits import DeleteRows, InsertRows, RowEdit, SetCell, Value, content, shown
from rrp_sheets.workbook.raw import Extent, Range
from rrp_sheets.workbook.schema import Recognised, recognise
from rrp_sheets.workbook.sheet_names import sheet_named
from rrp_sheets.workbook.xlsx import DECLARED, LAST_COLUMN, LAST_ROW, XlsxBook, block_of, place, rels_of, translated
from rrp_sheets.workbook.xlsx import number as whole

_UNICODE = {codecs.BOM_UTF16_LE: "utf-16", codecs.BOM_UTF16_BE: "utf-16", codecs.BOM_UTF8: "utf-8-sig"}
_DECLARATION = re.compile(rb"\A\s*<\?xml\s[^>]*\?>\s*")
_DOCTYPE = re.compile(rb"(?>\s+|<\?(?>.*?(?:\?>|\Z))|<!--(?>.*?(?:-->|\Z)))*+<!DOCTYPE", re.DOTALL)
_TOO_DEEP = etree.XPath(f"boolean({'/*' * (limits.XML_DEPTH + 1)})")


def broken() -> SheetsError:
    """The error for XML that cannot be changed safely."""
    remedy = N_("Open the workbook in Excel or LibreOffice, save it under a new name, and use that.")
    return SheetsError(N_("A part of the file cannot be understood, so it is left as it is."), remedy)


def parse(data: bytes) -> etree._Element:
    """Parse UTF-8 without a declaration; raises SheetsError for broken or unsafe XML."""
    if _DOCTYPE.match(data):
        message = N_("A part of the file declares its own document type.")
        raise SheetsError(message, N_("Save the workbook again in Excel."))
    refuse_endless(data)
    parser = etree.XMLParser(
        encoding="utf-8", resolve_entities=False, no_network=True, huge_tree=False, load_dtd=False, strip_cdata=False
    )
    try:
        root = etree.fromstring(data, parser)
    except etree.XMLSyntaxError as error:
        raise broken() from error
    if _TOO_DEEP(root):
        raise broken()
    return root


def refuse_endless(data: bytes) -> None:
    """Raise SheetsError for more elements than may be read."""
    if data.count(b"<") - data.count(b"</") > limits.XML_ELEMENTS:
        raise broken()


class Touchable:
    """XML that is parsed to be looked at or changed; `touched` tells which."""

    touched = False

    def touch(self) -> None:
        """Note a change."""
        self.touched = True


class XmlPart(Touchable):
    """A part of a package; raises SheetsError for broken or unsafe XML."""

    def __init__(self, data: bytes) -> None:
        declared = DECLARED.search(data)
        self._encoding = next(
            (name for mark, name in _UNICODE.items() if data.startswith(mark)),
            declared[1].decode("ascii", "replace").casefold() if declared else "utf-8",
        )
        if self._encoding not in ("utf-8", "utf8"):
            try:
                data = data.decode(self._encoding).encode()
            except (UnicodeError, LookupError) as error:
                raise broken() from error
        found = _DECLARATION.match(data)
        self._declaration = found[0] if found else b""
        self.root = self._parse(data[len(self._declaration) :])

    def _parse(self, body: bytes) -> etree._Element:
        return parse(body)

    def container(self, *path: str) -> etree._Element | None:
        """The element at a path of local names, which begins with that of the first element."""
        found: etree._Element | None = self.root if local(self.root) == path[0] else None
        for name in path[1:]:
            found = child(found, name) if found is not None else None
        return found

    def children(self, *path: str) -> list[etree._Element]:
        """The elements inside of the one at a path."""
        container = self.container(*path)
        return [] if container is None else list(container.iterchildren("*"))

    def find(self, *names: str) -> Iterator[tuple[Touchable, etree._Element]]:
        """All elements of these local names, each with what is to be touched when it is changed."""
        yield from ((self, element) for element in list(self.root.iter(*(f"{{*}}{name}" for name in names))))

    def to_bytes(self) -> bytes:
        """The part as it is now, in its own encoding."""
        data = self._declaration + self._body()
        if self._encoding in ("utf-8", "utf8"):
            return data
        return data.decode().encode(self._encoding, "xmlcharrefreplace")

    def _body(self) -> bytes:
        return etree.tostring(self.root.getroottree(), encoding="UTF-8", xml_declaration=False)


def local(element: etree._Element) -> str:
    """An element's name without its namespace."""
    return str(element.tag).rpartition("}")[2]


def named_like(element: etree._Element, name: str) -> str:
    """A name in the namespace of an element."""
    space, bracket, _ = str(element.tag).rpartition("}")
    return f"{space}{bracket}{name}"


def child(element: etree._Element, name: str) -> etree._Element | None:
    """The first element of that local name inside of another."""
    return next(element.iterchildren(f"{{*}}{name}"), None)


def text_of(element: etree._Element) -> str:
    """The text of an element and all within it.

    >>> text_of(parse(b"<a>1 &lt; <b>2</b><!-- no --><![CDATA[ < 3]]></a>"))
    '1 < 2 < 3'
    """
    return "".join(map(str, element.itertext()))


def set_text(element: etree._Element, text: str) -> None:
    """Have a text alone inside of an element."""
    del element[:]
    element.text = text or None


def change_text(holder: Touchable, element: etree._Element, text: str) -> bool:
    """Give an element another text; False when it has it already."""
    if text == text_of(element):
        return False
    set_text(element, text)
    holder.touch()
    return True


def set_attributes(element: etree._Element, changes: Mapping[str, str | None]) -> bool:
    """Change attributes, add them at the end, or (None) take them out; False when they were so already.

    >>> c = parse(b'<c r="A1" t="s"/>')
    >>> set_attributes(c, {"r": "A2", "t": None, "s": "3"}), etree.tostring(c)
    (True, b'<c r="A2" s="3"/>')
    """
    changes = {name: value for name, value in changes.items() if element.get(name) != value}
    for name, value in changes.items():
        if value is None:
            del element.attrib[name]
        else:
            element.set(name, value)
    return bool(changes)


def add(
    container: etree._Element, name: str, attributes: Mapping[str, str], text: str = "", at: int | None = None
) -> etree._Element:
    """Add an element of the container's namespace, at the end or at a place."""
    new = etree.SubElement(container, named_like(container, name), dict(attributes))
    new.text = text or None
    if at is not None:
        container.insert(at, new)
    return new


def new_element(like: etree._Element, name: str, attributes: Mapping[str, str]) -> etree._Element:
    """Return an element that is in no tree yet, with the namespaces of another one."""
    return etree.Element(named_like(like, name), dict(attributes), like.nsmap)  # type: ignore[arg-type]


def remove(element: etree._Element) -> None:
    """Take an element out of its tree."""
    parent = element.getparent()
    if parent is not None:
        parent.remove(element)


def canonical(element: etree._Element) -> bytes:
    """Return the canonical form (C14N) of an element, the same for equal ones."""
    return etree.tostring(element, method="c14n", exclusive=True, with_tail=False)


DATA_TABLE = N_("a data table")
_BLOCK_ROWS, _NEVER = 256, 1 << 30
_PLACES = re.compile(
    rb"<!--(?>.*?(?:-->|\Z))|<!\[CDATA\[(?>.*?(?:\]\]>|\Z))|<\?(?>.*?(?:\?>|\Z))"
    rb"|<(?P<end>/?)(?:[\w.-]+:)?(?P<name>sheetData|row)(?=[\s/>])(?P<rest>(?:[^<>\"']|\"[^\"<]*\"|'[^'<]*')*)>",
    re.DOTALL,
)
_NUMBER = re.compile(rb"""(?:\A|\s)r\s*=\s*["'](\d{1,7})["']""")
_FORMULA = re.compile(rb"<(?:[\w.-]+:)?f[\s/>]")
_REFERENCE = re.compile(rb"<(?:[\w.-]+:)?(?:f|formula[12]?|calculatedColumnFormula|totalsRowFormula|hyperlink)[\s/>]")
LINKED = re.compile(
    rb"""(\b(?:textlink|fmlaLink|fmlaRange|fmlaTxbx)\s*=\s*")([^"]*)(")|(<x:Fmla\w*>)([^<]*)(</x:Fmla)"""
)
"""A formula of a shape or a button between what is before and after it: groups 1 to 3, in an element 4 to 6."""
_MANY_CELLS = [quote + word + quote for word in (b"shared", b"array", b"dataTable") for quote in (b'"', b"'")]
_ROWS_HERE = b"<?rows here?>"


def may_have_formulas(data: bytes) -> bool:
    """Return whether there may be formulas in cells of a part."""
    return _FORMULA.search(data) is not None


def may_refer(data: bytes) -> bool:
    """Return whether there may be formulas anywhere in a part, or links."""
    return _REFERENCE.search(data) is not None


def block_text(block: Range) -> str:
    """A block as a reference.

    >>> block_text(Range(2, 2, 9, 3)), block_text(Range(2, 2, 2, 2))
    ('B2:C9', 'B2')
    """
    first = f"{column_letters(block.left)}{block.top}"
    last = f"{column_letters(block.right)}{block.bottom}"
    return first if first == last else f"{first}:{last}"


@dataclass(slots=True)
class CellFormula:
    """A formula in a cell (`place`: `C5`), with its text there; touch `block` when `element` is changed."""

    block: RowBlock
    row: int
    column: int
    place: str
    element: etree._Element
    text: str


def cells(row: etree._Element) -> list[tuple[int, etree._Element]]:
    """The cells of a row with their columns."""
    found, column = [], 0
    for cell in row.iterchildren("{*}c"):
        at = place(cell.get("r", ""))
        column = at[1] if at else column + 1
        found.append((column, cell))
    return found


def is_filled(row: etree._Element) -> bool:
    """Return whether a cell of the row has a content."""
    return any(len(cell) for cell in row.iterchildren("{*}c"))


def renumber(row: etree._Element, number: int) -> etree._Element:
    """Give a row another number, and its cells their new references."""
    text = str(number)
    row.set("r", text)
    for cell in row.iterchildren("{*}c"):
        if (old := cell.get("r")) is not None:
            cell.set("r", old.rstrip("0123456789") + text)
    return row


class RowBlock(Touchable):
    """Rows that follow each other, none before `first`; in a `special` block a formula may stand for several cells."""

    def __init__(self, sheet: SheetXml, data: bytes, first: int) -> None:
        self._sheet, self.first = sheet, first
        self._table: etree._Element | None = None
        self._rows: dict[int, etree._Element] | None = None
        self._keep(data)

    def _keep(self, data: bytes) -> None:
        self._data = data
        self.special = any(word in data for word in _MANY_CELLS)

    @property
    def table(self) -> etree._Element:
        """The rows within an element of their own."""
        if self._table is None:
            self._table = parse(self._data.join(self._sheet.frame))
        return self._table

    @property
    def rows(self) -> dict[int, etree._Element]:
        """The rows by number."""
        if self._rows is None:
            number, rows = max(self.first - 1, 0), {}
            for row in self.table.iterchildren("*"):
                before, number = number, whole(row.get("r"), number + 1)
                if local(row) != "row" or number <= before:
                    raise broken()
                rows[number] = row
            self._rows = rows
        return self._rows

    @property
    def has_formulas(self) -> bool:
        """True when there may be formulas."""
        if self._table is None:
            return may_have_formulas(self._data)
        return next(self._table.iter("{*}f"), None) is not None

    def touch(self) -> None:
        """Note a change, of the sheet too."""
        super().touch()
        self._sheet.touch()

    def take(self, rows: dict[int, etree._Element]) -> None:
        """Have these rows, which get their numbers, instead of those there were."""
        table, there = self.table, list(self.rows.values())
        staying = set(rows.values())
        for row in there:
            if row not in staying:
                table.remove(row)
        left = iter([row for row in there if row in staying])
        following = next(left, None)
        for number, row in sorted(rows.items()):
            if whole(row.get("r")) != number:
                renumber(row, number)
            if row is following:
                following = next(left, None)
            elif following is None:
                table.append(row)
            else:
                table.insert(table.index(following), row)
        self.first, self._rows = min(rows, default=_NEVER), None
        self.touch()

    def add(self, number: int) -> etree._Element:
        """Add a row without cells."""
        later = next((row for n, row in self.rows.items() if n > number), None)
        new = add(self.table, "row", {"r": str(number)}, at=None if later is None else self.table.index(later))
        self.first, self._rows = min(self.first, number), None
        return new

    def close(self) -> bytes:
        """Drop the tree; the bytes of the rows as they are now."""
        if self.touched:
            start, end = self._sheet.frame
            data = etree.tostring(self.table, encoding="UTF-8")
            self._keep(data[len(start) : -len(end)] if data.endswith(end) else b"")
        self._table, self._rows, self.touched = None, None, False
        return self._data


class SheetXml(XmlPart):
    """A sheet taken apart: its `root` without rows, the `table` that they belong to, and the rows in `blocks`.

    `frame` are the tags around the rows of a block when it is parsed alone.
    """

    def _parse(self, body: bytes) -> etree._Element:
        refuse_endless(body)
        begin, cuts, end = _cut(body)
        root = parse(body[:begin] + body[end:])
        table = child(root, "sheetData")
        if table is None or len(table) or local(root) != "worksheet":
            raise broken()
        self.table = table
        empty = bytes(etree.tostring(new_element(table, "sheetData", {}), encoding="UTF-8")).removesuffix(b"/>")
        name = re.match(rb"<[^\s/>]+", empty)
        assert name is not None
        self.frame = (empty + b">", b"</" + name[0][1:] + b">")
        places = [begin, *(at for at, _ in cuts), end]
        firsts = [0, *(first for _, first in cuts)]
        if firsts != sorted(set(firsts)):
            raise broken()
        self.blocks = [RowBlock(self, body[places[i] : places[i + 1]], first) for i, first in enumerate(firsts)]
        self._ranges: list[tuple[Range, str]] | None = None
        self._columns: set[int] | None = None
        return root

    def find(self, *names: str) -> Iterator[tuple[Touchable, etree._Element]]:
        """All elements of these local names, those in rows with formulas too."""
        yield from super().find(*names)
        for block in self.walk():
            if block.has_formulas:
                for element in list(block.table.iter(*(f"{{*}}{name}" for name in names))):
                    yield block, element

    def walk(self, start: int = 0) -> Iterator[RowBlock]:
        """The blocks one after the other from the one with a row on; each is parsed only while it is looked at."""
        for block in self.blocks[self.blocks.index(self.block(start)) :]:
            yield block
            block.close()

    def block(self, row: int) -> RowBlock:
        """The block with a row, or where it would be."""
        return next((b for b in reversed(self.blocks) if b.first <= row), self.blocks[0])

    def row(self, number: int) -> etree._Element | None:
        """The row of that number, if it exists."""
        return self.block(number).rows.get(number)

    def elements(self, *names: str) -> list[etree._Element]:
        """The elements of these local names outside of the rows."""
        return list(self.root.iter(*(f"{{*}}{name}" for name in names)))

    def rules(self) -> list[etree._Element]:
        """The formulas of drop-down lists and conditional formats."""
        found = self.elements("formula", "formula1", "formula2", "f")
        return [e for e in found if next(e.iterancestors("{*}sparkline"), None) is None]

    def merged(self) -> list[Range]:
        """The merged blocks."""
        blocks = (block_of(e.get("ref", "")) for e in self.elements("mergeCell"))
        return [b for b in blocks if b]

    @property
    def last(self) -> int:
        """The number of the last row; 0 where there is none."""
        return next((max(b.rows) for b in reversed(self.blocks) if b.rows), 0)

    @property
    def last_filled(self) -> int:
        """The number of the last row with a content; 0 where there is none."""
        found = ((n for n, row in reversed(b.rows.items()) if is_filled(row)) for b in reversed(self.blocks))
        return next((n for numbers in found for n in numbers), 0)

    @property
    def has_formulas(self) -> bool:
        """True when a cell may have a formula."""
        return any(block.has_formulas for block in self.blocks)

    @property
    def ranges(self) -> list[tuple[Range, str]]:
        """The blocks of cells that array formulas and data tables fill, each with what messages call it."""
        if self._ranges is None:
            self._ranges = []
            for block in self.blocks:
                for f in block.table.iter("{*}f") if block.special else ():
                    kind = f.get("t")
                    if kind in ("array", "dataTable") and (at := block_of(f.get("ref", ""))):
                        self._ranges.append((at, N_("an array formula") if kind == "array" else DATA_TABLE))
        return self._ranges

    def formulas(self) -> Iterator[CellFormula]:
        """Every formula; one that stands once for several cells (`t="shared"`) as it is in each of them."""
        masters: dict[str, tuple[str, str]] = {}
        for block in self.walk():
            for number, row in block.rows.items() if block.has_formulas else ():
                if next(row.iter("{*}f"), None) is None:
                    continue
                for column, cell in cells(row):
                    f = child(cell, "f")
                    if f is None:
                        continue
                    text, at = text_of(f), f"{column_letters(column)}{number}"
                    if f.get("t") == "shared":
                        group = f.get("si", "")
                        if text:
                            masters[group] = (text, at)
                        elif group in masters:
                            text = translated(*masters[group], at)
                    yield CellFormula(block, number, column, at, f, text)

    def write_out(self) -> None:
        """Give every cell its own formula, so that rows are independent; what is calculated stays the same."""
        if not any(block.special for block in self.blocks):
            return
        for formula in self.formulas():
            if formula.element.get("t") == "shared":
                set_text(formula.element, formula.text)
                formula.element.attrib.clear()
                formula.block.touch()

    def cell(self, row: int, column: int) -> etree._Element | None:
        """The cell at a place, if it exists."""
        found = self.row(row)
        return next((c for at, c in cells(found) if at == column), None) if found is not None else None

    def style(self, row: int, column: int) -> int:
        """The style that the cell has, or would get: the row's or the column's."""
        cell = self.cell(row, column)
        if cell is not None:
            return whole(cell.get("s"))
        line = self.row(row)
        if line is not None and line.get("customFormat") in ("1", "true"):
            return whole(line.get("s"))
        runs = (c for c in self.elements("col") if whole(c.get("min")) <= column <= whole(c.get("max")))
        return next((whole(col.get("style")) for col in runs), 0)

    def set_cell(self, row: int, column: int, value: Value, style: int) -> None:
        """Put a value into a cell, which then has this style."""
        cell = self.cell(row, column)
        if cell is None and value in (None, "") and style == self.style(row, column):
            return
        block = self.block(row)
        line = block.rows[row] if row in block.rows else block.add(row)
        set_attributes(line, {"spans": None})
        if cell is None:
            later = [(at, c) for at, c in cells(line) if at > column]
            for at, c in later:  # they may have counted on from the one before
                if c.get("r") is None:
                    c.set("r", f"{column_letters(at)}{row}")
            cell = add(line, "c", {}, at=line.index(later[0][1]) if later else None)
            self._columns = {column, *(self._columns or ())}
        if cell.get("r") is None:
            cell.set("r", f"{column_letters(column)}{row}")
        set_attributes(cell, {"s": str(style) if style else None, "cm": None, "vm": None})
        put_value(cell, value)
        block.touch()

    def change_style(self, row: int, column: int, changed: Callable[[int], int]) -> None:
        """Give a cell another style, made from the one that it has; its content stays."""
        cell = self.cell(row, column)
        if cell is None:
            self.set_cell(row, column, None, changed(self.style(row, column)))
        elif set_attributes(cell, {"s": str(changed(whole(cell.get("s"))))}):
            self.block(row).touch()

    def insert(self, before: int, rows: Iterable[etree._Element]) -> None:
        """Put rows, which have their numbers, where there are none yet: before the row `before` and those after it."""
        block = self.block(before)
        old = block.rows
        later = {n: row for n, row in old.items() if n >= before}
        new, coming = [], iter(rows)
        while chunk := list(islice(coming, _BLOCK_ROWS)):
            new.append(self._block(chunk))
        if later:
            block.take({n: row for n, row in old.items() if n < before})
            new.append(self._block(later.values()))
        at = self.blocks.index(block) + 1
        self.blocks[at:at] = new
        self.rows_changed()

    def _block(self, rows: Iterable[etree._Element]) -> RowBlock:
        found = {whole(row.get("r")): row for row in rows}
        block = RowBlock(self, b"", min(found))
        block.take(found)
        block.close()
        return block

    def rows_changed(self) -> None:
        """Note that rows were added, renumbered or taken out."""
        self._ranges = None
        self.touched = True
        self._columns = self._columns or set()

    def _body(self) -> bytes:
        dimension = child(self.root, "dimension")
        if self._columns is not None and dimension is not None:
            first, last = _used(self.blocks, 1), _used(reversed(self.blocks), -1)
            old = block_of(dimension.get("ref", ""))
            columns = self._columns | ({old.left, old.right} if old else {1})
            if first and last:
                dimension.set("ref", block_text(Range(first, min(columns), last, max(columns))))
        rows = b"".join(block.close() for block in self.blocks)
        if not rows:
            return super()._body()
        mark = etree.ProcessingInstruction("rows", "here")
        self.table.append(mark)
        before, _, after = super()._body().partition(_ROWS_HERE)
        self.table.remove(mark)
        return before + rows + after


def put_value(cell: etree._Element, value: Value) -> None:
    """Give a cell its content, and the type that belongs to it."""
    set_text(cell, "")
    kind, name, text = content(value)
    set_attributes(cell, {"t": kind})
    if name == "v":
        add(cell, "v", {}, text)
    elif name:
        inside = add(add(cell, "is", {}), "t", {}, text)
        if re.search(r"\A\s|\s\s|[\n\t]|\s\Z", str(value)):
            inside.set("{http://www.w3.org/XML/1998/namespace}space", "preserve")


def blank_like(row: etree._Element) -> etree._Element:
    """A blank row that looks like another."""
    new = new_element(row, "row", {str(name): str(value) for name, value in row.attrib.items()})
    set_attributes(new, dict.fromkeys(("hidden", "collapsed", "spans")))
    if new.get("customHeight") not in ("1", "true"):
        set_attributes(new, {"ht": None})
    for column, cell in cells(row):
        if style := cell.get("s"):
            add(new, "c", {"r": f"{column_letters(column)}{row.get('r', 1)}", "s": style})
    return new


def _used(blocks: Iterable[RowBlock], step: int) -> int:
    """The first row in this order that has cells, be they blank; 0 where there is none."""
    rows = (item for block in blocks for item in list(block.rows.items())[::step])
    return next((number for number, row in rows if child(row, "c") is not None), 0)


def _cut(body: bytes) -> tuple[int, list[tuple[int, int]], int]:
    """Return the place of the rows' begin, those of later blocks with their first numbers, and that of the end."""
    begin, count, number, cuts = 0, 0, 0, list[tuple[int, int]]()
    for match in _PLACES.finditer(body):
        if match["name"] == b"sheetData":
            if match["rest"].endswith(b"/") and not begin:
                return match.end(), [], match.end()
            if match["end"]:
                return begin, cuts, match.start()
            begin = begin or match.end()
        elif match["name"] and begin and not match["end"]:
            named = _NUMBER.search(match["rest"])
            number = int(named[1]) if named else number + 1
            if count == _BLOCK_ROWS:
                cuts.append((match.start(), number))
                count = 0
            count += 1
    raise broken()


TYPES_PART = "[Content_Types].xml"
_CALC_CHAIN = "calcchain"
_BEFORE_CALC = ("sheets", "functionGroups", "externalReferences", "definedNames")
_ZIP64 = 1


class PackageEdit:
    """The package of one file while it is being changed; raises UnreadableFile as in reading."""

    def __init__(self, data: bytes, name: str) -> None:
        self._data = data
        self.book = XlsxBook(data, name)
        self.dropped: set[str] = set()
        self.added: dict[str, bytes] = {}
        self._changed: dict[str, bytes] = {}
        self._parts: dict[str, XmlPart] = {}
        self._relations: dict[str, dict[str, tuple[str, str]]] = {}
        self._recognised: dict[int, Recognised] = {}
        self.formulas_moved = False
        self.ends: dict[int, int] = {}
        self.styled: dict[tuple[object, ...], int] = {}

    def note_end(self, index: int) -> None:
        """Remember where the filled rows of a sheet end, before it is changed."""
        if index not in self.ends:
            self.ends[index] = self.sheet(index).last_filled

    def index(self, sheet: str) -> int:
        """The number of the sheet of that name; raises SheetsError when there is none."""
        return self.book.names.index(sheet_named(self.book.names, sheet))

    def sheet(self, index: int) -> SheetXml:
        """A sheet as it is now."""
        sheet = self.part(self.book.entries[index].part)
        assert isinstance(sheet, SheetXml)
        return sheet

    @property
    def workbook(self) -> XmlPart:
        """The part with the lists of sheets and names."""
        return self.part(self.book.part)

    def part(self, part: str) -> XmlPart:
        """A part as it is now, to be looked at or changed."""
        spelt = part.casefold()
        if spelt not in self._parts:
            kind = SheetXml if any(e.part.casefold() == spelt for e in self.book.entries) else XmlPart
            self._parts[spelt] = kind(self.read(part))
        return self._parts[spelt]

    def recognised(self, index: int) -> Recognised:
        """Return the kind and columns that the sheet had when the file was opened."""
        if index not in self._recognised:
            self._recognised[index] = recognise(self.book.sheet(index, Extent.HEAD))
        return self._recognised[index]

    def read(self, part: str) -> bytes:
        """The bytes of a part as it is now."""
        spelt = part.casefold()
        if spelt in self._parts and self._parts[spelt].touched:
            return self._parts[spelt].to_bytes()
        return self._changed[spelt] if spelt in self._changed else self.book.read(part)

    def write(self, part: str, data: bytes) -> None:
        """Change a part that is not taken for XML."""
        self._changed[part.casefold()] = data
        self._parts.pop(part.casefold(), None)

    def related(self, part: str, kind: str) -> list[str]:
        """The parts that a part refers to, of one kind (the last word of the relation's type, in small letters)."""
        if part not in self._relations:
            self._relations[part] = self.book.relations(part)
        return [t for k, t in self._relations[part].values() if k == kind and t in self.book]

    def has_formulas(self, index: int) -> bool:
        """Return whether a sheet may have formulas in its cells."""
        part = self.book.entries[index].part
        sheet = self._parts.get(part.casefold())
        return sheet.has_formulas if isinstance(sheet, SheetXml) else may_have_formulas(self.book.read(part))

    def mentions(self, index: int, name: str) -> bool:
        """Return whether a sheet's part may mention a sheet of that name."""
        data = self.book.read(self.book.entries[index].part)
        return any(escape(spelt).encode() in data for spelt in (name, name.replace("'", "''")))

    def to_bytes(self) -> bytes:
        """The whole file as it is now; the file's own bytes when nothing has changed."""
        if not (self._changed or self.added or any(part.touched for part in self._parts.values())):
            return self._data
        if self.formulas_moved:
            self._drop_calc_chain()
        if self.formulas_moved or any(self.has_formulas(i) for i in range(len(self.book.entries))):
            self._recalculate()
        out = io.BytesIO()
        with zipfile.ZipFile(io.BytesIO(self._data)) as old, zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as new:
            new.comment = old.comment
            for entry in old.infolist():
                spelt = entry.filename.casefold()
                if spelt in self.dropped:
                    continue
                content = self.read(spelt) if spelt in self._parts or spelt in self._changed else old.read(entry)
                entry.extra = _without(entry.extra, _ZIP64)
                new.writestr(entry, content)
            for name, content in self.added.items():
                entry = zipfile.ZipInfo(name, (2026, 1, 1, 0, 0, 0))
                entry.compress_type = zipfile.ZIP_DEFLATED
                new.writestr(entry, content)
        return out.getvalue()

    def _recalculate(self) -> None:
        """Have the spreadsheet program calculate the user's own formulas anew when it opens the file."""
        book = self.workbook
        calc = child(book.root, "calcPr")
        if calc is None:
            before = [e for e in book.root.iterchildren("*") if local(e) in _BEFORE_CALC]
            if not before:
                return
            calc = add(book.root, "calcPr", {}, at=book.root.index(before[-1]) + 1)
        if calc.get("fullCalcOnLoad") not in ("1", "true"):
            calc.set("fullCalcOnLoad", "1")
            book.touch()

    def _drop_calc_chain(self) -> None:
        """Take out the order of calculation, which names cells; spreadsheet programs make it anew."""
        parts = self.related(self.book.part, _CALC_CHAIN)
        if not parts:
            return
        names = {"/" + p.casefold() for p in parts}
        for part, name in ((TYPES_PART, "Override"), (rels_of(self.book.part), "Relationship")):
            for holder, e in self.part(part).find(name):
                kind = e.get("Type", "").casefold()
                if e.get("PartName", "").casefold() in names or kind.endswith("/" + _CALC_CHAIN):
                    remove(e)
                    holder.touch()
        self.dropped |= {p.casefold() for p in parts}


def _without(extra: bytes, kind: int) -> bytes:
    """A zip entry's extra fields without those of one kind; sizes of large files are written anew."""
    out, at = b"", 0
    while at + 4 <= len(extra):
        end = at + 4 + int.from_bytes(extra[at + 2 : at + 4], "little")
        if int.from_bytes(extra[at : at + 2], "little") != kind:
            out += extra[at:end]
        at = end
    return out


def set_cell(package: PackageEdit, edit: SetCell) -> None:
    """Write a text, number or truth value to one place of a sheet.

    Raises SheetsError where the cell does not exist, cannot hold the value, or belongs to something that would break.
    """
    index = package.index(edit.sheet)
    edit = replace(edit, sheet=package.book.names[index])
    if not (1 <= edit.row <= LAST_ROW and 1 <= edit.column <= LAST_COLUMN):
        message = N_("There is no cell {cell}.", cell=edit.place)
        raise SheetsError(message, N_("A sheet has 1,048,576 rows and the columns A to XFD."))
    value = edit.checked_value()
    sheet = package.sheet(index)
    tables = sheet_tables(package, index)
    _refuse_harm(sheet, tables, edit)
    cell = sheet.cell(edit.row, edit.column)
    formula = child(cell, "f") if cell is not None else None
    if formula is not None:
        if formula.get("t") == "shared":
            sheet.write_out()
        package.formulas_moved = True
    package.note_end(index)
    style, row, styles = sheet.style(edit.row, edit.column), sheet.row(edit.row), package.book.styles
    was_blank = row is None or not is_filled(row)
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if is_number and (styles.is_text(style) or styles.kind(style)):
        value = shown(value)  # into a cell that shows numbers as text, or as dates
    sheet.set_cell(edit.row, edit.column, value, style)
    if was_blank and value not in (None, ""):
        for table in tables:
            table.append(edit.row, edit.column)


def _covers(block: Range, edit: SetCell) -> bool:
    return block.top <= edit.row <= block.bottom and block.left <= edit.column <= block.right


def _refuse_harm(sheet: SheetXml, tables: list[SheetTable], edit: SetCell) -> None:
    """Refuse a cell that is hidden, or part of something that would break."""
    for block in sheet.merged():
        if _covers(block, edit) and (edit.row, edit.column) != (block.top, block.left):
            at, first, text = edit.place, f"{column_letters(block.left)}{block.top}", block_text(block)
            told = N_("{cell} is hidden under {first}: the cells {cells} are merged.", cell=at, first=first, cells=text)
            raise SheetsError(told, N_("Set {first} instead, or unmerge the cells in Excel.", first=first))
    for block, what in sheet.ranges:
        if _covers(block, edit) and block.area > 1:
            text = block_text(block)
            told = N_("{cell} belongs to {what} that fills {cells}.", cell=edit.place, what=what, cells=text)
            raise SheetsError(told, N_("In Excel, select {cells}, press Delete, and then set the cell.", cells=text))
    for table in tables:
        for row, message in (
            (table.header, N_("{cell} is in the header of the Excel table “{table}”, which would be damaged.")),
            (table.totals, N_("{cell} is in the totals row of the Excel table “{table}”, which would be damaged.")),
        ):
            if edit.row == row and _covers(table.block, edit):
                told = N_(message, cell=edit.place, table=table.name)
                raise SheetsError(told, N_("Change it in Excel or LibreOffice."))


class SheetTable:
    """An Excel table (list object): its part of the package and the `block` it covers, with header and totals.

    `header` and `totals` are their rows; 0 where it has none.
    """

    def __init__(self, part: XmlPart, block: Range) -> None:
        self._part, self.block = part, block
        attributes = part.root.attrib
        self.name = attributes.get("displayName") or attributes.get("name", "")
        self.header = block.top if whole(attributes.get("headerRowCount"), 1) else 0
        self.totals = block.bottom if whole(attributes.get("totalsRowCount")) else 0

    def append(self, row: int, column: int) -> None:
        """Take in the row directly below, as Excel does when one types there."""
        if not self.totals and row == self.block.bottom + 1 and self.block.left <= column <= self.block.right:
            self._resize(row)

    def fits(self, edit: RowEdit) -> bool:
        """Return whether an edit of rows leaves the table whole: header and totals in place, its rows inside."""
        top, bottom = self.block.top + bool(self.header), self.block.bottom - bool(self.totals)
        if isinstance(edit, InsertRows):
            return edit.before > self.block.bottom or (top <= edit.before <= bottom and not self.totals)
        if isinstance(edit, DeleteRows):
            last = edit.first + edit.count - 1
            inside = top <= edit.first and last <= bottom and edit.count < bottom - top + 1 and not self.totals
            return edit.first > self.block.bottom or inside
        rows = [r for r in range(self.block.top, self.block.bottom + 1) if edit.mapped(r) != r]
        low, high = edit.start, max(edit.before - 1, edit.first + edit.count - 1)
        return not rows or (top <= low and high <= bottom)

    def follow(self, edit: RowEdit) -> None:
        """Grow or shrink with rows that are inserted or deleted inside."""
        if isinstance(edit, InsertRows) and edit.before <= self.block.bottom:
            self._resize(self.block.bottom + edit.count)
        if isinstance(edit, DeleteRows) and edit.first <= self.block.bottom:
            self._resize(self.block.bottom - edit.count)

    def _resize(self, bottom: int) -> None:
        old = block_text(self.block)
        self.block = Range(self.block.top, self.block.left, bottom, self.block.right)
        for element in (self._part.root, child(self._part.root, "autoFilter")):
            if element is not None and element.get("ref") == old:
                element.set("ref", block_text(self.block))
                self._part.touch()


def sheet_tables(package: PackageEdit, index: int) -> list[SheetTable]:
    """The tables of a sheet as they are now."""
    parts = map(package.part, package.related(package.book.entries[index].part, "table"))
    found = ((part, block_of(part.root.get("ref", ""))) for part in parts if local(part.root) == "table")
    return [SheetTable(part, block) for part, block in found if block]
