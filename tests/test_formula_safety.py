"""Safety of formulas: none can hang, grow, leave its scope, or change its inputs."""

from __future__ import annotations

import tracemalloc

import pytest
from busy import work_within
from examples import example_count
from formula_makers import Maker, inputs, scope
from hypothesis import given, settings
from hypothesis import strategies as st

from rrp_sheets.formulas import FormulaProblem, HelperDef, Input, Picker, compile_formula, make_scope, make_table
from rrp_sheets.formulas.evaluator import GuardedInterpreter
from rrp_sheets.formulas.limits import LARGEST_NUMBER, LONGEST_LIST, LONGEST_TEXT
from rrp_sheets.model.values import Failure, Record

SCOPE = scope()
INTERPRETER = GuardedInterpreter()
SECONDS = 1.0
MEGABYTES = 60


def outcome(text, values, in_scope=SCOPE):
    """Outcome of a formula: a FormulaProblem, a Failure or a value."""
    try:
        formula = compile_formula(text, in_scope)
    except FormulaProblem as problem:
        assert problem.message and problem.remedy and -1 <= problem.column <= len(text), text
        return problem
    return formula.prepare(INTERPRETER, Picker(1, "A!1"))(*values)


def fits(value, depth=0):
    """True when a value may be sent on a stream and is within its bounds."""
    kind = type(value)
    if kind in (int, float):
        return -LARGEST_NUMBER <= value <= LARGEST_NUMBER
    if kind is str:
        return len(value) <= LONGEST_TEXT
    if kind in (list, tuple):
        return len(value) <= LONGEST_LIST and depth < 40 and all(fits(v, depth + 1) for v in value[:50])
    return value is None or kind in (bool, Record)


@given(st.integers(0, 2**48))
@settings(max_examples=example_count(1_500), deadline=None)
def test_any_formula_ends_soon_within_its_bounds_and_changes_nothing(seed):
    text = Maker(seed).formula()
    values = inputs()
    before = repr(values)
    with work_within(SECONDS, text):
        result = outcome(text, values.values())
    assert repr(values) == before, text
    if not isinstance(result, FormulaProblem):
        assert isinstance(result, Failure) or fits(result), text
        assert not isinstance(result, Failure) or (result.code != "FORM109" and -1 <= result.column <= len(text)), text


@given(st.integers(0, 2**48))
@settings(max_examples=example_count(100), deadline=None)
def test_no_formula_grows_the_memory(seed):
    text = Maker(seed).formula()
    tracemalloc.start()
    try:
        outcome(text, inputs().values())
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < MEGABYTES * 1e6, text


class Trap:
    """Stands where a value belongs; whoever looks at an attribute of it is found out."""

    def __getattribute__(self, name):
        if name == "__class__":  # isinstance asks for it
            return Trap
        raise AssertionError(f"reached for {name}")


@pytest.mark.parametrize(
    "text",
    ["trap.x", "trap['x']", "trap[0]", "trap.real", "-trap", "trap + 1", "trap & 1", "trap * 2", "not trap", "trap.format", "f'{trap}'", "f'{trap:>5}'",
     "UPPER(trap)", "LEN(trap)", "SUM(trap; 1)", "trap < 1", "[t for t in trap]", "1 if trap else 2", "PICK(trap)", "INDEX(trap; 1)", "trap in [1]", "TEXT(trap; \"0\")"],
)  # fmt: skip
def test_attributes_are_looked_up_in_records_only(text):
    result = outcome(text, [Trap()], make_scope([("Trap", None)]))
    assert isinstance(result, (Failure, FormulaProblem)) or result is False


