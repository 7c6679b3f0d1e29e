"""Undo and redo: one's own edits, refused where someone has changed the same since."""

from __future__ import annotations

from dataclasses import dataclass

from rrp_sheets.documents.grid import Grid
from rrp_sheets.documents.row_changes import CellText
from rrp_sheets.workbook.edits import AddSheet, BringSheet

MOST = 500  # steps back per person


@dataclass(frozen=True, slots=True)
class Cells:
    """Texts were changed: put those of `back` in again, if `now` still stands there."""

    sheet: str
    back: tuple[CellText, ...]


@dataclass(frozen=True, slots=True)
class RemoveRows:
    """Rows were inserted: delete them again; `texts` are those that they had then, None where that does not matter."""

    sheet: str
    rows: tuple[str, ...]
    texts: tuple[dict[int, str], ...] | None = None


@dataclass(frozen=True, slots=True)
class RestoreRows:
    """Rows were deleted: insert them again, with their ids and texts, before a row (None: at the end)."""

    sheet: str
    rows: tuple[tuple[str, dict[int, str]], ...]
    before: str | None


@dataclass(frozen=True, slots=True)
class Moved:
    """Rows were moved: move them back before a row (None: to the end)."""

    sheet: str
    rows: tuple[str, ...]
    before: str | None


@dataclass(frozen=True, slots=True)
class Batch:
    """Several steps, one after the other, that are one for people; `sheet` is that of the first."""

    sheet: str
    steps: tuple[Cells | RemoveRows | RestoreRows | Moved, ...]


@dataclass(frozen=True, slots=True)
class SheetIn:
    """A sheet is missing: add it, or bring it back as it was.

    Attributes:
        cells: what changes with it, by sheet (the Protocol's Run), where it still stands there as it did.
        grid: of the sheet that comes back, whose rows keep their ids.
    """

    sheet: str
    edit: AddSheet | BringSheet
    cells: tuple[tuple[str, CellText], ...] = ()
    grid: Grid | None = None


@dataclass(frozen=True, slots=True)
class SheetOut:
    """A sheet is there: delete it; with `texts` only if nothing else stands in it by now."""

    sheet: str
    texts: tuple[tuple[tuple[int, str], ...], ...] | None = None


@dataclass(frozen=True, slots=True)
class SheetNamed:
    """A sheet has this name: give it another one.

    Attributes:
        cells: how the cells that name it were spelt, by sheet, where they still say what they do.
    """

    sheet: str
    name: str
    cells: tuple[tuple[str, CellText], ...] = ()


@dataclass(frozen=True, slots=True)
class SheetPlaced:
    """A sheet stands somewhere: let it stand before another one (empty: at the end)."""

    sheet: str
    before: str


SheetStep = SheetIn | SheetOut | SheetNamed | SheetPlaced
Step = Cells | RemoveRows | RestoreRows | Moved | Batch | SheetStep


class Steps:
    """Steps of each person that can be undone, and those that were undone and can be made again."""

    def __init__(self) -> None:
        self._back: dict[str, list[Step]] = {}
        self._again: dict[str, list[Step]] = {}

    def did(self, author: str, step: Step) -> None:
        """Note a new step; what was undone before it cannot be made again."""
        self._push(self._back, author, step)
        self._again.pop(author, None)

    def undone(self, author: str, step: Step) -> None:
        """Note an undo: `step` would make the change again."""
        self._push(self._again, author, step)

    def redone(self, author: str, step: Step) -> None:
        """Note a redo: `step` would undo it again."""
        self._push(self._back, author, step)

    def last(self, author: str, *, again: bool) -> Step | None:
        """Remove and return the newest step to undo or redo; None when there is none."""
        pile = (self._again if again else self._back).get(author)
        return pile.pop() if pile else None

    @staticmethod
    def _push(piles: dict[str, list[Step]], author: str, step: Step) -> None:
        pile = piles.setdefault(author, [])
        pile.append(step)
        del pile[:-MOST]
