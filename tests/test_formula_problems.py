"""Everything that is wrong with one formula is told at once, each at its place; nothing that only follows."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from play import check, rows

from rrp_sheets.formulas import FormulaProblem, compile_formula, make_scope

SCOPE = make_scope([("Red ball", None), ("Count", None)])
COLUMNS = "| On | Input streams | Connector | Formula | Output stream |\n|---|---|---|---|---|\n"


def problems(text: str) -> list[tuple[str, str]]:
    """The code and the text of each problem."""
    try:
        compile_formula(text, SCOPE)
    except FormulaProblem as problem:
        return [(one.code, text[one.column : one.column + one.length]) for one in problem.every]
    return []


SEVERAL = [
    ("redBal.x + SQRRT(cuont) * 2^3^2",
     [("FORM004", "redBal"), ("FORM005", "SQRRT"), ("FORM004", "cuont"), ("FORM003", "2^3^2")]),
    ("foo(bar; baz)", [("FORM005", "foo"), ("FORM004", "bar"), ("FORM004", "baz")]),
    ("MAX(1 +; 2) + foo(cuont)", [("FORM001", ";"), ("FORM005", "foo"), ("FORM004", "cuont")]),
    ("IF(a b; c; SQRRT(2))", [("FORM001", "b"), ("FORM004", "c"), ("FORM005", "SQRRT")]),
    ("MAX(1;; 2) + ABS(1; 2) + ABS()", [("FORM001", ";"), ("FORM006", "ABS"), ("FORM006", "ABS")]),
    ('f"{cuont} {SQRRT(2)}"', [("FORM004", "cuont"), ("FORM005", "SQRRT")]),
    ("[n * fooo for n in bar] ", [("FORM004", "fooo"), ("FORM004", "bar")]),
    ("-count^2 + MAX(not; cuont)", [("FORM003", "-count^2"), ("FORM001", ";"), ("FORM004", "cuont")]),
    ("IF(nota = 1; redBall; redBall(1))", [("FORM003", "nota = 1"), ("FORM003", "redBall(1)")]),
]  # fmt: skip


@pytest.mark.parametrize(("text", "told"), SEVERAL)
def test_each_problem_is_told_with_its_place(text: str, told: list[tuple[str, str]]) -> None:
    assert problems(text) == told


FOLLOWING = [
    ("cuont + cuont * cuont", "FORM004"),  # one name, misspelt alike
    ("cuont.x + cuont[0].y", "FORM004"),  # fields of what is not known
    ("PICK(prts[A])", "FORM004"),  # the column of a table that is not known
    ("SQRT(1 2; 3)", "FORM001"),  # how many there are to be is not known
    ("CLAMP(count 0; 1)", "FORM001"),
    ("IFERROR(cuont; 1)", "FORM004"),
    ("(1 + (2 * count) ", "FORM001"),  # brackets that do not end
    ("MIN(0,5; 3)", "FORM003"),
    ('"a & cuont', "FORM001"),
    ("SUM([n for n in cuont if n > 1])", "FORM004"),
]


@pytest.mark.parametrize(("text", "code"), FOLLOWING)
def test_what_only_follows_is_not_told(text: str, code: str) -> None:
    assert [found for found, _ in problems(text)] == [code]


def test_the_check_shows_them_all_in_the_cell_with_spans_and_fixes() -> None:
    line = "| | Red ball | map | SQRRT(redBal.x) + ABS(1; 2) | X |\n| | X | subscribe | | Print |"
    found = [d for d in check(rows(line, header=COLUMNS)).report if d.code.startswith("FORM")]
    assert [(d.code, str(d.address), d.span) for d in found] == [
        ("FORM004", "T!D2", (6, 12)), ("FORM005", "T!D2", (0, 5)), ("FORM006", "T!D2", (18, 21)),
    ]  # fmt: skip
    assert {fix.title for d in found for fix in d.fixes} == {"Write SQRT", "Write redBall"}


def test_a_helper_tells_all_its_problems_too() -> None:
    helpers = "\n## Helpers\n| Name | Inputs | Formula |\n|---|---|---|\n| Near | x | SQRRT(x) + yy |\n"
    line = "| | Red ball | map | redBall.x | X |\n| | X | subscribe | | Print |"
    found = check(rows(line, helpers, header=COLUMNS)).report
    assert [d.code for d in found if d.address and d.address.sheet == "Helpers" and d.code.startswith("FORM")] == [
        "FORM004", "FORM005",
    ]  # fmt: skip


@given(st.lists(st.sampled_from(["foo(", "ABS(", ")", ";", ",", "[", "]", "cuont", "count", "1 ", "+ ", "for n in ", "- ", "^", '"a"', "not ", "if ", "else "]), max_size=14))  # fmt: skip
def test_any_formula_is_refused_in_order_and_within_its_text(parts: list[str]) -> None:
    text = "".join(parts)
    try:
        compile_formula(text, SCOPE)
    except FormulaProblem as problem:
        places = [one.column for one in problem.every]
        assert places == sorted(places) and len(places) <= 10
        assert all(-1 <= one.column <= len(text) and not one.others for one in problem.others)
