"""A copy of an .xlsx in which every finding stands beside its row, with its cell marked, and all of them on a sheet."""

from __future__ import annotations

import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from xml.sax.saxutils import quoteattr

from rrp_sheets.diagnostics import Diagnostic
from rrp_sheets.diagnostics.languages import told
from rrp_sheets.diagnostics.phrase import counted
from rrp_sheets.model.cells import column_letters
from rrp_sheets.workbook import limits
from rrp_sheets.workbook.edits import Value
from rrp_sheets.workbook.maker import sheet_titles
from rrp_sheets.workbook.patch.markup import Element, as_utf8, find, splice, with_attributes
from rrp_sheets.workbook.patch.package_edit import PackageEdit
from rrp_sheets.workbook.patch.sheet_xml import SheetXml
from rrp_sheets.workbook.patch.values import content
from rrp_sheets.workbook.xlsx_parts import number

TITLE = "Findings"
_PART = "xl/worksheets/findings"
_FILLS = {"error": "F8C9C4", "warning": "FFE3A3", "info": "D6E6F2"}
_EDGES = {"error": "C0392B", "warning": "C98A00", "info": "4A7FA5"}
_WORDS = {"error": "Error", "warning": "Warning", "info": "Note"}
_HEADERS = ("Cell", "Kind", "Code", "What is wrong", "What to do")
_COLUMN_WIDTH = 70
_LINE, _LETTERS_PER_LINE = 13.5, 74  # points; of the note's font in a column of that width
_TALLEST = 400
_MAIN = "http://schemas.openxmlformats.org/spreadsheetml/2006/main"
_RELATIONS = "http://schemas.openxmlformats.org/officeDocument/2006/relationships"
_CONTENT = "application/vnd.openxmlformats-officedocument.spreadsheetml.worksheet+xml"


def marked_copy(data: bytes, name: str, findings: Sequence[Diagnostic], language: str = "en") -> bytes:
    """The copy's bytes; everything that carries no mark is as in the original.

    Args:
        data: the original's bytes.
        name: its name, for messages.
        findings: what is wrong with it.
        language: of what is written beside the rows.
    """
    package = PackageEdit(data, name)
    styles = StyleSheet(package)
    by_sheet: dict[str, list[Diagnostic]] = {}
    for finding in findings:
        if finding.address is not None:
            by_sheet.setdefault(finding.address.sheet, []).append(finding)
    for index, sheet in enumerate(package.book.names):
        if sheet in by_sheet:
            _mark(package, index, by_sheet[sheet], styles, language)
    _add_list(package, findings, styles, language)
    styles.store()
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
    beside = _last_column(sheet) + 1
    header = max(package.recognised(index).row, 1)
    worst: dict[tuple[int, int], str] = {}
    texts: dict[int, list[Diagnostic]] = {}
    for finding in findings:
        assert finding.address is not None
        row, column = finding.address.row or header, finding.address.column
        texts.setdefault(row, []).append(finding)
        if column and finding.address.row:
            worst.setdefault((row, column), finding.severity.value)
            if finding.severity.value == "error":
                worst[row, column] = "error"
    for (row, column), severity in worst.items():
        _restyle(sheet, row, column, styles.marked(sheet.style(row, column), _FILLS[severity], _EDGES[severity]))
    for row, found in texts.items():
        kind = "error" if any(f.severity.value == "error" for f in found) else found[0].severity.value
        text = "\n".join(_told(f, language) for f in found)[: limits.CELL_CHARACTERS]
        sheet.set_cell(row, beside, text, styles.note(_FILLS[kind]))
        _make_room(sheet, row, text)
    if header not in texts:
        named = sheet.cell(header, beside - 1)
        like = sheet.style(header, beside - 1) if named else styles.note("", bold=True)
        sheet.set_cell(header, beside, TITLE, like)
    _widen(sheet, beside)


