"""Facts about streams before the run: example values, kinds, bounds and paces."""

from __future__ import annotations

import math

import pytest
from busy import work_within
from play import check, findings, play, rows

from rrp_sheets.checks.check import row_examples
from rrp_sheets.checks.facts import Fact
from rrp_sheets.model.values import Record, show
from rrp_sheets.robots import load_robot
from rrp_sheets.robots.trajectory import JointLimits

PARTS = """
## Parts
| Zone | Name | Ask |
|---|---|---|
| Left hand | left hand | Touch my left hand! |
| Head | head | Where is my head? |
"""
DEVICES = """
## Devices
| Stream | Device | Label | Words | Joint | Text | Zone |
|---|---|---|---|---|---|---|
| Start | OperatorButton | Go | | | | |
| Words | WordRecognized | | maybe, no | | | |
| Hand | Touch | | | | | Left hand |
| Neck | SetJointPosition | | | HeadYaw | | |
| Hello | SayParameter | | | | Hello | |
"""
HELPERS = """
## Helpers
| Name | Inputs | Formula |
|---|---|---|
| Praise | | ["Super!"; "Yes!"] |
| Part of | n | INDEX(Parts; n) |
"""


def facts(text: str) -> dict[int, Fact]:
    """Facts about the output of each row, by the row's number."""
    checked = check(rows(text, PARTS, DEVICES, HELPERS))
    assert not checked.report.errors, [d.as_dict() for d in checked.report.errors]
    return {int(ref.split("!")[1]): fact for ref, fact in row_examples(checked).items()}


PRINT = "\n| X | subscribe | | Print |"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "example", "kind"),
    [
        ("| Red ball | map | redBall.distance | X |", 0.5, "number"),
        ("| Red ball | map | redBall.distance < 1 | X |", True, "truth"),
        ("| Head yaw | map | headYaw * 2 | X |", 0.2, "number"),
        ("| Left elbow roll, Head yaw | map | IF(headYaw > 0; 1; 2) | X |", 1, "number"),
        ("| Start | map | start.label | X |", "Go", "text"),
        ("| Words | map | words.word | X |", "maybe", "text"),
        ("| Hand | map | hand.zone | X |", "Left hand", "text"),
        ("| Hello done | map | helloDone.completed | X |", True, "truth"),
        ("| Start | map | PICK(praise) | X |", "Super!", "text"),
        ("| Start | map | PICK(Parts).ask | X |", "Touch my left hand!", "text"),
        ("| Start | accumulate | | X |", 1, "number"),
        ("| Start, Hand | accumulate | IF(ISBLANK(start); total + 1; 10) | X |", 10, "number"),
        ("| Red ball, Green ball | merge | | M |\n| M | map | m.colour | X |", "red", "text"),
        ("| Red ball | timestamp | | T |\n| T | map | t.v.colour | X |", "red", "text"),
        ("| Red ball | map | BLANK | X |", None, "blank"),
        ("| Red ball | forgetAfter | 1 s | F |\n| F | filter | ISBLANK(f) | X |", None, "blank"),
        ("| Red ball | map | (redBall.x, 2) | P |\n| P | map | p[1] | X |", 2, "number"),
    ],
)
def test_the_example_of_a_row(text, example, kind):
    found = facts(text.replace("Left elbow roll", "L elbow roll") + PRINT)
    last = max(n for n in found if n < len(text.splitlines()) + 2)
    assert (found[last].example, found[last].known.kind) == (example, kind)
    assert found[max(found)].example == example  # what is sent to the actuator


@pytest.mark.parametrize(
    "connector",
    ["| P | filter | p.zone <> 1 | Q |", "| P | sample | 1 s | Q |", "| P | throttle | 1 s | Q |", "| P | once | | Q |",
     "| P | delay | 1 s | Q |", "| P | changes | | Q |", "| P, Start | timeout | 1 s | Q |",
     "| P | forgetAfter | 1 s | Q |", "| P, P2 | merge | | Q |", "| P | map | IF(p.zone = 1; p; BLANK) | Q |",
     "| P | map | p | Q |"],
)  # fmt: skip
@pytest.mark.parametrize("row", ["INDEX(Parts; 1)", "PICK(Parts)", "partOf(2)", 'XLOOKUP("Head"; Parts[Zone]; Parts)'])
def test_a_row_of_a_table_keeps_its_fields_through_connectors(row, connector):
    """`part.ask` is checked with its nearest field wherever the record has gone."""
    text = f"| Start | map | {row} | P |\n| Start | map | {row} | P2 |\n{connector}\n| Q | map | q.aks | X |{PRINT}"
    text += "\n| P2 | subscribe | | Print |"
    assert findings(rows(text, PARTS, DEVICES, HELPERS))[0] == ("FORM007", "C5")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("formula", "low", "high"),
    [
        ("headYaw", -2.08567, 2.08567),
        ("headYaw * 2", -4.17134, 4.17134),
        ("-headYaw + 1", -1.08567, 3.08567),
        ("CLAMP(headYaw * 5; -0.5; 1)", -0.5, 1),
        ("IF(headYaw > 0; 3; 5)", 3, 5),
        ("MAX(0; headYaw)", 0, 2.08567),
        ("SIN(headYaw)", -1, 1),
        ("ROWS(Parts) + 1", 3, 3),
        ("1 / headYaw", -math.inf, math.inf),
    ],
)
def test_bounds(formula, low, high):
    known = facts(f"| Head yaw | map | {formula} | X |{PRINT}")[2].known
    assert (known.low, known.high) == (pytest.approx(low), pytest.approx(high))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "kind", "hz"),
    [
        ("| Red ball | map | 1 | X |", "camera", 10),
        ("| Head yaw | map | 1 | X |", "change", 30),
        ("| Start | map | 1 | X |", "event", 0),
        ("| Red ball | sample | 2 s | X |", "timer", 0.5),
        ("| Red ball | throttle | 4 s | X |", "camera", 0.25),
        ("| Timer | map | 1 | X |", "timer", 1),
        ("| Red ball, Head yaw | merge | | X |", "change", 30),
        ("| Red ball | once | | X |", "event", 0),
    ],
)
def test_how_often_values_come(text, kind, hz):
    rate = facts(text + PRINT)[2].rate
    assert (rate.kind, rate.hz) == (kind, hz)


