"""Lints: warnings about rows that work, but probably not as they are meant.

A lint must report nothing on workbooks that are in order, so it reports only what is certain.
"""

from __future__ import annotations

from rrp_sheets.checks.dataflow import Paths
from rrp_sheets.checks.formulas import Compiled
from rrp_sheets.checks.lints.conflicts import lint_conflicts
from rrp_sheets.checks.lints.context import LintContext
from rrp_sheets.checks.lints.deadlock import lint_deadlock
from rrp_sheets.checks.lints.failing_formulas import lint_failing_formulas
from rrp_sheets.checks.lints.flooded import lint_flooded
from rrp_sheets.checks.lints.input_specs import lint_input_specs
from rrp_sheets.checks.lints.stale import lint_stale
from rrp_sheets.checks.lints.unmatched import lint_unmatched
from rrp_sheets.checks.lints.unreachable import lint_unreachable
from rrp_sheets.checks.lints.unused_helpers import lint_unused_helpers
from rrp_sheets.diagnostics import Report
from rrp_sheets.graph import Graph
from rrp_sheets.model.workbook import Workbook
from rrp_sheets.robots import Robot

__all__ = ["lint"]


def lint(
    workbook: Workbook, robot: Robot, graph: Graph, compiled: Compiled, running: frozenset[str], report: Report
) -> None:
    """Report everything that the lints find; `running`: keys of the behaviours that run, or can be switched on."""
    routes = Paths(graph, compiled.formulas, compiled.facts)
    context = LintContext(workbook, robot, graph, compiled, running, routes, report)
    for each in (
        lint_stale, lint_flooded, lint_conflicts, lint_unreachable, lint_failing_formulas, lint_input_specs,
        lint_unused_helpers, lint_unmatched, lint_deadlock,
    ):  # fmt: skip
        each(context)
