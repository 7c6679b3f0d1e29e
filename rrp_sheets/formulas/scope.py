"""The names that a formula may use: the row's inputs, helpers, constants, tables, and the library's functions."""

from __future__ import annotations

import ast
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from rrp_sheets.formulas.functions import Function, library
from rrp_sheets.formulas.problems import FormulaProblem
from rrp_sheets.formulas.tables import Table
from rrp_sheets.model.names import Proposals, argument_name, key
from rrp_sheets.model.values import RecordType, Value
from rrp_sheets.registry import Registry


@dataclass(frozen=True)
class Input:
    """An input of a row as formulas see it.

    Attributes:
        shown: its name as the sheet has it.
        name: its name in formulas.
        kind: `number`, `text` or `truth` when it is known to be nothing else.
    """

    shown: str
    name: str
    record: RecordType | None = None
    kind: str = ""


@dataclass
class HelperDef:
    """A helper: parameters and its tree, filled in when it is compiled (helpers may call helpers)."""

    shown: str
    parameters: tuple[Input, ...]
    tree: ast.expr | None = None


@dataclass(frozen=True)
class Scope:
    """All names that a formula may use.

    Attributes:
        inputs: by key, what the connector adds to them included; a row with one input has it under `value` too.
        order: their names in order, as the evaluator's arguments are.
        tables: by the key of the sheet's name and of its name in formulas.
        propose: finds what may be meant by an unknown name.
    """

    inputs: Mapping[str, Input]
    order: tuple[str, ...]
    helpers: Mapping[str, HelperDef] = field(default_factory=dict)
    functions: Registry[Function] = field(default_factory=library)
    constants: Mapping[str, Value] = field(default_factory=lambda: {"pi": math.pi, "e": math.e})
    tables: Mapping[str, Table] = field(default_factory=dict)
    propose: Proposals = field(default_factory=Proposals)

    def known(self) -> list[str]:
        """Return all names that are not functions, for proposing the nearest."""
        named = [i.name for i in self.inputs.values()] + [h.shown for h in self.helpers.values()]
        return named + list(self.constants) + [t.name for t in self.tables.values()]

    def table(self, name: str) -> Table | None:
        """Return the table that a name means, or None; inputs, helpers and constants of that name come before it."""
        k = key(name)
        taken = k in self.inputs or k in self.helpers or k in self.constants
        return None if taken else self.tables.get(k)


def make_scope(
    inputs: Iterable[tuple[str, RecordType | None]], helpers: Mapping[str, HelperDef] | None = None,
    functions: Registry[Function] | None = None, *, tables: Mapping[str, Table] | None = None,
    extra: Iterable[str] = (), kinds: Mapping[str, str] | None = None, propose: Proposals | None = None,
) -> Scope:  # fmt: skip
    """Return the scope of a row with these input streams (name, record type if known).

    An input without a name (an anonymous stream) is reached as `value`.

    Args:
        inputs: the row's input streams in order.
        helpers: by key.
        functions: the library unless given.
        tables: by the sheet's key.
        extra: names that the connector adds, before the inputs (accumulate: `total`, `value`).
        kinds: what an input's values are (`number`, `text`, `truth`), by the stream's name, where known.
        propose: shared by the scopes of one check, which together look for no more names than it allows.

    Raises:
        FormulaProblem: FORM009 when two inputs have one name.
    """
    inputs, order = list(inputs), list(extra)
    found = {key(name): Input(name, name) for name in order}
    for place, (shown, record) in enumerate(inputs):
        name = argument_name(shown) or "value"
        k = key(name)
        if k in found and not shown:  # what the connector calls `value` is this one: it needs no name of its own
            order.append(f" {place}")
            continue
        if k in found:
            raise FormulaProblem("FORM009", first=found[k].shown or name, second=shown or name, name=name)
        found[k] = Input(shown, name, record, (kinds or {}).get(shown, ""))
        order.append(name)
    if len(inputs) == 1 and order[-1] in (i.name for i in found.values()):
        found.setdefault("value", found[key(order[-1])])
    named = {k: table for sheet, table in (tables or {}).items() for k in (key(argument_name(table.name)), sheet)}
    return Scope(found, tuple(order), helpers or {}, functions or library(), tables=named,
                 propose=propose or Proposals())  # fmt: skip
