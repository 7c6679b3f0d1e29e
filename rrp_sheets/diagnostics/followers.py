"""One cause, one finding: which findings only follow from another one, and are not told beside it."""

from __future__ import annotations

from collections.abc import Callable, Collection
from typing import TYPE_CHECKING

from rrp_sheets.diagnostics.catalogue import Severity
from rrp_sheets.model.names import key

if TYPE_CHECKING:
    from rrp_sheets.diagnostics.report import Diagnostic

OF_CELLS = ("SHEET006", "SHEET007", "SHEET016")
"""What stands in the cell is not what was meant, so nothing else is said about that cell."""
OF_ROWS = ("SHEET017",)
"""The row's cells stand in wrong columns, so nothing else is said about that row."""
_OF_INPUTS = ("CONN003", "CONN004", "CONN009")
"""The row's inputs are not the ones that were meant, so nothing is said about its formula."""
_LOST_OUTPUT = ("GRAPH002", "GRAPH004", "GRAPH007", "GRAPH008", "GRAPH013", "GRAPH016", "SHEET017", "SHEET021")
"""The row gives nothing under a name of its own: whoever wants that name misses it."""
_MISSING = ("GRAPH001", "GRAPH006", "GRAPH011")
_UNDECLARED = ("GRAPH001", "GRAPH006", "GRAPH007", "GRAPH009", "DEV008")
_UNKNOWN_HELPER = ("FORM001", "FORM004", "FORM005", "FORM014")
_UNREAD_SHEETS = {"devices": _UNDECLARED, "helpers": _UNKNOWN_HELPER}
"""What is missed everywhere when such a sheet, or a cell of it, cannot be read."""
_UNNAMED = {"DEV005": _UNDECLARED, "FORM016": _UNKNOWN_HELPER}
"""A row of Devices or Helpers without a name: whoever wants it misses it."""
_SCENE_ROW = ("SCENE001", "SCENE002", "SCENE003", "SCENE004")
_WRONG_ROWS = ("CONN", "GRAPH", "FORM", "DEV", "SHEET", "PROT")
_AS_WRONG = ("CONN010", "DEV007", "GRAPH011", "GRAPH014", "FORM012")  # warnings, but what is meant is another row
_OF_WRONG_ROWS = ("TEST002", "TEST011", "SCENE006", "LINT")
"""As long as rows are wrong, streams that tests name may be missing, and how rows act together is not known."""


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
        missing = _UNREAD_SHEETS.get(key(at.sheet), ())
        rules.append(lambda d: d.code in missing or (d.code in _MISSING and _sheet(d) == at.sheet))
    if code in OF_ROWS:
        rules.append(lambda d: _row(d) == (at.sheet, at.row) and d.code not in OF_ROWS)
    if code in _OF_INPUTS:
        rules.append(lambda d: _row(d) == (at.sheet, at.row) and d.code.startswith("FORM"))
    if code in _LOST_OUTPUT:
        rules.append(lambda d: d.code in _MISSING and _sheet(d) == at.sheet)
    missed = _UNNAMED.get(code) or (_UNREAD_SHEETS.get(key(at.sheet)) if code == "SHEET004" else None)
    if missed:
        rules.append(lambda d: d.code in missed)
    if code in _SCENE_ROW:
        rules.append(lambda d: d.code == "SCENE005")
    if (cause.severity is Severity.ERROR and code.startswith(_WRONG_ROWS)) or code in _AS_WRONG:
        rules.append(lambda d: d.code.startswith(_OF_WRONG_ROWS))
    return rules


def _sheet(d: Diagnostic) -> str | None:
    return d.address.sheet if d.address else None


def _row(d: Diagnostic) -> tuple[str, int] | None:
    return (d.address.sheet, d.address.row) if d.address else None
