"""A compiled formula, and its compilation from text."""

from __future__ import annotations

import ast
import unicodedata
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rrp_sheets.formulas.hints import if_example, instead_of_cell, refuse_setting
from rrp_sheets.formulas.limits import LONGEST_FORMULA
from rrp_sheets.formulas.parsing import parse, parse_all
from rrp_sheets.formulas.problems import FormulaProblem
from rrp_sheets.formulas.scope import Scope
from rrp_sheets.formulas.tokens import tokenize
from rrp_sheets.formulas.tree import resolve
from rrp_sheets.model.names import argument_name, key
from rrp_sheets.model.values import Value
from rrp_sheets.texts import N_

if TYPE_CHECKING:
    from rrp_sheets.formulas.evaluator import GuardedInterpreter
    from rrp_sheets.formulas.operations import Picker


@dataclass(frozen=True)
class Formula:
    """A checked formula, ready to be prepared for an interpreter.

    Attributes:
        tree: resolved; its columns are places in the text.
        names: of what the evaluator is given, in order: what the connector adds, then the inputs.
    """

    text: str
    tree: ast.expr
    names: tuple[str, ...]

    @property
    def used(self) -> frozenset[str]:
        """The `names` that occur in the tree."""
        return frozenset(n.id for n in ast.walk(self.tree) if isinstance(n, ast.Name)).intersection(self.names)

    def prepare(self, interpreter: GuardedInterpreter, picker: Picker | None = None) -> Callable[..., Value]:
        """Return a callable from the inputs' values to the value or a Failure, for this interpreter and its thread.

        Without a picker PICK takes the first, as `check` does.
        """
        return interpreter.prepare(self.tree, self.names, picker)


def compile_formula(text: str, scope: Scope, *, condition: bool = True) -> Formula:
    """Parse and check a formula, in a spreadsheet's spelling or in Python's.

    Where no `condition` is wanted, `x = 1` is refused: it compares in a spreadsheet and sets in Python.

    Raises:
        FormulaProblem: when it is refused; its column and length are in the text as typed.

    >>> from rrp_sheets.formulas import make_scope
    >>> from rrp_sheets.formulas.evaluator import GuardedInterpreter
    >>> scope = make_scope([("Distance", None)])
    >>> formula = compile_formula("=IF(distance < 1; distance * 2; 0)", scope)
    >>> formula.prepare(GuardedInterpreter())(0.25)
    0.5
    >>> compile_formula("distance * 2 if distance < 1 else 0", scope).prepare(GuardedInterpreter())(0.25)
    0.5
    """
    _check_characters(text)
    try:
        tree, problems = parse_all(tokenize(text, lambda name: scope.table(name) is not None), text)
        if not condition and not problems:
            refuse_setting(tree, text)
        return Formula(text, resolve(tree, scope, text, problems), scope.order)
    except FormulaProblem as problem:
        for one in problem.every:
            _propose_name(one, text, scope)
        raise
    except RecursionError:  # whoever calls from deep within another program has less room for brackets
        raise FormulaProblem("FORM002", 0, reason=N_("it is nested too deeply")) from None


def read_formula(text: str) -> ast.expr:
    """Return the tree of a formula as it is typed, with names and calls unresolved; raises FormulaProblem.

    >>> ast.unparse(read_formula("=IF(a <> 1; x^2; 50%)"))
    'IF(a != 1, x ** 2, 0.5)'
    """
    _check_characters(text)
    try:
        return parse(tokenize(text), text)
    except RecursionError:
        raise FormulaProblem("FORM002", 0, reason=N_("it is nested too deeply")) from None


def _check_characters(text: str) -> None:
    if len(text.strip()) > LONGEST_FORMULA:
        reason = N_("it has more than {most} characters", most=LONGEST_FORMULA)
        raise FormulaProblem("FORM002", LONGEST_FORMULA, reason=reason)
    if text.isprintable():
        return
    for i, c in enumerate(text):
        if unicodedata.category(c) in ("Cc", "Cs") and c not in "\n\r\t":
            raise FormulaProblem("FORM001", i, reason=N_("it contains an invisible character"),
                                 remedy=N_("Type the formula again."))  # fmt: skip


def _name_of_number(scope: Scope) -> str:
    """Return the name of an input that is a number, or of a field that is one; empty when there is none."""
    for one in scope.inputs.values():
        field = next((f for f in one.record.fields if f.kind == "number"), None) if one.record else None
        if field or (one.record is None and one.kind in ("", "number")):
            return f"{one.name}.{argument_name(field.name)}" if field else one.name
    return ""


def _propose_name(problem: FormulaProblem, text: str, scope: Scope) -> None:
    """Set the remedy where a stream's or table's name is spelt as in the sheet, with a space for instance."""
    names = list(dict.fromkeys(i.name for i in scope.inputs.values()))
    if names and "example" in problem.details and problem.code in ("FORM001", "FORM018"):
        problem.advise(
            instead_of_cell(names) if problem.code == "FORM018" else if_example(_name_of_number(scope) or names[0])
        )
    if problem.code not in ("FORM001", "FORM003"):
        return
    lower = text.casefold()
    at = text[problem.column : problem.column + problem.length].casefold() if problem.column >= 0 else ""
    for shown in [*(i.shown for i in scope.inputs.values()), *(t.name for t in scope.tables.values())]:
        folded = shown.casefold()
        word_of_python = at and folded == at and key(argument_name(shown)) != key(shown)  # class
        with_spaces = shown and folded in lower and key(shown) != folded
        with_digit = shown[:1].isdigit() and key(shown) in key(text)
        if word_of_python or (problem.code != "FORM003" and (with_spaces or with_digit)):
            problem.advise(N_("Write {name} for “{shown}”.", name=argument_name(shown), shown=shown))
            return
