"""One sheet's XML, taken apart into its rows: cells are set, rows get other numbers, the rest stays byte for byte."""

from __future__ import annotations

import bisect
import re
from collections.abc import Mapping
from dataclasses import dataclass

from rrp_sheets.model.cells import column_letters
from rrp_sheets.workbook.edits import Value
from rrp_sheets.workbook.patch.blocks import block_of, block_text
from rrp_sheets.workbook.patch.markup import Element, Scanner, as_utf8, broken, find, splice, with_attributes
from rrp_sheets.workbook.patch.values import content
from rrp_sheets.workbook.raw import Range
from rrp_sheets.workbook.xlsx_parts import number as whole
from rrp_sheets.workbook.xlsx_sheet import place

DATA_TABLE = "a data table"


@dataclass(slots=True)
class FormulaRange:
    """An array formula or a data table: the block of cells that it fills, in the words that tell it."""

    block: Range
    what: str


class _SheetScanner(Scanner):
    """Finds the rows, and everything outside of the rows."""

    def __init__(self, data: bytes) -> None:
        super().__init__(data)
        self.rows: list[tuple[Element, bool, bool, bool]] = []
        self.outside: list[Element] = []
        self.shared = False
        self.ranges: list[FormulaRange] = []
        self.plain = True
        self._used = self._filled = self._formulas = self._in_data = False

    def wants(self, path: list[str], attributes: Mapping[str, str]) -> bool:
        """All but what is inside of rows; that is only looked at."""
        depth = len(path)
        if depth <= 2:
            self._in_data = depth == 2 and path[1] == "sheetData"
        if depth <= 2 or not self._in_data:
            return True
        if depth == 3:
            self._used = self._filled = self._formulas = False
            self.plain = self.plain and path[2] == "row"
            return True
        if depth == 4:
            self._used = True
            self.plain = self.plain and path[3] == "c"
        elif depth == 5:
            self._filled = True
            if path[4] == "f":
                self._note(attributes)
        return False

    def _note(self, attributes: Mapping[str, str]) -> None:
        self._formulas = True
        kind = attributes.get("t", "normal")
        self.shared = self.shared or kind == "shared"
        if kind in ("array", "dataTable") and (block := block_of(attributes.get("ref", ""))):
            self.ranges.append(FormulaRange(block, "an array formula" if kind == "array" else DATA_TABLE))

    def found(self, element: Element) -> None:
        """A row, or an element outside of the rows, has ended."""
        if self._in_data and len(element.path) == 3:
            self.rows.append((element, self._used, self._filled, self._formulas))
        else:
            self.outside.append(element)


