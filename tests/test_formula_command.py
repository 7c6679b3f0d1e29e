"""`rrp-sheets formula`: one formula from the command line, or lines of JSON."""

from __future__ import annotations

import json

import pytest
from click.testing import CliRunner
from examples import example_count
from hypothesis import given, settings
from hypothesis import strategies as st

from rrp_sheets import api
from rrp_sheets.cli.formula import formula_command
from rrp_sheets.formulas.trial import answer_line


def formula(*arguments, lines=None):
    return CliRunner().invoke(formula_command, list(arguments), input=lines)


@pytest.mark.parametrize(
    ("text", "inputs", "shown"),
    [
        ("IF(x>3; 1; 0)", ["x=5"], "1"), ("x & y", ["x=2.5", "y=red"], '"2.5red"'), ("ball.distance < 1", ['ball={"distance": 0.4}'], "TRUE"),
        ("[x; BLANK]", ["x=TRUE"], "[TRUE; BLANK]"), ("1/3", [], "0.333333333333333"), ("redBall", ["Red ball=7"], "7"), ("x", ["x="], "BLANK"),
        ("SUM(x)", ["x=[1, 2]"], "3"), ("x", ['x="5"'], '"5"'), ('"a ""b"""', [], '"a ""b"""'), ("ball", ['ball={"x": 1, "Is red": true}'], "ball: x 1, Is red TRUE"),
    ],
)  # fmt: skip
def test_a_value_is_shown_as_a_formula_would_have_it(text, inputs, shown):
    result = formula(text, *(part for i in inputs for part in ("--input", i)))
    assert (result.exit_code, result.output) == (0, shown + "\n")


@pytest.mark.parametrize(
    ("text", "caret"),
    [("x + disstance", "      ^^^^^^^^^"), ("“赤い” & disstance", "           ^^^^^^^^^"), ("1 / x", "  ^"), ("x +", "    ^"), ("IF(x > 3; -x^2; 0)", "            ^^^^")],
)  # fmt: skip
def test_a_problem_is_marked_below_what_was_typed(text, caret):
    result = formula(text, "--input", "x=0")
    typed, marks, message, *_ = result.output.splitlines()
    assert result.exit_code == 1 and typed == f"  {text}" and message.startswith("error FORM")
    assert marks.rstrip() == caret if text != "1 / x" else "^" in marks


def test_an_input_that_was_not_given_is_asked_for():
    result = formula("IF(x > 3; 1; 0)")
    assert result.exit_code == 1 and "→ Give it a value: --input x=5." in result.output
    result = formula("IF(x > y; 1; 0)", "--input", "x=2")
    assert "→ Give it a value: --input y=5. The input is called x here." in result.output
    assert "Did you mean distance" in formula("distence", "--input", "distance=1").output
    assert "--input" not in formula("_x").output


@pytest.mark.parametrize(
    "order", [("-x^2", "--input", "x=2"), ("--input", "x=2", "-x^2"), ("--input", "x=2", "--", "-x^2")]
)
def test_a_formula_may_begin_with_a_minus(order):
    result = formula(*order)
    assert result.exit_code == 1 and "FORM" in result.output and "-(x^2)" in result.output
    assert formula("-x + 3", "--input", "x=2").output == "1\n" and formula("-3").output == "-3\n"


def test_all_that_is_wrong_with_a_formula_is_told():
    result = formula("foo(1) + bar + baz", "--input", "x=0")
    assert result.exit_code == 1
    marks = [line.index("^") - 2 for line in result.output.splitlines() if "^" in line]
    assert marks == [0, 9, 15]
    answer = json.loads(formula("foo(1) + bar + baz", "--input", "x=0", "--json").output)
    assert [(o["code"], o["column"]) for o in (answer, *answer["others"])] == [
        ("FORM005", 0), ("FORM004", 9), ("FORM004", 15)
    ]  # fmt: skip


def test_one_formula_answered_in_json():
    result = formula("x^2", "--input", "x=5", "--json")
    assert (result.exit_code, json.loads(result.output)) == (0, {"outcome": "ok", "value": 25})
    result = formula("1/x", "--input", "x=0", "--json")
    assert result.exit_code == 1 and json.loads(result.output)["code"] == "FORM101"


