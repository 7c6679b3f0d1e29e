"""One row of a sheet's XML and its cells: read, numbered anew, changed, byte for byte."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

from rrp_sheets.model.cells import column_letters
from rrp_sheets.workbook.patch.markup import Element, find, splice, with_attributes
from rrp_sheets.workbook.xlsx_sheet import place

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
