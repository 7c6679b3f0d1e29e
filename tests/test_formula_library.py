"""The library of functions: every example, and what each function answers to blanks and wrong kinds."""

from __future__ import annotations

import math
import reprlib

import pytest
from examples import example_count
from hypothesis import given, settings
from hypothesis import strategies as st

from rrp_sheets.checks.facts import known_of
from rrp_sheets.formulas import FormulaProblem, compile_formula, make_scope, make_table
from rrp_sheets.formulas.evaluator import GuardedInterpreter
from rrp_sheets.formulas.functions import library
from rrp_sheets.formulas.problems import kind_of_value
from rrp_sheets.help.functions import examples, literal_text
from rrp_sheets.model.values import Failure, record_from_mapping, to_json

FUNCTIONS = {f.name: f for f in library()}


def evaluate(text, **inputs):
    formula = compile_formula(text, make_scope([(n, None) for n in inputs]))
    return formula.prepare(GuardedInterpreter())(*inputs.values())


@pytest.mark.slow
@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_function_has_help_and_an_example_in_the_users_spelling_that_is_true(name):
    function = FUNCTIONS[name]
    assert function.usage.startswith(f"{name}(") and function.help.split("\n")[0].endswith(".")
    shown = examples(function)
    assert shown
    for formula, result in shown:
        assert f"{name}(" in formula
        assert literal_text(to_json(evaluate(formula))) == result, formula


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("ROUND(0.5)", 1), ("ROUND(-0.5)", -1), ("ROUND(2.675; 2)", 2.68), ("ROUND(1.15; 1)", 1.2), ("ROUND(15; -1)", 20), ("ROUND(1/3; 3)", 0.333),
        ("ROUNDUP(-0.1)", -1), ("ROUNDDOWN(-0.9)", 0), ("INT(-0.1)", -1), ("TRUNC(-0.9)", 0), ("MOD(-7; 3)", 2), ("MOD(7; -3)", -2), ("MOD(5.5; 2)", 1.5),
        ("CEILING(0.3; 0.1)", pytest.approx(0.3)), ("FLOOR(0.3; 0.1)", pytest.approx(0.3)), ("FLOOR(-2.5; 2)", -4), ("CEILING(7; 5)", 10), ("POWER(9; 0.5)", 3.0),
        ("SUM([1; BLANK; 2])", 3), ("SUM(TRUE; TRUE)", 2), ("AVERAGE([1; BLANK; 2])", 1.5), ("MAX([]; 3)", 3), ("MIN(-1; [2; -5])", -5), ("SUM([])", 0),
        ("MEDIAN(1; 2; 3; 4)", 2.5), ("COUNT(1; \"2\"; TRUE; BLANK)", 1), ("COUNTA(1; \"\"; BLANK)", 2), ("PRODUCT([])", 1), ("SIGN(0)", 0),
        ("IFS(FALSE; 1; TRUE; 2)", 2), ("IFS(TRUE; 1; 1/0; 2)", 1), ("SWITCH(2; 1; \"a\"; 2; \"b\")", "b"), ("SWITCH(\"RED\"; \"red\"; 1; 2)", 1), ("SWITCH(9; 1; 2; 3; 4; \"else\")", "else"),
        ("SWITCH(1; 1; \"a\"; 1/0; \"b\")", "a"), ("IFERROR(IFS(FALSE; 1); 5)", 5), ("ISERROR(1)", False), ("ISNUMBER(SEARCH(\"BALL\"; \"red ball\"))", True), ("ISNUMBER(1/0)", False), ("ISNUMBER(\"5\")", False), ("ISNUMBER(TRUE)", False), ("ISERROR(INDEX([1]; 5))", True), ("IFERROR(\"a\" + 1; 0)", 0),
        ("XOR(TRUE; TRUE; TRUE)", True), ("ISLIST((1; 2))", True), ("AND(TRUE)", True), ("OR(FALSE; 0; BLANK)", False), ("NOT(BLANK)", True),
        ("FIND(\"o\"; \"robot\"; 3)", 4), ("ISERROR(FIND(\"O\"; \"robot\"))", True), ("SEARCH(\"O\"; \"robot\")", 2), ("SUBSTITUTE(\"aaa\"; \"a\"; \"b\"; 2)", "aba"), ("SUBSTITUTE(\"aaa\"; \"\"; \"b\")", "aaa"),
        ("SUBSTITUTE(\"x1\"; \"x\"; 5)", "51"), ("LEFT(\"abc\")", "a"), ("LEFT(\"abc\"; 9)", "abc"), ("RIGHT(\"abc\"; 0)", ""), ("MID(\"abc\"; 2; 9)", "bc"), ("MID(\"abc\"; 2; 0)", ""), ("LEFT(\"abc\"; -1)", ""),
        ("PROPER(\"NAO the robot's friend\")", "Nao The Robot's Friend"), ("TRIM(\"\")", ""), ("REPT(\"ab\"; 0)", ""), ("TEXTJOIN(\", \"; FALSE; [\"a\"; BLANK; \"b\"])", "a, , b"), ("TEXTJOIN(\"-\"; TRUE)", ""),
        ("TEXTSPLIT(\"a b  c\")", ["a", "b", "", "c"]), ("TEXT(0; \"0.0\")", "0.0"), ("TEXT(5; \"000\")", "005"), ("TEXT(-5.5; \"00.0\")", "-05.5"), ("TEXT(1234567; \"#,##0\")", "1,234,567"), ("FIXED(2.5; 0)", "3"),
        ("VALUE(\" 12 \")", 12), ("VALUE(\"-.5\")", -0.5), ("VALUE(3)", 3), ("LEN(\"\")", 0), ("CONCAT(TRUE; 1; \"a\"; 0.5)", "TRUE1a0.5"), ("STR(0.1 + 0.2)", "0.3"), ("EXACT(\"a\"; \"a\")", True),
        ("SORT([3; 1; 2])", [1, 2, 3]), ("SORTED([\"b\"; \"A\"; \"a\"])", ["A", "a", "b"]), ("UNIQUE([1; 1.0; \"1\"; BLANK; BLANK])", [1, "1", None]), ("TAKE([1; 2]; 9)", [1, 2]), ("DROP([1; 2]; 9)", []),
        ("SEQUENCE(0)", []), ("RANGE(3; 0; -1)", [3, 2, 1]), ("REVERSE([])", []), ("LIST([1; 2])", [1, 2]), ("ALL([])", True), ("ANY([])", False),
        ("DEGREES(PI())", 180.0), ("ANGLE(0; 1)", math.pi / 2), ("ANGLEDIFF(0; PI())", -math.pi), ("CLAMP(5; 5; 5)", 5), ("SCALE(5; 0; 10; 10; 0)", 5.0), ("BETWEEN(1; 1; 1)", True),
        ("ISEVEN(0)", True), ("ISODD(-3)", True), ("QUOTIENT(-7; 2)", -3), ("MROUND(0.7; 0.5)", 0.5), ("STDEV([2; 2])", 0.0),
    ],
)  # fmt: skip
def test_values(text, value):
    assert to_json(evaluate(text)) == value