class SheetXml:
    """A sheet taken apart; raises SheetsError for XML that cannot be changed safely.

    Args:
        data: the part's bytes.
    """

    def __init__(self, data: bytes) -> None:
        self.data = as_utf8(data)
        scanner = _SheetScanner(self.data)
        scanner.scan()
        self.outside = sorted(scanner.outside, key=lambda e: e.start)
        self.ranges, self.shared = scanner.ranges, scanner.shared
        table = self.element("sheetData")
        if table is None or not scanner.plain:
            raise broken()
        self.table = table
        self.rows: dict[int, RowXml] = {}
        self._changes: dict[tuple[int, int], bytes] = {}
        self._columns: set[int] = set()
        self.touched = False
        at, number = table.inner, 0
        for element, *about in scanner.rows:
            number = whole(element.attributes.get("r"), number + 1)
            if number in self.rows:
                raise broken()
            raw, gap = self.data[element.start : element.end], self.data[at : element.start]
            self.rows[number] = RowXml(number, raw, gap, *about)
            at = element.end
        self._tail = self.data[at : table.inner_end]
        self._order = sorted(self.rows)

    def element(self, name: str) -> Element | None:
        """The sheet's part of that name, such as `dimension`."""
        return next((e for e in self.outside if len(e.path) == 2 and e.local == name), None)

    def all(self, *names: str) -> list[Element]:
        """The elements of these names outside of the rows."""
        return [e for e in self.outside if e.local in names]

    def replace(self, element: Element, new: bytes) -> None:
        """Replace an element outside of the rows."""
        self._changes[element.start, element.end] = new
        self.touched = True

    def insert(self, at: int, new: bytes) -> None:
        """Insert something outside of the rows."""
        self._changes[at, at] = self._changes.get((at, at), b"") + new
        self.touched = True

    def retag(self, element: Element, attributes: Mapping[str, str | None]) -> None:
        """Change attributes of an element outside of the rows."""
        tag = self._changes.get((element.start, element.inner), self.data[element.start : element.inner])
        self._changes[element.start, element.inner] = with_attributes(tag, attributes)
        self.touched = True

    def rewrite(self, element: Element, inside: bytes) -> None:
        """Change what stands between the tags of an element outside of the rows."""
        self._changes[element.inner, element.inner_end] = inside
        self.touched = True

    def merged(self) -> list[Range]:
        """The merged blocks."""
        blocks = (block_of(e.attributes.get("ref", "")) for e in self.all("mergeCell"))
        return [b for b in blocks if b]

    def to_bytes(self) -> bytes:
        """The sheet as it is now."""
        if not self.touched:
            return self.data
        self._set_dimension()
        body = b"".join(part for n in self._order for part in (self.rows[n].gap, self.rows[n].raw)) + self._tail
        table = self.table
        changes = [(start, end, new) for (start, end), new in self._changes.items()]
        if table.inner == table.end:  # `<sheetData/>`
            tag = self.data[table.start : table.inner].removesuffix(b"/>").rstrip() + b">"
            changes.append((table.start, table.end, tag + body + f"</{table.name}>".encode()))
        else:
            changes.append((table.inner, table.inner_end, body))
        return splice(self.data, changes)

    def take(self, rows: dict[int, RowXml]) -> None:
        """Take over other rows instead of those there were."""
        self.rows, self._order, self.touched = rows, sorted(rows), True

    def cell(self, row: int, column: int) -> CellXml | None:
        """The cell at a place, if it exists."""
        found = self.rows.get(row)
        return next((c for c in found.cells() if c.column == column), None) if found else None

    def style(self, row: int, column: int) -> int:
        """The style that the cell has, or would get: the row's or the column's."""
        cell = self.cell(row, column)
        if cell is not None:
            return whole(cell.element.attributes.get("s"))
        if row in self.rows:
            named = self.rows[row].tag.attributes
            if named.get("customFormat") in ("1", "true"):
                return whole(named.get("s"))
        for col in self.all("col"):
            if whole(col.attributes.get("min")) <= column <= whole(col.attributes.get("max")):
                return whole(col.attributes.get("style"))
        return 0

    def set_cell(self, row: int, column: int, value: Value, style: int) -> None:
        """Put a value into a cell, which then has this style."""
        cell = self.cell(row, column)
        if cell is None and value in (None, "") and style == self.style(row, column):
            return
        line = self._row(row)
        kind, inside = content(value, self.table.prefix)
        named = {"r": f"{column_letters(column)}{row}", "s": str(style) if style else None, "t": kind}
        name = f"{self.table.prefix}c".encode()
        old = line.raw[cell.element.start : cell.element.inner] if cell else b"<" + name + b">"
        tag = with_attributes(old, {**named, "cm": None, "vm": None}).removesuffix(b">").removesuffix(b"/").rstrip()
        line.put(cell, column, tag + (b">" + inside + b"</" + name + b">" if inside else b"/>"))
        self._columns.add(column)
        self.touched = True

    def _row(self, number: int) -> RowXml:
        """The row of that number, made where there is none."""
        if number not in self.rows:
            name = f"{self.table.prefix}row"
            self.rows[number] = RowXml(number, f'<{name} r="{number}"></{name}>'.encode())
            at = bisect.bisect(self._order, number)
            for later in self._order[at : at + 1]:  # it may have counted on from the one before
                self.rows[later] = self.rows[later].renumbered(later)
            self._order.insert(at, number)
        return self.rows[number]

    def _set_dimension(self) -> None:
        element = self.element("dimension")
        used = [n for n in self._order if self.rows[n].used]
        if element is None or not used:
            return
        old = block_of(element.attributes.get("ref", ""))
        columns = self._columns | ({old.left, old.right} if old else {1})
        self.retag(element, {"ref": block_text(Range(used[0], min(columns), used[-1], max(columns)))})


