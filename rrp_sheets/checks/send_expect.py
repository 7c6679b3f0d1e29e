"""Reads the cells Send and Expect of a test row: values, conditions, formulas, fields, `any` and `nothing`."""

from __future__ import annotations

import ast
import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from decimal import Decimal, InvalidOperation

from rrp_sheets.checks.facts import ANY, TEXT
from rrp_sheets.diagnostics import Report
from rrp_sheets.diagnostics.report import meant
from rrp_sheets.formulas import Formula, FormulaProblem, Scope, compile_formula
from rrp_sheets.formulas.limits import LARGEST_NUMBER
from rrp_sheets.model.names import key, nearest
from rrp_sheets.model.values import RecordType, Value
from rrp_sheets.model.workbook import Cell
from rrp_sheets.texts import N_, sentences, small

_NUMBER = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)(e[+-]?\d+)?", re.IGNORECASE | re.ASCII)
_WORDS: dict[str, Value] = {"true": True, "false": False, "blank": None}
_QUOTES = {'"': '"', "'": "'", "“": "”", "„": "“"}
_FIELD = re.compile(r"\s*(?P<name>[^\W\d][\w \-]*?)\s*=(?!=)\s*(?P<value>.*?)\s*", re.DOTALL)
_OPEN, _CLOSE = "([{", ")]}"
_MINUS = str.maketrans("−–", "--")
Given = Formula | Value
"""Source of a value: a formula without inputs, evaluated when it is sent, or the value itself."""
_OPERATOR = re.compile(r"(>=|<=|<>|!=|==|>|<|≥|≤|≠|＞|＜)\s*(?P<rest>.*)", re.DOTALL)
_SURELY = re.compile(r"(?<![\w.\"'])value\s*(\.\w|\[|>|<|!=|=|≥|≤|≠)", re.IGNORECASE)
_BEGINS = re.compile(r"(?P<name>[^\W\d]\w*)\s*(<|>|!=|=|≥|≤|≠)")
_WORD = re.compile(r"[^\W\d]\w*")
_NO_CONDITION = ("Name", "Constant", "Attribute", "Subscript", "BinOp", "Join", "List", "Tuple", "JoinedStr")
"""Nodes of a formula's tree that are rather part of a text than a question about the value."""
_ABOUT = re.compile(r"[≈~≃≅]\s*(?P<number>[^±]*?)\s*(?:±\s*(?P<within>.*))?", re.DOTALL)
_PAIRS = {"≥": ">=", "≤": "<=", "≠": "<>", "==": "=", "！=": "!="}


class TooLarge(ValueError):
    """Raised for a number beyond those that formulas work with."""


def literal(text: str) -> tuple[bool, Value]:
    """Return whether a text is a number, TRUE, FALSE, blank or a text in quotes, and its value; raises TooLarge.

    >>> literal("0.5"), literal('"Head"'), literal("true"), literal("Hello")
    ((True, 0.5), (True, 'Head'), (True, True), (False, None))
    """
    short = text.strip()
    if short.casefold() in _WORDS:
        return True, _WORDS[short.casefold()]
    digits = short.translate(_MINUS)
    if _NUMBER.fullmatch(digits):
        if abs(float(digits)) > LARGEST_NUMBER:
            raise TooLarge(digits)
        return True, float(digits) if any(c in digits for c in ".eE") else int(digits)
    quoted = in_quotes(short)
    return quoted is not None, quoted


def in_quotes(text: str) -> str | None:
    """Return the text between quotes, or None when it is not one text in quotes; a quote within it is written twice.

    >>> in_quotes('"Hello"'), in_quotes('"a ""b"" c"'), in_quotes('"a" & "b"')
    ('Hello', 'a "b" c', None)
    """
    closer = _QUOTES.get(text[:1], "")
    if not closer or len(text) < 2 or text[-1] not in (closer, text[0]):
        return None
    inner = text[1:-1]
    for quote in {text[0], closer}:
        inner = inner.replace(quote * 2, "\0") if quote in "\"'" else inner
        if quote in inner:
            return None
    return None if "\\" in inner else inner.replace("\0", text[0])


def fields(text: str) -> list[tuple[str, str]] | None:
    """Return the fields that a text gives values, or None when not every part of it is `field=value`.

    Parts are separated by `;` (or line breaks), or by commas where that is the only reading.

    >>> fields('x=0.1; zone="a;b"'), fields("x=1, y=[1, 2]"), fields("x == 1"), fields("Hello")
    ([('x', '0.1'), ('zone', '"a;b"')], [('x', '1'), ('y', '[1, 2]')], None, None)
    """
    if "=" not in text:
        return None
    for separators in (";\n,", ";\n"):
        found = [_FIELD.fullmatch(p) for p in _split(text, separators) if p.strip()]
        if found and all(found):
            return [(m["name"], m["value"]) for m in found if m]
    return None


