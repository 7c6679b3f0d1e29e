"""Reading a workbook of any format into the model; all that keeps it from being read ends as UnreadableFile."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rrp_sheets.diagnostics import Report
from rrp_sheets.model import workbook as model
from rrp_sheets.model.names import key
from rrp_sheets.texts import N_, os_reason
from rrp_sheets.workbook import limits
from rrp_sheets.workbook import sheet_readers as readers
from rrp_sheets.workbook.files import open_book
from rrp_sheets.workbook.raw import Book, Extent, Kind, RawCell, RawSheet, check_size, unreadable
from rrp_sheets.workbook.schema import BEHAVIOUR, DEVICES, PROTOCOL, NearMiss, language_of, recognise


@dataclass(frozen=True)
class Reading:
    r"""A workbook that was read.

    Attributes:
        report: what was noticed while reading; checks add to it.
        digest: SHA-256 (hexadecimal) of the .xlsx file's bytes; of CSV and Markdown of the texts with `\n` as line
            break and without byte order mark, so that a copy made by another program keeps it.
        format: the name of the format: `xlsx`, `csv`, `markdown`, …
        sheets: the sheets as the file has them; of an .xlsx the user's own only to row 20.
    """

    workbook: model.Workbook
    report: Report
    digest: str
    format: str
    sheets: tuple[RawSheet, ...] = field(default=(), repr=False, compare=False)


def read(path: Path | str, suffix: str = "") -> Reading:
    """Read a workbook: an .xlsx file, a folder of .csv or .tsv files (or one), or a Markdown file.

    `suffix` is the ending that tells its format, if its own does not (git's temporary files). What is wrong inside the
    sheets is in the reading's report. Raises UnreadableFile when it cannot be read at all, or is refused.
    """
    path = Path(path)
    try:
        book, digest = open_book(path, suffix)
    except OSError as error:
        why = os_reason(error)
        raise unreadable("FILE016", name=path.name or str(path), why=why) from error
    reader = Reader(book, str(path))
    return Reading(reader.workbook, reader.report, digest, book.format, tuple(reader.sheets))


class Reader:
    """Reads a book once; the result is in `workbook`, `report` and `sheets`."""

    def __init__(self, book: Book, source: str) -> None:
        self.report = Report()
        self.report.order_by(book.names)
        self._book = book
        self._characters = 0
        self._found: dict[str, list[Any]] = {}  # what the sheets say, by the name of their kind
        self._fields: dict[str, model.Cell] = {}
        self._names: dict[str, str] = {}
        self._protocol_end: model.Address | None = None
        self._device_sheet: model.DeviceSheet | None = None  # of several the first one
        self._headers: list[str] = []  # of the columns of ours, as they are spelt
        self._nearly = False  # whether a sheet is a behaviour but for a missing header, which is told
        self.sheets: list[RawSheet] = []
        own = [index for index in range(len(book.names)) if not self._read(index)]
        tables = self._tables(own)
        first: dict[str, str] = {}
        for name in book.names:
            if key(name) in first:
                self.report.add("SHEET014", model.Address(name), first=first[key(name)], sheet=name)
            first.setdefault(key(name), name)
        kinds = ("behaviour", "devices", "helpers", "gestures", "test")
        behaviours, devices, helpers, gestures, tests = (tuple(self._found.get(kind, ())) for kind in kinds)
        moves = {key(row.name.text) for row in gestures}
        devices = tuple(readers.with_standard_moves(device, moves) for device in devices)
        scene = tuple(self._found["scene"]) if "scene" in self._found else None
        risks = next(iter(self._found.get("risks", ())), None)  # of several with that header the first one counts
        if not behaviours and not self._nearly:
            self.report.add("SHEET001", None)
        protocol = model.Protocol(self._fields, self._names, self._protocol_end)
        self.workbook = model.Workbook(
            source, behaviours, devices, helpers, protocol, scene, gestures, tests, tables, tuple(book.names), risks,
            self._device_sheet, language_of(self._headers),
        )  # fmt: skip

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
            limit = N_("{n:,}, with the sheets before it,", n=limits.TEXT_CHARACTERS)
            raise unreadable("FILE013", sheet=sheet.name, what=N_("too many letters"), limit=limit)
        self.sheets.append(sheet)
        table = readers.OwnTable(sheet, recognised, recognised.kind, self.report)
        self._report_findings(sheet.name)
        table.report_merged()
        self._headers += [sheet.cells[recognised.row, c].text for c in recognised.columns.values()]
        if recognised.kind is PROTOCOL:
            self._protocol_end = readers.read_protocol(table, self._fields, self._names)
        else:
            kind = recognised.kind.name
            if recognised.kind is DEVICES and self._device_sheet is None:
                self._device_sheet = readers.place_of_devices(table)
            self._found.setdefault(kind, []).extend(readers.READERS[kind](table))
        return True

    def _report_findings(self, sheet: str) -> None:
        """Take over what the backend noticed about a sheet that is used."""
        self.report.extend(f for f in self._book.findings if f.address and f.address.sheet == sheet)

    def _report_near(self, sheet: str, near: NearMiss) -> None:
        self._nearly = self._nearly or near.kind is BEHAVIOUR
        address = model.Address(sheet, near.row, near.column or 1)
        told: dict[str, Any] = {"sheet": sheet, "kind": near.kind.shown, "wanted": near.wanted}
        if near.column:
            code = "SHEET002" if near.certain else "SHEET003"
            self.report.add(code, address, **told, header=near.header, guess=near.wanted)
        else:
            self.report.add("SHEET004", address, **told, row=near.row)

    def _tables(self, own: list[int]) -> Mapping[str, tuple[tuple[str, ...], ...]]:
        rows = [row for behaviour in self._found.get("behaviour", ()) for row in behaviour.rows]
        named = readers.words(row.formula.text for row in [*rows, *self._found.get("helpers", ())])
        tables = {}
        for index in own:
            name = self._book.names[index]
            if readers.is_named(name, named):
                sheet = self._book.sheet(index, Extent.TABLE)
                self._report_findings(name)
                tables[key(name)] = readers.read_table(sheet, self.report)
        return tables


def to_sheets(reading: Reading) -> Mapping[str, Sequence[Sequence[str]]]:
    """The rows of every sheet, each cell as the user typed it, for `maker.make_workbook`.

    Rows keep their numbers (blank ones stay blank), so that every message about a cell holds for the copy too. Of an
    .xlsx the user's own sheets end at row 20; `to_rows(read_sheets(path))` has all of them.
    """
    return to_rows(reading.sheets)


def to_rows(sheets: Iterable[RawSheet]) -> dict[str, list[list[str]]]:
    """The rows of sheets as texts; see `to_sheets`."""
    found: dict[str, list[list[str]]] = {}
    for sheet in sheets:
        what = recognise(sheet)
        ours = {n for name, n in what.columns.items() if what.kind and what.kind.column(name).cells.from_excel}
        rows: list[list[str]] = []
        for number, cells in sheet.rows().items():
            rows.extend([] for _ in range(number - len(rows) - 1))
            texts = {c: _text(cell, c in ours) for c, cell in cells.items()}
            rows.append([texts.get(c, "") for c in range(1, max(cells) + 1)])
        found.setdefault(sheet.name, rows)
    return found


def _text(cell: RawCell, ours: bool) -> str:
    """Return what was typed where a formula of ours is expected; elsewhere the value that the user sees, if any."""
    seen = cell.text and cell.kind is not Kind.ERROR
    return cell.text if seen and not ours else cell.typed
