"""Copies of an .xlsx with its findings: a note beside each row, a marked cell, and a sheet that lists them all."""

from __future__ import annotations

import zipfile
from collections.abc import Sequence
from contextlib import suppress
from copy import deepcopy
from itertools import count
from pathlib import Path
from xml.sax.saxutils import quoteattr

from lxml import etree

from rrp_sheets.diagnostics import Diagnostic
from rrp_sheets.diagnostics.report import MORE_LATER, checks_wait
from rrp_sheets.model.workbook import column_letters
from rrp_sheets.texts import N_, counted, translate
from rrp_sheets.workbook import limits
from rrp_sheets.workbook.maker import sheet_titles
from rrp_sheets.workbook.patch import package_edit as xml
from rrp_sheets.workbook.patch import sheet_list as listed
from rrp_sheets.workbook.patch.package_edit import PackageEdit
from rrp_sheets.workbook.patch.sheets import place_style
from rrp_sheets.workbook.xlsx import number as whole

TITLE = N_("Findings")
_PART = "xl/worksheets/findings"
_FILLS = {"error": "F8C9C4", "warning": "FFE3A3", "info": "D6E6F2"}
_EDGES = {"error": "C0392B", "warning": "C98A00", "info": "4A7FA5"}
_WORDS = {"error": N_("Error"), "warning": N_("Warning"), "info": N_("Note")}
_HEADERS = (N_("Cell"), N_("Kind"), N_("Code"), N_("What is wrong"), N_("What to do"))
_COLUMN_WIDTH = 70
_LINE, _LETTERS_PER_LINE = 13.5, 74  # points; of the note's font in a column of that width
_TALLEST = 400
_MAIN = "http://schemas.openxmlformats.org/spreadsheetml/2006/main"
_LISTS = ("fonts", "fills", "borders", "cellXfs")


def marked_copy(data: bytes, name: str, findings: Sequence[Diagnostic], language: str = "en") -> bytes:
    """Return the bytes of a workbook with its findings marked, in a language; nothing else in it is changed."""
    package = PackageEdit(data, name)
    styles = StyleSheet(package)
    by_sheet: dict[str, list[Diagnostic]] = {}
    for finding in findings:
        if finding.address is not None:
            by_sheet.setdefault(finding.address.sheet, []).append(finding)
    for index, sheet in enumerate(package.book.names):
        if sheet in by_sheet:
            _mark(package, index, by_sheet[sheet], styles, language)
    names = package.book.names
    title, other = translate(TITLE, language), translate(N_("Findings of the check"), language)
    *_, title = sheet_titles([*names, title if title not in names else other]).values()
    part = next(part for n in count(1) if (part := f"{_PART}{n}.xml") not in package.book)
    package.added[part] = _list_xml(findings, styles, language)
    listed.put_sheet(package, part, title)
    return package.to_bytes()


def is_marked_copy(path: Path) -> bool:
    """Return whether a file is an annotated copy, made earlier."""
    try:
        with zipfile.ZipFile(path) as package:
            return any(name.startswith(_PART) for name in package.namelist())
    except (zipfile.BadZipFile, OSError):
        return False


def _mark(package: PackageEdit, index: int, findings: Sequence[Diagnostic], styles: StyleSheet, language: str) -> None:
    sheet = package.sheet(index)
    filled = (at for block in sheet.walk() for row in block.rows.values() for at, cell in xml.cells(row) if len(cell))
    beside = 1 + max([*filled, *(b.right for b in sheet.merged())], default=1)  # blank cells with a format do not count
    header = max(package.recognised(index).row, 1)
    worst: dict[tuple[int, int], str] = {}
    texts: dict[int, list[Diagnostic]] = {}
    for finding in findings:
        assert finding.address is not None
        row, column = finding.address.row or header, finding.address.column
        texts.setdefault(row, []).append(finding)
        if column and finding.address.row:
            severity = finding.severity.value
            worst[row, column] = severity if severity == "error" else worst.get((row, column), severity)
    for (row, column), severity in worst.items():
        style = styles.marked(sheet.style(row, column), _FILLS[severity], _EDGES[severity])
        cell = sheet.cell(row, column)
        if cell is None:
            sheet.set_cell(row, column, None, style)
        else:
            cell.set("s", str(style))
            sheet.block(row).touch()
    for row, found in texts.items():
        kind = "error" if any(f.severity.value == "error" for f in found) else found[0].severity.value
        text = "\n".join(_told(f, language) for f in found)[: limits.CELL_CHARACTERS]
        sheet.set_cell(row, beside, text, styles.note(_FILLS[kind]))
        _make_room(sheet, row, text)
    if header not in texts:
        before = sheet.cell(header, beside - 1)
        like = styles.note("", bold=True) if before is None else sheet.style(header, beside - 1)
        sheet.set_cell(header, beside, translate(TITLE, language), like)
    _widen(sheet, beside)


