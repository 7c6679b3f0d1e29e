"""Sheets as the formats give them, before anything is understood; what a format is."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING, Protocol

from rrp_sheets.diagnostics import Diagnostic, Report
from rrp_sheets.diagnostics.report import UnreadableWorkbook
from rrp_sheets.texts import N_
from rrp_sheets.workbook import limits

if TYPE_CHECKING:
    from rrp_sheets.workbook.edits import Edit

Rows = Sequence[Sequence[str]]


class Kind(Enum):
    """Type of a cell's content, as a spreadsheet program sees it."""

    TEXT = "text"
    NUMBER = "number"
    TRUTH = "truth"
    DATE = "date"
    TIME = "time"
    ERROR = "error"


@dataclass(frozen=True, slots=True)
class RawCell:
    """A filled cell.

    Attributes:
        text: the content as text; of an evaluated formula the value that the user sees.
        kind: what it was in the file; CSV and Markdown know only text.
        formula: what the spreadsheet program evaluates here, without the leading `=`; empty for plain contents.
    """

    text: str
    kind: Kind = Kind.TEXT
    formula: str = ""

    @property
    def typed(self) -> str:
        """Text that the user typed, as far as the file tells."""
        return f"={self.formula}" if self.formula else self.text


@dataclass(frozen=True, slots=True)
class Range:
    """A block of cells, both corners included."""

    top: int
    left: int
    bottom: int
    right: int

    @property
    def area(self) -> int:
        """Number of cells in the block."""
        return (self.bottom - self.top + 1) * (self.right - self.left + 1)


@dataclass(frozen=True, slots=True)
class RawSheet:
    """One sheet: its filled cells by row and column (counted from 1), and what hides or joins them."""

    name: str
    cells: Mapping[tuple[int, int], RawCell]
    merged: tuple[Range, ...] = ()
    hidden_rows: frozenset[int] = frozenset()
    hidden: bool = False

    def rows(self) -> dict[int, dict[int, RawCell]]:
        """The filled rows in order, each with its filled cells by column."""
        rows: dict[int, dict[int, RawCell]] = {}
        for row, column in sorted(self.cells):
            rows.setdefault(row, {})[column] = self.cells[row, column]
        return rows


def text_sheet(name: str, rows: Iterable[Sequence[str]]) -> RawSheet:
    """Return a sheet of plain texts; blank ones are no cells."""
    cells = {(r, c): RawCell(t) for r, row in enumerate(rows, 1) for c, t in enumerate(row, 1) if t.strip()}
    return RawSheet(name, cells)


class Extent(Enum):
    """Part of a sheet to read: enough to recognise it, the most that a table may have, or all of it."""

    HEAD = "head"
    TABLE = "table"
    WHOLE = "whole"


class Book(Protocol):
    """An opened workbook: the sheets' names in order, and each sheet as far as it is wanted.

    `format` is the name of its format; the findings were noticed while taking the file apart.
    """

    format: str
    names: list[str]
    findings: list[Diagnostic]

    def sheet(self, index: int, extent: Extent) -> RawSheet:
        """Read a sheet; raises UnreadableFile where it is broken or beyond the limits."""
        ...


@dataclass(frozen=True, slots=True)
class Format:
    """A format in which one file is a workbook; `FORMATS` of `files.py` has them all.

    Attributes:
        suffixes: of its files, in small letters, the usual one first.
        read: gives the sheets in a file's bytes; the name is for messages. Raises UnreadableFile, whatever they are.
        edit: gives the bytes with the edits made, and of each deleted sheet what brings it back (`BringSheet`).
        write: gives the bytes of a new file with these rows by sheet, in which cells are as one types them.
        digest: tells contents apart.
    """

    name: str
    suffixes: tuple[str, ...]
    read: Callable[[bytes, str], Book]
    edit: Callable[[bytes, str, Sequence[Edit]], tuple[bytes, tuple[str, ...]]]
    write: Callable[[Mapping[str, Rows]], bytes]
    digest: Callable[[bytes, str], str]


def number_text(value: float) -> str:
    """A number as its text; whole ones without a fraction.

    >>> number_text(1000.0), number_text(0.1), number_text(-0.0)
    ('1000', '0.1', '0')
    """
    return str(int(value)) if value.is_integer() and abs(value) < 1e15 else repr(value)


def unreadable(code: str, **details: object) -> UnreadableWorkbook:
    """The exception for a code of the catalogue; `details` fill its texts."""
    return UnreadableWorkbook(Report().add(code, None, span=None, fixes=(), **details))


def check_size(sheet: RawSheet) -> None:
    """Raise UnreadableFile when a sheet of ours is beyond the limits. Counts what is filled, not where it stands."""
    rows, columns = len({row for row, _ in sheet.cells}), len({column for _, column in sheet.cells})
    for count, limit, what in (
        (rows, limits.ROWS, N_("{n} rows")),
        (columns, limits.COLUMNS, N_("{n} columns")),
        (len(sheet.cells), limits.CELLS, N_("{n} filled cells")),
        (sum(r.area for r in sheet.merged), limits.MERGED_CELLS, N_("{n} merged cells")),
    ):
        if count > limit:
            raise unreadable("FILE013", sheet=sheet.name, what=N_(what, n=f"{count:,}"), limit=f"{limit:,}")
