"""Running the tests inside workbooks: the command, how long it takes, and that every workbook’s own tests hold."""

from __future__ import annotations

import dataclasses
import json
from xml.etree import ElementTree as ET

import play
import pytest
from busy import work_within
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st
from tested import TRACKING, held, sheet

from rrp_sheets import api
from rrp_sheets.checks.send_expect import fields, half_of_last_digit, in_quotes, literal
from rrp_sheets.cli.check import test_command as command
from rrp_sheets.engine.plan import make_plan
from rrp_sheets.resources import bundled
from rrp_sheets.testing import run_tests
from rrp_sheets.testing.case_output import junit
from rrp_sheets.testing.judge import _Lane, equal
from rrp_sheets.testing.run import run_case

FOLDER = bundled("workbooks")
NAMES = sorted(p.stem for p in FOLDER.glob("*.xlsx"))
VARIED = {
    "attention-training", "complex-tracking-fixed", "exercise-coach", "follow-my-pointing", "greeter-with-memory",
    "mixed-control", "reflect-ball-colour", "sing-and-dance",
}  # fmt: skip
"""Those whose tests have between them all that any of them has."""


# ---- the command


@pytest.fixture
def book(tmp_path):
    def write(test, rows=TRACKING):
        path = tmp_path / "日本 book.md"
        path.write_text(play.rows(rows) + (sheet(test) if test else ""), encoding="utf-8")
        return path

    return write


GOOD = "| 0 | Red ball | distance=0.2 | |\n| 0 | Say | | any |"
BAD = '| 0 | Red ball | distance=0.2 | |\n| 0 | Say | | a <b>&"no"]]> 赤 |'


@pytest.mark.parametrize(
    ("test", "code"), [(GOOD, 0), (BAD, 1), ("| x | Red ball | | |", 2), ("", 5), ("| 0 | Red ball | | |", 5)]
)
def test_exit_codes(book, test, code):
    assert CliRunner().invoke(command, [str(book(test))]).exit_code == code


def test_what_expects_nothing_does_not_hold(book):
    result = CliRunner().invoke(command, [str(book("| 0 | Red ball | | |"))])
    assert "– Test: nothing is expected" in result.output and "hold" not in result.output


def test_the_output_names_cell_value_and_draws_the_streams(book):
    out = CliRunner().invoke(command, [str(book("| 0 | Red ball | distance=0.2 | |\n| 0 | Say | | Hello |"))]).output
    assert "✗ Test: 1 of 1 row fails" in out
    two = CliRunner().invoke(command, [str(book(BAD + "\n| 1 | Say | | nothing |"))]).output
    assert "✗ Test: 1 of 2 rows fails" in two
    assert "Test!D3 (0 ms, Say): expected Hello" in out
    assert "got: “It is close, at 0.2” at 0 ms" in out
    assert "▣ Say" in out and "□ Red ball" in out and "▲ row 3" in out


def test_the_notes_of_a_row_that_does_not_hold_are_shown(tmp_path):
    path = tmp_path / "book.md"
    test = "\n## Test\n| Time (ms) | Stream | Send | Expect | Notes |\n|---|---|---|---|---|\n"
    path.write_text(play.rows(TRACKING) + test + "| 0 | Say | | any | nobody is there |\n", encoding="utf-8")
    assert "(0 ms, Say): expected any – nobody is there" in CliRunner().invoke(command, [str(path)]).output


def test_json(book):
    found = json.loads(CliRunner().invoke(command, [str(book(BAD)), "--json"]).output)
    assert found["passed"] is False
    (row,) = found["tests"][0]["rows"]
    assert (row["cell"], row["time_ms"], row["stream"], row["passed"]) == ("D3", 0.0, "Say", False)


def test_junit_is_xml_whatever_the_texts_say(book, tmp_path):
    target = tmp_path / "out.xml"
    assert CliRunner().invoke(command, [str(book(BAD)), "--junit", str(target)]).exit_code == 1
    root = ET.fromstring(target.read_bytes())
    assert (root.tag, root.get("tests"), root.get("failures")) == ("testsuites", "1", "1")
    failure = root.find("testsuite/testcase/failure")
    assert 'a <b>&"no"]]> 赤' in failure.get("message")


def test_junit_holds_no_character_that_xml_forbids():
    checked = play.check(play.rows(TRACKING) + sheet(GOOD))
    report = run_tests(checked)
    case = report.cases[0]
    row = dataclasses.replace(case.rows[0], passed=False, got="a\x00b\ud800c")
    odd = dataclasses.replace(report, cases=(dataclasses.replace(case, rows=(row,)),))
    assert "a\ufffdb\ufffdc" in ET.fromstring(junit(odd)).find("testsuite/testcase/failure").get("message")


def test_stopping_is_polite():
    checked = play.check(play.rows(TRACKING) + sheet(GOOD) + sheet(GOOD, "Second"))
    asked = iter([False])
    report = run_tests(checked, lambda: next(asked, True))
    assert report.stopped and len(report.cases) < 2


# ---- how much


@pytest.mark.slow
def test_ten_thousand_rows_with_times_in_any_order_are_quick():
    rows = [f"| {(i * 7919) % 10000 * 40} | Red ball | distance={i / 1e5} | |" for i in range(5000)]
    rows += [f"| {(i * 7919) % 10000 * 40} | Distance | | {i / 1e5} |" for i in range(4999)]
    checked = play.check(play.rows(TRACKING) + sheet("\n".join(rows)))
    assert not checked.report.errors
    with work_within(10):
        report = run_tests(checked)
    assert report.passed


