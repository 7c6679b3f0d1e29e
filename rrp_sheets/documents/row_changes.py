"""Changes that pass between a document and those who edit it, and refusals of edits."""

from __future__ import annotations

from dataclasses import dataclass

from rrp_sheets.errors import SheetsError


@dataclass(frozen=True, slots=True)
class CellText:
    """A cell's new text.

    Attributes:
        row: the row's id.
        column: the sheet's own column number.
        was: what stood there when its author began to type; None to overwrite whatever stands there.
    """

    row: str
    column: int
    text: str
    was: str | None = None


@dataclass(frozen=True, slots=True)
class SheetChange:
    """Change of a sheet as a whole.

    Attributes:
        what: `added`, `deleted`, `renamed`, `moved`; `reshaped` when another program has changed its columns.
        name: its name now.
        kind: of a sheet that was added: `behaviour`, `devices`, …; empty for one of the user's own.
        was: the name of a renamed one until now.
    """

    what: str
    name: str
    kind: str = ""
    was: str = ""


@dataclass(frozen=True, slots=True)
class Changed:
    """Changes that an edit made in a sheet: ids of rows, in the order of the sheet.

    Attributes:
        inserted: each new row with the row it stands before (None: at the end), in the order to insert them.
        moved: each moved row with the row it now stands before.
        grown: blank rows at the end, so that there is always room below the last filled row.
        cells: the cells that have other texts now, as row and column; empty where whole rows came or went.
        then: what was changed after that, when one edit does several things.
        change: what became of the sheet itself.
    """

    sheet: str
    touched: tuple[str, ...] = ()
    inserted: tuple[tuple[str, str | None], ...] = ()
    removed: tuple[str, ...] = ()
    moved: tuple[tuple[str, str | None], ...] = ()
    grown: tuple[str, ...] = ()
    cells: tuple[tuple[str, int], ...] = ()
    then: tuple[Changed, ...] = ()
    change: SheetChange | None = None


@dataclass(frozen=True, slots=True)
class Clash:
    """A cell that someone else has changed meanwhile: what is wanted, what stands there, and whose that is."""

    row: str
    column: int
    mine: str
    theirs: str
    by: str = ""


class Refused(SheetsError):
    """An edit that was not made, and why; `clashes` are the cells that someone else has changed meanwhile."""

    def __init__(self, message: str, remedy: str = "", clashes: tuple[Clash, ...] = ()) -> None:
        super().__init__(message, remedy)
        self.clashes = clashes
