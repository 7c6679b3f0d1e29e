"""Reading an .xlsx file and its sheets: existing cells only, in one pass that counts while it reads."""

from __future__ import annotations

import math
import re
from functools import cached_property
from typing import Any

from rrp_sheets.diagnostics import Diagnostic
from rrp_sheets.errors import UnreadableFile
from rrp_sheets.model.workbook import column_letters
from rrp_sheets.texts import N_
from rrp_sheets.workbook import limits
from rrp_sheets.workbook.package import Handler, Package, Stop, XmlReader, block_of, number, place, translated, truth
from rrp_sheets.workbook.raw import Extent, Kind, Range, RawCell, RawSheet, number_text, unreadable

_ESCAPED = re.compile(r"_x([0-9A-Fa-f]{4})_")
_LITERAL = re.compile("_(?=x[0-9A-Fa-f]{4}_)")
IMPOSSIBLE = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\ud800-\udfff\ufffe\uffff]")
"""Characters, and halves of characters, that XML cannot hold."""


def unescape(text: str) -> str:
    r"""Undo Excel's `_x000D_` for characters that XML cannot hold; a carriage return is a line break.

    >>> unescape("a_x000D_b")
    'a\nb'
    """
    if "_x" in text:
        text = _ESCAPED.sub(lambda m: chr(int(m[1], 16)) if not 0xD800 <= int(m[1], 16) < 0xE000 else "", text)
    return text.replace("\r\n", "\n").replace("\r", "\n") if "\r" in text else text


def escape_literal(text: str) -> str:
    """A text that has the form of such an escape itself, so that it is read as it stands.

    >>> escape_literal("a_x000D_b"), unescape(escape_literal("a_x000D_b"))
    ('a_x005F_x000D_b', 'a_x000D_b')
    """
    return _LITERAL.sub("_x005F_", text) if "_x" in text else text


class _StringsHandler(Handler):
    """Collects the shared texts. Phonetic readings of Japanese texts (`rPh`) are no part of the text."""

    def __init__(self, name: str) -> None:
        super().__init__()
        self.texts: list[str] = []
        self._name, self._phonetic = name, False

    def start(self, name: str, attributes: Any) -> None:
        if name == "t":
            self.wanted = not self._phonetic
        elif name == "rPh":
            self._phonetic = True
        elif name == "si":
            self.take_text()

    def end(self, name: str) -> None:
        if name == "t":
            self.wanted = False
        elif name == "rPh":
            self._phonetic = False
        elif name == "si":
            self.texts.append(unescape(self.take_text()))
            if len(self.texts) > limits.SHARED_STRINGS:
                what = N_("more than {n} texts", n=f"{limits.SHARED_STRINGS:,}")
                raise unreadable("FILE007", name=self._name, what=what)


class SharedStrings:
    """The shared texts, read only as far as a sheet asks for them."""

    def __init__(self, package: Package) -> None:
        self._name, self._handler = package.name, _StringsHandler(package.name)
        part = package.by_kind.get("sharedstrings")
        self._reader = XmlReader(package, part, self._handler) if part else None

    def get(self, index: int) -> str:
        """The text of that number; raises UnreadableFile when there is none."""
        texts = self._handler.texts
        while len(texts) <= index and self._reader and self._reader.step():
            pass
        if len(texts) <= index:
            raise unreadable("FILE008", name=self._name, what=N_("a cell refers to a text that is missing"))
        return texts[index]


# Cells that have only a colour, before a cell that says where it stands or at a row's end. A comment or a text that
# is marked as one could have the same letters: where there is one, nothing is left out.
_BARE = re.compile(rb'(?:<c r="[A-Z]{1,3}[0-9]{1,7}"(?: s="[0-9]{1,6}")?(?: t="n")? ?/>)+(?=<c r="[A-Z]|</row>)')
_MARKED = re.compile(rb"\A!|<!|<\Z")