def test_which_streams_may_be_blank():
    found = facts(
        "| Red ball | forgetAfter | 1 s | F |\n| F | filter | NOT(ISBLANK(f)) | G |\n| F | map | IF(ISBLANK(f); BLANK; 1) | X |\n"
        "| G | subscribe | | Print |" + PRINT
    )
    assert (found[2].known.blank, found[3].known.blank, found[4].known.blank) == (True, False, True)


def test_an_example_that_a_filter_keeps_back_is_not_sure():
    found = facts("| Red ball | filter | redBall.distance > 2 | F |\n| F | map | f.distance | X |" + PRINT)
    assert (found[2].sure, found[3].sure, found[3].example) == (False, False, 0.5)


def test_a_field_of_a_number_is_found():
    assert findings(rows("| Head yaw | map | headYaw.foo | X |" + PRINT))[0][1] == "C2"
    assert findings(rows("| Red ball | map | redBall.x | D |\n| D | map | d.y | X |" + PRINT))[0][1] == "C3"


def test_a_formula_that_fails_on_its_example_is_told_with_the_values():
    report = check(rows("| Red ball | map | 1 / (redBall.distance - 0.5) | X |" + PRINT)).report
    (finding,) = list(report)
    assert (finding.code, finding.address.cell, finding.span is not None) == ("LINT010", "C2", True)
    assert "divides by zero" in finding.message and "0.5" in finding.message


def test_examples_leave_no_trace_in_a_run():
    """PICK and totals begin anew, whatever the check has worked out."""
    text = rows("| Head yaw | accumulate | | N |\n| Head yaw | map | PICK(praise) | X |\n| N | subscribe | | Print |" + PRINT,
                HELPERS.replace("| Part of | n | INDEX(Parts; n) |\n", ""))  # fmt: skip
    checked = check(text)
    events = [(0, "Head yaw", 1.0), (100, "Head yaw", 2.0)]
    first, second = (play(checked, events, 1000) for _ in range(2))
    assert first.values("N") == second.values("N") == [1, 2]
    assert first.values("X") == second.values("X") and sorted(first.values("X")) == ["Super!", "Yes!"]


@pytest.mark.parametrize(
    "formula",
    ["[x + y for x in RANGE(1; 100) for y in RANGE(1; 100)]", "SUM([SUM(RANGE(1; 900)) for x in RANGE(1; 900)])"],
)
def test_endless_work_is_bounded_for_one_row_and_for_all(formula):
    one = "\n".join(f"| Red ball | map | {formula} | X{i} |" for i in range(300))
    with work_within(20):
        check(rows(one))


def test_helpers_that_call_each_other_are_followed_only_so_far():
    lines = "\n".join(f"| H{i} | x | h{i + 1}(x) + h{i + 1}(x) |" for i in range(40))
    helpers = f"## Helpers\n| Name | Inputs | Formula |\n|---|---|---|\n{lines}\n| H40 | x | x |"
    with work_within(10):
        check(rows("| Head yaw | filter | h0(headYaw) > 1 | X |" + PRINT, helpers))


def test_what_goes_round_through_a_done_stream():
    """The loop goes through the world: what is commanded is not known when its end is read."""
    found = facts("| Hello done | map | helloDone.value | X |\n| X | subscribe | | Hello |")
    assert found[2].known.kind == "any"


@pytest.mark.parametrize(("yaw", "low", "high"), [(0, -0.672, 0.515), (1.527, -0.330, 0.200), (-2.086, -0.449, 0.330)])
def test_how_far_the_head_nods_depends_on_where_it_looks(yaw, low, high):
    limits = JointLimits(load_robot()).of("HeadPitch", yaw)
    assert limits == (pytest.approx(low, abs=1e-3), pytest.approx(high, abs=1e-3))


def test_a_record_example_is_shown_in_short():
    fact = facts("| Red ball | filter | redBall.x > 0 | X |" + PRINT)[2]
    assert isinstance(fact.example, Record) and show(fact.example).startswith("Red ball (x 0.1")
