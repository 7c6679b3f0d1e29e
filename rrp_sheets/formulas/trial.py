"""Evaluation of a single formula with inputs from outside: JSON, or typed text."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from rrp_sheets.diagnostics import CODES
from rrp_sheets.formulas.evaluator import GuardedInterpreter
from rrp_sheets.formulas.formula import compile_formula
from rrp_sheets.formulas.limits import LARGEST_NUMBER, LONGEST_LIST, LONGEST_TEXT, MOST_LEAVES
from rrp_sheets.formulas.problems import FormulaProblem
from rrp_sheets.formulas.scope import make_scope
from rrp_sheets.formulas.tables import value_of
from rrp_sheets.model.names import key
from rrp_sheets.model.values import Failure, Record, Value, record_from_mapping, to_json
from rrp_sheets.texts import N_

_MOST_INPUTS = 50
_DEEPEST = 8  # objects and lists within each other
_KINDS = {bool: "truth", int: "number", float: "number", str: "text"}


@dataclass(frozen=True)
class Answer:
    """Result of the trial of a formula.

    Attributes:
        outcome: `ok`; `rejected` before it was evaluated; or `error`, found by evaluating it.
        guess: a known name near one that is not known.
        column, length: the place in the formula as typed, counted from 0; -1 when it has none.
        others: what else is wrong with it.
    """

    outcome: str
    value: Value = None
    code: str = ""
    message: str = ""
    remedy: str = ""
    column: int = -1
    length: int = 1
    others: tuple[Answer, ...] = ()
    guess: str = ""

    def as_dict(self) -> dict[str, Any]:
        """Return the answer as `formula --json` prints it."""
        if self.outcome == "ok":
            return {"outcome": "ok", "value": to_json(self.value)}
        told = {"outcome": self.outcome, "code": self.code, "message": self.message, "column": self.column}
        return {**told, "others": [other.as_dict() for other in self.others]} if self.others else told


def try_formula(text: str, inputs: Mapping[str, Any], interpreter: GuardedInterpreter | None = None) -> Answer:
    """Evaluate a formula once. Inputs are values of JSON; an object becomes a record with its keys as fields.

    >>> try_formula("IF(ball.distance > 3; 1; 0)", {"ball": {"distance": 5}}).value
    1
    >>> try_formula("1 / x", {"x": 0}).code, try_formula("x +", {"x": 1}).outcome
    ('FORM101', 'rejected')
    """
    try:
        if len(inputs) > _MOST_INPUTS:
            raise FormulaProblem("FORM022", reason=N_("there are more than {most} inputs", most=_MOST_INPUTS))
        left = [MOST_LEAVES]
        values = {name: _value(value, name, left, 0) for name, value in inputs.items()}
        kinds = {name: _KINDS.get(type(v), "") for name, v in values.items()}
        scope = make_scope([(n, v.type if isinstance(v, Record) else None) for n, v in values.items()], kinds=kinds)
        evaluate = compile_formula(text, scope, condition=False).prepare(interpreter or GuardedInterpreter())
    except FormulaProblem as problem:
        return _rejected(problem)
    result = evaluate(*values.values())
    if isinstance(result, Failure):
        return Answer("error", None, result.code, result.message, CODES[result.code].constant_remedy, result.column)
    return Answer("ok", result)


def answer_line(line: str, interpreter: GuardedInterpreter | None = None) -> Answer:
    """Return the answer to `{"formula": …, "inputs": {…}}`; any other line is rejected with the reason.

    >>> answer_line('{"formula": "x & 1", "inputs": {"x": "a"}}').value, answer_line("{").code
    ('a1', 'FORM022')
    """
    try:
        request = json.loads(line, parse_constant=_no_constant)
    except ValueError as error:
        return _no_request(error.args[0] if type(error) is ValueError else N_("it is not JSON"))
    except RecursionError:
        return _no_request(N_("it is nested too deeply"))
    if not isinstance(request, dict) or not isinstance(request.get("formula"), str):
        return _no_request(N_('it is not an object with a text as its "formula"'))
    inputs = request.get("inputs", {})
    if not isinstance(inputs, dict):
        return _no_request(N_('its "inputs" are not an object'))
    return try_formula(request["formula"], inputs, interpreter)


def typed_value(text: str) -> Any:
    """Return the value that was typed for an input: JSON, or what a cell of a table would be.

    >>> typed_value("2.5"), typed_value("red"), typed_value('{"x": 1}'), typed_value("TRUE"), typed_value("[1, 2]")
    (2.5, 'red', {'x': 1}, True, [1, 2])
    """
    if text[:1] in ("{", "[", '"'):
        try:
            return json.loads(text, parse_constant=_no_constant)
        except (ValueError, RecursionError):
            return text
    return value_of(text)


def _rejected(problem: FormulaProblem) -> Answer:
    others = tuple(map(_rejected, problem.others))
    place = problem.column, problem.length
    guess = str(problem.details.get("guess") or "")
    return Answer("rejected", None, problem.code, problem.message, problem.remedy, *place, others, guess)


def _no_request(reason: str) -> Answer:
    return _rejected(FormulaProblem("FORM022", reason=reason))


def _no_constant(name: str) -> None:
    raise ValueError(N_("{name} is not a value", name=name))


def _value(value: Any, name: str, left: list[int], depth: int) -> Value:
    """Return a value from JSON as formulas know it; raises FormulaProblem when it is too large or unfit."""
    left[0] -= 1
    if left[0] < 0:
        raise FormulaProblem("FORM022", reason=N_("the inputs have more than {most} values", most=MOST_LEAVES))
    reason = N_("the input {name} is nested too deeply", name=name) if depth > _DEEPEST else _unfit(value, name)
    if reason:
        raise FormulaProblem("FORM022", reason=reason)
    if isinstance(value, (list, tuple)):
        return [_value(v, name, left, depth + 1) for v in value]
    if isinstance(value, Mapping):
        return record_from_mapping(name, {k: _value(v, name, left, depth + 1) for k, v in value.items()})
    return value


def _unfit(value: Any, name: str) -> str:
    """Return the problem with a value in words, or an empty text."""
    if value is None or isinstance(value, bool):
        return ""
    if isinstance(value, str):
        if len(value) > LONGEST_TEXT:
            return N_("the input {name} has more than {most} characters", name=name, most=LONGEST_TEXT)
        broken = any("\ud800" <= c <= "\udfff" for c in value)
        return N_("the input {name} has a character that is none", name=name) if broken else ""
    if isinstance(value, (int, float)):
        fits = -LARGEST_NUMBER <= value <= LARGEST_NUMBER
        return "" if fits else N_("the input {name} is beyond the numbers of formulas, which go up to 1e15", name=name)
    if isinstance(value, (list, tuple)):
        fits = len(value) <= LONGEST_LIST
        return "" if fits else N_("the input {name} has more than {most} places", name=name, most=LONGEST_LIST)
    if isinstance(value, Mapping) and all(isinstance(k, str) for k in value):
        single = len({key(k) for k in value}) == len(value)
        return "" if single else N_("the input {name} has two fields of one name", name=name)
    return N_("the input {name} is not a value that formulas know", name=name)
