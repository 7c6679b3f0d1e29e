"""Conversion of the problems of a formula into findings at its cell."""

from __future__ import annotations

from rrp_sheets.diagnostics import Report
from rrp_sheets.formulas import FormulaProblem
from rrp_sheets.model.cells import Cell


def tell(report: Report, cell: Cell, problem: FormulaProblem) -> None:
    """Report a formula's problem, and the others of the same formula, at its cell."""
    for one in problem.every:
        span = (one.column, one.column + one.length) if one.column >= 0 else None
        report.add(one.code, cell.address, span=span, fixes=(), **one.details)