@pytest.mark.parametrize(
    ("text", "value"),
    [("SUM([0.1 for n in RANGE(10)])", 1.0), ("AVERAGE([0.1 for n in RANGE(10)])", 0.1), ("SUM(0.1; 0.2; 0.3)", 0.6),
     ("STDEV(1.1; 2.7; 3.3)", 1.1372481406154653), ("SUM(1; 2; 3)", 6)],
)  # fmt: skip
def test_sums_are_rounded_once_and_so_alike_in_every_python(text, value):
    result = to_json(evaluate(text))
    assert (type(result), result) == (type(value), value)


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("SQRT(-1)", "FORM107"), ("LN(0)", "FORM107"), ("LOG10(-1)", "FORM107"), ("ASIN(1.1)", "FORM107"), ("MOD(1; 0)", "FORM101"), ("QUOTIENT(1; 0)", "FORM101"), ("SCALE(1; 2; 2; 0; 1)", "FORM101"),
        ("POWER(0; -1)", "FORM101"), ("POWER(-8; 1/3)", "FORM107"), ("POWER(10; 20)", "FORM105"), ("EXP(99)", "FORM105"), ("PRODUCT(RANGE(1; 99))", "FORM105"), ("MIN([])", "FORM107"), ("AVERAGE([])", "FORM107"),
        ("STDEV(1)", "FORM107"), ("FLOOR(1; 0)", "FORM107"), ("CEILING(1; -1)", "FORM107"), ("FLOOR(1e15; 1e-9)", "FORM105"), ("MROUND(1; 0)", "FORM107"), ("CLAMP(1; 3; 2)", "FORM107"), ("ISEVEN(\"a\")", "FORM103"),
        ("UPPER(1)", "FORM103"), ("UPPER(BLANK)", "FORM102"), ("LEFT(\"a\"; 0.5)", "FORM107"), ("FIND(\"x\"; \"abc\")", "FORM107"), ("FIND(\"a\"; \"abc\"; 0)", "FORM107"), ("VALUE(\"1,5\")", "FORM107"), ("VALUE(\"\")", "FORM107"),
        ("REPT(\"ab\"; 1001)", "FORM105"), ("REPT(\"a\"; -1)", "FORM107"), ("SUBSTITUTE(REPT(\"a\"; 1000); \"a\"; \"bbb\")", "FORM105"), ("SUBSTITUTE(\"a\"; \"a\"; \"b\"; 0)", "FORM107"), ("TEXTSPLIT(\"a\"; \"\")", "FORM107"),
        ("TEXTJOIN(REPT(\"-\"; 99); TRUE; RANGE(99))", "FORM105"), ("CONCAT([[1]])", "FORM103"), ("CONCAT(BLANK)", "FORM102"), ("TEXT(1; \"yyyy\")", "FORM107"), ("TEXT(\"a\"; \"0\")", "FORM103"), ("FIXED(\"a\")", "FORM103"),
        ("RANGE(1; 2; 0)", "FORM107"), ("RANGE(1001)", "FORM105"), ("SEQUENCE(1001)", "FORM105"), ("SEQUENCE(-1)", "FORM105"), ("SEQUENCE(3; 1e15; 1e15)", "FORM105"), ("FIRST([])", "FORM107"), ("LAST(1)", "FORM103"), ("SORT([1; \"a\"])", "FORM103"),
        ("COUNTIF([1; 2]; \">1\")", "FORM107"), ("IFS(FALSE; 1)", "FORM113"), ("SWITCH(1; 2; 3)", "FORM113"), ("IFS(\"a\"; 1)", "FORM108"), ("XOR(\"a\")", "FORM108"), ("ALL([\"a\"])", "FORM103"), ("IF(BLANK + 1; 1; 2)", "FORM102"),
    ],
)  # fmt: skip
def test_errors_have_their_own_words(text, code):
    failure = evaluate(text)
    assert isinstance(failure, Failure), failure
    assert failure.code == code and failure.message


