"""References to rows inside formulas: found, and rewritten or refused when their rows go elsewhere."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from rrp_sheets.workbook.edits import MoveRows, RowEdit

_CELL = r"(?<![\w.$])\$?[A-Z]{1,3}(?P<a>\$?)(?P<top>[1-9]\d{0,6})(?::\$?[A-Z]{1,3}(?P<b>\$?)(?P<bottom>[1-9]\d{0,6}))?"
_ROWS = r"(?<![\w.$:])(?P<c>\$?)(?P<from>[1-9]\d{0,6}):\$?(?P<to>[1-9]\d{0,6})"
_SHEET = r"(?:(?P<sheet>'(?:[^']|'')+'|[^\W\d][\w.]*(?::[^\W\d][\w.]*)?)!)?"
_TOKEN = re.compile(
    rf'"(?:[^"]|"")*"|\[[^\[\]]*\]|{_SHEET}(?:{_CELL}|{_ROWS})(?![\w.(!\[])',
    re.IGNORECASE,
)


@dataclass(frozen=True, slots=True)
class Reference:
    """A reference inside a formula.

    Attributes:
        sheet: the sheet's name as written; empty for the formula's own sheet.
        absolute: whether its rows are fixed with `$`.
        spans: where the numbers of its first and its last row stand in the formula.
    """

    sheet: str
    top: int
    bottom: int
    absolute: bool
    spans: tuple[tuple[int, int], tuple[int, int]]

    def on(self, sheet: str, own: str) -> bool:
        """Whether it refers to a sheet, from a formula in the sheet `own` (empty: from outside of sheets)."""
        if not self.sheet:
            return own.casefold() == sheet.casefold()
        return sheet.casefold() in self.sheet.casefold().split(":")


def references(formula: str) -> Iterator[Reference]:
    r"""The references of a formula; whole columns refer to no row.

    >>> [(r.sheet, r.top, r.bottom) for r in references('SUM(A2:$B$9, \'My data\'!C5) & "A1" + LOG10(2) + T[A1]')]
    [('', 2, 9), ('My data', 5, 5)]
    """
    for match in _TOKEN.finditer(formula):
        top, bottom, absolute = "top", "bottom", match["a"] == "$"
        if match["from"]:
            top, bottom, absolute = "from", "to", match["c"] == "$"
        elif not match["top"]:
            continue
        last = bottom if match[bottom] else top
        sheet = (match["sheet"] or "").strip("'").replace("''", "'")
        yield Reference(sheet, int(match[top]), int(match[last]), absolute, (match.span(top), match.span(last)))


class ReferenceConflict(Exception):
    """A reference would mean something else afterwards; `top` and `bottom` are its rows."""

    def __init__(self, top: int, bottom: int) -> None:
        super().__init__(f"{top}:{bottom}")
        self.top, self.bottom = top, bottom


Moves = Sequence[tuple[int, int | None]]
"""Filled rows that go elsewhere: from where, to where (None: away)."""


def check(top: int, bottom: int, moves: Moves) -> None:
    """Raise Harm when rows `top` to `bottom` would not hold the same contents afterwards.

    A range may lose deleted rows, and rows may change places within it; a single row must stay as it is.
    """
    for old, new in moves:
        if top == bottom:
            if top in (old, new):
                raise ReferenceConflict(top, bottom)
        elif new is not None and (top <= old <= bottom) != (top <= new <= bottom):
            raise ReferenceConflict(top, bottom)


def adapted(formula: str, sheet: str, edit: RowEdit, moves: Moves) -> str:
    """A formula of the edited sheet itself, with its references following their rows as in a spreadsheet program.

    Raises:
        Harm: when they cannot.

    >>> from rrp_sheets.workbook.edits import InsertRows
    >>> adapted("A4+SUM(B2:B9)+Other!C4", "T", InsertRows("T", 3), [(4, 5)])
    'A5+SUM(B2:B10)+Other!C4'
    """
    out: list[str] = []
    at = 0
    for ref in references(formula):
        if not ref.on(sheet, sheet):
            continue
        top, bottom = edit.mapped(ref.top), edit.mapped(ref.bottom)
        if top is None or bottom is None or (isinstance(edit, MoveRows) and ref.top != ref.bottom):
            check(ref.top, ref.bottom, moves)
            continue
        for (start, end), new in dict(zip(ref.spans, (top, bottom), strict=True)).items():
            out += (formula[at:start], str(new))
            at = end
    return "".join([*out, formula[at:]])
