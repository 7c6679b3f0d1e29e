"""An .xlsx file being changed: its sheets as they are now, values put into cells, and the new package.

Excel's own tables (a block of cells with a header, a name and a filter) are kept whole.
"""

from __future__ import annotations

import io
import zipfile
from dataclasses import replace
from xml.sax.saxutils import escape

from rrp_sheets.errors import SheetsError
from rrp_sheets.model.workbook import column_letters
from rrp_sheets.texts import N_
from rrp_sheets.workbook.edits import DeleteRows, InsertRows, RowEdit, SetCell, shown
from rrp_sheets.workbook.patch import xml_parts as xml
from rrp_sheets.workbook.raw import Extent, Range
from rrp_sheets.workbook.schema import Recognised, recognise
from rrp_sheets.workbook.sheet_names import sheet_named
from rrp_sheets.workbook.xlsx import LAST_COLUMN, LAST_ROW, XlsxBook, block_of, number, rels_of

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
        self._parts: dict[str, xml.XmlPart] = {}
        self._relations: dict[str, dict[str, tuple[str, str]]] = {}
        self._recognised: dict[int, Recognised] = {}
        self.formulas_moved = False
        self.ends: dict[int, int] = {}

    def note_end(self, index: int) -> None:
        """Remember where the filled rows of a sheet end, before it is changed."""
        if index not in self.ends:
            self.ends[index] = self.sheet(index).last_filled

    def index(self, sheet: str) -> int:
        """The number of the sheet of that name; raises SheetsError when there is none."""
        return self.book.names.index(sheet_named(self.book.names, sheet))

    def sheet(self, index: int) -> xml.SheetXml:
        """A sheet as it is now."""
        sheet = self.part(self.book.entries[index].part)
        assert isinstance(sheet, xml.SheetXml)
        return sheet

    @property
    def workbook(self) -> xml.XmlPart:
        """The part with the lists of sheets and names."""
        return self.part(self.book.part)

    def part(self, part: str) -> xml.XmlPart:
        """A part as it is now, to be looked at or changed."""
        spelt = part.casefold()
        if spelt not in self._parts:
            kind = xml.SheetXml if any(e.part.casefold() == spelt for e in self.book.entries) else xml.XmlPart
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
        return sheet.has_formulas if isinstance(sheet, xml.SheetXml) else xml.may_have_formulas(self.book.read(part))

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
        calc = xml.child(book.root, "calcPr")
        if calc is None:
            before = [e for e in book.root.iterchildren("*") if xml.local(e) in _BEFORE_CALC]
            if not before:
                return
            calc = xml.add(book.root, "calcPr", {}, at=book.root.index(before[-1]) + 1)
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
                    xml.remove(e)
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
    formula = xml.child(cell, "f") if cell is not None else None
    if formula is not None:
        if formula.get("t") == "shared":
            sheet.write_out()
        package.formulas_moved = True
    package.note_end(index)
    style, row, styles = sheet.style(edit.row, edit.column), sheet.row(edit.row), package.book.styles
    was_blank = row is None or not xml.is_filled(row)
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if is_number and (styles.is_text(style) or styles.kind(style)):
        value = shown(value)  # into a cell that shows numbers as text, or as dates
    sheet.set_cell(edit.row, edit.column, value, style)
    if was_blank and value not in (None, ""):
        for table in tables:
            table.append(edit.row, edit.column)


def _covers(block: Range, edit: SetCell) -> bool:
    return block.top <= edit.row <= block.bottom and block.left <= edit.column <= block.right


def _refuse_harm(sheet: xml.SheetXml, tables: list[SheetTable], edit: SetCell) -> None:
    """Refuse a cell that is hidden, or part of something that would break."""
    for block in sheet.merged():
        if _covers(block, edit) and (edit.row, edit.column) != (block.top, block.left):
            at, first, text = edit.place, f"{column_letters(block.left)}{block.top}", xml.block_text(block)
            told = N_("{cell} is hidden under {first}: the cells {cells} are merged.", cell=at, first=first, cells=text)
            raise SheetsError(told, N_("Set {first} instead, or unmerge the cells in Excel.", first=first))
    for block, what in sheet.ranges:
        if _covers(block, edit) and block.area > 1:
            text = xml.block_text(block)
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

    def __init__(self, part: xml.XmlPart, block: Range) -> None:
        self._part, self.block = part, block
        attributes = part.root.attrib
        self.name = attributes.get("displayName") or attributes.get("name", "")
        self.header = block.top if number(attributes.get("headerRowCount"), 1) else 0
        self.totals = block.bottom if number(attributes.get("totalsRowCount")) else 0

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
        old = xml.block_text(self.block)
        self.block = Range(self.block.top, self.block.left, bottom, self.block.right)
        for element in (self._part.root, xml.child(self._part.root, "autoFilter")):
            if element is not None and element.get("ref") == old:
                element.set("ref", xml.block_text(self.block))
                self._part.touch()


def sheet_tables(package: PackageEdit, index: int) -> list[SheetTable]:
    """The tables of a sheet as they are now."""
    parts = map(package.part, package.related(package.book.entries[index].part, "table"))
    found = ((part, block_of(part.root.get("ref", ""))) for part in parts if xml.local(part.root) == "table")
    return [SheetTable(part, block) for part, block in found if block]
