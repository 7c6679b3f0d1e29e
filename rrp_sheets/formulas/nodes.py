"""Kinds of nodes that Python's own tree lacks, each with a handler in the evaluator."""

from __future__ import annotations

import ast


class Join(ast.expr):
    """`a & b & c`: a text of all of them."""

    _fields = ("values",)

    values: list[ast.expr]


class IfError(ast.expr):
    """IFERROR: `value`, or `otherwise` when evaluating it fails. ISERROR: `otherwise` is None."""

    _fields = ("value", "otherwise")

    value: ast.expr
    otherwise: ast.expr | None


class Switch(ast.expr):
    """SWITCH: the result of the first case that `value` equals, or `otherwise`; IFS: of the first that holds."""

    _fields = ("value", "cases", "results", "otherwise")

    value: ast.expr | None
    cases: list[ast.expr]
    results: list[ast.expr]
    otherwise: ast.expr | None


class Pick(ast.expr):
    """PICK: it draws from `members`; `site` distinguishes those of a row that draw from different lists."""

    _fields = ("members",)

    members: list[ast.expr]
    site: str