@pytest.mark.parametrize(
    "text",
    [
        # growth
        "REPT(\"a\"; 10^9)", "\"a\" * 10^9", "10^9 * [0]", "(0;) * 10^9", "[[[0] * 1000] * 1000] * 1000", "[[[0] * 1000] * 1000] * 9", "SUBSTITUTE(REPT(\"a\"; 2000); \"a\"; REPT(\"b\"; 2000))",
        "TEXTJOIN(REPT(\"a\"; 2000); TRUE; RANGE(1000))", "CONCAT([REPT(\"a\"; 2000) for q in RANGE(1000)])", "[REPT(\"a\"; 2000) for q in RANGE(1000)]",
        "[RANGE(1000) for q in RANGE(1000)]", "[[RANGE(99) for q in RANGE(99)] for p in RANGE(99)]", "[balls * 300 for q in RANGE(1000)]",
        "[balls + RANGE(900) for q in RANGE(1000)]", "[name & REPT(\"a\"; 1900) for q in RANGE(1000)]", "[f\"{REPT('a'; 1900)}{q}\" for q in RANGE(1000)]",
        "most(most(most(x)))", "most(grow(name))", "grow(grow(grow(grow(name))))", "[SORT(Wide[C29]) for q in RANGE(1000)]", "[REVERSE(Wide) for q in RANGE(1000)]",
        "TEXTSPLIT(REPT(\"a \"; 1000); \" \")", "[TEXTSPLIT(REPT(\"a \"; 900); \" \") for q in RANGE(1000)]", "[UPPER(REPT(\"ß\"; 1999)) for q in RANGE(999)]",
        # numbers
        "9**9**9", "(10^15)^15", "((10^15)^15)^15", "10^15 * 10^15", "PRODUCT(RANGE(1; 999))", "EXP(1e15)", "POWER(1.0000001; 1e15)", "1e308 * 10", "ROUND(1e15; 1e15)",
        "ROUND(1e15; 15)", "SCALE(1e15; 0; 1e-300; 0; 1e15)", "1e15 // 1e-300", "1e15 % 1e-300", "RANGE(1e15)", "RANGE(-1e15; 1e15)", "RANGE(0; 1e15; 1e15)", "SEQUENCE(1000; 1e15; 1e15)",
        "f'{1e15:.99f}'", "f'{1e15:99.99f}'", "TEXT(1e15; \"000000000000000.000000000000000\")", "FIXED(1e15; 15)", "DEGREES(1e15)", "1e-300 / 1e15", "-(-1e15)", "ANGLEDIFF(1e15; -1e15)",
        # time
        "[0 for q in RANGE(1000) for p in RANGE(1000)]", "SUM([SUM([a * b for a in RANGE(999)]) for b in RANGE(999)])", "[[x for q in Wide] for p in Wide]",
        "[MATCH(\"x\"; Wide[C1]) for q in Wide]", "[XLOOKUP(-1; Wide[C1]; Wide; 0) for q in Wide]", "[COUNTIF(Wide[C2]; 4) for q in Wide]", "UNIQUE(Wide[C29])", "UNIQUE(Wide)", "[UNIQUE(Wide) for q in Wide]",
        "deep = deep", "[deep = deep for q in Wide for p in Wide]", "[[Wide[C1] = Wide[C1]] for q in RANGE(1000)]", "[[0] * 1000] * 1000 = [[0] * 1000] * 1000", "[PICK(Wide) for q in Wide]",
        "MEDIAN([MEDIAN(Wide[C3]) for q in Wide])", "COUNT([SORT([REPT(\"a\"; 2000) for q in RANGE(9)]) for p in RANGE(1000)])", "IFERROR([0 for q in Wide for p in Wide]; [0 for q in Wide for p in Wide])",
        "IFERROR(IFERROR(most(most(x)); most(most(x))); 1)", "REPT(\"a\"; 2000) in [REPT(\"b\"; 2000)] * 999", "[REPT(\"a\"; 2000) in [REPT(\"b\"; 2000)] * 999 for q in RANGE(999)]",
        "[\"b\" in REPT(\"a\"; 2000) for q in RANGE(1000)]", "[SUBSTITUTE(REPT(\"a\"; 2000); \"b\"; \"\") for q in RANGE(1000)]", "[FIND(\"ab\"; REPT(\"a\"; 2000)) for q in RANGE(1000)]",
    ],
)  # fmt: skip
def test_attacks_by_hand_end_soon_and_small(text):
    values = inputs()
    with work_within(SECONDS):
        result = outcome(text, values.values())
    assert isinstance(result, (Failure, FormulaProblem)) or fits(result)
    assert getattr(result, "code", "") != "FORM109"
    tracemalloc.start()
    try:
        outcome(text, values.values())
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < MEGABYTES * 1e6, f"{peak / 1e6:.0f} MB"


def chained(count, text):
    """Helpers h0, h1, … of which each has `{h}` for the one before."""
    helpers = {}
    before = "x"
    for i in range(count):
        tree = compile_formula(text.replace("{h}", before), make_scope([("x", None)], dict(helpers))).tree
        helpers[f"h{i}"] = HelperDef(f"h{i}", (Input("x", "x"),), tree)
        before = f"h{i}(x)"
    return helpers, before


