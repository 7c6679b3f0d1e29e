"""The formula language, through compile_formula and the guarded interpreter."""

from __future__ import annotations

import pytest
from busy import work_within
from examples import example_count
from hypothesis import given, settings
from hypothesis import strategies as st

from rrp_sheets.formulas import FormulaProblem, compile_formula, make_scope
from rrp_sheets.formulas.evaluator import GuardedInterpreter
from rrp_sheets.formulas.functions import library
from rrp_sheets.model.values import Failure, Record, record_from_mapping, to_json
from rrp_sheets.robots import load_robot

BALL = {"distance": 12.5, "x": 3.0, "y": 4.0, "colour": "red", "visible": True}
INPUTS = {"ball": BALL, "x": 5, "y": 2.0, "balls": [1, 2, 3], "name": "Kim", "gone": None}


def evaluate(text, inputs=INPUTS):
    values = [record_from_mapping(n, v) if isinstance(v, dict) else v for n, v in inputs.items()]
    scope = make_scope([(n, getattr(v, "type", None)) for n, v in zip(inputs, values, strict=True)])
    return compile_formula(text, scope).prepare(GuardedInterpreter())(*values)


def rejected(text, inputs=INPUTS):
    with pytest.raises(FormulaProblem) as caught:
        evaluate(text, inputs)
    assert caught.value.message and caught.value.remedy
    return caught.value.code


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("x + 1", 6), ("=x + 1", 6), ("x ** 2", 25), ("-x", -5), ("x // 2 + x % 2", 3), ("1_000", 1000),
        ("ball.distance", 12.5), ("ball['distance']", 12.5), ("Ball.Distance", 12.5), ("BALL.dis_tance", 12.5),
        ("ball.colour == 'Red'", True), ("EXACT(ball.colour, 'Red')", False), ("0 < x < 10", True),
        ("'near' if ball.distance < 20 else 'far'", "near"), ("IF(x > 3, 'a', 'b')", "a"),
        ("AND(x > 3, y < 1)", False), ("OR(x > 3, 1/0)", True), ("NOT(x > 3)", False), ("x > 3 and y < 3", True),
        ("TRUE", True), ("false", False), ("blank", None), ("ISBLANK(gone)", True), ("gone is None", True),
        ("gone == 0", False), ("f'{name} is {ball.distance:.1f} m away'", "Kim is 12.5 m away"),
        ("f'{0.1 + 0.2}'", "0.3"), ("'a' + name", "aKim"), ("'Score: ' + str(x)", "Score: 5"),
        ("ROUND(1e14, 15)", 1e14), ("TRUNC(TRUE)", 1), ("-(x**2)", -25), ("(-x)**2", 25), ("(3, 5)", [3, 5]), ("round(2.5)", 3), ("ROUND(-2.5)", -3), ("INT(-3.5)", -4), ("max(1, x, 2)", 5), ("sum(balls) / len(balls)", 2.0),
        ("[i * 10 for i in range(3)]", [0, 10, 20]), ("[p + q for p, q in [(1, 2), (3, 4)]]", [3, 7]),
        ("balls[0:2]", [1, 2]), ("balls[-1]", 3), ("7 not in balls", True), ("'k' in name", True),
        ("(0.2, -0.1)", [0.2, -0.1]), ("IFERROR(1 / 0, -1)", -1), ("CLAMP(x * 10, 0, 20)", 20), ("pi > 3", True),
        ("“red”", "red"), ("x – 1", 4), ("x ≤ 5", True), ("x ≠ 5", False), ("（x）", 5), ("x + 1  # closer", 6), ("ball == ball", True),
        ("'it’s'", "it’s"), ('"say \\"hi\\""', 'say "hi"'), ("1.5E3", 1500.0), ("not gone", True),
    ],
)  # fmt: skip
def test_values(text, value):
    assert to_json(evaluate(text)) == value


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("", "FORM001"), ("=", "FORM001"), ("(4", "FORM001"), ("x = = 3", "FORM001"), ("'red", "FORM001"),
        ("x if x > 3", "FORM001"), ("20 cm", "FORM001"), ("x ≤ ", "FORM001"), ("import os", "FORM001"), ("x\x00", "FORM001"),
        ("1 + " * 200 + "1", "FORM002"), ("x" * 501, "FORM002"), ("(" * 40 + "1" + ")" * 40, "FORM002"),
        ("[0 for a in balls for b in balls for c in balls]", "FORM002"),
        ("lambda: 1", "FORM003"), ("(q := 5)", "FORM003"), ("{1, 2}", "FORM003"), ("{'a': 1}", "FORM003"),
        ("name.upper()", "FORM003"), ("max(*balls)", "FORM003"), ("round(x, places=1)", "FORM003"), ("1j", "FORM001"),
        ("x.__class__", "FORM003"), ("[abs][0](x)", "FORM003"), ("abs", "FORM003"), ("x << 1", "FORM003"), ("~x", "FORM003"),
        ("b'a'", "FORM003"), ("...", "FORM001"), ("f'{x!r}'", "FORM003"), ("[ball for ball in balls]", "FORM003"),
        ("-x**2", "FORM003"), ("2**3**2", "FORM003"), ("x < 3,5", "FORM003"), ("'\\ud800'", "FORM003"),
        ("'\\x1b[2J'", "FORM003"), ("log(2)", "FORM019"), ("atan2(1, 2)", "FORM019"), ("x is 5", "FORM003"), ("x(1)", "FORM003"),
        ("disstance", "FORM004"), ("__builtins__", "FORM004"), ("open('f')", "FORM005"), ("Foo(x)", "FORM005"),
        ("sqrt(1, 2)", "FORM006"), ("IF()", "FORM006"), ("ball.distanse", "FORM007"), ("ball['distanse']", "FORM007"),
        ("10000000000000001", "FORM008"), ("1e999", "FORM008"), ("f'{x:{y}}'", "FORM010"), ("f'{x:999999}'", "FORM010"),
    ],
)  # fmt: skip
def test_refused_before_evaluation(text, code):
    assert rejected(text) == code


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("1 / 0", "FORM101"), ("x % 0", "FORM101"), ("gone + 1", "FORM102"), ("gone.x", "FORM102"), ("gone < 1", "FORM102"),
        ("'a' + 1", "FORM114"), ("'a' < 1", "FORM103"), ("balls + 1", "FORM103"), ("'5' * 2", "FORM115"), ("x[0]", "FORM103"), ("x.y", "FORM103"),
        ("ball < 3", "FORM103"), ("f'{ball}'", "FORM103"), ("-name", "FORM103"), ("sqrt('a')", "FORM103"),
        ("[balls][0].x", "FORM103"), ("[ball][0].z", "FORM104"), ("balls[9]", "FORM106"), ("10 ** 400", "FORM105"), ("9.0 ** (9 ** 9)", "FORM105"), ("[[[0] * 1000] * 1000] * 1000", "FORM105"),
        ("[[[0] * 1000] * 1000] * 1000 == [[[0] * 1000] * 1000] * 1000", "FORM105"), ("f'{y / 3:d}'", "FORM107"),
        ("['a' * 2000 in ['b' * 2000] * 999 for i in range(999)]", "FORM105"),
        ("[[sum(a, a, a, a, a, a, a, a) for i in a] for a in [range(999)]]", "FORM105"),

        ("'a' * 10**9", "FORM105"), ("10**9 * [0]", "FORM105"), ("range(10**9)", "FORM105"),
        ("[0 for a in range(999) for b in range(999)]", "FORM105"), ("sqrt(-1)", "FORM107"), ("asin(2)", "FORM107"),
        ("min([])", "FORM107"), ("1 if name else 2", "FORM108"), ("name and x", "FORM108"),
        ("IFERROR(sum([sum([a * b for a in range(999)]) for b in range(999)]), 1)", "FORM105"),
    ],
)  # fmt: skip
def test_errors_are_values_with_their_own_words(text, code):
    result = evaluate(text)
    assert isinstance(result, Failure) and result.code == code and result.message


