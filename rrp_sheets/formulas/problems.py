"""Problems of formulas, found while these are read or evaluated, and the user's words for kinds of values."""

from __future__ import annotations

from collections.abc import Iterable

from rrp_sheets.diagnostics import CODES
from rrp_sheets.formulas.tables import Table
from rrp_sheets.model.values import Failure, Record, Value
from rrp_sheets.texts import N_


class FormulaProblem(Exception):
    """A problem in a formula: a code of the catalogue, the details for its texts, and its place.

    It never leaves this package as an exception at run time: the evaluator turns it into a Failure.

    Attributes:
        others: what else is wrong with the formula, independently of this.
        written: what to write at its place instead, where the remedy leaves no choice; empty otherwise.
    """

    def __init__(self, code: str, column: int = -1, length: int = 1, **details: object) -> None:
        super().__init__(code)
        self.code = code
        self.column = column
        self.length = length
        self.details = details
        self.others: tuple[FormulaProblem, ...] = ()
        self.written = ""

    @property
    def every(self) -> tuple[FormulaProblem, ...]:
        """This problem and the `others` of the same formula, in the order of their places."""
        return (self, *self.others)

    def advise(self, remedy: str, guess: str | None = None) -> None:
        """Set another remedy; `guess` is the name that it proposes, if it proposes one."""
        self.written = ""
        for name in ("guess", "example", "quotes"):
            self.details.pop(name, None)
        self.details |= {"remedy": remedy, "guess": guess} if guess else {"remedy": remedy}

    @property
    def message(self) -> str:
        """Description of the problem in the user's words."""
        return CODES[self.code].text("message", self.details)

    @property
    def remedy(self) -> str:
        """Advice for correcting the formula."""
        return CODES[self.code].text("remedy", self.details)

    def failure(self, column: int = -1) -> Failure:
        """Return the problem as a value."""
        return Failure(self.code, self.message, self.column if self.column >= 0 else column)


KINDS = {
    "blank": N_("blank"), "truth": N_("TRUE or FALSE"), "number": N_("a number"), "text": N_("a text"),
    "list": N_("a list"), "table": N_("a whole table"), "record": N_("a whole record"),
}  # fmt: skip
"""The user's words for the kinds of values."""


def kind_of_value(value: Value) -> str:
    """Return the kind of a value, a key of `KINDS`, or `any` when it is of none.

    >>> kind_of_value(2), kind_of_value(True), kind_of_value(None)
    ('number', 'truth', 'blank')
    """
    if value is None:
        return "blank"
    if isinstance(value, bool):
        return "truth"
    if isinstance(value, (int, float)):
        return "number"
    if isinstance(value, str):
        return "text"
    if isinstance(value, (list, tuple)):
        return "list"
    return "record" if isinstance(value, Record) else "table" if isinstance(value, Table) else "any"


def kind_of(value: Value) -> str:
    """Return the kind of a value in the user's words.

    >>> kind_of("hi"), kind_of(2), kind_of(None), kind_of([])
    ('a text', 'a number', 'blank', 'a list')
    """
    return KINDS.get(kind_of_value(value), KINDS["record"])


def wrong_kind(needed: str, value: Value) -> FormulaProblem:
    """Return the problem that `value` is not `needed` (“a number”)."""
    if value is None:
        return FormulaProblem("FORM102", needed=needed)
    what = N_("This needs {needed}, but gets {kind}", needed=needed, kind=kind_of(value))
    return FormulaProblem("FORM103", what=what)


_COMPARISONS = N_("{before} or {after}", before="=", after="<")


def no_condition(value: Value) -> FormulaProblem:
    """Return the problem that `value` is neither TRUE or FALSE nor a number."""
    return FormulaProblem("FORM108", what=kind_of(value), example=_COMPARISONS)


_MOST_TOLD = 10  # problems of one formula


def together(found: Iterable[FormulaProblem]) -> FormulaProblem:
    """Return the first of a formula's problems, with the others; problems with one name count once."""
    known: dict[tuple[object, ...], FormulaProblem] = {}
    for problem in sorted(found, key=lambda p: p.column):
        unknown = problem.details.get("name") if problem.code in ("FORM003", "FORM004", "FORM005") else None
        known.setdefault((problem.code, str(unknown) if unknown else problem.column), problem)
    first, *others = list(known.values())[:_MOST_TOLD]
    first.others = tuple(others)
    return first


def problem_of(error: Exception) -> FormulaProblem | None:
    """Return the problem that an exception of an evaluation stands for; None when the program itself is broken."""
    if isinstance(error, FormulaProblem):
        return error
    if isinstance(error, ZeroDivisionError):
        return FormulaProblem("FORM101")
    if isinstance(error, RecursionError):
        return FormulaProblem("FORM105", reason=N_("it is nested too deeply"))
    if isinstance(error, (OverflowError, MemoryError)):
        return FormulaProblem("FORM105", reason=N_("numbers go up to 1e15"))
    if isinstance(error, (TypeError, ValueError, ArithmeticError, LookupError, AttributeError)):
        # a mistake of ours in a library function: the session goes on, and the tests hold that it never happens
        return FormulaProblem("FORM109")
    return None