def _split(text: str, separators: str) -> list[str]:
    """Return the parts between separators that stand outside of quotes and brackets."""
    parts, start, depth, quote = [], 0, 0, ""
    for i, c in enumerate(text):
        if quote:
            quote = "" if c == quote else quote
        elif c in _QUOTES and not (c == "'" and i and text[i - 1].isalnum()):
            quote = _QUOTES[c]
        elif c in _OPEN:
            depth += 1
        elif c in _CLOSE:
            depth = max(0, depth - 1)
        elif c in separators and not depth:
            parts.append(text[start:i])
            start = i + 1
    return [*parts, text[start:]]


def without_equals(text: str) -> str:
    """Return the text without the `=` that people write before formulas by habit.

    >>> without_equals("= 5"), without_equals("== 5")
    ('5', '== 5')
    """
    return text[1:].lstrip() if text.startswith("=") and not text.startswith("==") else text


def compiled(text: str, scope: Scope) -> Formula | FormulaProblem:
    """Return the formula, or the problem with it."""
    try:
        return compile_formula(text, scope)
    except FormulaProblem as problem:
        return problem


@dataclass(frozen=True)
class Sending:
    """The meaning of a test row's Send cell: `value` when it is `whole`, else the example values but for `fields`."""

    text: str
    value: Given = None
    fields: tuple[tuple[str, Given], ...] = ()
    whole: bool = False


def read_send(cell: Cell, record: RecordType | None, scope: Scope, report: Report) -> Sending | None:
    """Return the meaning of a Send cell; None when it is refused, which is reported.

    `scope` is that of a formula without inputs.
    """
    text = without_equals(cell.text)
    try:
        found, value = literal(text)
        if found:
            if record is not None and value is not None:
                names = [f.name for f in record.fields]
                every, example = ", ".join(names), names[0]
                report.add("TEST015", cell.address, text=cell.text, record=record.name, fields=every, example=example)
            return Sending(cell.text, value, whole=True)
        parts = fields(text)
        if parts is not None:
            return _sent_fields(cell, parts, record, scope, report)
    except TooLarge as error:
        report.add("TEST014", cell.address, text=str(error))
        return None
    formula = compiled(text, scope)
    if isinstance(formula, FormulaProblem):
        tell_formula(report, "TEST007", cell, formula)
        return None
    return Sending(cell.text, formula, whole=True)


def _sent_fields(
    cell: Cell, parts: list[tuple[str, str]], record: RecordType | None, scope: Scope, report: Report
) -> Sending | None:
    if not known_fields(cell, [name for name, _ in parts], record, report):
        return None
    given: list[tuple[str, Given]] = []
    for name, text in parts:
        found, value = literal(text)
        if not found:
            formula = compiled(text, scope)
            if isinstance(formula, Formula):
                value = formula
            elif _is_text(name, record):
                value = text  # zone=Left hand
            else:
                tell_formula(report, "TEST007", cell, formula)
                return None
        given.append((name, record.standard(name, value) if record else value))
    return Sending(cell.text, fields=tuple(given))


def known_fields(cell: Cell, names: list[str], record: RecordType | None, report: Report) -> bool:
    """Return whether a record has all these fields, each named once; problems are reported."""
    seen: set[str] = set()
    for name in names:
        k = record.keys.get(key(name)) if record else key(name)
        if k is None and record is not None:
            every = [f.name for f in record.fields]
            remedy = meant(nearest(name, every), N_("Its fields are: {every}.", every=", ".join(every)))
            report.add("TEST008", cell.address, record=record.name, field=name, **remedy)
            return False
        if k in seen:
            report.add("TEST013", cell.address, field=name)
            return False
        seen.add(k or "")
    return True


def _is_text(name: str, record: RecordType | None) -> bool:
    found = record.field(name) if record else None
    return found is None or found.kind in (TEXT, ANY)


