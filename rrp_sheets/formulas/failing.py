"""An error in a formula as a value: what went wrong, at which of its letters, and in which helper."""

from __future__ import annotations

import ast

from rrp_sheets.diagnostics.phrase import Phrase
from rrp_sheets.formulas.problems import problem_of
from rrp_sheets.model.values import Failure


def failure_of(error: Exception) -> Failure:
    """The failure of an evaluation that has raised; an error that is none of a formula's is raised again."""
    problem = problem_of(error)
    if problem is None:
        raise error
    column, helper = -1, ""
    trace = error.__traceback__
    while trace is not None and not helper:  # the innermost node, but of this formula, not of its helpers
        node = trace.tb_frame.f_locals.get("node")
        if isinstance(node, ast.expr) and hasattr(node, "col_offset"):
            column = node.col_offset
            inside = "outer" in trace.tb_frame.f_locals and hasattr(node, "helper")
            helper = node.helper.shown if inside else ""  # type: ignore[attr-defined]
        trace = trace.tb_next
    failure = problem.failure(column)
    if not helper:
        return failure
    message = Phrase("In the helper {helper}: {message}", helper=helper, message=failure.message)
    return Failure(failure.code, message, column)
