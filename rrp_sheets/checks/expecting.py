"""Reads the Expect cell of a test row: a value, a condition, values of fields, `any` or `nothing`."""

from __future__ import annotations

import ast
import re
from collections.abc import Callable
from dataclasses import dataclass
from decimal import Decimal, InvalidOperation

from rrp_sheets.checks.parts import TooLarge, compiled, fields, in_quotes, literal, without_equals
from rrp_sheets.checks.sending import Given, known_fields, tell_formula
from rrp_sheets.diagnostics import Report
from rrp_sheets.formulas import Formula, FormulaProblem, Scope
from rrp_sheets.model.cells import Cell
from rrp_sheets.model.names import key
from rrp_sheets.model.values import RecordType, Value

_OPERATOR = re.compile(r"(>=|<=|<>|!=|==|>|<|≥|≤|≠|＞|＜)\s*(?P<rest>.*)", re.DOTALL)
_SURELY = re.compile(r"(?<![\w.\"'])value\s*(\.\w|\[|>|<|!=|=|≥|≤|≠)", re.IGNORECASE)
_BEGINS = re.compile(r"(?P<name>[^\W\d]\w*)\s*(<|>|!=|=|≥|≤|≠)")
_WORD = re.compile(r"[^\W\d]\w*")
_NO_CONDITION = ("Name", "Constant", "Attribute", "Subscript", "BinOp", "Join", "List", "Tuple", "JoinedStr")
"""Nodes of a formula's tree that are rather part of a text than a question about the value."""
_ABOUT = re.compile(r"[≈~≃≅]\s*(?P<number>[^±]*?)\s*(?:±\s*(?P<within>.*))?", re.DOTALL)
_PAIRS = {"≥": ">=", "≤": "<=", "≠": "<>", "==": "=", "！=": "!="}


@dataclass(frozen=True)
class Expectation:
    """The meaning of a test row's Expect cell.

    Attributes:
        kind: `any`, `nothing`, `value`, `about` (a number within a distance), `condition`, or `fields`.
        text: as the cell says it.
        value: of kind `value` (a formula without inputs is worked out first), and the number of kind `about`.
        quoted: whether a text was in quotes, so that spaces at its ends count.
        within: how far a number may be away, for kind `about`.
        condition: a formula with the stream's value as its one input.
        fields: expectations by the name of a record's field.
        blanks: of kind `nothing`, whether blanks may come: they stop an actuator and start nothing.
    """

    kind: str
    text: str
    value: Given = None
    quoted: bool = False
    within: float = 0.0
    condition: Formula | None = None
    fields: tuple[tuple[str, Expectation], ...] = ()
    blanks: bool = False


@dataclass(frozen=True)
class Place:
    """The stream on which a test row expects something: its names, its record type, and the scopes of formulas.

    Attributes:
        names: keys of the names that its value has in conditions.
        record: of its values, where it is known.
        with_value: the scope of a condition.
        alone: the scope of a formula without inputs.
    """

    names: frozenset[str]
    record: RecordType | None
    with_value: Callable[[], Scope]
    alone: Scope


def read_expect(cell: Cell, place: Place, report: Report) -> Expectation | None:
    """Return the meaning of an Expect cell; None when it is refused, which is reported."""
    text = cell.text
    if key(text) in ("any", "nothing"):
        return Expectation(key(text), text)
    if key(text) in ("nothingorblank", "blankornothing"):
        return Expectation("nothing", text, blanks=True)
    try:
        return _condition(cell, place, report) or _other(cell, place, report)
    except TooLarge as error:
        report.add("TEST014", cell.address, text=str(error))
    except _RefusedError:
        pass
    return None


class _RefusedError(Exception):
    """Raised for a cell that cannot be understood, after that has been reported."""


