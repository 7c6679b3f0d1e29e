"""Both spellings of formulas: what means the same, what is refused, and where."""

from __future__ import annotations

import pytest
from examples import example_count
from hypothesis import given, settings
from hypothesis import strategies as st
from play import findings, rows

from rrp_sheets.formulas import FormulaProblem, compile_formula, make_scope
from rrp_sheets.formulas.evaluator import GuardedInterpreter
from rrp_sheets.formulas.tokens import tokenize
from rrp_sheets.model.values import record_from_mapping, to_json

BALL = {"distance": 12.5, "x": 3.0, "y": 4.0, "colour": "red", "visible": True}
INPUTS = {"ball": BALL, "x": 5, "y": 2.0, "balls": [1, 2, 3], "name": "Kim", "gone": None}


def evaluate(text, inputs=INPUTS):
    values = [record_from_mapping(n, v) if isinstance(v, dict) else v for n, v in inputs.items()]
    scope = make_scope([(n, getattr(v, "type", None)) for n, v in zip(inputs, values, strict=True)])
    return to_json(compile_formula(text, scope).prepare(GuardedInterpreter())(*values))


def refused(text, inputs=INPUTS):
    with pytest.raises(FormulaProblem) as caught:
        evaluate(text, inputs)
    return caught.value


@pytest.mark.slow
@pytest.mark.parametrize(
    ("sheet", "python"),
    [
        ("=IF(x>20, 0, 1)", "0 if x > 20 else 1"), ("=IF(x>20; 0; 1)", "0 if x > 20 else 1"), ("if(x<20;1;2)", "1 if x < 20 else 2"),
        ("IF(x>3;\"a\")", "'a' if x > 3 else False"), ("If (x = 5; IF(y = 2; 1; 2); 3)", "(1 if y == 2 else 2) if x == 5 else 3"),
        ("AND(x>3; y<10)", "x > 3 and y < 10"), ("OR(x>30; y>10)", "x > 30 or y > 10"), ("NOT(x>3)", "not x > 3"),
        ("And(x>3, y<10)", "x > 3 and y < 10"), ("not(x=5)", "not (x == 5)"), ("NOT(x)=FALSE", "(not x) == False"), ("and(x; y)", "x and y"),
        ("OR(AND(x=5;y=9);NOT(FALSE))", "(x == 5 and y == 9) or not False"), ("XOR(x=5; y=2)", "(x == 5) != (y == 2)"),
        ("x<>5", "x != 5"), ("x <> 6", "x != 6"), ("x=5", "x == 5"), ("name=\"kim\"", "name == 'kim'"), ("x≠5", "x != 5"), ("x≤5", "x <= 5"),
        ("x^2", "x ** 2"), ("(-x)^2", "(-x) ** 2"), ("-(x^2)", "-(x ** 2)"), ("2^-1", "2 ** -1"), ("(2^3)^2", "64"), ("2*x^2", "2 * x ** 2"),
        ("\"I see \"&ball.colour", "f'I see {ball.colour}'"), ("name&\" \"&x", "f'{name} {x}'"), ("x&y", "'52'"), ("\"a\"&1+1", "'a2'"),
        ("\"a\"&x=\"A5\"", "True"), ("TRUE&\"\"", "'TRUE'"), ("\"\"&0.1+0.2", "'0.3'"), ("1&\"\"=\"1\"", "True"), ("\"x\"&-1", "'x-1'"),
        ("TRUE", "True"), ("false", "False"), ("True()", "True"), ("TRUE( )", "True"), ("BLANK", "None"), ("IF(TRUE;1;2)", "1"),
        ("50%", "0.5"), ("5%*200", "10.0"), ("x*10%", "0.5"), ("(x+y)%", "0.07"), ("x%", "0.05"), ("100%", "1.0"), ("MAX(50%;20%)", "0.5"),
        ("10%3", "1"), ("x % 2", "1"), ("x%(2)", "1"), ("2^50%", "2 ** 0.5"), ("50%=0.5", "True"), ("50 %", "0.5"), ("x%y", "1.0"),
        ("MAX(1;2;x)", "max(1, 2, x)"), ("[1;2]", "[1, 2]"), ("(1;2)", "(1, 2)"), ("[\"a\"; \"b\"][1]", "'b'"), ("SUM([1;2];3)", "6"),
        ("Average(balls)", "average(balls)"), ("sUm(balls)", "sum(balls)"), ("log10(100)", "LOG10(100)"),
        ("\"say \"\"hi\"\"\"", "'say \"hi\"'"), ("\"\"\"\"", "'\"'"), ("\"a\"\"\"", "'a\"'"), ("\"\"", "''"), ("'it''s'", "\"it's\""),
        ("30°", "radians(30)"), ("-90°", "-radians(90)"), ("SIN(30 °)", "sin(radians(30))"), ("180º = pi", "True"), ("2*45°", "radians(90)"),
        ("=x", "x"), (" = x", "x"), ("=+x", "x"), ("=-x", "-x"), ("\n=x\n+1", "x + 1"),
        ("IF(ball.visible;ball.distance;BLANK)", "ball.distance if ball.visible else None"),
        ("IF(x>3;\"near; or, far\";1)", "'near; or, far'"), ("\"a = b <> c & d; 50%\"", "'a = b <> c & d; 50%'"),
        ("(1<2)=TRUE", "True"), ("0<x<10", "0 < x and x < 10"), ("1<=x<=5", "True"), ("x in balls", "False"),
        ("x==5==5", "True"), ("not x = 5", "False"), ("not x = 5 and y = 3", "False"), ("x>=5 and not y>5", "True"),
    ],
)  # fmt: skip
def test_a_spreadsheets_spelling_means_the_same_as_pythons(sheet, python):
    assert evaluate(sheet) == evaluate(python)


