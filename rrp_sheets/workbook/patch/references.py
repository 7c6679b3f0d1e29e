"""References to rows inside formulas: found, rewritten or refused when rows move, and grown with a sheet's table."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

from rrp_sheets.workbook.edits import InsertRows, MoveRows, RowEdit
from rrp_sheets.workbook.patch.package_edit import PackageEdit
from rrp_sheets.workbook.patch.sheet_xml import block_of, block_text
from rrp_sheets.workbook.patch.xml_part import set_text, text_of

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
        """Return whether it refers to a sheet, from a formula in the sheet `own` (empty: from outside of sheets)."""
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
    """Raise ReferenceConflict when rows `top` to `bottom` would not hold the same contents afterwards.

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
        ReferenceConflict: when they cannot.

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


SPARE = 50
"""Blank rows below the last filled one that are covered too when something grows."""
LISTS = "List_"
"""Prefix of the names of generated lists; the user's own names stay as they are."""
_FORMULAS = ("formula", "formula1", "formula2", "f")


def note(package: PackageEdit, index: int) -> None:
    """Remember how far a sheet's table reaches, before it is changed."""
    if index not in package.reached:
        package.reached[index] = package.sheet(index).last_filled


def grow(package: PackageEdit, index: int) -> None:
    """Let everything that covered a sheet's table before cover it again, where it has become longer since `note`."""
    before, now = package.reached[index], package.sheet(index).last_filled
    package.reached[index] = now
    if now <= before or not package.recognised(index).kind:
        return
    top = package.recognised(index).row + 1
    last = now + SPARE

    def longer(first: int, bottom: int) -> int:
        return last if first == top and first < bottom and before <= bottom < now else bottom

    _grow_rules(package, index, longer)
    _grow_names(package, index, longer)


def follows(package: PackageEdit, index: int, ref: Reference, edit: RowEdit) -> bool:
    """Return whether a reference covers the whole table of a sheet, so that it grows when rows are inserted."""
    known = package.recognised(index)
    whole = known.kind and ref.top == known.row + 1 and ref.top < ref.bottom
    return isinstance(edit, InsertRows) and bool(whole) and ref.bottom >= package.sheet(index).last_filled


def _grow_rules(package: PackageEdit, index: int, longer: Callable[[int, int], int]) -> None:
    """Extend the ranges where the sheet's rules hold, and those that the rules of all sheets refer to."""
    name = package.book.names[index]
    sheet = package.sheet(index)
    for e in sheet.elements("conditionalFormatting", "dataValidation"):
        old = e.get("sqref", "")
        if old and (new := _grown(old, longer)) != old:
            e.set("sqref", new)
            sheet.touch()
    for e in sheet.elements("sqref"):  # of the rules that newer programs keep elsewhere
        if (new := _grown(text_of(e), longer)) != text_of(e):
            set_text(e, new)
            sheet.touch()
    for i, own in enumerate(package.book.names):
        if i != index and not package.mentions(i, name):
            continue
        other = package.sheet(i)
        for e in other.elements(*_FORMULAS):
            inside = next(e.iterancestors("{*}sparkline"), None) is not None
            if not inside and (new := _referring(text_of(e), name, own, longer)) != text_of(e):
                set_text(e, new)
                other.touch()


def _grow_names(package: PackageEdit, index: int, longer: Callable[[int, int], int]) -> None:
    """Extend the lists behind the drop-downs."""
    for book, e in package.part(package.book.part).find("definedName"):
        if e.get("name", "").startswith(LISTS):
            new = _referring(text_of(e), package.book.names[index], "", longer)
            if new != text_of(e):
                set_text(e, new)
                book.touch()


def _grown(blocks: str, longer: Callable[[int, int], int]) -> str:
    """Return the blocks of cells where a rule holds, made longer."""
    found = []
    for text in blocks.split():
        block = block_of(text)
        bottom = longer(block.top, block.bottom) if block else 0
        found.append(block_text(replace(block, bottom=bottom)) if block and bottom != block.bottom else text)
    return " ".join(found)


def _referring(formula: str, sheet: str, own: str, longer: Callable[[int, int], int]) -> str:
    """A formula whose references to a whole table of the sheet reach its new end."""
    out, at = [], 0
    for ref in references(formula):
        if ref.absolute and ref.on(sheet, own) and (bottom := longer(ref.top, ref.bottom)) != ref.bottom:
            start, end = ref.spans[1]
            out += [formula[at:start], str(bottom)]
            at = end
    return "".join([*out, formula[at:]])