def _condition(cell: Cell, place: Place, report: Report) -> Expectation | None:
    """Return the condition of a cell: `>0.5`, or a formula over `value` or the stream's name; None for other cells."""
    text = cell.text
    operator = _OPERATOR.fullmatch(text)
    if operator:
        sign = _PAIRS.get(operator[1], operator[1])
        return _over_value(cell, f"value {sign} {operator['rest']}", place, report)
    if in_quotes(text) is not None or not any(key(m[0]) in place.names for m in _WORD.finditer(text)):
        return None
    if _is_fields(text, place):
        return None
    begins = _BEGINS.match(text)
    if _SURELY.search(text) or (begins and key(begins["name"]) in place.names):
        return _over_value(cell, text, place, report)
    formula = compiled(text, place.with_value())
    if isinstance(formula, Formula) and type(formula.tree).__name__ not in _NO_CONDITION:
        return Expectation("condition", text, condition=formula)
    return None


def _is_fields(text: str, place: Place) -> bool:
    """Return whether a text gives values to fields, as `value=1; completed=FALSE` does, and is no condition."""
    parts = fields(text)
    if parts is None:
        return False
    if place.record is None:
        return not any(key(name) in place.names for name, _ in parts)
    return all(key(name) in place.record.keys for name, _ in parts)


def _over_value(cell: Cell, text: str, place: Place, report: Report) -> Expectation:
    formula = compiled(text, place.with_value())
    if isinstance(formula, FormulaProblem):
        tell_formula(report, "TEST009", cell, formula)
        raise _RefusedError
    return Expectation("condition", cell.text, condition=formula)


def _other(cell: Cell, place: Place, report: Report) -> Expectation:
    about = _ABOUT.fullmatch(cell.text)
    if about:
        return _about(cell, about["number"], about["within"], report)
    parts = fields(cell.text)
    if parts is not None and (place.record is not None or len(parts) > 1 or not _sentence(parts)):
        return _fields(cell, parts, place, report)
    return _value(cell.text, place)


def _sentence(parts: list[tuple[str, str]]) -> bool:
    """Return whether `a b c d = e` is rather a text than a field: its name has more than three words."""
    return any(len(name.split()) > 3 for name, _ in parts)


def _fields(cell: Cell, parts: list[tuple[str, str]], place: Place, report: Report) -> Expectation:
    if not known_fields(cell, [name for name, _ in parts], place.record, report):
        raise _RefusedError
    expected = []
    for name, text in parts:
        about = _ABOUT.fullmatch(text)
        one = _about(cell, about["number"], about["within"], report) if about else _value(text, place)
        expected.append((name, Expectation("any", text) if key(text) == "any" else one))
    return Expectation("fields", cell.text, fields=tuple(expected))


def _about(cell: Cell, number: str, within: str | None, report: Report) -> Expectation:
    try:
        about = Decimal(number.replace("−", "-").replace("．", "."))
        distance = half_of_last_digit(about) if within is None else Decimal(within)
        if not (about.is_finite() and distance.is_finite() and distance >= 0 and abs(about) < Decimal(10) ** 15):
            raise InvalidOperation
    except InvalidOperation:
        report.add("TEST010", cell.address, text=cell.text)
        raise _RefusedError from None
    return Expectation("about", cell.text, float(about), within=float(distance))


def half_of_last_digit(number: Decimal) -> Decimal:
    """Return half a unit of the last written digit: numbers that are nearer are rounded to the written one.

    >>> [str(half_of_last_digit(Decimal(n))) for n in ("0.5", "0.50", "20")]
    ['0.05', '0.005', '0.5']
    """
    exponent = number.as_tuple().exponent
    return Decimal(5).scaleb(int(exponent) - 1) if isinstance(exponent, int) else Decimal(0)


def _value(text: str, place: Place) -> Expectation:
    """Return the expected value: a literal, a formula that is more than a word, or else the text itself."""
    short = without_equals(text.strip())
    found, value = literal(short)
    if found:
        return Expectation("value", text, value, quoted=isinstance(value, str))
    if short[:1] in "[(\"'" or short.endswith(")"):
        formula = compiled(short, place.alone)
        if isinstance(formula, Formula) and not isinstance(formula.tree, (ast.Name, ast.Constant)):
            return Expectation("value", text, formula)
    return Expectation("value", text, short)


__all__ = ["Expectation", "Place", "Value", "read_expect"]
