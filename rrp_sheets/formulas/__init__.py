"""Formulas: tokens → tree → checks → evaluator, and the library of functions by topic."""

from rrp_sheets.formulas.formula import Formula, compile_formula, read_formula
from rrp_sheets.formulas.operations import Picker
from rrp_sheets.formulas.problems import FormulaProblem
from rrp_sheets.formulas.scope import HelperDef, Input, Scope, make_scope
from rrp_sheets.formulas.tables import Table, make_table
from rrp_sheets.formulas.tokens import replace_names

__all__ = [
    "Formula",
    "FormulaProblem",
    "HelperDef",
    "Input",
    "Picker",
    "Scope",
    "Table",
    "compile_formula",
    "make_scope",
    "make_table",
    "read_formula",
    "replace_names",
]
