"""Blocks of cells as a workbook's parts write them."""

from __future__ import annotations

from rrp_sheets.model.cells import column_letters
from rrp_sheets.workbook.raw import Range
from rrp_sheets.workbook.xlsx_sheet import place


def block_of(reference: str) -> Range | None:
    """The block that a reference such as `B2:C9` names.

    >>> block_of("C9:B2")
    Range(top=2, left=2, bottom=9, right=3)
    """
    first, _, last = reference.partition(":")
    a, b = place(first), place(last or first)
    if a is None or b is None:
        return None
    return Range(min(a[0], b[0]), min(a[1], b[1]), max(a[0], b[0]), max(a[1], b[1]))


def block_text(block: Range) -> str:
    """A block as a reference.

    >>> block_text(Range(2, 2, 9, 3)), block_text(Range(2, 2, 2, 2))
    ('B2:C9', 'B2')
    """
    first = f"{column_letters(block.left)}{block.top}"
    last = f"{column_letters(block.right)}{block.bottom}"
    return first if first == last else f"{first}:{last}"
