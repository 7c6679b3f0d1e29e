"""One cause, one finding: which findings only follow from another one, and are not told beside it."""

from __future__ import annotations

import re
from collections.abc import Collection
from typing import TYPE_CHECKING

from rrp_sheets.diagnostics.catalogue import Severity
from rrp_sheets.model.cells import Address
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
_MISSED_BEHAVIOUR = ("PROT004", "DEV010")
_UNNAMED = {"DEV005": _UNDECLARED, "FORM016": _UNKNOWN_HELPER, "FORM024": ("FORM007", "FORM017")}
"""A row of Devices or Helpers, or a column of a table, without a name: whoever wants it misses it."""
_SCENE_ROW = ("SCENE001", "SCENE002", "SCENE003", "SCENE004", "SCENE007", "SCENE008")
_OF_SCENE_ROWS = ("SCENE005", "SCENE009", "SCENE010")
"""What has come, and what has gone, is not known as long as rows of the scene are wrong."""
_WRONG_ROWS = ("CONN", "GRAPH", "FORM", "DEV", "SHEET", "PROT")
_AS_WRONG = ("CONN010", "DEV007", "GRAPH011", "GRAPH014", "FORM012")  # warnings, but what is meant is another row
_OF_WRONG_ROWS = ("TEST002", "TEST011", "SCENE006", "SCENE007", "DEV009", "LINT")
"""As long as rows are wrong, streams that tests name may be missing, and how rows act together is not known."""
_OF_AS_WRONG = ("TEST011", "SCENE006", "DEV009", "LINT")
"""No error is among these: a warning must not let a workbook with an error pass for one without."""


def without_followers(found: Collection[Diagnostic]) -> list[Diagnostic]:
    """The findings without those that follow from another: a date in a period cell, say, is no wrong period besides."""
    causes = _Causes(found)
    return [d for d in found if not causes.explain(d)]


class _Causes:
    """Where findings have followers: looked up by cell, row and sheet, as there may be thousands of findings."""

    def __init__(self, found: Collection[Diagnostic]) -> None:
        self.cells: set[Address] = set()
        self.rows: set[tuple[str, int]] = set()
        self.input_rows: set[tuple[str, int]] = set()
        self.sheets: set[str] = set()
        self.names: set[tuple[str, str]] = set()  # keys of streams that are missing in a sheet
        self.formulas: set[str] = set()  # sheets with formulas that lack a name
        self.anywhere: set[str] = set()
        for d in found:
            if d.severity is Severity.ERROR and d.code.startswith(_WRONG_ROWS):
                self.anywhere.update(_OF_WRONG_ROWS)
            elif d.code in _AS_WRONG:
                self.anywhere.update(_OF_AS_WRONG)
            if d.address is not None:
                self._add(d.code, d.address)
                if d.code == "GRAPH001":
                    self.names.add((d.address.sheet, _named(d)))

    def _add(self, code: str, at: Address) -> None:
        if code in OF_CELLS:
            self.cells.add(at)
        if code in OF_ROWS:
            self.rows.add((at.sheet, at.row))
        if code in _OF_INPUTS:
            self.input_rows.add((at.sheet, at.row))
        if code in _LOST_OUTPUT or code in OF_CELLS:
            self.sheets.add(at.sheet)
        if code == "SHEET004" or code in OF_CELLS:
            self.anywhere.update(_UNREAD_SHEETS.get(key(at.sheet), ()))
        if code == "SHEET004":
            self.anywhere.update(_MISSED_BEHAVIOUR)
        self.anywhere.update(_UNNAMED.get(code, ()))
        if code == "FORM004":
            self.formulas.add(at.sheet)
        if code in _SCENE_ROW:
            self.anywhere.update(_OF_SCENE_ROWS)

    def explain(self, d: Diagnostic) -> bool:
        """Whether a finding only follows from another one."""
        if d.code in self.anywhere or (d.code.startswith("LINT") and "LINT" in self.anywhere):
            return True
        if d.address is None or d.code in OF_CELLS or d.code in OF_ROWS:
            return False
        row = (d.address.sheet, d.address.row)
        return (
            d.address in self.cells
            or row in self.rows
            or (row in self.input_rows and d.code.startswith("FORM"))
            or (d.address.sheet in self.sheets and d.code in _MISSING)
            or (d.code == "FORM004" and (d.address.sheet, _named(d)) in self.names)
            or (d.code == "GRAPH011" and d.address.sheet in self.formulas)
        )


def _named(d: Diagnostic) -> str:
    """The key of the name that a finding is about."""
    quoted = re.search("“(.+?)”", d.message)
    return key(quoted[1]) if quoted else ""