@pytest.mark.parametrize(
    ("count", "text"),
    [(60, "{h} + {h}"), (60, "[{h}; {h}]"), (60, "{h} & {h}"), (300, "{h}"), (40, "[{h}]"), (19, "[{h} for q in RANGE(2)]"), (100, "IFERROR({h}; {h})"),
     (15, "IF(TRUE; " * 20 + "{h}" + "; 0)" * 20), (19, "((((((((((((((((((((-{h}" + "))))))))))))))))))))"), (18, "({h}; {h}; {h})"), (10, "[{h}] * 1000")],
)  # fmt: skip
def test_helpers_upon_helpers_end_soon(count, text):
    helpers, last = chained(count, text)
    with work_within(SECONDS):
        result = outcome(last, [1], make_scope([("x", None)], helpers))
    assert getattr(result, "code", "FORM105") == "FORM105" or fits(result)


def test_helpers_in_a_circle_end():
    a, b = HelperDef("a", (Input("n", "n"),)), HelperDef("b", (Input("n", "n"),))
    inner = make_scope([("n", None)], {"a": a, "b": b})
    a.tree, b.tree = compile_formula("b(n) + 1", inner).tree, compile_formula("a(n) + 1", inner).tree
    assert outcome("a(1)", [0], make_scope([("x", None)], {"a": a, "b": b})).code == "FORM105"


def test_the_budget_is_shared_with_helpers_and_nothing_forgives_its_end():
    helpers, last = chained(15, "[{h} for q in RANGE(99)]")
    result = outcome(f"IFERROR({last}; 1)", [1], make_scope([("x", None)], helpers))
    assert isinstance(result, Failure) and result.code == "FORM105"


def test_deep_values_from_outside_do_not_break_it():
    deep = []
    for _ in range(5_000):
        deep = [deep]
    for text in ("x = x", "x", "[x]", "x = [x]", "COUNT(x)", "UNIQUE([x; x])", "PICK([x; x])", "IFERROR(x = [x]; 1)"):
        result = outcome(text, [deep], make_scope([("x", None)]))
        assert isinstance(result, (Failure, int)), text


def test_interpreters_do_not_share_anything():
    formula = compile_formula("[q * x for q in RANGE(3)]", make_scope([("x", None)]))
    first, second = formula.prepare(GuardedInterpreter()), formula.prepare(GuardedInterpreter())
    assert (first(1), second(10), first(2)) == ([0, 1, 2], [0, 10, 20], [0, 2, 4])


def test_the_interpreter_knows_no_name_and_no_handler_but_ours():
    interpreter = GuardedInterpreter()
    assert interpreter.symtable == {} and interpreter.node_handlers == {}
    assert not {"Import", "Assign", "Lambda", "FunctionDef", "Delete", "For", "While", "Try"} & {
        k.__name__ for k in interpreter.handlers
    }


def test_a_table_from_a_stranger_is_not_a_way_in():
    table = make_table("T", [["__class__", "f(x)", "a]b"], ["=1+1", "{x.__class__}", "%s"]])
    in_scope = make_scope([("x", None)], tables={"t": table})
    assert outcome("INDEX(T; 1)", [1], in_scope).values == {"class": "=1+1", "f(x)": "{x.__class__}", "a]b": "%s"}
    assert outcome("T[__class__]", [1], in_scope) == ["=1+1"]
    assert outcome("INDEX(T; 1).__class__", [1], in_scope).code == "FORM003"


NESTED = ["(" * 30 + "x" + ")" * 30, "[" * 30 + "x" + "]" * 30, "f'{" * 100 + "x" + "}'" * 100, "f'{(" * 20 + "x" + ")}'" * 20, "-" * 400 + "x", "not " * 100 + "x",
          "x" + "[0]" * 150, "x" + ".x" * 200, "2^(" * 40 + "1" + ")" * 40, "IF(x; " * 40, "x if " * 80 + "x", "1+" * 200 + "1", "x & " * 100 + "x", "{" * 200, "f'{{" * 50]  # fmt: skip


@pytest.mark.parametrize("text", NESTED)
@pytest.mark.parametrize("below", [0, 600, 850])
def test_nesting_is_refused_and_never_breaks_the_program_whatever_stands_below(text, below):
    def at(depth):
        return at(depth - 1) if depth else outcome(text, [1], make_scope([("x", None)]))

    result = at(below)
    assert isinstance(result, (FormulaProblem, Failure)) or fits(result)
