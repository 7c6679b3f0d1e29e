"""From a backend's sheets to the model: recognise each, read ours whole, leave the user's own alone."""

from __future__ import annotations

from collections.abc import Mapping

from rrp_sheets.diagnostics import Report
from rrp_sheets.model.cells import Address, Cell
from rrp_sheets.model.names import key
from rrp_sheets.model.workbook import Behaviour, Device, GestureRow, Helper, Protocol, SceneRow, TestSheet, Workbook
from rrp_sheets.workbook import limits
from rrp_sheets.workbook.columns import Table
from rrp_sheets.workbook.headers import BEHAVIOUR, NearMiss, Recognised, recognise
from rrp_sheets.workbook.kinds.behaviour import read_behaviour
from rrp_sheets.workbook.kinds.devices import read_devices
from rrp_sheets.workbook.kinds.gestures import read_gestures
from rrp_sheets.workbook.kinds.helpers import read_helpers
from rrp_sheets.workbook.kinds.protocol import read_protocol
from rrp_sheets.workbook.kinds.scene import read_scene
from rrp_sheets.workbook.kinds.tables import is_named, read_table, words
from rrp_sheets.workbook.kinds.tests import read_test
from rrp_sheets.workbook.raw import Book, Extent, RawSheet, check_size, unreadable


class Reader:
    """Reads a book once; the result is in `workbook`, `report` and `sheets`."""

    def __init__(self, book: Book, source: str) -> None:
        self.report = Report()
        self.report.order_by(book.names)
        self._book = book
        self._characters = 0
        self._behaviours: list[Behaviour] = []
        self._devices: list[Device] = []
        self._helpers: list[Helper] = []
        self._scene: list[SceneRow] | None = None
        self._gestures: list[GestureRow] = []
        self._tests: list[TestSheet] = []
        self._fields: dict[str, Cell] = {}
        self._names: dict[str, str] = {}
        self._nearly = False  # whether a sheet is a behaviour but for a missing header, which is told
        self.sheets: list[RawSheet] = []
        own = [index for index in range(len(book.names)) if not self._read(index)]
        tables = self._tables(own)
        self._check_names()
        if not self._behaviours and not self._nearly:
            self.report.add("SHEET001", None)
        self.workbook = Workbook(
            source=source,
            behaviours=tuple(self._behaviours),
            devices=tuple(self._devices),
            helpers=tuple(self._helpers),
            protocol=Protocol(self._fields, self._names),
            scene=None if self._scene is None else tuple(self._scene),
            gestures=tuple(self._gestures),
            tests=tuple(self._tests),
            tables=tables,
            sheets=tuple(book.names),
        )

    def _read(self, index: int) -> bool:
        """Read a sheet of ours; False for one of the user's own."""
        head = self._book.sheet(index, Extent.HEAD)
        recognised = recognise(head)
        if recognised.near:
            self._report_near(head.name, recognised.near)
        if recognised.kind is None:
            self.sheets.append(head)
            return False
        sheet = self._book.sheet(index, Extent.WHOLE)
        check_size(sheet)
        self._characters += sum(len(c.text) + len(c.formula) for c in sheet.cells.values())
        if self._characters > limits.TEXT_CHARACTERS:
            limit = f"{limits.TEXT_CHARACTERS:,}, with the sheets before it,"
            raise unreadable("FILE013", sheet=sheet.name, what="too many letters", limit=limit)
        self.sheets.append(sheet)
        table = Table(sheet, recognised, self.report)
        self._report_findings(sheet.name)
        table.report_merged()
        self._add(recognised, table)
        return True

    def _report_findings(self, sheet: str) -> None:
        """Take over what the backend noticed about a sheet that is used."""
        for finding in self._book.findings:
            if finding.address.sheet == sheet:
                self.report.add(finding.code, finding.address, span=None, fixes=(), **finding.details)

    def _add(self, recognised: Recognised, table: Table) -> None:
        match recognised.kind.name if recognised.kind else "":
            case "behaviour":
                self._behaviours.append(read_behaviour(table))
            case "devices":
                self._devices.extend(read_devices(table))
            case "helpers":
                self._helpers.extend(read_helpers(table))
            case "scene":
                self._scene = [*(self._scene or ()), *read_scene(table)]
            case "gestures":
                self._gestures.extend(read_gestures(table))
            case "test":
                self._tests.append(read_test(table))
            case "protocol":
                read_protocol(table, self._fields, self._names)

    def _report_near(self, sheet: str, near: NearMiss) -> None:
        kind = near.kind.shown
        self._nearly = self._nearly or near.kind is BEHAVIOUR
        if not near.column:
            address = Address(sheet, near.row, 1)
            self.report.add("SHEET004", address, sheet=sheet, kind=kind, wanted=near.wanted, row=near.row)
            return
        address = Address(sheet, near.row, near.column)
        code = "SHEET002" if near.certain else "SHEET003"
        self.report.add(code, address, sheet=sheet, kind=kind, wanted=near.wanted, header=near.header)

    def _tables(self, own: list[int]) -> Mapping[str, tuple[tuple[str, ...], ...]]:
        formulas = [row.formula.text for b in self._behaviours for row in b.rows]
        named = words([*formulas, *(h.formula.text for h in self._helpers)])
        tables = {}
        for index in own:
            name = self._book.names[index]
            if is_named(name, named):
                sheet = self._book.sheet(index, Extent.TABLE)
                self._report_findings(name)
                tables[key(name)] = read_table(sheet, self.report)
        return tables

    def _check_names(self) -> None:
        first: dict[str, str] = {}
        for name in self._book.names:
            if key(name) in first:
                self.report.add("SHEET014", Address(name), first=first[key(name)], sheet=name)
            first.setdefault(key(name), name)
