"""An .xlsx file being changed: its sheets as they are now, the parts that differ, and the new package."""

from __future__ import annotations

import io
import re
import zipfile
from html import escape

from rrp_sheets.errors import SheetsError
from rrp_sheets.model.names import key
from rrp_sheets.workbook.headers import Recognised, recognise
from rrp_sheets.workbook.patch.markup import as_utf8, find, splice, with_attributes
from rrp_sheets.workbook.patch.sheet_xml import SheetXml
from rrp_sheets.workbook.raw import Extent
from rrp_sheets.workbook.xlsx_sheet import XlsxBook

_CALC_CHAIN = "calcchain"
_BEFORE_CALC = ("sheets", "functionGroups", "externalReferences", "definedNames")
_FORMULA = re.compile(rb"<(?:\w+:)?f[\s>/]")
_ZIP64 = 1


class PackageEdit:
    """The package of one file while it is being changed.

    Args:
        data: the file's bytes.
        name: the file's name, for messages.

    Raises:
        UnreadableFile: for what is broken or refused, as in reading.
    """

    def __init__(self, data: bytes, name: str) -> None:
        self._data = data
        self.book = XlsxBook(data, name)
        self.package = self.book.package
        self.changed: dict[str, bytes] = {}
        self.dropped: set[str] = set()
        self.added: dict[str, bytes] = {}
        self._sheets: dict[int, SheetXml] = {}
        self._relations: dict[str, dict[str, tuple[str, str]]] = {}
        self._recognised: dict[int, Recognised] = {}
        self.formulas_moved = False
        self.reached: dict[int, int] = {}

    def index(self, sheet: str) -> int:
        """The number of the sheet of that name; raises SheetsError when there is none."""
        names = self.book.names
        if sheet in names:
            return names.index(sheet)
        found = [i for i, n in enumerate(names) if key(n) == key(sheet)]
        if not found:
            raise SheetsError(f"There is no sheet “{sheet}”.", f"The sheets are: {', '.join(names)}.")
        return found[0]

    def sheet(self, index: int) -> SheetXml:
        """A sheet as it is now."""
        if index not in self._sheets:
            self._sheets[index] = SheetXml(self.package.read(self.book.entries[index].part))
        return self._sheets[index]

    def renew(self, index: int) -> SheetXml:
        """Take a sheet that was changed apart again, after its rows got other numbers."""
        touched = self.sheet(index).touched
        self._sheets[index] = SheetXml(self.sheet(index).to_bytes())
        self._sheets[index].touched = touched
        return self._sheets[index]

    def recognised(self, index: int) -> Recognised:
        """Return the kind and columns that the sheet had when the file was opened."""
        if index not in self._recognised:
            self._recognised[index] = recognise(self.book.sheet(index, Extent.HEAD))
        return self._recognised[index]

    def read(self, part: str) -> bytes:
        """A part as it is now."""
        return self.changed.get(part.casefold()) or self.package.read(part)

    def write(self, part: str, data: bytes) -> None:
        """Change a part."""
        self.changed[part.casefold()] = data

    def related(self, part: str, kind: str) -> list[str]:
        """The parts that a part refers to, of one kind (the last word of the relation's type, in small letters)."""
        if part not in self._relations:
            self._relations[part] = self.package.relations(part)
        return [t for k, t in self._relations[part].values() if k == kind and t in self.package]

    def has_formulas(self, index: int, pattern: re.Pattern[bytes] = _FORMULA) -> bool:
        """Return whether a sheet may have formulas: in its cells, or elsewhere as a pattern finds them."""
        if index in self._sheets and pattern is _FORMULA:
            return any(row.formulas for row in self._sheets[index].rows.values())
        return pattern.search(self.package.read(self.book.entries[index].part)) is not None

    def mentions(self, index: int, name: str) -> bool:
        """Return whether a sheet's part may mention a sheet of that name."""
        return escape(name).encode() in self.package.read(self.book.entries[index].part)

    def to_bytes(self) -> bytes:
        """The whole file as it is now; the file's own bytes when nothing has changed."""
        calculates = any(self.has_formulas(i) for i in range(len(self.book.entries)))
        for index, sheet in self._sheets.items():
            if sheet.touched:
                self.write(self.book.entries[index].part, sheet.to_bytes())
        if not (self.changed or self.added):
            return self._data
        if self.formulas_moved:
            self._drop_calc_chain()
        if calculates or self.formulas_moved:
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
                content = self.changed[spelt] if spelt in self.changed else old.read(entry)
                entry.extra = _without(entry.extra, _ZIP64)
                new.writestr(entry, content)
            for name, content in self.added.items():
                entry = zipfile.ZipInfo(name, (2026, 1, 1, 0, 0, 0))
                entry.compress_type = zipfile.ZIP_DEFLATED
                new.writestr(entry, content)
        return out.getvalue()

    def _recalculate(self) -> None:
        """Have the spreadsheet program calculate the user's own formulas anew when it opens the file."""
        data = as_utf8(self.read(self.book.part))
        found = find(data, lambda path: len(path) == 2)
        calc = next((e for e in found if e.local == "calcPr"), None)
        if calc is not None:
            if calc.attributes.get("fullCalcOnLoad") not in ("1", "true"):
                tag = with_attributes(data[calc.start : calc.inner], {"fullCalcOnLoad": "1"})
                self.write(self.book.part, splice(data, [(calc.start, calc.inner, tag)]))
            return
        last = next((e for e in reversed(found) if e.local in _BEFORE_CALC), None)
        if last is not None:
            new = f'<{last.prefix}calcPr fullCalcOnLoad="1"/>'.encode()
            self.write(self.book.part, splice(data, [(last.end, last.end, new)]))

    def _drop_calc_chain(self) -> None:
        """Take out the order of calculation, which names cells; spreadsheet programs make it anew."""
        parts = self.related(self.book.part, _CALC_CHAIN)
        if not parts:
            return
        folder, _, leaf = self.book.part.rpartition("/")
        names = {"/" + p.casefold() for p in parts}
        for part, local in (("[Content_Types].xml", "Override"), (f"{folder}/_rels/{leaf}.rels", "Relationship")):
            data = as_utf8(self.read(part))
            gone = [
                (e.start, e.end, b"")
                for e in find(data, lambda path, local=local: path[-1] == local)  # type: ignore[misc]
                if e.attributes.get("PartName", "").casefold() in names
                or e.attributes.get("Type", "").casefold().endswith("/" + _CALC_CHAIN)
            ]
            self.write(part, splice(data, gone))
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