@pytest.mark.parametrize(
    ("typed", "value"),
    [
        ("“red”", "red"), ("„red“", "red"), ("”red”", "red"), ("‘red’", "red"), ("＂red＂", "red"), ('"red”', "red"), ("“red\"", "red"),
        ("“say ””hi”””", "say ”hi”"), ("‘it’s’", "it’s"), ('"it’s"', "it’s"), ('"“quoted”"', "“quoted”"), ("“she said 'no'”", "she said 'no'"),
        ("x – 1", 4), ("x—1", 4), ("−x", -5), ("x‑1", 4), ("x × 2", 10), ("x ÷ 2", 2.5), ("x\u00a0+\u00a01", 6), ("x\u202f+ 1", 6),
        ("（x＋１）＊２", 12), ("ＩＦ（ｘ＞３；１；２）", 1), ("＝ｘ", 5), ("［1；2］", [1, 2]), ("ball．x", 3.0), ("x\u200b+1", 6), ("\ufeffx", 5),
        ("x ≥ 5", True), ("“ＡＢＣ”", "ＡＢＣ"), ("\"50 ％\"", "50 ％"), ("５０％", 0.5), ("x\t+\t1", 6), ("x + 1 # closer", 6), ("# all\nx", 5),
        ("1_000", 1000), ("0x1F", 31), ("1.5E3", 1500.0), (".5", 0.5), ("5.", 5.0), ("007", 7), ("1e-3", 0.001),
        (r"'say \"hi\"'", 'say "hi"'), (r'"a\nb"', "a\nb"), (r'"a\\b"', "a\\b"), (r'"50\%"', "50\\%"), (r"'\u00e9'", "é"), (r'"\"', None),
        ("f\"{x}\"", "5"), ("F'{x:.1f}'", "5.0"), ("f\"{{{x}}}\"", "{5}"), ("f\"{IF(x=5;\"yes\";\"no\")}!\"", "yes!"), ("f'{x^2}'", "25"),
        ("f\"say \"\"{name}\"\"\"", 'say "Kim"'), ("f“{x} m”", "5 m"), ("f'{ball[\"x\"]:.0f}'", "3"), ("f'{name:>5}|'", "  Kim|"), ("f''", ""),
    ],
)  # fmt: skip
def test_what_is_typed_with_other_keys_is_folded(typed, value):
    if value is None:
        assert refused(typed).code == "FORM001"
    else:
        assert evaluate(typed) == value


