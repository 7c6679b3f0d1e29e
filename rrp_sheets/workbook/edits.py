"""Edits of a workbook, the same few for every format, and the values that they put into cells."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass

from rrp_sheets.errors import SheetsError
from rrp_sheets.model.workbook import column_letters
from rrp_sheets.texts import N_
from rrp_sheets.workbook import limits
from rrp_sheets.workbook.comments import Comment, Thread
from rrp_sheets.workbook.raw import number_text

Value = str | float | bool | None
"""A text, a number, a truth value, or nothing."""


@dataclass(frozen=True, slots=True)
class SetCell:
    """Put a value into a cell; None or an empty text empties it. The cell keeps its style.

    A `str` is stored as text, never as a live formula. A number goes as text into cells that are formatted as text or
    as a date, because there it would be shown as something else.
    """

    sheet: str
    row: int
    column: int
    value: Value

    @property
    def place(self) -> str:
        """`Tracking!C5`."""
        return f"{self.sheet}!{column_letters(self.column)}{self.row}"

    def checked_value(self) -> Value:
        r"""The value as it can be stored, line breaks as `\n`; raises SheetsError when a cell cannot hold it."""
        value, at = self.value, self.place
        if isinstance(value, (int, float)) and not isinstance(value, bool) and not math.isfinite(value):
            message = N_("A cell cannot contain the number {value} ({cell}).", value=str(value), cell=at)
            raise SheetsError(message, N_("Write a number, or a text."))
        if not isinstance(value, str):
            return value
        value = value.replace("\r\n", "\n").replace("\r", "\n")
        n, most = len(value.encode("utf-16-le", "surrogatepass")) // 2, limits.CELL_CHARACTERS  # as Excel counts
        if n > most:
            told = N_(
                "The text for {cell} has {n:,} characters. The limit of a cell is {most:,}.", cell=at, n=n, most=most
            )
            raise SheetsError(told, N_("Shorten it, or split it over several cells."))
        if match := _IMPOSSIBLE.search(value):
            code = f"U+{ord(match[0]):04X}"
            told = N_("The text for {cell} contains an invalid character ({code}).", cell=at, code=code)
            raise SheetsError(told, N_("Type the text again instead of pasting it."))
        return value


@dataclass(frozen=True, slots=True)
class SetComments:
    """Give a cell a thread of comments instead of the one that it has; an empty one takes it away."""

    sheet: str
    row: int
    column: int
    thread: Thread

    def __post_init__(self) -> None:
        """Make comments of what a journal has kept of them."""
        made = tuple(c if isinstance(c, Comment) else Comment(**c) for c in self.thread)
        object.__setattr__(self, "thread", made)


@dataclass(frozen=True, slots=True)
class SetLook:
    """Let a cell be bold, have a fill (`RRGGBB`), or break long texts; what is None stays, as does all else."""

    sheet: str
    row: int
    column: int
    bold: bool | None = None
    fill: str | None = None
    wrap: bool | None = None


@dataclass(frozen=True, slots=True)
class InsertRows:
    """Insert blank rows before a row; they look like the row above them."""

    sheet: str
    before: int
    count: int = 1

    def mapped(self, row: int) -> int | None:
        """Return the number that a row has afterwards.

        >>> [InsertRows("T", 3, 2).mapped(n) for n in (2, 3, 4)]
        [2, 5, 6]
        """
        return row if row < self.before else row + self.count

    @property
    def start(self) -> int:
        """The first row that is touched."""
        return self.before


@dataclass(frozen=True, slots=True)
class DeleteRows:
    """Delete rows with everything in them."""

    sheet: str
    first: int
    count: int = 1

    def mapped(self, row: int) -> int | None:
        """Return the number that a row has afterwards; None when it is deleted.

        >>> [DeleteRows("T", 3, 2).mapped(n) for n in (2, 3, 4, 5)]
        [2, None, None, 3]
        """
        if row < self.first:
            return row
        return None if row < self.first + self.count else row - self.count

    @property
    def start(self) -> int:
        """The first row that is touched."""
        return self.first


@dataclass(frozen=True, slots=True)
class MoveRows:
    """Move a block of rows so that it stands before another row; `before` counts as the rows are now."""

    sheet: str
    first: int
    count: int
    before: int

    def mapped(self, row: int) -> int | None:
        """Return the number that a row has afterwards.

        >>> [MoveRows("T", 2, 1, 5).mapped(n) for n in (1, 2, 3, 4, 5)]
        [1, 4, 2, 3, 5]
        >>> [MoveRows("T", 4, 2, 2).mapped(n) for n in (1, 2, 3, 4, 5, 6)]
        [1, 4, 5, 2, 3, 6]
        """
        last = self.first + self.count
        if self.first <= row < last:
            up = self.before <= self.first
            return row + ((self.before if up else self.before - self.count) - self.first if self.moves else 0)
        if self.before <= row < self.first:
            return row + self.count
        return row - self.count if last <= row < self.before else row

    @property
    def moves(self) -> bool:
        """True when any row changes its place."""
        return not self.first <= self.before <= self.first + self.count

    @property
    def start(self) -> int:
        """The first row that is touched."""
        return min(self.first, self.before)


@dataclass(frozen=True, slots=True)
class AddSheet:
    """Add a sheet, with the looks of a new workbook's; which of its rows is the header is found as in reading.

    It stands before the sheet `before`; empty: at the end.
    """

    sheet: str
    rows: Sequence[Sequence[str]]
    before: str = ""


@dataclass(frozen=True, slots=True)
class RenameSheet:
    """Give a sheet another name; the spreadsheet program's own formulas, names and charts follow."""

    sheet: str
    name: str


