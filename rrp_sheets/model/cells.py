"""Cells and where they are."""

from __future__ import annotations

from dataclasses import dataclass, field


def column_letters(column: int) -> str:
    """The letters of a column, counted from 1.

    >>> column_letters(1), column_letters(28)
    ('A', 'AB')
    """
    letters = ""
    while column:
        column, rest = divmod(column - 1, 26)
        letters = chr(65 + rest) + letters
    return letters


@dataclass(frozen=True, slots=True, order=True)
class Address:
    """A cell's place: sheet name, row and column counted from 1.

    >>> str(Address("Tracking", 7, 3))
    'Tracking!C7'
    """

    sheet: str
    row: int = 0
    column: int = 0

    @property
    def cell(self) -> str:
        """`C7`; empty for a whole sheet."""
        return f"{column_letters(self.column)}{self.row}" if self.row else ""

    def __str__(self) -> str:
        return f"{self.sheet}!{self.cell}" if self.row else self.sheet


@dataclass(frozen=True, slots=True)
class Cell:
    """A cell's cleaned text (what the program works with), its place, and what the user typed."""

    text: str
    address: Address
    original: str = field(default="")

    def __bool__(self) -> bool:
        return bool(self.text)

    def __str__(self) -> str:
        return self.text
