"""Conclusions of the check hold whenever a formula is evaluated."""

from __future__ import annotations

import itertools

from hypothesis import given
from hypothesis import strategies as st

from rrp_sheets.checks.dataflow import can_hold, cases
from rrp_sheets.checks.facts import ANY, NUMBER, TEXT, AbstractValue, known_of
from rrp_sheets.formulas import compile_formula, make_scope
from rrp_sheets.formulas.evaluator import GuardedInterpreter
from rrp_sheets.formulas.problems import kind_of_value
from rrp_sheets.model.values import Failure

SCOPE = make_scope([("X", None), ("Y", None), ("Word", None)])
KNOWN = {"x": AbstractValue(NUMBER, low=-2.0, high=3.0), "y": AbstractValue(NUMBER, low=0.5, high=4.0, blank=True),
         "word": AbstractValue(TEXT, choices=("yes", "no"))}  # fmt: skip
XS, YS, WORDS = (-2.0, -0.5, 0.0, 1.0, 3.0), (None, 0.5, 1.0, 4.0), ("yes", "no")
INPUTS = list(itertools.product(XS, YS, WORDS))

numbers = st.sampled_from(["x", "y", "0", "1", "-2", "0.5", "3"])


def _grown(inner: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    conditions = st.builds("{} {} {}".format, inner, st.sampled_from(["<", "<=", ">", ">=", "=", "<>"]), inner)
    return st.one_of(
        st.builds("({} {} {})".format, inner, st.sampled_from("+-*/"), inner),
        st.builds("IF({}; {}; {})".format, conditions, inner, inner),
        st.builds("IF(ISBLANK(y); {}; {})".format, inner, inner),
        st.builds("{}({}; {})".format, st.sampled_from(["MIN", "MAX"]), inner, inner),
        st.builds("CLAMP({}; -1; 2)".format, inner),
        st.builds("{}({})".format, st.sampled_from(["ABS", "SIN", "-"]), inner),
        st.builds("IFERROR({}; {})".format, inner, inner),
        st.builds("({}, {})[0]".format, inner, inner),
        st.builds('SWITCH(word; "yes"; {}; {})'.format, inner, inner),
    )


formulas = st.recursive(numbers, _grown, max_leaves=6)


@given(formulas)
def test_what_is_known_of_a_formula_holds_for_all_its_inputs(text):
    formula = compile_formula(text, SCOPE)
    known = known_of(formula.tree, KNOWN)
    evaluate = formula.prepare(GuardedInterpreter())
    for values in INPUTS:
        result = evaluate(*values)
        if isinstance(result, Failure):
            continue
        kind = kind_of_value(result)
        assert known.kind in (kind, ANY) or (result is None and known.blank), (text, values, result, known)
        if kind == NUMBER:
            assert known.low - 1e-9 <= result <= known.high + 1e-9, (text, values, result, known)
        if known.choices is not None:
            assert any(c == result for c in known.choices), (text, values, result, known)


_LEAVES = st.one_of(
    st.builds("{} {} {}".format, st.sampled_from(["x", "y", "(x + y)"]), st.sampled_from(["<", "<=", ">", ">=", "=", "<>"]),
              st.sampled_from(["0", "0.5", "1", "x", "y"])),
    st.builds("word {} {}".format, st.sampled_from(["=", "<>"]), st.sampled_from(['"Yes"', '"no"', '"maybe"'])),
    st.sampled_from(["ISBLANK(y)", "NOT(ISBLANK(y))", "x", "-1 < x <= 1", "BETWEEN(x; 0; 1)", "x in [0, 1]", "x <> BLANK"]),
)  # fmt: skip
conditions = st.recursive(
    _LEAVES,
    lambda inner: st.one_of(st.builds("AND({}; {})".format, inner, inner), st.builds("OR({}; {})".format, inner, inner),
                            st.builds("NOT({})".format, inner)),
    max_leaves=4,
)  # fmt: skip


@given(st.lists(conditions, min_size=1, max_size=3))
def test_conditions_that_are_said_to_exclude_each_other_never_hold_together(texts):
    compiled = [compile_formula(t, SCOPE) for t in texts]
    found = [cases(f.tree) for f in compiled]
    given_known = list(KNOWN.items())
    together = any(can_hold(itertools.chain(*c), given_known) for c in itertools.product(*found))
    if together:
        return
    interpreter = GuardedInterpreter()
    evaluated = [f.prepare(interpreter) for f in compiled]
    for values in INPUTS:
        results = [e(*values) for e in evaluated]
        assert not all(type(r) in (bool, int, float) and r for r in results), (texts, values)
