"""Tables, PICK, helpers and what connectors add to a scope."""

from __future__ import annotations

import itertools
from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rrp_sheets.formulas import FormulaProblem, HelperDef, Input, Picker, compile_formula, make_scope, make_table
from rrp_sheets.formulas.evaluator import GuardedInterpreter
from rrp_sheets.model.values import Failure, to_json

PARTS = make_table("Parts", [
    ["Ask", "Zone", "What it means", "Points", "Last"], ["Where is my head?", "head", "top", "2", "FALSE"],
    ["Where is my hand?", "Hand", "arm", "0.5", "false"], ["Where is my toe?", "foot", "", "-1", "TRUE"],
])  # fmt: skip
ANSWERS = make_table("My answers", [["Word", "Means"], ["yes", "yes"], ["okay", "yes"], ["no", "no"]])
TABLES = {"parts": PARTS, "myanswers": ANSWERS}


def helper(name, inputs, text, helpers=None, tables=TABLES):
    scope = make_scope([(i, None) for i in inputs], helpers, tables=tables)
    return HelperDef(name, tuple(Input(i, i) for i in inputs), compile_formula(text, scope).tree)


def evaluate(text, inputs=None, helpers=None, picker=None, **scope):
    inputs = {"step": 2, "word": "OKAY"} if inputs is None else inputs
    formula = compile_formula(text, make_scope([(n, None) for n in inputs], helpers, tables=TABLES, **scope))
    return formula.prepare(GuardedInterpreter(), picker)(*inputs.values())


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("ROWS(Parts)", 3), ("ROWS(parts)", 3), ("LEN(Parts)", 3), ("step <= ROWS(Parts)", True),
        ("INDEX(Parts; step).zone", "Hand"), ("INDEX(Parts; 1).what_it_means", "top"), ("INDEX(Parts; 3)['What it means']", None),
        ("INDEX(Parts[Ask]; step)", "Where is my hand?"), ("Parts[Zone]", ["head", "Hand", "foot"]), ("Parts[zone]", ["head", "Hand", "foot"]),
        ("Parts[What it means]", ["top", "arm", None]), ("Parts[ What it means ]", ["top", "arm", None]), ("Parts['Zone'][0]", "head"),
        ("SUM(Parts[Points])", 1.5), ("Parts[Last]", [False, False, True]), ("MAX(Parts[Points]) + 1", 3),
        ("XLOOKUP(word; myAnswers[Word]; myAnswers[Means])", "yes"), ("XLOOKUP(\"hand\"; Parts[Zone]; Parts).points", 0.5),
        ("XLOOKUP(\"maybe\"; myAnswers[Word]; myAnswers[Means]; \"?\")", "?"), ("XLOOKUP(\"maybe\"; myAnswers[Word]; myAnswers; BLANK)", None),
        ("MATCH(\"FOOT\"; Parts[Zone])", 3), ("MATCH(\"foot\"; Parts[Zone]; 0)", 3), ("PICK(Parts).zone", "head"), ("PICK([3; 4])", 3),
        ("PICK(3; 4)", 3), ("[p.zone for p in Parts if p.points > 0]", ["head", "Hand"]), ("FIRST(Parts).zone & LAST(Parts).zone", "headfoot"),
        ("ISBLANK(INDEX(Parts; 3).whatItMeans)", True), ("\"hand\" in Parts[Zone]", True), ("COUNTIF(myAnswers[Means]; \"yes\")", 2),
        ("INDEX(Parts; step)", {"Ask": "Where is my hand?", "Zone": "Hand", "What it means": "arm", "Points": 0.5, "Last": False}),
    ],
)  # fmt: skip
def test_tables(text, value):
    assert to_json(evaluate(text)) == value