_CELL = ["row", "c"]
_ROW_NUMBER = re.compile(rb"""(<(?:\w+:)?row(?=\s)[^<>]*?\sr=["'])\d+(["'])""")
_CELL_NUMBER = re.compile(rb"""(<(?:\w+:)?c(?=\s)[^<>]*?\sr=["'][A-Z]+)\d+(["'])""")


@dataclass(slots=True)
class CellXml:
    """A cell within its row's bytes.

    Attributes:
        formula: the attributes of its `f`, None where it has none.
    """

    column: int
    element: Element
    formula: Mapping[str, str] | None


@dataclass(slots=True)
class RowXml:
    """A row: its bytes from `<row` to `</row>`, and what stands between the row before and it.

    Attributes:
        used: whether it has cells, be they blank.
        filled: whether one of its cells has a content.
        formulas: whether one of its cells has a formula.
    """

    number: int
    raw: bytes
    gap: bytes = b""
    used: bool = False
    filled: bool = False
    formulas: bool = False

    @property
    def tag(self) -> Element:
        """The row itself as an element."""
        return find(self.raw, lambda path: len(path) == 1)[0]

    def cells(self) -> list[CellXml]:
        """The cells in their order."""
        found = find(self.raw, lambda path: path[:2] == _CELL and (len(path) == 2 or path[2:] == ["f"]))
        cells: list[CellXml] = []
        column = 0
        for element in found:
            if element.local == "c":
                at = place(element.attributes.get("r", ""))
                column = at[1] if at else column + 1
                cells.append(CellXml(column, element, None))
            elif cells:
                cells[-1].formula = element.attributes
        return cells

    def renumbered(self, number: int) -> RowXml:
        """The same row with another number, in its tag and in those of its cells."""
        if b"<!" not in self.raw and _ROW_NUMBER.match(self.raw):  # nothing but tags: quicker
            raw = _ROW_NUMBER.sub(rb"\g<1>%d\g<2>" % number, self.raw, count=1)
            raw = _CELL_NUMBER.sub(rb"\g<1>%d\g<2>" % number, raw)
            return RowXml(number, raw, self.gap, self.used, self.filled, self.formulas)
        changes = []
        tag = self.tag
        changes.append((0, tag.inner, with_attributes(self.raw[: tag.inner], {"r": str(number)})))
        for cell in self.cells():
            e = cell.element
            named = {"r": f"{column_letters(cell.column)}{number}"}
            changes.append((e.start, e.inner, with_attributes(self.raw[e.start : e.inner], named)))
        return RowXml(number, splice(self.raw, changes), self.gap, self.used, self.filled, self.formulas)

    def put(self, cell: CellXml | None, column: int, new: bytes) -> None:
        """Replace a cell's bytes, or (None) put a new one where its column wants it.

        The row's hint which columns it spans is dropped; cells that counted on from the one before get their names.
        """
        tag = self.tag
        changes = [(0, tag.inner, with_attributes(self.raw[: tag.inner], {"spans": None}))]
        if tag.inner == tag.end:
            self.raw = changes[0][2].removesuffix(b"/>").rstrip() + b">" + new + f"</{tag.name}>".encode()
        elif cell is not None:
            self.raw = splice(self.raw, [*changes, (cell.element.start, cell.element.end, new)])
        else:
            later = [c for c in self.cells() if c.column > column]
            at = later[0].element.start if later else tag.inner_end
            changes.append((at, at, new))
            for c in later:
                e = c.element
                if "r" not in e.attributes:
                    named = {"r": f"{column_letters(c.column)}{self.number}"}
                    changes.append((e.start, e.inner, with_attributes(self.raw[e.start : e.inner], named)))
            self.raw = splice(self.raw, changes)
        inside = find(self.raw, lambda path: path[:2] == _CELL and len(path) == 3)
        self.used, self.filled, self.formulas = True, bool(inside), any(e.local == "f" for e in inside)
