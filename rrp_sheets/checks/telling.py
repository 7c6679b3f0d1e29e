"""How a formula's problem becomes a finding at its cell."""

from __future__ import annotations

from rrp_sheets.diagnostics import Report
from rrp_sheets.formulas import FormulaProblem
from rrp_sheets.model.cells import Cell


def tell(report: Report, cell: Cell, problem: FormulaProblem) -> None:
    """Report a formula's problem at its cell."""
    span = (problem.column, problem.column + problem.length) if problem.column >= 0 else None
    report.add(problem.code, cell.address, span=span, fixes=(), **problem.details)