def tell_formula(report: Report, code: str, cell: Cell, problem: FormulaProblem) -> None:
    """Report a formula's problem at a test's cell."""
    why, remedy = small(problem.message), problem.remedy
    if code == "TEST007" and problem.code == "FORM004":
        name = problem.details.get("name", "")
        why = N_("“{name}” is not a number, a text in quotes, a helper or a table.", name=name)
        remedy = N_('Put a text in quotes: "{name}". Write fields of a record as field=value.', name=name)
    elif code == "TEST007" and problem.code == "FORM001" and "quotes" not in problem.details:
        remedy = sentences(remedy, N_('Put a text to send in quotes: "Hello".'))
    report.add(code, cell.address, text=cell.text, why=why, remedy=remedy)


@dataclass(frozen=True)
class Expectation:
    """The meaning of a test row's Expect cell."""

    kind: str  # `any`, `nothing`, `value`, `about` (a number within a distance), `condition`, or `fields`
    text: str
    # of kind `value` (a formula without inputs is worked out first), and the number of kind `about`
    value: Given = None
    quoted: bool = False  # whether a text was in quotes, so that spaces at its ends count
    within: float = 0.0  # of kind `about`, how far a number may be away
    condition: Formula | None = None  # a formula with the stream's value as its one input
    fields: tuple[tuple[str, Expectation], ...] = ()
    blanks: bool = False  # of kind `nothing`, whether blanks may come: they stop an actuator and start nothing


@dataclass(frozen=True)
class Place:
    """The stream on which a test row expects something."""

    names: frozenset[str]  # keys of the names that its value has in conditions
    record: RecordType | None
    with_value: Callable[[], Scope]  # makes the scope of a condition
    alone: Scope  # the scope of a formula without inputs


def read_expect(cell: Cell, place: Place, report: Report) -> Expectation | None:
    """Return the meaning of an Expect cell; None when it is refused, which is reported."""
    text = cell.text
    if key(text) in ("any", "nothing"):
        return Expectation(key(text), text)
    if key(text) in ("nothingorblank", "blankornothing"):
        return Expectation("nothing", text, blanks=True)
    try:
        return _condition(cell, place, report) or _other(cell, place, report)
    except _RefusedError:
        return None
    except TooLarge as error:
        report.add("TEST014", cell.address, text=str(error))
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
    named = any(key(m[0]) in place.names for m in _WORD.finditer(text))
    if not named or in_quotes(text) is not None or _is_fields(text, place):
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
    parts = None if _ABOUT.fullmatch(cell.text) else fields(cell.text)
    # `a b c d = e` is rather a text than a field: a name of more than three words
    if parts is None or (place.record is None and len(parts) == 1 and len(parts[0][0].split()) > 3):
        return _one(cell.text, cell, place, report)
    if not known_fields(cell, [name for name, _ in parts], place.record, report):
        raise _RefusedError
    expected = []
    for name, text in parts:
        one = _one(text, cell, place, report)
        one = replace(one, value=place.record.standard(name, one.value)) if place.record else one
        expected.append((name, Expectation("any", text) if key(text) == "any" else one))
    return Expectation("fields", cell.text, fields=tuple(expected))


def _one(text: str, cell: Cell, place: Place, report: Report) -> Expectation:
    """Return the meaning of a text that expects one value: the cell's, or that of a field in it."""
    if number := _ABOUT.fullmatch(text):
        try:
            about = Decimal(number["number"].replace("−", "-").replace("．", "."))
            distance = half_of_last_digit(about) if number["within"] is None else Decimal(number["within"])
            if not (about.is_finite() and distance.is_finite() and distance >= 0 and abs(about) < Decimal(10) ** 15):
                raise InvalidOperation
        except InvalidOperation:
            report.add("TEST010", cell.address, text=cell.text)
            raise _RefusedError from None
        return Expectation("about", cell.text, float(about), within=float(distance))
    short = without_equals(text.strip())
    found, value = literal(short)
    if found:
        return Expectation("value", text, value, quoted=isinstance(value, str))
    if short[:1] in "[(\"'" or short.endswith(")"):
        formula = compiled(short, place.alone)
        if isinstance(formula, Formula) and not isinstance(formula.tree, (ast.Name, ast.Constant)):
            return Expectation("value", text, formula)
    return Expectation("value", text, short)  # the text itself


def half_of_last_digit(number: Decimal) -> Decimal:
    """Return half a unit of the last written digit: numbers that are nearer are rounded to the written one.

    >>> [str(half_of_last_digit(Decimal(n))) for n in ("0.5", "0.50", "20")]
    ['0.05', '0.005', '0.5']
    """
    exponent = number.as_tuple().exponent
    return Decimal(5).scaleb(int(exponent) - 1) if isinstance(exponent, int) else Decimal(0)
