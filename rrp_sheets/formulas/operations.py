"""The evaluator's operations on values that are not plain numbers, bounded and charged, and the draws of PICK."""

from __future__ import annotations

import ast
import operator
import random
from collections.abc import Callable, Sequence
from typing import Any

from rrp_sheets.formulas.functions.define import shown
from rrp_sheets.formulas.limits import LONGEST_FIELD, LONGEST_LIST, LONGEST_TEXT, Charge, free, letters, searching
from rrp_sheets.formulas.problems import FormulaProblem, kind_of, wrong_kind
from rrp_sheets.formulas.tables import Table, value_of
from rrp_sheets.model.values import Record, Value
from rrp_sheets.texts import N_, capital

_SIGNS: dict[type, str] = {
    ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.FloorDiv: "//", ast.Mod: "%", ast.Pow: "^",
}  # fmt: skip


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
                raise FormulaProblem("FORM115", text=many[:40])  # 10 to a spreadsheet, 55 to Python
            size = len(many) * max(times, 0)
            _fits(size, many)
            charge(size)
            return many * times
    if left is None or right is None:
        raise FormulaProblem("FORM102", needed=N_("a value next to {value}", value=_SIGNS[kind]))
    if kind is ast.Add and {type(left), type(right)} & {str} and {type(left), type(right)} & NUMBERS:
        raise FormulaProblem("FORM114")
    raise FormulaProblem("FORM103", what=N_("{value} cannot work with {kind} and {kind2}", value=_SIGNS[kind],
                                            kind=kind_of(left), kind2=kind_of(right)))  # fmt: skip


def _fits(size: int, like: Value) -> None:
    if size > (LONGEST_TEXT if isinstance(like, str) else LONGEST_LIST):
        raise FormulaProblem("FORM105", reason=N_("it becomes too long"))