@pytest.mark.parametrize(
    ("text", "remedy"),
    [
        ("x > 3 AND y < 1", "small letters"),
        ("x < 0.8 m", "unit"), ("500 ms", '"500 ms"'), ("x between 1 and 2", "<= distance"), ("Red ball.x < 1", "redBall"), ("x < 0,8", "0.8"),
        ("name == kim", "quotes"), ("value + 1", "redBall"),
    ],
)  # fmt: skip
def test_what_people_are_used_to_write_is_answered_with_how_to_write_it_here(text, remedy):
    with pytest.raises(FormulaProblem) as caught:
        evaluate(text, {**INPUTS, "Red ball": BALL})
    assert remedy in caught.value.remedy


def test_an_unknown_name_proposes_the_nearest_in_the_formulas_spelling():
    with pytest.raises(FormulaProblem) as caught:
        evaluate("redBal.x", {"Red ball": BALL})
    assert "redBall" in caught.value.remedy and caught.value.column == 0


@pytest.mark.parametrize("spelling", ["redBall", "red_ball", "redball", "RedBall", "REDBALL", "value"])
def test_an_input_in_any_spelling_and_as_value(spelling):
    assert evaluate(f"{spelling}.x", {"Red ball": BALL}) == 3.0


def test_the_function_value_is_not_hidden_by_the_input_value():
    assert evaluate("VALUE(text) + len(value)", {"Text": "12"}) == 14


