"""Functions of the library, and their definition from plain Python functions."""

from __future__ import annotations

import ast
import inspect
import math
import re
from collections.abc import Callable
from dataclasses import dataclass

from rrp_sheets.formulas.limits import DEEPEST, LARGEST_NUMBER, LONGEST_LIST, LONGEST_TEXT, MOST_LEAVES
from rrp_sheets.formulas.problems import FormulaProblem, no_condition, wrong_kind
from rrp_sheets.formulas.tables import Table
from rrp_sheets.model.values import Record, Value
from rrp_sheets.texts import N_

MANY = 255


def arguments(count: int) -> str:
    """The number of arguments, in words."""
    return {0: N_("no arguments"), 1: N_("one argument")}.get(count) or N_("{count} arguments", count=count)


@dataclass(frozen=True)
class Function:
    """A function of the library.

    Attributes:
        names: the first is shown; the others are accepted too.
        call: the Python function; it raises FormulaProblem for values that it cannot take.
        usage: `CLAMP(number; low; high)`.
        make: for IF, AND, OR, NOT, IFERROR: makes the node from the arguments' nodes, which are evaluated lazily.
        gives: the kind of its results, or the bounds of the number; `any` when they differ.
        words: plain words, in all languages, by which people look for it.
        charges: whether it takes a keyword `charge`, to be told steps of work beyond the length of its arguments.
    """

    names: tuple[str, ...]
    call: Callable[..., Value]
    least: int
    most: int
    usage: str
    help: str
    make: Callable[[list[ast.expr]], ast.expr] | None = None
    charges: bool = False
    gives: str | tuple[float, float] = "any"
    words: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """The name as shown."""
        return self.names[0]

    @property
    def takes(self) -> str:
        """The number of arguments, in words."""
        if self.most >= MANY:
            return N_("{least} or more arguments", least=self.least)
        if self.least == self.most:
            return arguments(self.least)
        return N_("{least} to {most} arguments", least=self.least, most=self.most)


_KINDS = {"str": "text", "bool": "truth", "list": "list", "int": "number", "float": "number", "int | float": "number",
          "Number": "number"}  # fmt: skip


def define(
    call: Callable[..., Value], *synonyms: str, name: str = "", bounds: tuple[float, float] | None = None,
    make: Callable[[list[ast.expr]], ast.expr] | None = None,
) -> Function:  # fmt: skip
    """A library function from a Python function: its name in capitals, its parameters and its docstring.

    The check knows the kind of its results from their annotation, or else the `bounds` of its numbers.

    >>> def double(number): return 2 * number
    >>> define(double).usage
    'DOUBLE(number)'
    """
    signature = inspect.signature(call)
    parameters = [p for p in signature.parameters.values() if p.kind is not p.KEYWORD_ONLY]
    least = sum(1 for p in parameters if p.default is p.empty and p.kind is not p.VAR_POSITIONAL)
    many = any(p.kind is p.VAR_POSITIONAL for p in parameters)
    shown = name or call.__name__.strip("_").upper()
    names = "; ".join(f"{p.name}; …" if p.kind is p.VAR_POSITIONAL else p.name for p in parameters)
    most = MANY if many else len(parameters)
    least = max(least, 1) if many else least
    usage = f"{shown}({names})"
    results = inspect.formatannotation(signature.return_annotation).strip("'")
    gives = bounds or _KINDS.get(re.sub(r"\[.*\]", "", results), "any")
    charges = "charge" in signature.parameters
    return Function((shown, *synonyms), call, least, most, usage, inspect.getdoc(call) or "", make, charges, gives)


def number(value: Value) -> int | float:
    """The value if it is a number; TRUE is 1."""
    if isinstance(value, (int, float)):
        return value
    raise wrong_kind(N_("a number"), value)


def truth(value: Value) -> bool:
    """The value as a condition: TRUE, FALSE, a number or blank."""
    if value is None or isinstance(value, (int, float)):
        return bool(value)
    raise no_condition(value)


def whole(value: Value) -> int:
    """The value if it is a whole number."""
    n = number(value)
    if n != int(n):
        raise FormulaProblem("FORM107", what=N_("{n:g} is not a whole number", n=n))
    return int(n)


def text(value: Value) -> str:
    """The value if it is a text."""
    if isinstance(value, str):
        return value
    raise wrong_kind(N_("a text"), value)


def listing(value: Value) -> list[Value] | tuple[Value, ...]:
    """The value if it is a list; a table is the list of its rows."""
    if isinstance(value, (list, tuple)):
        return value
    if isinstance(value, Table):
        return value.rows
    raise wrong_kind(N_("a list"), value)


def islist(value: Value) -> bool:
    """Return whether a value is a list, or a table, which is the list of its rows."""
    return isinstance(value, (list, tuple, Table))


def flat(values: tuple[Value, ...]) -> list[Value]:
    """Arguments and the members of lists among them, blanks left out, as spreadsheets count."""
    found: list[Value] = []
    for v in values:
        found.extend(listing(v) if islist(v) else [v])
    return [v for v in found if v is not None]


def too_many() -> FormulaProblem:
    """The problem that a list becomes too long."""
    return FormulaProblem("FORM105", reason=N_("lists have at most {most} places", most=LONGEST_LIST))


def too_long() -> FormulaProblem:
    """The problem that a text becomes too long."""
    return FormulaProblem("FORM105", reason=N_("texts have at most {most} characters", most=LONGEST_TEXT))


def shown(value: Value) -> str:
    """A value as a text that is joined to others shows it.

    >>> shown(0.1 + 0.2), shown(3.0), shown(True)
    ('0.3', '3', 'TRUE')
    """
    if isinstance(value, str):
        return value
    if isinstance(value, bool):
        return "TRUE" if value else "FALSE"
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        return format(value, ".15g")
    raise wrong_kind(N_("a text or a number"), value)


def weighed(value: Value) -> Value:
    """A formula's result if it is small enough to travel; lists within lists are counted whole.

    Raises FormulaProblem FORM105.
    """
    leaves = 0
    level: list[Value] = [value]
    for _ in range(DEEPEST):
        inner: list[Value] = []
        for v in level:
            kind = type(v)
            if kind is list or kind is tuple:
                inner.extend(v)
            elif kind is Record:
                inner.extend(v.values.values())
            elif kind is Table:
                raise FormulaProblem("FORM110", table=v.name)
            elif kind is str:
                leaves += len(v) // 100
            if leaves + len(inner) > MOST_LEAVES:
                reason = N_("lists have at most {most} places altogether", most=MOST_LEAVES)
                raise FormulaProblem("FORM105", reason=reason)
        leaves += len(inner)
        if not inner:
            return value
        level = inner
    raise FormulaProblem("FORM105", reason=N_("lists within lists go {deepest} deep at most", deepest=DEEPEST))


def bounded(value: Value) -> Value:
    """The value if it is within the bounds of formulas; raises FormulaProblem FORM105."""
    kind = type(value)
    if kind is float or kind is int:
        if -LARGEST_NUMBER <= value <= LARGEST_NUMBER:
            return value
        reason = N_("it is not a number" if math.isnan(value) else "numbers go up to 1e15")
        raise FormulaProblem("FORM105", reason=reason)
    if kind is str and len(value) > LONGEST_TEXT:
        raise too_long()
    if (kind is list or kind is tuple) and len(value) > LONGEST_LIST:
        raise too_many()
    return value
