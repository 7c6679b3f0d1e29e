"""Logic: IF and what chooses. Those that are nodes of their own evaluate only what they need."""

from __future__ import annotations

import ast

from rrp_sheets.formulas.functions.define import MANY, Function, define, truth
from rrp_sheets.formulas.operations import is_number
from rrp_sheets.formulas.parsing import IfError, Switch
from rrp_sheets.formulas.problems import FormulaProblem
from rrp_sheets.model.values import Record, Value
from rrp_sheets.texts import N_


def xor(*conditions: Value) -> bool:
    """TRUE when an odd number of conditions holds; of two: when just one does.

    >>> xor(True, False), xor(True, True)
    (True, False)
    """
    return sum(1 for c in conditions if truth(c)) % 2 == 1


def isblank(value: Value) -> bool:
    """TRUE when a value is blank.

    >>> isblank(None), isblank(0), isblank("")
    (True, False, False)
    """
    return value is None


def istext(value: Value) -> bool:
    """TRUE when a value is a text.

    >>> istext("hi"), istext(1)
    (True, False)
    """
    return isinstance(value, str)


def islogical(value: Value) -> bool:
    """TRUE when a value is TRUE or FALSE.

    >>> islogical(False), islogical(0)
    (True, False)
    """
    return isinstance(value, bool)


def islist(value: Value) -> bool:
    """TRUE when a value is a list.

    >>> islist([1, 2]), islist(1)
    (True, False)
    """
    return isinstance(value, (list, tuple))


def isrecord(value: Value) -> bool:
    """TRUE when a value is a whole record, such as what a sensor gives.

    >>> isrecord(1)
    False
    """
    return isinstance(value, Record)


def _lazy(*_arguments: Value) -> Value:
    raise AssertionError("evaluated as a node of its own")


def _iferror(args: list[ast.expr]) -> ast.expr:
    node = IfError()
    node.value, node.otherwise = args[0], args[1] if len(args) > 1 else None
    return node


def _isnumber(args: list[ast.expr]) -> ast.expr:
    # spreadsheets ask ISNUMBER(SEARCH("ball"; text)), and the SEARCH fails where there is none
    call = ast.copy_location(ast.Call(ast.Name("ISNUMBER"), args, []), args[0])
    call.bound, call.charges, call.gives = is_number, False, "truth"  # type: ignore[attr-defined]
    node = IfError()
    node.value, node.otherwise = call, ast.copy_location(ast.Constant(False), args[0])
    return node


def _if(args: list[ast.expr]) -> ast.expr:
    return ast.IfExp(args[0], args[1], args[2] if len(args) == 3 else ast.Constant(False))


def _ifs(args: list[ast.expr]) -> ast.expr:
    if len(args) % 2:
        raise FormulaProblem("FORM006", name="IFS", takes=N_("a value behind every condition"), gets=len(args),
                             usage="IFS(condition; value; condition; value; TRUE; otherwise)")  # fmt: skip
    node = Switch()
    node.value, node.cases, node.results, node.otherwise = None, args[::2], args[1::2], None
    return node


def _switch(args: list[ast.expr]) -> ast.expr:
    pairs = args[1 : len(args) - (len(args) % 2 == 0)]
    node = Switch()
    node.value, node.cases, node.results = args[0], pairs[::2], pairs[1::2]
    node.otherwise = args[-1] if len(args) % 2 == 0 else None
    return node


FUNCTIONS = (
    Function(("IF",), _lazy, 2, 3, "IF(condition; then; otherwise)",
             "The second value when the condition holds, else the third (FALSE when there is none).\n\n"
             '>>> IF(2 > 1; "more"; "less")\n\'more\'', _if),
    Function(("IFS",), _lazy, 2, MANY, "IFS(condition; value; …)",
             "The value behind the first condition that holds; write TRUE as the last condition for all others.\n\n"
             '>>> IFS(5 < 1; "near"; 5 < 10; "middle"; TRUE; "far")\n\'middle\'', _ifs),
    Function(("SWITCH",), _lazy, 3, MANY, "SWITCH(value; case; result; …; otherwise)",
             "The result behind the first case that the value equals, or what stands at the end.\n\n"
             '>>> SWITCH("red"; "green"; "go"; "red"; "stop"; "wait")\n\'stop\'', _switch),
    Function(("AND",), _lazy, 1, MANY, "AND(condition; …)", "TRUE when all conditions hold.\n\n"
             ">>> AND(1 < 2; 2 < 3)\nTrue", lambda args: ast.BoolOp(ast.And(), args)),
    Function(("OR",), _lazy, 1, MANY, "OR(condition; …)", "TRUE when at least one condition holds.\n\n"
             ">>> OR(1 > 2; 2 < 3)\nTrue", lambda args: ast.BoolOp(ast.Or(), args)),
    Function(("NOT",), _lazy, 1, 1, "NOT(condition)", "TRUE when the condition does not hold.\n\n"
             ">>> NOT(1 > 2)\nTrue", lambda args: ast.UnaryOp(ast.Not(), args[0])),
    Function(("IFERROR",), _lazy, 2, 2, "IFERROR(value; otherwise)",
             "The first value, or the second when working out the first fails.\n\n"
             ">>> IFERROR(1 / 0; -1)\n-1", _iferror),
    Function(("ISERROR",), _lazy, 1, 1, "ISERROR(value)", "TRUE when working out a value fails.\n\n"
             ">>> ISERROR(1 / 0)\nTrue", _iferror),
    Function(("ISNUMBER",), _lazy, 1, 1, "ISNUMBER(value)",
             "TRUE when a value is a number; FALSE too when working it out fails.\n\n"
             '>>> ISNUMBER(SEARCH("ball"; "red hat"))\nFalse', _isnumber),
    define(xor), define(isblank), define(istext), define(islogical), define(islist), define(isrecord),
)  # fmt: skip
