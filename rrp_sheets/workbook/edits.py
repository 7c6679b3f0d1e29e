"""Edits of a workbook: the same few for every format."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from rrp_sheets.model.workbook import column_letters

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
    """Add a sheet, with the looks of a new workbook's.

    Attributes:
        rows: its texts; which of them is the header is found as in reading.
        before: the sheet that it stands before; empty: at the end.
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
Edit = SetCell | RowEdit | SheetEdit
