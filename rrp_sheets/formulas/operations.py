"""The evaluator's operations on values that are not plain numbers; everything is bounded and charged."""

from __future__ import annotations

import ast
from typing import Any

from rrp_sheets.diagnostics.phrase import Phrase, capital
from rrp_sheets.formulas.compare import NUMBERS
from rrp_sheets.formulas.functions.define import shown
from rrp_sheets.formulas.limits import LONGEST_FIELD, LONGEST_LIST, LONGEST_TEXT, Charge, letters
from rrp_sheets.formulas.problems import FormulaProblem, kind_of, wrong_kind
from rrp_sheets.formulas.tables import Table, value_of
from rrp_sheets.model.values import Record, Value

_SIGNS: dict[type, str] = {
    ast.Add: "+",
    ast.Sub: "-",
    ast.Mult: "*",
    ast.Div: "/",
    ast.FloorDiv: "//",
    ast.Mod: "%",
    ast.Pow: "^",
}


def arithmetic(kind: type, left: Value, right: Value, charge: Charge) -> Value:
    """Join two texts or two lists with `+`, or repeat one with `*`; raises FormulaProblem for everything else.

    >>> arithmetic(ast.Add, "a", "b", print), arithmetic(ast.Mult, 2, [0], lambda _steps: None)
    0
    ('ab', [0, 0])
    """
    if kind is ast.Add and isinstance(left, (str, list, tuple)) and type(left) is type(right):
        size = len(left) + len(right)
        _fits(size, left)
        charge(size // (100 if isinstance(left, str) else 10))
        joined: Any = left
        return joined + right
    if kind is ast.Mult:
        many, times = (left, right) if isinstance(left, (str, list, tuple)) else (right, left)
        if isinstance(many, (str, list, tuple)) and type(times) is int:
            charge(letters(many) if isinstance(many, str) else 0)
            if isinstance(many, str) and isinstance(value_of(many), (int, float)):
                # 10 to a spreadsheet, 55 to Python
                raise FormulaProblem("FORM115", text=many[:40])
            size = len(many) * max(times, 0)
            _fits(size, many)
            charge(size)
            return many * times
    if left is None or right is None:
        raise FormulaProblem("FORM102", needed=Phrase("a value beside {value}", value=_SIGNS[kind]))
    if kind is ast.Add and {type(left), type(right)} & {str} and {type(left), type(right)} & NUMBERS:
        raise FormulaProblem("FORM114")
    raise FormulaProblem(
        "FORM103",
        what=Phrase(
            "{value} cannot work with {kind} and {kind2}", value=_SIGNS[kind], kind=kind_of(left), kind2=kind_of(right)
        ),
    )


def _fits(size: int, like: Value) -> None:
    if size > (LONGEST_TEXT if isinstance(like, str) else LONGEST_LIST):
        raise FormulaProblem("FORM105", reason="it becomes too long")


def field(owner: Value, name: str) -> Value:
    """Return a field of a record; nothing else has fields."""
    if type(owner) is not Record:
        if owner is None:
            raise FormulaProblem("FORM102", needed=Phrase("something with a field “{name}”", name=name))
        raise FormulaProblem(
            "FORM103", what=Phrase("{what} has no field “{name}”", what=capital(kind_of(owner)), name=name)
        )
    if len(name) <= LONGEST_FIELD:  # looking a name up folds it, and keeps what it is folded to
        try:
            return owner.get(name)
        except KeyError:
            pass
    short = name if len(name) <= 40 else name[:39] + "…"
    raise FormulaProblem("FORM104", record=owner.type.name, field=short, remedy="Check its fields.")


def at_place(owner: Value, index: Value, charge: Charge) -> Value:
    """Return a place in a list or text, a slice of one, or a field in brackets."""
    if type(owner) is Record:
        if isinstance(index, str):
            return field(owner, index)
        if type(index) is int and owner.type.positions:
            try:
                return owner.get(index)
            except KeyError:
                raise FormulaProblem("FORM106", index=index, count=len(owner.type.positions)) from None
        raise FormulaProblem("FORM103", what="Write a field's name between the brackets")
    if isinstance(owner, Table):
        raise FormulaProblem("FORM103", what="A whole table has columns and rows: write INDEX(table; 1)")
    if not isinstance(owner, (list, tuple, str)):
        raise wrong_kind("a list", owner)
    if isinstance(index, slice):
        charge(len(owner) // 10)
        return owner[index]
    if type(index) is not int:
        raise wrong_kind("a whole number as the place in a list", index)
    if not -len(owner) <= index < len(owner):
        raise FormulaProblem("FORM106", index=index, count=len(owner))
    return owner[index]


def formatted(value: Value, spec: str) -> str:
    """Return a value as a text in a format such as `.1f`.

    >>> formatted(2.345, ".1f")
    '2.3'
    """
    if isinstance(value, bool) or not isinstance(value, (int, float, str)):
        value = shown(value)
    try:
        return format(value, spec)
    except ValueError:
        raise FormulaProblem(
            "FORM107", what=Phrase("The format “{spec}” does not fit {kind}", spec=spec, kind=kind_of(value))
        ) from None