@pytest.mark.parametrize(
    ("text", "code", "remedy"),
    [  # where the two worlds disagree: never guessed
        ("-x^2", "FORM003", "-(x^2)"), ("-2**2", "FORM003", "(-x)^2"), ("3 - -x^2", "FORM003", "(-x)^2"), ("2^3^2", "FORM003", "2^(3^2)"),
        ("2^-3^2", "FORM003", "(-x)^2"), ("LOG(100)", "FORM019", "LOG10"), ("log(2; 10)", "FORM019", "LN"), ("ATAN2(1;2)", "FORM019", "ANGLE(x; y)"),
        ("a = b = c", "FORM003", "AND(a = b"), ("x=5=TRUE", "FORM003", "AND"), ("1<x<>3", "FORM003", "AND"), ("TRUE=1", "FORM003", "TRUE"),
        ("not (x) = 5", "FORM003", "not (a = b)"), ("not(x)+1", "FORM003", "not"), ("50%-10%", "FORM003", "(50%)"), ("10 % -3", "FORM003", "MOD(10"),
        ("3,5", "FORM003", "3.5"), ("x*1,5", "FORM003", "1.5"), ("x < 0,8", "FORM003", "0.8"), ("1.000,5", "FORM003", "1000.5"),
        ("1,000", "FORM003", "1000"), ("IF(x>0,5; 1; 2)", "FORM003", "0.5"), ("MAX(1,5;2)", "FORM003", "1.5"), ("[0,5; 1,5]", "FORM003", "0.5"),
        ("MAX(x,y;2)", "FORM003", "same sign"), ("x, y", "FORM003", "brackets"), ("x; y", "FORM003", "brackets"), ("ROUND(2,5,1)", "FORM006", "2.5"),
        # spreadsheets' own
        ("A1", "FORM018", "ball"), ("=A1+1", "FORM018", "ball"), ("$A$1", "FORM018", "ball"), ("A$1", "FORM018", "ball"), ("SUM(A1:B3)", "FORM018", "ball"),
        ("A1:A3", "FORM018", "ball"), ("Sheet1!A1", "FORM018", "Parts[Ask]"), ("'My sheet'!$B$2", "FORM018", "Parts[Ask]"), ("AB12*2", "FORM018", "ball"),
        ("{1;2}", "FORM003", "[1; 2]"), ("SUM({1,2})", "FORM003", "[1; 2]"), ("#REF!", "FORM001", "again"), ("x+#N/A", "FORM001", "again"),
        ("@x", "FORM003", "out"), ("MAX(1;;2)", "FORM001", "BLANK"), ("IF(x>3;;1)", "FORM001", "BLANK"), ("MAX(;)", "FORM001", "BLANK"),
        ("MAX(1;)", "FORM001", "BLANK"), ("VLOOKUP(x;balls;2)", "FORM005", "XLOOKUP"), ("WENN(x>3;1;2)", "FORM005", "IF"), ("SOMME(balls)", "FORM005", "SUM"),
        ("RAND()", "FORM005", "PICK"), ("NOW()", "FORM005", "timestamp"), ("wahr", "FORM004", "TRUE"), ("null", "FORM004", "BLANK"),
        # what people write
        ("x > 3 AND y < 1", "FORM001", "small letters"), ("NOT x", "FORM001", "NOT(…)"), ("x && y", "FORM003", "AND"), ("x || y", "FORM003", "OR"),
        ("!x", "FORM003", "NOT"), ("x ? 1 : 2", "FORM003", "IF"), ("x => 3", "FORM003", ">="), ("x =< 3", "FORM003", "<="), ("x++", "FORM001", "belongs"),
        ("x += 1", "FORM001", "belongs"), ("20 cm", "FORM001", "metres"), ("20cm", "FORM001", "metres"), ("30 deg", "FORM001", "30°"), ("2x", "FORM001", "2 * x"),
        ("1 000", "FORM001", "1000"), ("x²", "FORM001", "^2"), ("√x", "FORM001", "SQRT"), ("½", "FORM001", "0.5"), ("«red»", "FORM001", "quotes"),
        ("if x > 3 then 1", "FORM001", "IF(x < 1"), ("x > 3 then 5", "FORM001", "IF(x < 1"), ("'red' if x > 3", "FORM001", "IF("), ("x between 1 and 2", "FORM001", "<= 2"),
        ('"a" "b"', "FORM001", "&"), ('"a" name', "FORM001", "&"), ("x name", "FORM001", "&"), ("(x", "FORM001", ")"), ("x)", "FORM001", "bracket"), ("[x", "FORM001", "]"),
        ("", "FORM001", "Write"), ("=", "FORM001", "Write"), ("x +", "FORM001", "belongs"), ("* x", "FORM003", "list"), ("x * * 2", "FORM001", "belongs"),
        ('"red', "FORM001", "same quote"), ("x..y", "FORM001", "distance"), ("'it's'", "FORM001", "double quotes"), ("balls[0,1]", "FORM001", "[0]"), ("MAX()", "FORM006", "MAX("), ("x.", "FORM001", "distance"), ("1..2", "FORM001", "point"), ("x:y", "FORM001", "["),
        ("= = x", "FORM001", "belongs"), ("x = = 3", "FORM001", "=="), ("()()", "FORM003", ""), ("balls[]", "FORM001", "["), ("balls[1:2:3:4]", "FORM001", "["),
        # programs
        ("lambda: 1", "FORM003", "calculation"), ("(q := 5)", "FORM003", "accumulate"), ("import os", "FORM001", "calculation"), ("x.y = 1 for", "FORM001", ""),
        ("max(*balls)", "FORM003", "list"), ("max(**balls)", "FORM003", "list"), ("round(x, places=1)", "FORM003", "alone"), ("name.upper()", "FORM003", "UPPER"),
        ("sum(i for i in balls)", "FORM003", "[ ]"), ("{'a': 1}", "FORM003", "XLOOKUP"), ("b'a'", "FORM003", "out"), ("r'a'", "FORM003", "out"),
        ("'''a'''", "FORM003", "one quote"), ("f'{x!r}'", "FORM003", ".1f"), ("f'{x=}'", "FORM001", "belongs"), ("f'{}'", "FORM001", ""),
        ("f'{x'", "FORM001", "quote"), ("f'}'", "FORM001", "}}"), (r"'\x1b'", "FORM003", "backslash"), (r"'\N{DASH}'", "FORM003", "itself"), ("x is 5", "FORM003", "="),
        ("1j", "FORM001", "1 * j"), ("x @ y", "FORM003", ""), ("x << 1", "FORM003", ""), ("~x", "FORM003", "NOT"), ("x | y", "FORM003", "OR"), ("`x`", "FORM003", "quotes"),
        ("[x for x in balls]", "FORM003", "name"), ("[q for sum in balls]", "FORM003", "name"), ("[q for (q) in balls]", "FORM003", ""), ("[0 for q.x in balls]", "FORM003", "name"),
    ],
)  # fmt: skip
def test_what_is_refused_is_told_with_how_to_write_it(text, code, remedy):
    problem = refused(text)
    assert (problem.code, remedy in problem.remedy) == (code, True), problem.remedy


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "marked"),
    [
        ("  = “赤い” & ball.distanse", "distanse"), ("IF(x > 3; fo(1); 2)", "fo"), ("=  x + disstance", "disstance"), ("MAX(1,5; 2)", "1,5"),
        ("３ ＋ ＡＢＣ", "ＡＢＣ"), ("x ≤ unknown", "unknown"), ("-x^2 + 1", "-x^2"), ("f\"it is {disstance:.1f}\"", "disstance"), ("SUM(A1:B3)", "A1:B3"),
        ("sqrt(1; 2)", "sqrt"), ("'a' & \"it\"\"s\" & fo", "fo"), ("x > 3 AND y", "AND"), ("ball['distanse']", "'distanse'"), ("x \"a\"", "\"a\""),
        ("10000000000000001 + 1", "10000000000000001"), ("f'{x:999}'", "{x:999}"), ("IF(x; name.upper(); 1)", "name.upper"), ("log(x)", "log"),
    ],
)  # fmt: skip
def test_problems_point_into_what_was_typed(text, marked):
    problem = refused(text)
    start = problem.column
    assert text[start : start + problem.length].strip("'") == marked.strip("'"), text[start : start + problem.length]