def test_columns_are_counted_in_letters():
    with pytest.raises(FormulaProblem) as caught:
        evaluate("'赤い' + ball.distanse")
    assert caught.value.column == 12


@pytest.mark.parametrize(
    ("stream", "name"),
    [("Blank", "sBlank"), ("TRUE", "sTrue"), ("2nd ball", "s2ndBall"), ("from", "sFrom"), ("ball-1", "ball1"), ("bäll", "bäll"), ("距離", "距離"), ("Abstand (m)", "abstandM")],
)  # fmt: skip
def test_stream_names_that_are_no_plain_words(stream, name):
    assert evaluate(f"{name} + 1", {stream: 1}) == 2


def test_two_inputs_of_one_name_are_refused():
    with pytest.raises(FormulaProblem) as caught:
        make_scope([("Red ball", None), ("red_ball", None)])
    assert caught.value.code == "FORM009"


def test_inputs_are_not_changed_and_records_pass_whole():
    ball = record_from_mapping("ball", dict(BALL))
    scope = make_scope([("ball", ball.type)])
    assert compile_formula("ball", scope).prepare(GuardedInterpreter())(ball) is ball


def test_every_function_is_documented_with_an_example():
    for name in library().names():
        function = library().get(name)
        assert function.help and function.usage.startswith(function.name)
        assert ">>>" in function.help or function.make is not None, name


WORDS = st.sampled_from(
    [*"()[]{}.,:+-*/%<>=!'\"^~&|@", " ", "**", "==", "and", "or", "not", "if", "else", "for", "in", "lambda", "x", "ball",
     "balls", "name", ".x", "1", "0", "9**9", "1e15", "'a'", "[1]", "range(", "sum(", "IF(", "max(", "sorted(", "f'{", "}'",
     "__", "None", "TRUE", "is", "REPT(", "concat(", "str(", "sqrt(", "IFERROR(", "_", "await", "yield", "*", ":="]
)  # fmt: skip


@pytest.mark.slow
@given(st.lists(WORDS, max_size=25).map(" ".join))
@settings(max_examples=example_count(400), deadline=None)
def test_any_formula_ends_soon_with_a_value_or_a_message(text):
    with work_within(1):
        try:
            result = evaluate(text)
        except FormulaProblem as problem:
            assert problem.message and problem.remedy
        else:
            assert result is None or isinstance(result, (bool, int, float, str, list, tuple, Record, Failure))
            assert not isinstance(result, Failure) or result.code != "FORM109"


@given(st.text(max_size=60))
@settings(max_examples=example_count(300), deadline=None)
def test_any_text_is_read_or_refused(text):
    try:
        evaluate(text)
    except FormulaProblem as problem:
        assert problem.message


@pytest.mark.parametrize(
    ("text", "code", "remedy"),
    [
        ("distance < 1", "FORM004", "redBall.distance"),
        ("X + 1", "FORM004", "redBall.x"),
        ("left", "FORM003", "left(…)"),
        ("redBall.colour = blue", "FORM004", '"blue"'),
    ],
)
def test_a_field_without_its_input_and_a_text_without_quotes(text, code, remedy):
    ball = load_robot().find("Red ball").type.payload
    with pytest.raises(FormulaProblem) as caught:
        compile_formula(text, make_scope([("Red ball", ball)]))
    assert caught.value.code == code and remedy in caught.value.remedy