@pytest.mark.parametrize(
    ("line", "outcome", "code", "column"),
    [
        ('{"formula": "x + 1", "inputs": {"x": 5}}', "ok", None, None), ('{"formula": "1"}', "ok", None, None),
        ('{"formula": "x + disstance", "inputs": {"x": 5}}', "rejected", "FORM004", 4), ('{"formula": "x + 1 / 0", "inputs": {"x": 5}}', "error", "FORM101", 4),
        ('{"formula": "ball.y", "inputs": {"ball": {"x": 1}}}', "rejected", "FORM007", 5), ("{", "rejected", "FORM022", -1), ("[]", "rejected", "FORM022", -1),
        ("null", "rejected", "FORM022", -1), ('{"formula": 5}', "rejected", "FORM022", -1), ('{"formula": "1", "inputs": []}', "rejected", "FORM022", -1),
        ('{"formula": "x", "inputs": {"x": NaN}}', "rejected", "FORM022", -1), ('{"formula": "x", "inputs": {"x": Infinity}}', "rejected", "FORM022", -1),
        ('{"formula": "x", "inputs": {"x": 1e999}}', "rejected", "FORM022", -1), ('{"formula": "x", "inputs": {"x": 1e16}}', "rejected", "FORM022", -1),
        ('{"formula": "x", "inputs": {"x": ' + "9" * 5000 + "}}", "rejected", "FORM022", -1), ("[" * 100_000, "rejected", "FORM022", -1),
        ('{"formula": "x", "inputs": {"x": ' + "[" * 20 + "]" * 20 + "}}", "rejected", "FORM022", -1), ('{"formula": "x", "inputs": {"x": "\\ud800"}}', "rejected", "FORM022", -1),
        ('{"formula": "x", "inputs": {"x": "' + "a" * 2001 + '"}}', "rejected", "FORM022", -1), ('{"formula": "\\ud800"}', "rejected", "FORM001", 0),
        ('{"formula": "b", "inputs": {"b": {"a b": 1, "a_b": 2}}}', "rejected", "FORM022", -1), ('{"formula": "x", "inputs": {"x": 1, "X": 2}}', "rejected", "FORM009", -1),
        ('{"formula": "1", "inputs": {' + ",".join(f'"x{i}": 1' for i in range(51)) + "}}", "rejected", "FORM022", -1),
        ('{"formula": "sClass", "inputs": {"__class__": 1}}', "ok", None, None), ('{"formula": "b.c.d", "inputs": {"b": {"c": {"d": 4}}}}', "ok", None, None),
        ('{"formula": "b.__class__", "inputs": {"b": {"__class__": 4}}}', "rejected", "FORM003", 0), ('{"formula": "x.real", "inputs": {"x": 1}}', "rejected", "FORM021", 0),
    ],
)  # fmt: skip
def test_a_line_of_json_is_answered_by_one(line, outcome, code, column):
    result = formula("--json", lines=line + "\n")
    assert result.exit_code == 0 and result.output.count("\n") == 1
    answer = json.loads(result.output)
    assert (answer["outcome"], answer.get("code"), answer.get("column")) == (outcome, code, column), answer


def test_lines_are_answered_in_order_whatever_they_are():
    lines = b'{"formula": "1"}\n\xff\xfe{\n\n{"formula": "2"}\n' + b"x" * 5_000_000 + b'\n{"formula": "3"}'
    answers = [json.loads(a) for a in formula("--json", lines=lines).output.splitlines()]
    assert [a.get("value", a.get("code")) for a in answers] == [1, "FORM022", 2, "FORM022", 3]


def test_inputs_that_are_none_and_a_missing_formula():
    assert formula("1", "--input", "x").exit_code == 2 and formula().exit_code == 2
    assert formula("x", "--input", "x=1", "--input", "X=2").exit_code == 1


def test_the_facade():
    assert api.formula("SUM(a)", {"a": [1, 2]}).as_dict() == {"outcome": "ok", "value": 3}


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=10),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=5), inner, max_size=4), max_leaves=10,
)  # fmt: skip


@pytest.mark.slow
@given(
    st.text(max_size=30) | st.sampled_from(["x", "x & 1", "x.a", "[x]", "x = x"]),
    st.dictionaries(st.text(max_size=3) | st.just("x"), JSON, max_size=3),
)
@settings(max_examples=example_count(300), deadline=None)
def test_any_request_has_an_answer_that_is_json(text, inputs):
    answer = answer_line(json.dumps({"formula": text, "inputs": inputs})).as_dict()
    assert answer["outcome"] in ("ok", "rejected", "error")
    again = json.loads(json.dumps(answer, allow_nan=False))
    assert again["outcome"] == "ok" or (
        again["code"].startswith("FORM") and again["message"] and again["code"] != "FORM109"
    )