def _told(finding: Diagnostic, language: str) -> str:
    """Format a finding as a note: `C5: Error FORM001: … → …`."""
    cell = finding.address.cell if finding.address else ""
    word = f"{translate(_WORDS[finding.severity.value], language)} {finding.code}"
    message, remedy = translate(finding.message, language), translate(finding.remedy, language)
    return f"{cell}: {word}: {message} → {remedy}" if cell else f"{word}: {message}"


def _make_room(sheet: xml.SheetXml, row: int, text: str) -> None:
    """Raise the height of a row to that of its note."""
    line = sheet.row(row)
    assert line is not None
    lines = sum(1 + len(part) // _LETTERS_PER_LINE for part in text.split("\n"))
    height = min(5 + _LINE * lines, _TALLEST)
    old = 0.0
    with suppress(ValueError):
        old = float(line.get("ht", 0))
    if height > old:
        xml.set_attributes(line, {"ht": f"{height:g}", "customHeight": "1"})
        sheet.block(row).touch()


def _widen(sheet: xml.SheetXml, column: int) -> None:
    """Set the width of one column; splits a `col` element that is for several."""
    holder = xml.child(sheet.root, "cols")
    if holder is None:
        holder = xml.add(sheet.root, "cols", {}, at=sheet.root.index(sheet.table))
    named = {"min": str(column), "max": str(column), "width": str(_COLUMN_WIDTH), "customWidth": "1"}
    there = list(holder.iterchildren("{*}col"))
    run = next((col for col in there if whole(col.get("max")) >= column), None)
    new = xml.add(holder, "col", named, at=None if run is None else holder.index(run))
    if run is not None and whole(run.get("min")) <= column:
        if whole(run.get("min")) < column:
            before = deepcopy(run)
            before.set("max", str(column - 1))
            holder.insert(holder.index(new), before)
        if whole(run.get("max")) > column:
            run.set("min", str(column + 1))
        else:
            holder.remove(run)
    sheet.touch()


def _list_xml(findings: Sequence[Diagnostic], styles: StyleSheet, language: str) -> bytes:
    plain, head = styles.note(""), styles.note("", bold=True)
    kinds = [f.severity.value for f in findings]
    counts = translate(counted({kind: kinds.count(kind) for kind in _WORDS}), language)
    headers = [translate(text, language) for text in _HEADERS]
    later = [translate(MORE_LATER, language)] if checks_wait(findings) else []
    rows: list[tuple[int, Sequence[str], Sequence[int]]] = [(1, [counts], [head]), (2, later, [plain] * len(later))]
    rows.append((3, headers, [head] * 5))
    links = []
    for row, f in enumerate(findings, 4):
        kind = f.severity.value
        texts = [str(f.address or ""), translate(_WORDS[kind], language), f.code]
        texts += [translate(f.message, language), translate(f.remedy, language)]
        rows.append((row, texts, [plain, styles.note(_FILLS[kind]), plain, plain, plain]))
        if f.address is not None:
            sheet = f.address.sheet.replace("'", "''")
            spot = quoteattr(f"'{sheet}'!{f.address.cell or 'A1'}")
            links.append(f'<hyperlink ref="A{row}" location={spot}/>')
    widths = enumerate((24, 10, 12, 60, 60), 1)
    columns = "".join(f'<col min="{n}" max="{n}" width="{width}" customWidth="1"/>' for n, width in widths)
    view = '<sheetViews><sheetView workbookViewId="0"><pane ySplit="3" topLeftCell="A4" activePane="bottomLeft" '
    view += 'state="frozen"/></sheetView></sheetViews>'
    held = f"<hyperlinks>{''.join(links)}</hyperlinks>" if links else ""
    page = '<pageMargins left="0.5" right="0.5" top="0.7" bottom="0.6" header="0.3" footer="0.3"/>'
    page += '<pageSetup paperSize="9" orientation="landscape" fitToHeight="0"/>'
    text = (
        f'<?xml version="1.0" encoding="UTF-8" standalone="yes"?>\n<worksheet xmlns="{_MAIN}">'
        f'<sheetPr><pageSetUpPr fitToPage="1"/></sheetPr>{view}<cols>{columns}</cols>'
        f"<sheetData/>{held}{page}</worksheet>"
    )
    made = xml.SheetXml(text.encode())
    made.insert(1, (_row(made.table, *row) for row in rows))
    return made.to_bytes()


def _row(table: etree._Element, number: int, texts: Sequence[str], styles: Sequence[int]) -> etree._Element:
    row = xml.new_element(table, "row", {"r": str(number)})
    for column, (text, style) in enumerate(zip(texts, styles, strict=True), 1):
        xml.put_value(xml.add(row, "c", {"r": f"{column_letters(column)}{number}", "s": str(style)}), text)
    return row


class StyleSheet:
    """Style sheet of a workbook, to which the styles of notes and marked cells are added."""

    def __init__(self, package: PackageEdit) -> None:
        parts = package.related(package.book.part, "styles")
        part = package.part(parts[0]) if parts else None
        lists = [part.container("styleSheet", name) for name in _LISTS] if part else []
        self._part = part if all(found is not None for found in lists) else None
        self._styles = part.children("styleSheet", "cellXfs") if part else []
        self._known: dict[str, list[bytes]] = {}
        self._made: dict[tuple[int, str, bool], int] = {}

    def note(self, fill: str, *, bold: bool = False) -> int:
        """Return the index of the style of a note: small and wrapped."""
        return self.marked(-1, fill, "", bold)

    def marked(self, style: int, fill: str, edge: str, bold: bool = False) -> int:
        """Return the index of a style with this fill and border (`RRGGBB`); a conditional format may hide a fill."""
        if self._part is None:
            return max(style, 0)  # a workbook without styles: told by its texts only
        if (style, fill, bold) not in self._made:
            self._made[style, fill, bold] = self._style(self._part, style, fill, edge, bold)
        return self._made[style, fill, bold]

    def _style(self, part: xml.XmlPart, base: int, fill: str, edge: str, bold: bool) -> int:
        def placed(group: str, text: str) -> str:
            return str(place_style(part, group, xml.parse(text.encode()), self._known))

        named: dict[str, str | None] = {}
        if fill:
            solid = f'<patternFill patternType="solid"><fgColor rgb="FF{fill}"/><bgColor indexed="64"/></patternFill>'
            named |= {"fillId": placed("fills", f"<fill>{solid}</fill>"), "applyFill": "1"}
        if edge:
            names = ("left", "right", "top", "bottom")
            sides = "".join(f'<{side} style="medium"><color rgb="FF{edge}"/></{side}>' for side in names)
            named |= {"borderId": placed("borders", f"<border>{sides}<diagonal/></border>"), "applyBorder": "1"}
        if base >= 0:
            new = deepcopy(self._styles[base]) if base < len(self._styles) else xml.parse(b"<xf/>")
        else:
            thick = "<b/>" if bold else ""
            font = f'<font>{thick}<sz val="9"/><color rgb="FF1F2D3A"/><name val="Arial"/></font>'
            named |= {"fontId": placed("fonts", font), "applyFont": "1"}
            start = '<xf numFmtId="49" fontId="0" fillId="0" borderId="0" xfId="0" applyAlignment="1">'
            new = xml.parse(f'{start}<alignment vertical="center" wrapText="1"/></xf>'.encode())
        xml.set_attributes(new, named)
        return place_style(part, "cellXfs", new, self._known)