class SheetHandler(Handler):
    """Collects the filled cells, merged ranges and hidden rows of a sheet, as much of it as `extent` wants."""

    def __init__(self, book: XlsxBook, sheet: str, extent: Extent) -> None:
        super().__init__()
        self.cells: dict[tuple[int, int], RawCell] = {}
        self.merged: list[Range] = []
        self.hidden_rows: set[int] = set()
        self._book, self._sheet, self._extent = book, sheet, extent
        self._row = self._column = self._elements = self._merged_area = self._filled_rows = 0
        self._at: tuple[int, int] = (0, 0)
        self._type = self._style = self._value = self._formula = ""
        self._formula_kind = self._shared = ""
        self._masters: dict[str, tuple[str, str]] = {}
        self._phonetic = self._in_cell = self._in_data = False
        self._thins = extent is Extent.WHOLE

    def thin(self, piece: bytes) -> bytes:
        """Leave out cells without a value, which are most of a prepared sheet; they count all the same."""
        self._thins = self._thins and not _MARKED.search(piece)
        if not self._thins:
            return piece
        thinned = _BARE.sub(b"", piece)
        if len(thinned) != len(piece):
            left_out = piece.count(b"<c ") - thinned.count(b"<c ")
            self._elements += left_out
            self._budget.left -= left_out
            self._refuse_too_many()
        return thinned

    def start(self, name: str, attributes: Any) -> None:
        """A row, a cell, or a part of a cell begins."""
        if name == "sheetData":
            self._in_data = True
        elif not self._in_data:
            if name == "mergeCell":
                self._merge(attributes.get("ref", ""))
        elif name == "c":
            self._start_cell(attributes)
        elif name == "row":
            self._row = number(attributes.get("r"), self._row + 1)
            self._column = 0
            self._stop_after(self._row)
            if truth(attributes.get("hidden")) and len(self.hidden_rows) < limits.CELLS:
                self.hidden_rows.add(self._row)
        elif self._in_cell and (name in ("v", "f") or (name == "t" and not self._phonetic)):
            if name == "f":
                self._formula_kind, self._shared = attributes.get("t", "normal"), attributes.get("si", "")
            self.take_text()
            self.wanted = True
        elif name == "rPh":
            self._phonetic = True

    def end(self, name: str) -> None:
        """A part of a cell, or a cell, ends."""
        if name in ("v", "f", "t"):
            if self.wanted:
                text = unescape(self.take_text())
                self.wanted = False
                if name == "f":
                    self._formula = text
                else:
                    self._value += text
        elif name == "c" and self._in_data:
            self._end_cell()
        elif name == "rPh":
            self._phonetic = False
        elif name == "sheetData":
            self._in_data = False

    def _start_cell(self, attributes: Any) -> None:
        self._elements += 1
        reference = attributes.get("r", "")  # old writers leave it out: the next cell of the row
        self._at = (place(reference) or (0, 0)) if reference else (self._row, self._column + 1)
        self._column = self._at[1]
        self._type, self._style = attributes.get("t", "n"), attributes.get("s", "")
        self._value = self._formula = self._formula_kind = self._shared = ""
        self._in_cell = True
        self._refuse_too_many()

    def _refuse_too_many(self) -> None:
        if self._elements > (limits.HEAD_CELLS if self._extent is Extent.HEAD else limits.CELL_ELEMENTS):
            if self._extent is not Extent.WHOLE:
                raise Stop
            raise self._too_large(N_("more than {n} cells", n=f"{limits.CELL_ELEMENTS:,}"), limits.CELLS)

    def _end_cell(self) -> None:
        self._in_cell = False
        if not (self._value or self._formula or self._formula_kind):
            return  # most of the cells that there are have only a colour
        formula = self._shared_formula() if self._formula_kind == "shared" else self._formula
        text, kind = self._typed()
        beyond = self._extent is Extent.TABLE and self._at[1] > _LAST_TABLE_COLUMN
        if not (formula or text) or not self._at[0] or beyond:
            return
        self.cells[self._at] = RawCell(text, kind, formula.lstrip("="))
        if self._extent is Extent.WHOLE and len(self.cells) > limits.CELLS:
            raise self._too_large(N_("more than {n} filled cells", n=f"{limits.CELLS:,}"), limits.CELLS)

    def _shared_formula(self) -> str:
        """A formula that stands once for several cells is written out for this one, as Excel shows it."""
        here = f"{column_letters(self._at[1])}{self._at[0]}"
        if self._formula:
            self._masters[self._shared] = (self._formula, here)
            return self._formula
        if self._shared not in self._masters:
            return ""
        return translated(*self._masters[self._shared], here)

    def _typed(self) -> tuple[str, Kind]:
        value, kind = self._value, self._type
        if kind == "s":
            index = value.strip()
            known = index.isascii() and index.isdigit()
            return self._book.strings.get(number(index)) if known else "", Kind.TEXT
        if kind in ("str", "inlineStr"):
            return value, Kind.TEXT
        value = value.strip()
        if kind == "b":
            return ("TRUE" if truth(value) else "FALSE") if value else "", Kind.TRUTH
        if kind in ("e", "d"):
            return value, Kind.ERROR if kind == "e" else Kind.DATE
        return self._number(value)

    def _number(self, value: str) -> tuple[str, Kind]:
        try:
            parsed = float(value)
        except ValueError:
            return value, Kind.TEXT
        if not math.isfinite(parsed):
            return value, Kind.TEXT
        kind = self._book.styles.kind(number(self._style))
        if kind is None:
            return number_text(parsed), Kind.NUMBER
        from openpyxl.utils.datetime import MAC_EPOCH, WINDOWS_EPOCH, from_excel

        try:
            moment = from_excel(parsed, MAC_EPOCH if self._book.mac_epoch else WINDOWS_EPOCH, timedelta=False)
        except (OverflowError, ValueError):
            return number_text(parsed), Kind.NUMBER
        return str(moment).removesuffix(" 00:00:00") if kind is Kind.DATE else str(moment).rpartition(" ")[2], kind

    def _stop_after(self, row: int) -> None:
        if self._extent is Extent.HEAD and row > limits.HEADER_ROWS:
            raise Stop
        self._filled_rows += 1
        if self._extent is Extent.TABLE and self._filled_rows > _TABLE_ROWS_READ:
            raise Stop

    def _merge(self, reference: str) -> None:
        if (block := block_of(reference)) is None:
            return
        self.merged.append(block)
        self._merged_area += block.area
        if self._extent is Extent.WHOLE and self._merged_area > limits.MERGED_CELLS:
            raise self._too_large(N_("{n} merged cells", n=f"{self._merged_area:,}"), limits.MERGED_CELLS)

    def _too_large(self, what: str, limit: int) -> UnreadableFile:
        return unreadable("FILE013", sheet=self._sheet, what=what, limit=f"{limit:,}")


_LAST_TABLE_COLUMN = limits.TABLE_COLUMNS + limits.COLUMNS
"""A table may begin further right; what is beyond its own 30 columns is found out later."""
_TABLE_ROWS_READ = limits.TABLE_ROWS + limits.HEADER_ROWS + 2


class XlsxBook(Package):
    """An opened .xlsx file; see Book."""

    format = "xlsx"

    def __init__(self, data: bytes, name: str) -> None:
        super().__init__(data, name)
        self.findings: list[Diagnostic] = []

    @cached_property
    def strings(self) -> SharedStrings:
        """The shared texts of its cells."""
        return SharedStrings(self)

    def sheet(self, index: int, extent: Extent) -> RawSheet:
        """Read a sheet; see Book."""
        entry = self.entries[index]
        handler = SheetHandler(self, entry.name, extent)
        self.parse(entry.part, handler)
        return RawSheet(entry.name, handler.cells, tuple(handler.merged), frozenset(handler.hidden_rows), entry.hidden)