@pytest.mark.slow
def test_ten_thousand_rows_at_one_time_and_none_that_holds_end():
    rows = ["| 0 | Red ball | | |"] * 3000 + ["| 0 | Distance | | >1 |"] * 3000 + ["| 0 | Distance | | any |"] * 3000
    checked = play.check(play.rows(TRACKING) + sheet("\n".join(rows)))
    with work_within(30):
        results = run_tests(checked).cases[0].rows
    assert sum(r.passed for r in results) == 3000


def test_a_day_of_waiting_takes_no_time():
    with work_within(5):
        found = held("| 23 h | Red ball | | |\n| 23 h | Distance | | any |\n| 24 h | Distance | | nothing |")
    assert found == [True, True]


# ---- the workbooks


FAILS_ON_PURPOSE = {
    "complex-tracking": [("Test old angle", "Arm tracker", 3000)],
    "debugging-exercise": [
        ("Test", "Eye brightness", 500), ("Test", "Eye brightness", 1000), ("Test", "Eye brightness", 1500),
    ],
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_the_workbooks_own_tests(name):
    _, report = api.test(FOLDER / f"{name}.xlsx")
    assert report.cases, "every workbook has a test"
    failed = [(c.case.name, r.row.name, r.row.time_us / 1000) for c in report.cases for r in c.failed_rows]
    assert failed == FAILS_ON_PURPOSE.get(name, [])


def test_the_exercise_is_solved_by_its_helper():
    text = (FOLDER / "source" / "debugging-exercise.md").read_text(encoding="utf-8")
    wrong = "1 if distance > 1.5 else 0 if distance < 0.5 else distance - 0.5"
    assert wrong in text
    solved = play.check(text.replace(wrong, "0 if distance > 1.5 else 1 if distance < 0.5 else 1.5 - distance"))
    assert run_tests(solved).passed


@pytest.mark.slow
@pytest.mark.parametrize("fix", ["forget-old-value", "join-close-in-time"])
def test_either_fix_of_the_stale_combination_makes_its_test_hold(fix, tmp_path):
    mended = tmp_path / "mended.xlsx"
    api.fix(FOLDER / "complex-tracking.xlsx", mended, {"LINT001": fix})
    _, report = api.test(mended)
    assert report.passed and len(report.cases) == 2


def test_the_workbook_that_new_makes_has_a_test_that_holds(tmp_path):
    _, report = api.test(api.new(tmp_path / "mine.xlsx"))
    assert report.passed and report.cases


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * (name not in VARIED)) for name in NAMES]
)
def test_a_workbooks_tests_notice_when_what_they_expect_is_changed(name):
    checked = api.check(FOLDER / f"{name}.xlsx")
    plan = make_plan(checked)
    for case in checked.tests:
        if any(sheet == case.name for sheet, *_ in FAILS_ON_PURPOSE.get(name, [])):
            continue
        for place, row in enumerate(case.rows):
            if row.expectation is None:
                continue
            kind = {"any": "nothing", "nothing": "any"}.get(row.expectation.kind, "value")
            other = dataclasses.replace(row.expectation, kind=kind, value="something else")
            rows = list(case.rows)
            rows[place] = dataclasses.replace(row, expectation=other)
            assert not run_case(plan, dataclasses.replace(case, rows=tuple(rows))).passed, row


# ---- properties


@given(st.text(max_size=60))
def test_whatever_is_typed_is_understood_or_refused(text):
    fields(text)
    quoted = in_quotes(text)
    assert quoted is None or quoted in text.replace('""', '"').replace("''", "'")


@given(st.floats(allow_nan=False, allow_infinity=False, min_value=-1e12, max_value=1e12))
def test_a_number_is_the_number_it_is_written_as(number):
    found, value = literal(repr(number))
    assert found and equal(number, value)


@given(st.decimals(allow_nan=False, allow_infinity=False, places=3, min_value=-1000, max_value=1000))
def test_about_is_how_a_number_rounds(number):
    assert float(half_of_last_digit(number)) == pytest.approx(0.0005)


@pytest.mark.slow
@settings(deadline=None, max_examples=40)
@given(st.lists(st.tuples(st.integers(0, 3), st.sampled_from(["send", "any", "nothing"])), min_size=1, max_size=12))
def test_the_order_of_the_sheet_does_not_matter(rows):
    """But for rows that send at the time of a `nothing`, where it says which of them is the row before."""
    lines = [
        f"| {at * 500} | Red ball | | |" if what == "send" else f"| {at * 500} | Distance | | {what} |"
        for at, what in rows
    ]
    sends = [line for line in lines if line.endswith("| | |")]
    others = [line for line in lines if not line.endswith("| | |")]
    if not others:
        return
    forwards, backwards = held("\n".join(sends + others)), held("\n".join(sends + others[::-1]))
    assert sorted(forwards) == sorted(backwards)


@pytest.mark.slow
def test_thousands_of_expectations_at_one_time_are_judged_at_once(book):
    count = 4_900
    path = book("| 0 | Red ball | distance=0.2 | |\n" * count + "| 0 | Say | | any |\n" * count)
    with work_within(8):  # looking at every event for every row takes much longer
        _, report = api.test(path)
    assert report is not None and report.passed and len(report.cases[0].rows) == count


def test_the_free_events_of_a_window_are_those_that_no_row_has_taken():
    lane = _Lane([], [], {})
    for event in (3, 1, 2, 7, 3, 8):
        lane.take(event, 0)
        left = [i for i in range(10) if i not in lane.taken]
        assert list(lane.free(range(10))) == left and list(lane.free(range(2, 8))) == [i for i in left if 2 <= i < 8]
