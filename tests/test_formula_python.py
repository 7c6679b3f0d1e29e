"""Python's spelling means here what it means in Python: the parser against Python's own, and values against Python's."""

from __future__ import annotations

import ast
import warnings

import pytest
from examples import example_count
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from rrp_sheets.formulas import FormulaProblem, compile_formula, make_scope, read_formula
from rrp_sheets.formulas.evaluator import GuardedInterpreter
from rrp_sheets.formulas.parsing import Join
from rrp_sheets.model.values import Failure

NAMES = ("a", "b", "ball", "größe", "x1")
LOAD = ast.Load()


def nodes(leaves):
    """Trees of what formulas may be, as Python makes them."""

    def grow(inner):
        several = st.lists(inner, min_size=1, max_size=3)
        signs = st.sampled_from([ast.Add(), ast.Sub(), ast.Mult(), ast.Div(), ast.FloorDiv(), ast.Mod(), ast.Pow()])
        order = st.sampled_from(
            [ast.Lt(), ast.LtE(), ast.Gt(), ast.GtE(), ast.Eq(), ast.NotEq(), ast.In(), ast.NotIn()]
        )
        return st.one_of(
            st.builds(ast.BinOp, inner, signs, inner),
            st.builds(ast.UnaryOp, st.sampled_from([ast.USub(), ast.UAdd(), ast.Not()]), inner),
            st.builds(ast.BoolOp, st.sampled_from([ast.And(), ast.Or()]), st.lists(inner, min_size=2, max_size=3)),
            st.builds(lambda left, rest: ast.Compare(left, [o for o, _ in rest], [v for _, v in rest]), inner, st.lists(st.tuples(order, inner), min_size=1, max_size=2)),
            st.builds(ast.IfExp, inner, inner, inner),
            st.builds(lambda e: ast.List(e, LOAD), several), st.builds(lambda e: ast.Tuple(e, LOAD), several),
            st.builds(lambda f, a: ast.Call(ast.Name(f, LOAD), a, []), st.sampled_from(["f", "max", "IF"]), several),
            st.builds(lambda v, n: ast.Attribute(v, n, LOAD), inner, st.sampled_from(["x", "distance"])),
            st.builds(lambda v, i: ast.Subscript(v, i, LOAD), inner, inner),
            st.builds(lambda v, i, j: ast.Subscript(v, ast.Slice(i, j, None), LOAD), inner, st.none() | inner, st.none() | inner),
            st.builds(lambda e, i, c: ast.ListComp(e, [ast.comprehension(ast.Name("q", ast.Store()), i, c, 0)]), inner, inner, st.lists(inner, max_size=1)),
            st.builds(lambda v: ast.JoinedStr([ast.Constant("it is "), ast.FormattedValue(v, -1, None)]), inner),
        )  # fmt: skip

    return st.recursive(leaves, grow, max_leaves=8)


CONSTANTS = (
    st.integers(0, 10**6)
    | st.floats(0.001, 1e6)
    | st.text("ab\"' \\{}é&=;", max_size=5)
    | st.sampled_from([True, False, None])
)
TREES = nodes(st.builds(ast.Constant, CONSTANTS) | st.builds(lambda n: ast.Name(n, LOAD), st.sampled_from(NAMES)))


@pytest.mark.slow
@given(TREES)
@settings(max_examples=example_count(400), deadline=None)
def test_the_parser_reads_what_pythons_own_reads(tree):
    try:
        text = ast.unparse(tree)
        assert ast.dump(ast.parse(text, mode="eval").body)
    except (ValueError, SyntaxError):  # Python 3.11 cannot write all texts with values
        assume(False)
    assume(len(text) <= 500)
    assume(not any(isinstance(n, ast.Subscript) and isinstance(n.slice, ast.Tuple) for n in ast.walk(tree)))
    try:
        ours = read_formula(text)
    except FormulaProblem as problem:  # what the two worlds would read differently, and the bounds
        assert problem.code in ("FORM002", "FORM003", "FORM008"), (text, problem.message)
        return
    assert ast.dump(ours) == ast.dump(ast.parse(text, mode="eval").body), text


@pytest.mark.slow
@given(TREES)
@settings(max_examples=example_count(250), deadline=None)
def test_values_are_pythons_where_both_have_one(tree):
    """Texts are compared without regard to capitals, and `and` gives TRUE or FALSE: such trees are left out."""
    apart = (ast.Compare, ast.BoolOp, ast.Attribute, ast.JoinedStr, Join, ast.Call)
    assume(not any(isinstance(n, apart) for n in ast.walk(tree)))
    values = {"a": 3, "b": 2.5, "ball": [1, 2], "größe": "text", "x1": True}
    try:
        text = ast.unparse(tree)
        assume(len(text) <= 500 and "**" not in text)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            expected = eval(text, {"__builtins__": {}}, dict(values))
    except Exception:
        return
    try:
        formula = compile_formula(text, make_scope([(n, None) for n in values]))
    except FormulaProblem:
        return
    result = formula.prepare(GuardedInterpreter())(*values.values())
    assert isinstance(result, Failure) or result == expected, text
