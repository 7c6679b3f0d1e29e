"""The .xlsx backend: the checked package, its sheets read one by one and only as far as they are wanted.

The XML is read as a stream, so that the limits hold while reading and sheets of the user's own are left after
their first rows. openpyxl knows what is hard: which number formats are dates, how dates count, how shared
formulas are written out; it also makes new workbooks.
"""

from __future__ import annotations

from rrp_sheets.workbook import limits
from rrp_sheets.workbook.package import Package
from rrp_sheets.workbook.raw import Extent, Finding, RawSheet, unreadable
from rrp_sheets.workbook.xlsx_parts import SharedStrings, SheetEntry, StylesHandler, WorkbookHandler
from rrp_sheets.workbook.xlsx_sheet import SheetHandler


class XlsxBook:
    """An opened .xlsx file; raises UnreadableFile for what is broken or refused.

    Attributes:
        package: its parts.
        part: the name of the workbook part.
        entries: its sheets in order.
        styles: which cell styles show dates, times or texts.
    """

    format = "xlsx"

    def __init__(self, data: bytes, name: str) -> None:
        self.package = package = Package(data, name)
        part = next((t for k, t in package.relations("").values() if k == "officedocument"), "xl/workbook.xml")
        if part not in package or not part.endswith(".xml"):
            raise unreadable("FILE002", name=name)
        workbook = WorkbookHandler()
        package.parse(part, workbook)
        relations = package.relations(part)
        by_kind = {kind: target for kind, target in relations.values() if target in package}
        styles = StylesHandler()
        if "styles" in by_kind:
            package.parse(by_kind["styles"], styles)
        self.part, self.styles, self._mac_epoch = part, styles, workbook.mac_epoch
        self._strings = SharedStrings(package, by_kind.get("sharedstrings"))
        self.entries = [
            SheetEntry(title, relations[relation][1], hidden)
            for title, relation, hidden in workbook.sheets
            if relation in relations and relations[relation][0] == "worksheet"  # not a chart on a sheet of its own
        ]
        if len(self.entries) > limits.SHEETS:
            raise unreadable("FILE012", name=name, count=len(self.entries), limit=limits.SHEETS)
        if not self.entries:
            raise unreadable("FILE008", name=name, what="it lists no sheets")
        self.names = [s.name for s in self.entries]
        self.findings: list[Finding] = []

    def sheet(self, index: int, extent: Extent) -> RawSheet:
        """Read a sheet; see Book."""
        entry = self.entries[index]
        handler = SheetHandler(entry.name, extent, self._strings, self.styles, self._mac_epoch)
        self.package.parse(entry.part, handler)
        return RawSheet(entry.name, handler.cells, tuple(handler.merged), frozenset(handler.hidden_rows), entry.hidden)
