"""A recognised sheet as rows of cleaned cells; everything odd about a cell is reported on the way."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass

from rrp_sheets.diagnostics import Report
from rrp_sheets.diagnostics.fix import Fix
from rrp_sheets.diagnostics.phrase import Phrase
from rrp_sheets.model.cells import Address, Cell
from rrp_sheets.model.names import key
from rrp_sheets.workbook import limits
from rrp_sheets.workbook.cleaning import (
    ERROR_VALUES,
    clean_fields,
    clean_formula,
    clean_name,
    clean_prose,
    clean_spaces,
    from_excel,
)
from rrp_sheets.workbook.headers import Recognised
from rrp_sheets.workbook.raw import Kind, Range, RawCell, RawSheet

_SEPARATORS = re.compile(r"[,、，\n]")
_BLANK = RawCell("")
_MOST_MERGES = 20


@dataclass(frozen=True, slots=True)
class FilledRow:
    """A filled row of a table: its number and its raw cells by column."""

    number: int
    cells: Mapping[int, RawCell]


class OwnTable:
    """A sheet of ours.

    Args:
        sheet: as the backend gave it, whole.
        recognised: where its headers are.
        report: where findings go.
    """

    def __init__(self, sheet: RawSheet, recognised: Recognised, report: Report) -> None:
        self.sheet, self.report = sheet, report
        self.header_row = recognised.row
        self.columns, self.others = recognised.columns, recognised.others
        self.ours = {*self.columns.values(), *(self.others if recognised.kind and recognised.kind.open else ())}
        self._notes = self.columns.get("Notes", 0)
        headers = sheet.cells
        for column, first in recognised.twice.items():
            text = clean_spaces(headers[self.header_row, column].text)
            first_cell = self.address(self.header_row, first).cell
            self.add("SHEET005", self.address(self.header_row, column), header=text, first=first_cell)

    def add(self, code: str, address: Address, *, fixes: Iterable[Fix] = (), **details: object) -> None:
        """Report a finding, unless there are too many already."""
        if len(self.report) < limits.FINDINGS:
            self.report.add(code, address, span=None, fixes=fixes, **details)

    def address(self, row: int, column: int) -> Address:
        """The address of a cell."""
        return Address(self.sheet.name, row, column)

    def lines(self) -> Iterator[FilledRow]:
        """The rows below the header that say something: not blank, no comment, more than notes."""
        says = self.ours - {self._notes, self.columns.get("On", 0), self.columns.get("Priority", 0)}
        for number, cells in self.sheet.rows().items():
            if number > self.header_row and not self._is_comment(cells) and self._filled(cells, says):
                yield FilledRow(number, cells)

    def comments(self) -> Iterator[FilledRow]:
        """The comment rows below the header."""
        for number, cells in self.sheet.rows().items():
            if number > self.header_row and self._is_comment(cells):
                yield FilledRow(number, cells)

    @staticmethod
    def _filled(cells: Mapping[int, RawCell], columns: set[int]) -> bool:
        return any(c in columns and (cell.formula or clean_spaces(cell.text)) for c, cell in cells.items())

    def _is_comment(self, cells: Mapping[int, RawCell]) -> bool:
        """Return whether a row is a comment: its first cell, leaving out the user's own columns, begins with `#`."""
        for column, cell in cells.items():
            if column in self.ours or column not in self.others:
                text = clean_name(cell.text)
                if text:
                    return text.startswith("#") and cell.kind is Kind.TEXT and not is_error_value(text)
        return False

    def name(self, line: FilledRow, header: str) -> Cell:
        """A cell that holds a name."""
        return self._cell(line, self.columns.get(header, 0), clean_name)

    duration = name
    """A cell that holds a time or a duration is cleaned like a name."""

    def formula(self, line: FilledRow, header: str) -> Cell:
        """A cell that holds a formula; one that the spreadsheet program took for its own is read all the same."""
        column = self.columns.get(header, 0)
        cell = line.cells.get(column, _BLANK)
        if cell.formula:
            original = cell.typed
            return self._checked(clean_formula(from_excel(cell.formula)), original, self.address(line.number, column))
        return self._cell(line, column, clean_formula)

    def prose(self, line: FilledRow, header: str) -> Cell:
        """A cell that holds a text for people."""
        return self._cell(line, self.columns.get(header, 0), clean_prose)

    def fields(self, line: FilledRow, header: str) -> Cell:
        """A cell that holds a value to send or to expect."""
        return self._cell(line, self.columns.get(header, 0), clean_fields)

    def other(self, line: FilledRow, column: int) -> Cell:
        """A cell of a column with a header of its own: a device's setting, a gesture's joint."""
        return self._cell(line, column, clean_prose)

    def notes(self, line: FilledRow) -> str:
        """The row's notes, as typed."""
        return line.cells.get(self._notes, _BLANK).text.strip()

    def names(self, cell: Cell) -> tuple[Cell, ...]:
        """The names in a cell, separated by commas or line breaks."""
        parts = [name for part in _SEPARATORS.split(cell.text) if (name := clean_spaces(part))]
        if len(parts) > limits.NAMES:
            self.add("SHEET021", cell.address, count=len(parts), limit=limits.NAMES)
        return tuple(Cell(name, cell.address, cell.original) for name in parts[: limits.NAMES])

    def _cell(self, line: FilledRow, column: int, clean: Callable[[str], str]) -> Cell:
        address = self.address(line.number, column) if column else Address(self.sheet.name, line.number, 1)
        raw = line.cells.get(column, _BLANK) if column else _BLANK
        if raw.kind in (Kind.DATE, Kind.TIME):
            self.add("SHEET006", address, value=raw.text)
            return Cell(raw.text, address, raw.typed)
        if raw.formula and (raw.kind is Kind.ERROR or not raw.text):
            return self._checked(clean(from_excel(raw.formula)), raw.typed, address)  # typed with = by habit
        return self._checked(clean(raw.text), raw.typed, address)

    def _checked(self, text: str, original: str, address: Address) -> Cell:
        if len(text) > limits.CELL_CHARACTERS:
            self.add("SHEET016", address, count=len(text), limit=limits.CELL_CHARACTERS)
            text, original = text[: limits.CELL_CHARACTERS], original[: limits.CELL_CHARACTERS]
        elif is_error_value(text):
            self.add("SHEET007", address, value=text)
        return Cell(text, address, original)

    def report_hidden(self, lines: Mapping[int, object]) -> None:
        """Warn of rows that cannot be seen but are active.

        Args:
            lines: the active rows by number.
        """
        if self.sheet.hidden and lines:
            self.add("SHEET010", Address(self.sheet.name), sheet=self.sheet.name)
        hidden = sorted(self.sheet.hidden_rows & lines.keys())
        blocks: list[list[int]] = []
        for row in hidden:
            if blocks and blocks[-1][1] == row - 1:
                blocks[-1][1] = row
            else:
                blocks.append([row, row])
        for first, last in blocks:
            rows: str = Phrase("Row {n}", n=first)
            if first != last:
                rows = Phrase("Rows {first} to {last}", first=first, last=last)
            address = self.address(first, min(self.columns.values()))
            self.add("SHEET009", address, rows=rows, sheet=self.sheet.name)

    def report_merged(self) -> None:
        """Warn of merged cells that reach into the table."""
        last = max((row for row, _ in self.sheet.cells), default=0)
        reaching = [r for r in self.sheet.merged if r.bottom >= self.header_row and r.top <= last and r.area > 1]
        found = [(block, second) for block in reaching if (second := self._second(block))]
        for block, second in found[:_MOST_MERGES]:
            first, end = self.address(block.top, block.left), self.address(block.bottom, block.right)
            self.add("SHEET008", second, range=f"{first.cell}:{end.cell}", first=first.cell)

    def _second(self, block: Range) -> Address | None:
        """The first cell of a merged range that is one of ours and not the one with the content."""
        columns = sorted(c for c in self.ours if block.left <= c <= block.right)
        for row in (block.top, block.top + 1):
            for column in columns:
                if row <= block.bottom and (row, column) != (block.top, block.left):
                    return self.address(row, column)
        return None


def is_error_value(text: str) -> bool:
    """Return whether a text is one of Excel's or LibreOffice's error values.

    >>> is_error_value("#NAME?"), is_error_value("Err:508"), is_error_value("# note")
    (True, True, False)
    """
    return text[:1] in ("#", "E") and (text.upper() in ERROR_VALUES or re.fullmatch(r"Err:\d{3}", text) is not None)


def header_keys(table: OwnTable) -> dict[int, str]:
    """The keys of the columns with headers of their own, by column."""
    return {column: key(header) for column, header in table.others.items() if key(header)}