@dataclass(frozen=True, slots=True)
class MoveSheet:
    """Let a sheet stand before another one; empty: at the end."""

    sheet: str
    before: str = ""


@dataclass(frozen=True, slots=True)
class DeleteSheet:
    """Delete a sheet with everything in it; what refers to it is `#REF!` then, as a spreadsheet program writes it."""

    sheet: str


@dataclass(frozen=True, slots=True)
class BringSheet:
    """Bring a deleted sheet back as it was, byte for byte; `kept` is what its deletion gave (`Edited.kept`)."""

    sheet: str
    kept: str


RowEdit = InsertRows | DeleteRows | MoveRows
SheetEdit = AddSheet | RenameSheet | MoveSheet | DeleteSheet | BringSheet
Edit = SetCell | SetComments | SetLook | RowEdit | SheetEdit


_NUMBER = re.compile(r"-?(?:0|[1-9]\d{0,14})(?:\.\d{1,15})?")
_IMPOSSIBLE = re.compile("[\ud800-\udfff\ufffe\uffff]")
_ESCAPED = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f]|_(?=x[0-9A-Fa-f]{4}_)")


def parse_typed(text: str) -> Value:
    """Return what a spreadsheet program would make of a typed text, where there is no doubt; else the text.

    A number is one when it reads the same afterwards: leading and trailing zeros, long numbers, dates and whatever
    begins with `=` stay texts. So do `true` and `false` in small letters.

    >>> [parse_typed(text) for text in ("20", "-0.5", "007", "1.50", "TRUE", "=A1", "")]
    [20.0, -0.5, '007', '1.50', True, '=A1', None]
    """
    if text in ("TRUE", "FALSE"):
        return text == "TRUE"
    if _NUMBER.fullmatch(text) and shown(float(text)) == text:
        return float(text)
    return text or None


def shown(value: Value) -> str:
    """A value as the reader gives it back.

    >>> shown(20.0), shown(True), shown(None)
    ('20', 'TRUE', '')
    """
    if value is None:
        return ""
    if isinstance(value, bool):
        return "TRUE" if value else "FALSE"
    return value if isinstance(value, str) else number_text(float(value))


def content(value: Value) -> tuple[str | None, str, str]:
    """The cell's type attribute, the element inside it (none: an empty name), and the text.

    A text stays in the cell itself (`inlineStr`), so that the part with the shared texts need not change. It can never
    become a formula, whatever it begins with.
    """
    if value is None or value == "":
        return None, "", ""
    if isinstance(value, bool):
        return "b", "v", f"{value:d}"
    if isinstance(value, (int, float)):
        return None, "v", number_text(float(value))
    return "inlineStr", "is", _ESCAPED.sub(lambda m: f"_x{ord(m[0]):04X}_", value)