def _told(finding: Diagnostic, language: str) -> str:
    """A finding in the words of a note: `C5: Error FORM001: … → …`."""
    cell = finding.address.cell if finding.address else ""
    word = f"{told(_WORDS[finding.severity.value], language)} {finding.code}"
    message, remedy = told(finding.message, language), told(finding.remedy, language)
    return f"{cell}: {word}: {message} → {remedy}" if cell else f"{word}: {message}"


def _restyle(sheet: SheetXml, row: int, column: int, style: int) -> None:
    """Give a cell another style; its content stays."""
    cell = sheet.cell(row, column)
    if cell is None:
        sheet.set_cell(row, column, None, style)
        return
    raw = sheet.rows[row].raw
    e = cell.element
    tag = with_attributes(raw[e.start : e.inner], {"s": str(style)})
    sheet.rows[row].raw = splice(raw, [(e.start, e.inner, tag)])
    sheet.touched = True


def _last_column(sheet: SheetXml) -> int:
    """The last column with a content; formatted blank ones do not count."""
    filled = (
        c.column for row in sheet.rows.values() if row.filled for c in row.cells() if c.element.end > c.element.inner
    )
    merged = (b.right for b in sheet.merged())
    return max([*filled, *merged], default=1)


def _make_room(sheet: SheetXml, row: int, text: str) -> None:
    """Make a row high enough for the note; higher rows stay."""
    line = sheet.rows[row]
    tag = line.tag
    lines = sum(1 + len(part) // _LETTERS_PER_LINE for part in text.split("\n"))
    height = min(5 + _LINE * lines, _TALLEST)
    if height > float(tag.attributes.get("ht") or 0):
        named = {"ht": f"{height:g}", "customHeight": "1"}
        line.raw = with_attributes(line.raw[: tag.inner], named) + line.raw[tag.inner :]


def _widen(sheet: SheetXml, column: int) -> None:
    """Give one column its width; a run of columns that it is part of is split."""
    prefix = sheet.table.prefix
    new = f'<{prefix}col min="{column}" max="{column}" width="{_COLUMN_WIDTH}" customWidth="1"/>'.encode()
    holder = sheet.element("cols")
    if holder is None:
        sheet.insert(sheet.table.start, f"<{prefix}cols>".encode() + new + f"</{prefix}cols>".encode())
        return
    at = holder.inner_end
    for col in (e for e in sheet.all("col") if e.path[1:2] == ("cols",)):
        first, last = int(col.attributes.get("min", 0)), int(col.attributes.get("max", 0))
        if last < column:
            continue
        if first > column:
            at = min(at, col.start)
            continue
        tag = sheet.data[col.start : col.end]
        pieces = [with_attributes(tag, {"max": str(column - 1)})] if first < column else []
        pieces += [new, *([with_attributes(tag, {"min": str(column + 1)})] if last > column else [])]
        sheet.replace(col, b"".join(pieces))
        return
    sheet.insert(at, new)


def _add_list(package: PackageEdit, findings: Sequence[Diagnostic], styles: StyleSheet, language: str) -> None:
    """Add the sheet with all findings; each leads to its cell."""
    names = package.book.names
    title = list(sheet_titles([*names, TITLE] if TITLE not in names else [*names, f"{TITLE} of the check"]).values())[
        -1
    ]
    number = 1
    while f"{_PART}{number}.xml" in package.package:
        number += 1
    part = f"{_PART}{number}.xml"
    package.added[part] = _list_xml(findings, styles, language)
    types = as_utf8(package.read("[Content_Types].xml"))
    root = find(types, lambda path: len(path) == 1)[0]
    override = f'<{root.prefix}Override PartName="/{part}" ContentType="{_CONTENT}"/>'.encode()
    package.write("[Content_Types].xml", splice(types, [(root.inner_end, root.inner_end, override)]))
    folder, _, leaf = package.book.part.rpartition("/")
    rels = f"{folder}/_rels/{leaf}.rels"
    data = as_utf8(package.read(rels))
    root = find(data, lambda path: len(path) == 1)[0]
    taken = {e.attributes.get("Id") for e in find(data, lambda path: path[-1] == "Relationship")}
    ident = next(f"rIdFindings{n}" for n in range(1, 1000) if f"rIdFindings{n}" not in taken)
    relation = f'<{root.prefix}Relationship Id="{ident}" Type="{_RELATIONS}/worksheet" Target="/{part}"/>'.encode()
    package.write(rels, splice(data, [(root.inner_end, root.inner_end, relation)]))
    _list_sheet(package, title, ident)


def _list_sheet(package: PackageEdit, title: str, ident: str) -> None:
    data = as_utf8(package.read(package.book.part))
    found = find(data, lambda path: path[-1] in ("sheets", "sheet"))
    holder = next(e for e in found if e.local == "sheets")
    used = [int(e.attributes.get("sheetId") or 0) for e in found if e.local == "sheet"]
    named = next((n for e in found for n in e.attributes if n.endswith(":id")), "")
    relation = f'{named}="{ident}"' if named else f'xmlns:f="{_RELATIONS}" f:id="{ident}"'
    new = f'<{holder.prefix}sheet name={quoteattr(title)} sheetId="{max(used) + 1}" {relation}/>'.encode()
    package.write(package.book.part, splice(data, [(holder.inner_end, holder.inner_end, new)]))


def _list_xml(findings: Sequence[Diagnostic], styles: StyleSheet, language: str) -> bytes:
    plain, head = styles.note(""), styles.note("", bold=True)
    kinds = [f.severity.value for f in findings]
    counts = told(counted({word.lower(): kinds.count(kind) for kind, word in _WORDS.items()}), language)
    rows = [_row(1, [counts], [head])]
    rows.append(_row(3, [told(text, language) for text in _HEADERS], [head] * 5))
    links = []
    for row, f in enumerate(findings, 4):
        kind = f.severity.value
        texts = [str(f.address or ""), told(_WORDS[kind], language), f.code]
        texts += [told(f.message, language), told(f.remedy, language)]
        rows.append(_row(row, texts, [plain, styles.note(_FILLS[kind]), plain, plain, plain]))
        if f.address is not None:
            sheet = f.address.sheet.replace("'", "''")
            spot = quoteattr(f"'{sheet}'!{f.address.cell or 'A1'}")
            links.append(f'<hyperlink ref="A{row}" location={spot}/>')
    columns = "".join(
        f'<col min="{n}" max="{n}" width="{width}" customWidth="1"/>' for n, width in enumerate((24, 10, 12, 60, 60), 1)
    )
    view = '<sheetViews><sheetView workbookViewId="0"><pane ySplit="3" topLeftCell="A4" activePane="bottomLeft" '
    view += 'state="frozen"/></sheetView></sheetViews>'
    held = f"<hyperlinks>{''.join(links)}</hyperlinks>" if links else ""
    page = '<pageMargins left="0.5" right="0.5" top="0.7" bottom="0.6" header="0.3" footer="0.3"/>'
    page += '<pageSetup paperSize="9" orientation="landscape" fitToHeight="0"/>'
    return (
        f'<?xml version="1.0" encoding="UTF-8" standalone="yes"?>\n<worksheet xmlns="{_MAIN}">'
        f'<sheetPr><pageSetUpPr fitToPage="1"/></sheetPr>{view}<cols>{columns}</cols>'
        f"<sheetData>{''.join(rows)}</sheetData>{held}{page}</worksheet>"
    ).encode()


def _row(number: int, texts: Sequence[Value], styles: Sequence[int]) -> str:
    cells = []
    for column, (text, style) in enumerate(zip(texts, styles, strict=True), 1):
        kind, inside = content(text, "")
        attributes: Mapping[str, str | None] = {"t": kind}
        tag = with_attributes(f'<c r="{column_letters(column)}{number}" s="{style}">'.encode(), attributes)
        cells.append((tag + inside + b"</c>").decode())
    return f'<row r="{number}">{"".join(cells)}</row>'


_LISTS = ("fonts", "fills", "borders", "cellXfs")


class StyleSheet:
    """The style part of a package; call `store` when all styles are made.

    Args:
        package: a package that has one, as every workbook with a spreadsheet program behind it.
    """

    def __init__(self, package: PackageEdit) -> None:
        self._package = package
        self._parts = package.related(package.book.part, "styles")
        self._data = as_utf8(package.read(self._parts[0])) if self._parts else b""
        self._lists: dict[str, Element] = {}
        self._styles: list[bytes] = []
        self._new: dict[str, list[bytes]] = {name: [] for name in _LISTS}
        self._made: dict[tuple[int, str, bool], int] = {}
        if self._parts:
            found = find(self._data, lambda path: len(path) in (2, 3))
            self._lists = {e.local: e for e in found if len(e.path) == 2 and e.local in _LISTS}
            self._styles = [self._data[e.start : e.end] for e in found if e.path[1:] == ("cellXfs", "xf")]
            self._counts = {name: sum(e.path[1:2] == (name,) and len(e.path) == 3 for e in found) for name in _LISTS}

    def marked(self, style: int, fill: str, edge: str) -> int:
        """A style like another one, with this fill and this border (`RRGGBB`); a conditional format may hide a fill."""
        return self._make(style, fill, edge, False)

    def note(self, fill: str, *, bold: bool = False) -> int:
        """The style of a text of ours: small and wrapped."""
        return self._make(-1, fill, "", bold)

    def _make(self, base: int, fill: str, edge: str, bold: bool) -> int:
        if any(name not in self._lists for name in _LISTS):
            return max(base, 0)  # a workbook without styles: told by its texts only
        made = self._made.get((base, fill, bold))
        if made is None:
            made = self._made[base, fill, bold] = self._add("cellXfs", self._style(base, fill, edge, bold))
        return made

    def _style(self, base: int, fill: str, edge: str, bold: bool) -> bytes:
        p = self._lists["cellXfs"].prefix
        named: dict[str, str | None] = {}
        if fill:
            solid = f'<{p}patternFill patternType="solid"><{p}fgColor rgb="FF{fill}"/><{p}bgColor indexed="64"/>'
            named |= {"fillId": str(self._add("fills", f"<{p}fill>{solid}</{p}patternFill></{p}fill>".encode()))}
            named |= {"applyFill": "1"}
        if edge:
            sides = "".join(
                f'<{p}{side} style="medium"><{p}color rgb="FF{edge}"/></{p}{side}>'
                for side in ("left", "right", "top", "bottom")
            )
            named |= {"borderId": str(self._add("borders", f"<{p}border>{sides}<{p}diagonal/></{p}border>".encode()))}
            named |= {"applyBorder": "1"}
        if base >= 0:
            old = self._styles[base] if base < len(self._styles) else f"<{p}xf/>".encode()
            tag = find(old, lambda path: len(path) == 1)[0]
            return with_attributes(old[: tag.inner], named) + old[tag.inner :]
        thick = f"<{p}b/>" if bold else ""
        font = f'<{p}font>{thick}<{p}sz val="9"/><{p}color rgb="FF1F2D3A"/><{p}name val="Arial"/></{p}font>'
        named |= {"fontId": str(self._add("fonts", font.encode())), "applyFont": "1"}
        start = f'<{p}xf numFmtId="49" fontId="0" fillId="0" borderId="0" xfId="0" applyAlignment="1">'.encode()
        return with_attributes(start, named) + f'<{p}alignment vertical="center" wrapText="1"/></{p}xf>'.encode()

    def _add(self, name: str, element: bytes) -> int:
        new = self._new[name]
        if element not in new:
            new.append(element)
        return self._counts[name] + new.index(element)

    def store(self) -> None:
        """Write the part, if there are new styles."""
        changes = []
        for name, new in self._new.items():
            if new:
                e = self._lists[name]
                count = max(number(e.attributes.get("count")), self._counts[name]) + len(new)
                tag = with_attributes(self._data[e.start : e.inner], {"count": str(count)})
                changes += [(e.start, e.inner, tag), (e.inner_end, e.inner_end, b"".join(new))]
        if changes:
            self._package.write(self._parts[0], splice(self._data, changes))
