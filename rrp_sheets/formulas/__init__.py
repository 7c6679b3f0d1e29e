"""Formulas: spelling → tree → checks → evaluator, and the library of functions by topic (design: 3-formulas)."""

from rrp_sheets.formulas.formula import Formula, compile_formula
from rrp_sheets.formulas.problems import FormulaProblem
from rrp_sheets.formulas.scope import HelperDef, Input, Scope, make_scope

__all__ = ["Formula", "FormulaProblem", "HelperDef", "Input", "Scope", "compile_formula", "make_scope"]
