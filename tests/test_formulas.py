"""The formula language (design: 3-formulas), through compile_formula and the guarded interpreter."""

from __future__ import annotations

import pytest

from rrp_sheets.formulas import FormulaProblem, compile_formula, make_scope
from rrp_sheets.formulas.evaluator import GuardedInterpreter
from rrp_sheets.model.values import Failure, record_from_mapping


def evaluate(text, **inputs):
    values = [record_from_mapping(n, v) if isinstance(v, dict) else v for n, v in inputs.items()]
    scope = make_scope([(n, getattr(v, "type", None)) for n, v in zip(inputs, values, strict=True)])
    return compile_formula(text, scope).prepare(GuardedInterpreter())(*values)


def test_x():
    assert evaluate("x+1", x=1) == 2