@pytest.mark.parametrize(
    ("text", "code", "remedy"),
    [
        ("Parts", "FORM020", "INDEX(Parts; 1)"), ("Parts[Zon]", "FORM017", "Parts[Zone]"), ("Parts[xyz]", "FORM017", "Ask, Zone"),
        ("Parts[2]", "FORM017", "INDEX(Parts; 2)"), ("Parts.zone", "FORM021", "Parts[zone]"), ("Parts(2)", "FORM005", "INDEX"),
        ("Part[Zone]", "FORM004", "parts"), ("INDEX(Parts; 1).zon", "FORM007", "Zone"), ("PICK(Parts).zon", "FORM007", "Zone"),
        ("My answers[Word]", "FORM001", "myAnswers"), ("Parts[Zone", "FORM001", "Parts["), ("[0 for parts in [1]]", "FORM003", "name"),
    ],
)  # fmt: skip
def test_what_is_refused(text, code, remedy):
    with pytest.raises(FormulaProblem) as caught:
        evaluate(text)
    assert (caught.value.code, remedy in caught.value.remedy) == (code, True), caught.value.remedy


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("INDEX(Parts; 4)", "FORM112"), ("INDEX(Parts; 0)", "FORM112"), ("XLOOKUP(\"x\"; Parts[Zone]; Parts)", "FORM111"), ("MATCH(9; [1])", "FORM111"),
        ("XLOOKUP(1; Parts; Parts)", "FORM103"), ("XLOOKUP(1; [1]; Parts)", "FORM107"), ("MATCH(1; [1]; 1)", "FORM107"), ("PICK([])", "FORM107"),
        ("IF(step = 2; Parts; 1)", "FORM110"), ("[Parts]", "FORM110"), ("Parts & 1", "FORM103"), ("Parts + 1", "FORM103"), ("PICK(1)", "FORM103"),
        ("IF(Parts; 1; 2)", "FORM108"), ("INDEX(Parts; 1.5)", "FORM107"), ("INDEX(Parts; BLANK)", "FORM102"),
    ],
)  # fmt: skip
def test_errors_have_their_own_words(text, code):
    failure = evaluate(text)
    assert isinstance(failure, Failure) and failure.code == code and failure.message


def test_a_row_of_a_table_travels_and_the_table_does_not_change():
    row = evaluate("INDEX(Parts; 1)")
    assert row is PARTS.rows[0] and PARTS.column("zone") == ["head", "Hand", "foot"]


def test_names_resolve_to_inputs_helpers_and_constants_before_tables():
    assert evaluate("parts + 1", {"Parts": 1}) == 2
    assert evaluate("parts", {"x": 1}, {"parts": helper("parts", [], "7")}) == 7
    assert evaluate("parts[0]", {"Parts": [5]}) == 5


def test_cells_of_a_table_are_numbers_truths_blanks_or_texts():
    cells = ["3", "-0.5", "1e3", "−2", "TRUE", "false", "", "007", "1,5", "2 m", "1e99", " 4 ", "99999999999999999"]
    table = make_table("T", [["V"], *([c] for c in cells)])
    assert table.column("V") == [
        3,
        -0.5,
        1000.0,
        -2,
        True,
        False,
        None,
        "007",
        "1,5",
        "2 m",
        "1e99",
        4,
        "99999999999999999",
    ]


def test_headers_without_or_with_the_same_name_and_short_rows():
    table = make_table("T", [["A b", "", "a_B", "C"], ["1", "2", "3"], []])
    assert [f.name for f in table.type.fields] == ["A b", "C"] and to_json(table.rows[0]) == {"A b": 1, "C": None}


# ---- PICK


@given(st.integers(0, 10**9), st.integers(2, 12))
@settings(max_examples=60, deadline=None)
def test_each_once_before_any_repeats_and_never_the_same_twice_running(seed, size):
    picker = Picker(seed, "Play!3")
    drawn = [picker.pick("#1", list(range(size))) for _ in range(size * 4)]
    for start in range(0, len(drawn), size):
        assert sorted(drawn[start : start + size]) == list(range(size))
    assert all(a != b for a, b in itertools.pairwise(drawn))


def test_the_same_seed_draws_the_same_on_every_machine_and_rows_and_places_differ():
    praise = list("abcdefgh")

    def draws(seed, row, site):
        picker = Picker(seed, row)
        return "".join(picker.pick(site, praise) for _ in range(8))

    assert draws(7, "Play!3", "#1") == "fbachdge"
    assert (
        len({draws(7, "Play!3", "#1"), draws(7, "Play!4", "#1"), draws(7, "Play!3", "#2"), draws(8, "Play!3", "#1")})
        == 4
    )


@pytest.mark.parametrize(
    ("text", "drawn"),
    [("PICK(list)", "dgfabhec"), ('PICK([x for x in list if x > "a"])', "ceghfdbd"),
     ('PICK("a"; "b"; UPPER("c"); "d"; "e")', "CadbedCa"), ("PICK(SORT(list))", "gfchaedb")],
)  # fmt: skip
def test_a_formula_draws_the_same_in_every_python(text, drawn):
    evaluate = compile_formula(text, make_scope([("List", None)])).prepare(GuardedInterpreter(), Picker(7, "A!2"))
    assert "".join(evaluate(list("abcdefgh")) for _ in range(8)) == drawn


