"""One cause, one finding: which findings only follow from another one, and are not told beside it."""

from __future__ import annotations

from collections.abc import Callable, Collection
from typing import TYPE_CHECKING

from rrp_sheets.model.names import key

if TYPE_CHECKING:
    from rrp_sheets.diagnostics.report import Diagnostic

OF_CELLS = ("SHEET006", "SHEET007", "SHEET016")
"""What stands in the cell is not what was meant, so nothing else is said about that cell."""
OF_ROWS = ("SHEET017",)
"""The row's cells stand in wrong columns, so nothing else is said about that row."""
_MISSED_NAMES = {"SHEET017": ("GRAPH001", "GRAPH006", "GRAPH011"), "SHEET021": ("GRAPH011",)}
"""Names that a row could not give or take are missed, or seem to be without use, elsewhere in its sheet."""
_UNREAD_SHEETS = {
    "devices": ("GRAPH001", "GRAPH006", "DEV008", "GRAPH007"),
    "helpers": ("FORM004", "FORM005", "FORM014"),
}
"""A sheet that is not read because a column is missing: what it declares is missed everywhere."""


def without_followers(found: Collection[Diagnostic]) -> list[Diagnostic]:
    """The findings without those that follow from another: a date in a period cell, say, is no wrong period besides."""
    rules = [rule for d in found for rule in _rules(d)]
    return [d for d in found if not any(follows(d) for follows in rules)]


def _rules(cause: Diagnostic) -> list[Callable[[Diagnostic], bool]]:
    """What follows from a finding, as tests of other findings."""
    at, code = cause.address, cause.code
    if at is None:
        return []
    rules: list[Callable[[Diagnostic], bool]] = []
    if code in OF_CELLS:
        rules.append(lambda d: d.address == at and d.code not in OF_CELLS)
    if code in OF_ROWS:
        rules.append(lambda d: _row(d) == (at.sheet, at.row) and d.code not in OF_ROWS)
    if code in _MISSED_NAMES:
        missed = _MISSED_NAMES[code]
        rules.append(lambda d: d.code in missed and d.address is not None and d.address.sheet == at.sheet)
    if code == "SHEET004" and key(at.sheet) in _UNREAD_SHEETS:
        declared = _UNREAD_SHEETS[key(at.sheet)]
        rules.append(lambda d: d.code in declared)
    return rules


def _row(d: Diagnostic) -> tuple[str, int] | None:
    return (d.address.sheet, d.address.row) if d.address else None