def field(owner: Value, name: str) -> Value:
    """Return a field of a record; nothing else has fields."""
    if type(owner) is not Record:
        if owner is None:
            raise FormulaProblem("FORM102", needed=N_("something with a field “{name}”", name=name))
        what = N_("{what} has no field “{name}”", what=capital(kind_of(owner)), name=name)
        raise FormulaProblem("FORM103", what=what)
    if len(name) <= LONGEST_FIELD:  # looking a name up folds it, and keeps what it is folded to
        try:
            return owner.get(name)
        except KeyError:
            pass
    short = name if len(name) <= 40 else name[:39] + "…"
    raise FormulaProblem("FORM104", record=owner.type.name, field=short, remedy=N_("Check its fields."))


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
        raise FormulaProblem("FORM103", what=N_("Write a field's name between the brackets"))
    if isinstance(owner, Table):
        raise FormulaProblem("FORM103", what=N_("A whole table has columns and rows: write INDEX(table; 1)"))
    if not isinstance(owner, (list, tuple, str)):
        raise wrong_kind(N_("a list"), owner)
    if isinstance(index, slice):
        charge(len(owner) // 10)
        return owner[index]
    if type(index) is not int:
        raise wrong_kind(N_("a whole number as the position in a list"), index)
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
        what = N_("The format “{spec}” does not fit {kind}", spec=spec, kind=kind_of(value))
        raise FormulaProblem("FORM107", what=what) from None


ORDER: dict[type, Callable[[Any, Any], bool]] = {
    ast.Lt: operator.lt, ast.LtE: operator.le, ast.Gt: operator.gt, ast.GtE: operator.ge,
}  # fmt: skip
NUMBERS = frozenset((int, float, bool))


def is_number(value: Value) -> bool:
    """Return whether a value is a number; TRUE and FALSE are none."""
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def same(left: Value, right: Value, charge: Charge = free) -> bool:
    """Return whether two values are equal; texts are compared without regard to capitals.

    `charge` is called with the work that it took, in steps.

    >>> same("Red", "red"), same([1, "A"], [1, "a"]), same(None, 0)
    (True, True, False)
    """
    if isinstance(left, str) and isinstance(right, str):
        charge(letters(left, right))
        return left.casefold() == right.casefold()
    if isinstance(left, (list, tuple)) and isinstance(right, (list, tuple)):
        charge(len(left))
        return len(left) == len(right) and all(same(a, b, charge) for a, b in zip(left, right, strict=True))
    if isinstance(left, Record) and isinstance(right, Record):
        return left is right or _identical(left, right, charge)
    if left is None or right is None or isinstance(left, str) or isinstance(right, str):
        return left is right
    return bool(left == right)


def _identical(left: Value, right: Value, charge: Charge) -> bool:
    """Return the result of Python's `==` on what records hold, and charge for what it reads."""
    if type(left) is Record and type(right) is Record:
        charge(1 + len(left.values) // 4)
        mine, other = left.values, right.values
        return mine.keys() == other.keys() and all(_identical(v, other[k], charge) for k, v in mine.items())
    if type(left) is type(right) and isinstance(left, (list, tuple)):
        charge(len(left))
        return len(left) == len(right) and all(_identical(a, b, charge) for a, b in zip(left, right, strict=True))
    if isinstance(left, str) and isinstance(right, str):
        charge(letters(left, right))
    return bool(left == right)


def compare(op: ast.cmpop, left: Value, right: Value, charge: Charge = free) -> bool:
    """Return the result of one comparison; raises FormulaProblem when the values cannot be compared."""
    if isinstance(op, (ast.Eq, ast.Is)):
        return same(left, right, charge)
    if isinstance(op, (ast.NotEq, ast.IsNot)):
        return not same(left, right, charge)
    if isinstance(op, (ast.In, ast.NotIn)):
        if isinstance(right, (list, tuple)):
            charge(len(right))
            held = any(same(left, r, charge) for r in right)
        elif isinstance(left, str) and isinstance(right, str):
            sought, text = left.casefold(), right.casefold()
            charge(searching(sought, text))
            held = sought in text
        else:
            raise wrong_kind(N_("a list"), right)
        return held is isinstance(op, ast.In)
    if isinstance(left, str) and isinstance(right, str):
        charge(letters(left, right))
        return ORDER[type(op)](left.casefold(), right.casefold())
    if type(left) in NUMBERS and type(right) in NUMBERS:
        return ORDER[type(op)](left, right)
    if left is None or right is None:
        raise FormulaProblem("FORM102", needed=N_("a value to compare"))
    what = N_("{what} cannot be compared with {kind}", what=capital(kind_of(left)), kind=kind_of(right))
    raise FormulaProblem("FORM103", what=what)


class Picker:
    """The draws of one row's formula in one run; those of its PICKs that draw from one list share its sequence.

    Each member comes once before any repeats, never the same twice running; the seed decides. Rows draw independently
    of each other; `row` is the ref of one (`Tracking!4`).

    >>> picker = Picker(7, "Play!3")
    >>> sorted(picker.pick("", ["a", "b", "c"]) for _ in range(3))
    ['a', 'b', 'c']
    """

    def __init__(self, seed: int, row: str) -> None:
        self._name = f"{seed}\n{row}"
        self._sites: dict[str, _Site] = {}

    def pick(self, site: str, members: Sequence[Value], charge: Charge = free) -> Value:
        """Return the next member for one PICK of the formula; `members` is not empty, `charge` gets the steps."""
        if site not in self._sites:
            # seeded with a text, Python hashes it the same way everywhere
            self._sites[site] = _Site(random.Random(f"{self._name}\n{site}"))
        return self._sites[site].draw(members, charge)


class _Site:
    """Draws of one PICK, as places of the list, so that a list of the same length continues the sequence."""

    def __init__(self, chance: random.Random) -> None:
        self._chance = chance
        self._count = 0
        self._left: list[int] = []
        self._last: list[Value] = []

    def draw(self, members: Sequence[Value], charge: Charge) -> Value:
        if len(members) != self._count or not self._left:
            self._count, self._left = len(members), list(range(len(members)))

        def is_last(member: Value) -> bool:  # lists are compared by identity alone
            is_list = isinstance(member, (list, tuple))
            return any(member is last or (not is_list and same(member, last, charge)) for last in self._last)

        fresh = [i for i in self._left if not is_last(members[i])]
        choice = fresh or self._left
        # only random() is promised to stay the same between versions of Python
        place = choice[int(self._chance.random() * len(choice))]
        self._left.remove(place)
        self._last = [members[place]]
        return members[place]