def test_failures_point_into_what_was_typed_and_name_the_helper():
    failure = compile_formula("=  “赤” & 1 / x", make_scope([("x", None)])).prepare(GuardedInterpreter())(0)
    assert (failure.code, failure.column) == ("FORM101", 9)


@pytest.mark.parametrize(
    ("shown", "name"),
    [("Red ball", "redBall"), ("2nd ball", "s2ndBall"), ("Red ball", "red_ball"), ("赤い ボール", "赤いボール"), ("Größe", "größe"),
     ("ลูกบอล", "ลูกบอล"), ("गेंद", "गेंद"), ("A1", "A1"), ("B12", "b12"), ("Abstand (m)", "abstandM"), ("if", "sIf"), ("Not", "sNot")],
)  # fmt: skip
def test_streams_of_any_name(shown, name):
    assert evaluate(f"{name} + 1", {shown: 1, "other": 2}) == 2


@pytest.mark.parametrize(
    ("text", "offer"),
    [("Red ball.x", "redBall"), ("2nd ball.x", "s2ndBall"), ("IF(Red ball.x > 1; 1; 2)", "redBall"), ("Bal.x", "ball")],
)
def test_a_name_as_it_stands_in_the_sheet_is_answered_with_its_name_in_formulas(text, offer):
    assert offer in refused(text, {"Red ball": BALL, "2nd ball": BALL, "ball": BALL}).remedy


