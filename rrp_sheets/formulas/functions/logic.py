"""Logic: IF, AND, OR, NOT, IFERROR, ISBLANK. The first five evaluate only what they need."""

from __future__ import annotations

import ast

from rrp_sheets.formulas.functions.define import MANY, Function, define
from rrp_sheets.model.values import Value


class IfError(ast.expr):
    """The node of IFERROR: `value`, or `otherwise` when evaluating it fails."""

    _fields = ("value", "otherwise")

    value: ast.expr
    otherwise: ast.expr


def isblank(value: Value) -> bool:
    """Whether a value is blank.

    >>> isblank(None), isblank(0), isblank("")
    (True, False, False)
    """
    return value is None


def istext(value: Value) -> bool:
    """Whether a value is a text.

    >>> istext("hi"), istext(1)
    (True, False)
    """
    return isinstance(value, str)


def isnumber(value: Value) -> bool:
    """Whether a value is a number.

    >>> isnumber(1.5), isnumber("1.5"), isnumber(True)
    (True, False, False)
    """
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _lazy(*_arguments: Value) -> Value:
    raise AssertionError("evaluated as a node of its own")


def _iferror(args: list[ast.expr]) -> ast.expr:
    node = IfError()  # nodes are copied, so it must be possible to make one without arguments
    node.value, node.otherwise = args
    return node


def _if(args: list[ast.expr]) -> ast.expr:
    return ast.IfExp(args[0], args[1], args[2] if len(args) == 3 else ast.Constant(False))


FUNCTIONS = (
    Function(("IF",), _lazy, 2, 3, "IF(condition, then, otherwise)",
             "The second value when the condition holds, else the third (FALSE when there is none).", _if),
    Function(("AND",), _lazy, 1, MANY, "AND(condition, …)", "TRUE when all conditions hold.",
             lambda args: ast.BoolOp(ast.And(), args)),
    Function(("OR",), _lazy, 1, MANY, "OR(condition, …)", "TRUE when at least one condition holds.",
             lambda args: ast.BoolOp(ast.Or(), args)),
    Function(("NOT",), _lazy, 1, 1, "NOT(condition)", "TRUE when the condition does not hold.",
             lambda args: ast.UnaryOp(ast.Not(), args[0])),
    Function(("IFERROR",), _lazy, 2, 2, "IFERROR(value, otherwise)",
             "The first value, or the second when working out the first fails.", _iferror),
    define(isblank),
    define(istext),
    define(isnumber),
)  # fmt: skip