@pytest.mark.parametrize(
    ("text", "usage"),
    [("IFS(1; 2; 3)", "TRUE; otherwise"), ("IF(1)", "IF(condition; then; otherwise)"), ("SWITCH(1; 2)", "SWITCH(")],
)
def test_the_wrong_number_of_values_is_told_with_the_usage(text, usage):
    with pytest.raises(FormulaProblem) as caught:
        evaluate(text)
    assert caught.value.code == "FORM006" and usage in caught.value.remedy


ODD = [
    None, True, 0, -1, 1, 2.5, -0.0, 1e15, -1e15, 1e-300, "", "a", "Red ball", "1.5", "İß", "ﬀ", "\U0001f600", "a" * 2000, [], [1, 2], ["a", None],
    [[1], ["b"]], (1, 2), [0] * 1000, ["ab"] * 999, record_from_mapping("ball", {"x": 1}), make_table("T", [["A"], ["1"]]), [[0] * 1000] * 1000,
]  # fmt: skip


@pytest.mark.slow
@given(st.sampled_from(sorted(FUNCTIONS)), st.lists(st.sampled_from(ODD), max_size=5), st.data())
@settings(max_examples=example_count(500), deadline=None)
def test_every_function_answers_any_values_with_a_value_or_with_words(name, values, data):
    function = FUNCTIONS[name]
    count = min(max(len(values), function.least), function.most)
    values = [*values, *(data.draw(st.sampled_from(ODD)) for _ in range(count - len(values)))][:count]
    names = [f"v{i}" for i in range(count)]
    before = [reprlib.repr(v) for v in values]
    try:
        formula = compile_formula(f"{name}({'; '.join(names)})", make_scope([(n, None) for n in names]))
    except FormulaProblem as problem:
        assert problem.code == "FORM006"
        return
    result = formula.prepare(GuardedInterpreter())(*values)
    if not isinstance(result, Failure):
        known = known_of(formula.tree, {})
        kind = kind_of_value(result)
        assert known.kind in ("any", kind, "number" if kind == "truth" else kind), (values, result)  # TRUE is 1
        assert not known.bounded or known.low <= result <= known.high
    assert not isinstance(result, Failure) or (result.code != "FORM109" and result.message)
    assert not isinstance(result, float) or abs(result) <= 1e15
    assert not isinstance(result, str) or len(result) <= 2000
    assert not isinstance(result, list) or len(result) <= 1000
    assert [reprlib.repr(v) for v in values] == before