def test_the_function_value_is_there_beside_the_input_value():
    assert evaluate("VALUE(value) + 1", {"value": "2"}) == 3


@given(st.text(max_size=80))
@settings(max_examples=example_count(300), deadline=None)
def test_tokens_lie_side_by_side_in_any_text(text):
    try:
        tokens = tokenize(text)
    except FormulaProblem as problem:
        assert problem.message and problem.remedy and 0 <= problem.column <= len(text)
        return
    ends = 0
    for token in tokens:
        assert ends <= token.start <= token.end <= len(text)
        ends = token.end


@given(st.text(alphabet="ab\"“”„'‘’ \\", max_size=20))
@settings(max_examples=example_count(300), deadline=None)
def test_any_text_can_be_written_between_quotes(text):
    doubled = text.replace("\\", "\\\\").replace('"', '""')
    assert evaluate(f'"{doubled}" & "!"') == text + "!"


# ---- what a spreadsheet compares, and Python sets


@pytest.mark.parametrize("text", ["x = 1", "ball.x = 99", "ball['x'] = 0", "  x  =  1 "])
def test_a_number_that_looks_as_if_it_were_set_is_refused_where_no_condition_is_wanted(text: str) -> None:
    ball = record_from_mapping("ball", {"x": 3.0}).type
    scope = make_scope([("x", None), ("ball", ball)])
    with pytest.raises(FormulaProblem) as refused:
        compile_formula(text, scope, condition=False)
    remedy = refused.value.remedy
    assert "==" in remedy
    for way in (text.replace(" = ", " == "), "=" + text.strip(), text.strip().replace(" ", "")):
        compile_formula(way, scope, condition=False)
    compile_formula(text, scope)  # a filter asks


def test_a_filter_may_ask_with_a_single_equals_sign_and_a_map_says_how() -> None:
    text = """
    | Red ball | filter | redBall.distance = 1 | Near |
    | Red ball | map | redBall.distance = 1 | IsNear |
    | Near | subscribe | | Print |
    | IsNear | subscribe | | Print |
    """
    assert findings(rows(text)) == [("FORM003", "C3")]
