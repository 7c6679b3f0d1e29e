"""An .xlsx file being changed: its sheets as they are now, the parts that differ, and the new package."""

from __future__ import annotations

import io
import zipfile
from xml.sax.saxutils import escape

from rrp_sheets.workbook.patch.sheet_xml import SheetXml, may_have_formulas
from rrp_sheets.workbook.patch.xml_part import XmlPart, add, child, local, remove
from rrp_sheets.workbook.raw import Extent
from rrp_sheets.workbook.schema import Recognised, recognise
from rrp_sheets.workbook.sheet_names import sheet_named
from rrp_sheets.workbook.xlsx import XlsxBook

TYPES_PART = "[Content_Types].xml"
_CALC_CHAIN = "calcchain"
_BEFORE_CALC = ("sheets", "functionGroups", "externalReferences", "definedNames")
_ZIP64 = 1


class PackageEdit:
    """The package of one file while it is being changed; raises UnreadableFile as in reading."""

    def __init__(self, data: bytes, name: str) -> None:
        self._data = data
        self.book = XlsxBook(data, name)
        self.package = self.book.package
        self.dropped: set[str] = set()
        self.added: dict[str, bytes] = {}
        self._changed: dict[str, bytes] = {}
        self._parts: dict[str, XmlPart] = {}
        self._relations: dict[str, dict[str, tuple[str, str]]] = {}
        self._recognised: dict[int, Recognised] = {}
        self.formulas_moved = False
        self.reached: dict[int, int] = {}

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
        return self._changed[spelt] if spelt in self._changed else self.package.read(part)

    def write(self, part: str, data: bytes) -> None:
        """Change a part that is not taken for XML."""
        self._changed[part.casefold()] = data
        self._parts.pop(part.casefold(), None)

    def related(self, part: str, kind: str) -> list[str]:
        """The parts that a part refers to, of one kind (the last word of the relation's type, in small letters)."""
        if part not in self._relations:
            self._relations[part] = self.package.relations(part)
        return [t for k, t in self._relations[part].values() if k == kind and t in self.package]

    def has_formulas(self, index: int) -> bool:
        """Return whether a sheet may have formulas in its cells."""
        part = self.book.entries[index].part
        sheet = self._parts.get(part.casefold())
        return sheet.has_formulas if isinstance(sheet, SheetXml) else may_have_formulas(self.package.read(part))

    def mentions(self, index: int, name: str) -> bool:
        """Return whether a sheet's part may mention a sheet of that name."""
        data = self.package.read(self.book.entries[index].part)
        return any(escape(spelt).encode() in data for spelt in (name, name.replace("'", "''")))

    def to_bytes(self) -> bytes:
        """The whole file as it is now; the file's own bytes when nothing has changed."""
        if not (self._changed or self.added or any(part.touched for part in self._parts.values())):
            return self._data
        if self.formulas_moved:
            self._drop_calc_chain()
        if self.formulas_moved or any(self.has_formulas(i) for i in range(len(self.book.entries))):
            self._recalculate()
        return self._packed()

    def _packed(self) -> bytes:
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
        folder, _, leaf = self.book.part.rpartition("/")
        names = {"/" + p.casefold() for p in parts}
        for part, name in ((TYPES_PART, "Override"), (f"{folder}/_rels/{leaf}.rels", "Relationship")):
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