def test_picks_of_one_list_in_a_formula_share_its_draws():
    formula = compile_formula("PICK(list) & PICK(list)", make_scope([("List", None)]))
    evaluate = formula.prepare(GuardedInterpreter(), Picker(1, "A!2"))
    drawn = "".join(evaluate(list("abcd")) for _ in range(8))
    for first in range(0, 16, 4):
        assert sorted(drawn[first : first + 4]) == list("abcd")
    assert all(x != y for x, y in pairwise(drawn))


def test_picks_of_different_lists_have_draws_of_their_own():
    formula = compile_formula("PICK(one) & PICK(two)", make_scope([("One", None), ("Two", None)]))
    evaluate = formula.prepare(GuardedInterpreter(), Picker(1, "A!2"))
    drawn = [evaluate(list("ab"), list("xyz")) for _ in range(6)]
    assert sorted(d[0] for d in drawn[:2]) == ["a", "b"] and sorted(d[1] for d in drawn[:3]) == ["x", "y", "z"]


def test_a_list_that_changes_its_length_begins_anew_and_one_of_one_repeats():
    picker = Picker(3, "A!2")
    assert [picker.pick("", [1]) for _ in range(3)] == [1, 1, 1]
    assert picker.pick("", [1, 2]) == 2
    assert sorted(picker.pick("", ["a", "b", "c"]) for _ in range(3)) == ["a", "b", "c"]


def test_pick_in_a_helper_draws_for_the_row_that_calls_it():
    helpers = {"praise": helper("praise", [], 'PICK("a"; "b"; "c")')}
    formula = compile_formula("praise & value", make_scope([("", None)], helpers))
    rows = [formula.prepare(GuardedInterpreter(), Picker(7, ref)) for ref in ("A!2", "A!3")]
    drawn = [[row("!") for _ in range(3)] for row in rows]
    assert all(sorted(d) == ["a!", "b!", "c!"] for d in drawn)


# ---- helpers and what connectors add


def test_helpers_call_helpers_use_tables_and_have_positional_arguments():
    helpers = {}
    helpers["zoneof"] = helper("zoneOf", ["n"], "INDEX(Parts; n).zone")
    helpers["shout"] = helper("shout", ["n"], 'UPPER(zone_of(n)) & "!"', helpers)
    helpers["limit"] = helper("limit", [], "3")
    assert evaluate("SHOUT(step)", helpers=helpers) == "HAND!" and evaluate("step < limit", helpers=helpers) is True


def test_a_failure_in_a_helper_says_where_and_points_at_the_call():
    helpers = {"inverse": helper("inverse", ["n"], "1 / n")}
    failure = evaluate("step + inverse(0)", helpers=helpers)
    assert (failure.code, failure.column) == ("FORM101", 7) and "In the helper inverse:" in failure.message


@pytest.mark.parametrize(
    ("text", "value"), [("total + 1", 8), ("IF(ISBLANK(start); total + 1; 1)", 8), ("value & next", "vn")]
)
def test_what_a_connector_adds_comes_before_the_inputs(text, value):
    scope = make_scope([("Start", None), ("Next", None)], extra=("total", "value"))
    assert scope.order == ("total", "value", "start", "next")
    assert compile_formula(text, scope).prepare(GuardedInterpreter())(7, "v", None, "n") == value


def test_an_unnamed_stream_is_the_value_that_the_connector_adds():
    scope = make_scope([("", None)], extra=("total", "value"))
    assert compile_formula("total + value", scope).prepare(GuardedInterpreter())(1, 2, 3) == 3
    with pytest.raises(FormulaProblem) as caught:
        make_scope([("Total", None)], extra=("total", "value"))
    assert caught.value.code == "FORM009"


def test_a_field_of_a_plain_number_is_refused_before_the_run():
    scope = make_scope([("Head yaw", None)], kinds={"Head yaw": "number"})
    with pytest.raises(FormulaProblem) as caught:
        compile_formula("headYaw.angle", scope)
    assert caught.value.code == "FORM021" and "headYaw is a number" in caught.value.message
