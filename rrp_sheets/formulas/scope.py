"""The names that a formula may use: the row's inputs, helpers, the library, constants; in this order."""

from __future__ import annotations

import ast
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from rrp_sheets.formulas.functions import Function, library
from rrp_sheets.formulas.problems import FormulaProblem
from rrp_sheets.model.names import argument_name, key
from rrp_sheets.model.values import RecordType, Value
from rrp_sheets.registry import Registry


@dataclass(frozen=True)
class Input:
    """An input of a row as formulas see it: its shown name, its name in formulas, and its record type if known."""

    shown: str
    name: str
    record: RecordType | None = None


@dataclass
class HelperDef:
    """A helper: parameters and its tree, filled in when it is compiled (helpers may call helpers)."""

    shown: str
    parameters: tuple[Input, ...]
    tree: ast.expr | None = None


@dataclass(frozen=True)
class Scope:
    """All names in scope.

    Attributes:
        inputs: by key; a row with one input has it under `value` too.
        order: the inputs' names in order, as the evaluator's arguments are.
    """

    inputs: Mapping[str, Input]
    order: tuple[str, ...]
    helpers: Mapping[str, HelperDef] = field(default_factory=dict)
    functions: Registry[Function] = field(default_factory=library)
    constants: Mapping[str, Value] = field(default_factory=lambda: {"pi": math.pi, "e": math.e})

    def known(self) -> list[str]:
        """All names that are not functions, for proposing the nearest."""
        return [i.name for i in self.inputs.values()] + [h.shown for h in self.helpers.values()] + list(self.constants)


def make_scope(
    inputs: Iterable[tuple[str, RecordType | None]],
    helpers: Mapping[str, HelperDef] | None = None,
    functions: Registry[Function] | None = None,
) -> Scope:
    """The scope of a row with these input streams (name, record type if known).

    An input without a name (an anonymous stream) is reached as `value`.

    Raises:
        FormulaProblem: FORM009 when two inputs have one name.
    """
    found: dict[str, Input] = {}
    order: list[str] = []
    inputs = list(inputs)
    for shown, record in inputs:
        name = argument_name(shown) or "value"
        k = key(name)
        if k in found:
            raise FormulaProblem("FORM009", first=found[k].shown or name, second=shown or name, name=name)
        found[k] = Input(shown, name, record)
        order.append(name)
    if len(inputs) == 1:
        found.setdefault("value", found[key(order[0])])
    return Scope(found, tuple(order), helpers or {}, functions or library())
