"""A formula: from its text to something that can be evaluated."""

from __future__ import annotations

import ast
import copy
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rrp_sheets.formulas.problems import FormulaProblem
from rrp_sheets.formulas.scope import Scope
from rrp_sheets.formulas.spelling import to_python
from rrp_sheets.formulas.syntax import parse
from rrp_sheets.formulas.tree import resolve
from rrp_sheets.model.values import Value

if TYPE_CHECKING:
    from rrp_sheets.formulas.evaluator import GuardedInterpreter
    from rrp_sheets.formulas.pick import Picker


@dataclass(frozen=True)
class Formula:
    """A checked formula.

    Attributes:
        text: as typed.
        tree: resolved; shared, so it is copied before an interpreter binds it.
        names: the inputs' names in order.
    """

    text: str
    tree: ast.expr
    names: tuple[str, ...]

    def prepare(self, interpreter: GuardedInterpreter, picker: Picker | None = None) -> Callable[..., Value]:
        """A callable from the inputs' values to the value, or to a Failure, on this interpreter (and its thread).

        Args:
            interpreter: one per thread.
            picker: what PICK draws with; without one it takes the first, as `check` does.
        """
        return interpreter.prepare(copy.deepcopy(self.tree), self.names, picker)


def compile_formula(text: str, scope: Scope) -> Formula:
    """Parse and check a formula; raises FormulaProblem when it is refused.

    >>> from rrp_sheets.formulas import make_scope
    >>> from rrp_sheets.formulas.evaluator import GuardedInterpreter
    >>> formula = compile_formula("=distance * 2 if distance < 1 else 0", make_scope([("Distance", None)]))
    >>> formula.prepare(GuardedInterpreter())(0.25)
    0.5
    """
    source = to_python(text)
    try:
        tree = parse(source)
    except FormulaProblem as problem:
        spaced = next(
            (i for i in scope.inputs.values() if " " in i.shown and i.shown.casefold() in text.casefold()), None
        )
        if spaced is not None and problem.code == "FORM001":
            problem.details["remedy"] = f"Write {spaced.name} for “{spaced.shown}”."
        raise
    try:
        return Formula(text, resolve(tree, scope, source), scope.order)
    except FormulaProblem as problem:
        if problem.column > 0:  # Python counts bytes, people count letters
            problem.column = len(source.encode()[: problem.column].decode(errors="ignore"))
        raise
