"""Tables and looking up: ROWS, INDEX, XLOOKUP, MATCH, PICK. What takes a list takes a table too: its rows."""

from __future__ import annotations

import ast

from rrp_sheets.formulas.functions.define import MANY, Function, define, listing, shown, whole
from rrp_sheets.formulas.limits import Charge, free
from rrp_sheets.formulas.operations import same
from rrp_sheets.formulas.parsing import Pick
from rrp_sheets.formulas.problems import FormulaProblem, kind_of, wrong_kind
from rrp_sheets.formulas.tables import Table
from rrp_sheets.model.values import Value
from rrp_sheets.texts import N_, capital

_NO_DEFAULT = object()


def rows(table: Value) -> int:
    """The number of rows of a table, or of places of a list.

    >>> rows(["first", "second"])
    2
    """
    return len(listing(table))


def index(values: Value, place: Value) -> Value:
    """The member of a list at a place, or the row of a table; the first has number 1.

    >>> index(["a", "b"], 2)
    'b'
    """
    members, at = listing(values), whole(place)
    if not 1 <= at <= len(members):
        what = N_("table {name}", name=values.name) if isinstance(values, Table) else N_("list")
        raise FormulaProblem("FORM112", index=at, count=len(members), what=what)
    return members[at - 1]


def match(what: Value, where: Value, kind: Value = 0, *, charge: Charge = free) -> int:
    """The place of a value in a list, the first has number 1; texts are found without regard to capitals.

    >>> match("Hand", ["head", "hand"])
    2
    """
    if kind not in (0, False):
        raise FormulaProblem("FORM107", what=N_("MATCH finds only what is equal: leave its third value out"))
    place = _find(what, where, charge)
    if place is None:
        raise FormulaProblem("FORM111", what=_named(what))
    return place + 1


def xlookup(
    what: Value, where: Value, results: Value, otherwise: Value = _NO_DEFAULT, *, charge: Charge = free
) -> Value:
    """The entry of `results` at the place where a value is in a list; `otherwise` when it is not there.

    >>> xlookup("no", ["yes", "no"], ["Good!", "Never mind."]), xlookup("what", ["yes"], ["Good!"], None)
    ('Never mind.', None)
    """
    among, count = listing(results), len(listing(where))
    if len(among) != count:
        what = N_("The two lists have {count} and {second} places", count=count, second=len(among))
        raise FormulaProblem("FORM107", what=what)
    place = _find(what, where, charge)
    if place is not None:
        return among[place]
    if otherwise is _NO_DEFAULT:
        raise FormulaProblem("FORM111", what=_named(what))
    return otherwise


def _find(what: Value, where: Value, charge: Charge) -> int | None:
    if isinstance(where, Table):
        column = where.type.fields[0].name if where.type.fields else "…"
        raise wrong_kind(N_("a column such as {name}[{value}]", name=where.name, value=column), where)
    return next((i for i, v in enumerate(listing(where)) if same(what, v, charge)), None)


def _named(what: Value) -> str:
    if isinstance(what, (str, int, float)):
        text = shown(what)
        return N_("“{text}”", text=text if len(text) <= 40 else text[:39] + "…")
    return capital(kind_of(what))


def members_of(values: list[Value]) -> list[Value] | tuple[Value, ...]:
    """The values that PICK draws from: the one list or table that it is given, or its several values."""
    members = listing(values[0]) if len(values) == 1 else values
    if not members:
        raise FormulaProblem("FORM107", what=N_("There is nothing in the list to pick from"))
    return members


def _pick(args: list[ast.expr]) -> ast.expr:
    node = Pick()
    node.members = args
    return node


def _lazy(*_arguments: Value) -> Value:
    raise AssertionError("evaluated as a node of its own")


FUNCTIONS = (
    define(rows, bounds=(0, 1_000)), define(index), define(match, bounds=(1, 1_000)), define(xlookup),
    Function(("PICK",), _lazy, 1, MANY, "PICK(list)",
             "One of a list or a row of a table, by chance: each once before any repeats, never the same twice "
             "running.\n\n>>> PICK([\"Super!\"; \"Well done!\"])\n'Super!'", _pick,
             words=("random", "chance", "choose", "draw", "乱数", "ランダム", "くじ", "選ぶ")),
)  # fmt: skip
