"""Tests inside workbooks: what is wrong with their rows, and what is told when one does not hold."""

from __future__ import annotations

import play
import pytest
from tested import TRACKING, held, ran, sheet, wrong

from rrp_sheets import api
from rrp_sheets.engine.engine import FrameClock
from rrp_sheets.resources import bundled
from rrp_sheets.testing import run_tests

FOLDER = bundled("workbooks")
NAMES = sorted(p.stem for p in FOLDER.glob("*.xlsx"))


# ---- what is wrong with rows


@pytest.mark.parametrize(
    ("row", "expected"),
    [
        ("| soon | Red ball | | |", [("TEST001", "A2")]),
        ("| -5 | Red ball | | |", [("TEST001", "A2")]),
        ("| 1e99 | Red ball | | |", [("TEST001", "A2")]),
        ("| 999 h | Red ball | | |", [("TEST001", "A2")]),
        ("| 0 | Rad ball | | |", [("TEST002", "B2")]),
        ("| 0 | Nothing like it | | |", [("TEST002", "B2")]),
        ("| 0 | Say | hello | |", [("TEST004", "C2")]),
        ("| 0 | Red ball | x=1 | any |", [("TEST005", "D2")]),
        ("| 0 | Say | | |", [("TEST006", "C2")]),
        ("| 0 | Distance | | |", [("TEST006", "C2")]),
        ("| 0 | Distance | hello | |", [("TEST007", "C2")]),
        ("| 0 | Distance | 1 + | |", [("TEST007", "C2")]),
        ("| 0 | Distance | OPEN(1) | |", [("TEST007", "C2")]),
        ("| 0 | Red ball | distence=1 | |", [("TEST008", "C2")]),
        ("| 0 | Red ball | distance=0,5; x=hello | |", [("TEST007", "C2")]),
        ("| 0 | Red ball | x=1; x=2 | |", [("TEST013", "C2")]),
        ("| 0 | Red ball | x=1e999 | |", [("TEST014", "C2")]),
        ("| 0 | Distance | 1e999 | |", [("TEST014", "C2")]),
        ("| 0 | Red ball | 0.5 | |", [("TEST015", "C2")]),
        ('| 0 | Red ball | "red" | |', [("TEST015", "C2")]),
        ("| 0 | Red ball | BLANK | |", []),
        ("| 0 | Red ball | distance=0,5 | |", [("TEST007", "C2")]),
        ("| 0 | Distance | | distance > 1 AND 2 |", [("TEST009", "D2")]),
        ("| 0 | Distance | | >  |", [("TEST009", "D2")]),
        ("| 0 | Distance | | > > 5 |", [("TEST009", "D2")]),
        ("| 0 | Red ball | | value.distence > 1 |", [("TEST009", "D2")]),
        ("| 0 | Red ball | | distence=1 |", [("TEST008", "D2")]),
        ("| 0 | Distance | | ≈ nearly |", [("TEST010", "D2")]),
        ("| 0 | Distance | | ≈1 ± x |", [("TEST010", "D2")]),
        ("| 0 | Distance | | 1e400 |", [("TEST014", "D2")]),
        ("| | Red ball | | |", [("SHEET013", "A2")]),
    ],
)
def test_a_row_that_cannot_be_understood(row, expected):
    assert wrong(row + "\n| 0 | Distance | | any |") == expected


@pytest.mark.parametrize(
    ("rows", "title", "left"),
    [
        ("| 0 | Red ball | | |\n| 9 | Near | | any |\n| 99 | Near | | 1 |", "Delete all rows of this test", []),
        ("| 0 | Red ball | | |\n| 9 | Near | | any |\n| 9 | Distance | | any |\n| 99 | near | | 1 |",
         "Delete the rows of the test that name “Near”", ["Red ball", "Distance"]),
    ],
)  # fmt: skip
@pytest.mark.parametrize("suffix", [".md", ".xlsx"])
def test_rows_of_a_stream_that_no_row_gives_any_more_are_deleted(rows, title, left, suffix, tmp_path):
    book = tmp_path / "book.md"
    book.write_text(play.rows(TRACKING) + sheet(rows), encoding="utf-8")
    first, second = (d for d in api.check(book).report if d.address.sheet == "Test")
    assert (first.code, second.code, second.fixes) == ("TEST002", "TEST002", ())
    assert "If no row gives “Near” any more" in first.remedy
    assert [(fix.id, fix.title, fix.safe) for fix in first.fixes] == [("delete-rows", title, False)]
    _, checked = api.fix(book, tmp_path / f"fixed{suffix}", {"TEST002": "delete-rows"})
    assert [row.stream.text for row in checked.workbook.tests[0].rows] == left
    assert [d.code for d in checked.report if d.address.sheet == "Test"] == ([] if left else ["TEST012"])


def test_a_test_without_expectations_and_rows_without_effect_are_warned_of():
    assert wrong("| 0 | Red ball | | |") == [("TEST012", "")]
    header = play.HEADER.replace("Output stream |", "Output stream | On |").replace("---|\n", "---|---|\n")
    book = play.rows(
        "| Red ball | map | 1 | Out | |\n| Out | subscribe | | Print | |\n| Green ball | map | 1 | Other | off |",
        header=header,
    )
    checked = play.check(book + sheet("| 0 | Red ball | | |\n| 0 | Out | | 1 |\n| 0 | Other | | nothing |"))
    assert [d.code for d in checked.report if d.address.sheet == "Test"] == ["TEST011"]
    assert run_tests(checked).passed


def test_a_warning_elsewhere_hides_no_error_of_a_test():
    """A row that leads nowhere is only a warning: the misspelt stream is still told, and the test does not hold without it."""
    unused = TRACKING + "    | Distance | map | distance * 2 | Double |\n"
    assert wrong("| 0 | Red bull | | |\n| 0 | Say | | any |", unused) == [("TEST002", "B2")]


def test_an_actuator_that_no_row_drives_is_not_told_beside_a_row_that_leads_nowhere():
    """The row that sent it there may have been deleted, which each row of the test would tell again."""
    book = "| Red ball | map | 1 | Out |\n| Green ball | subscribe | | Print |"
    found = play.findings(
        play.rows(book) + sheet("| 0 | Say | | any |\n| 1 | Say | | any |\n| 1 | Blue ball | | any |")
    )
    assert found == [("GRAPH011", "D2"), ("TEST011", "B4")]
    found = play.findings(play.rows(book.replace("Green ball", "Out")) + sheet("| 0 | Say | | any |"))
    assert found == [("TEST011", "B2")]


def test_every_message_has_a_remedy_that_says_what_to_do():
    checked = play.check(play.rows(TRACKING) + sheet("| 0 | Distance | hello | |\n| 0 | Say | hi | |"))
    remedies = [d.remedy for d in checked.report.errors]
    assert '"hello"' in remedies[0]
    assert "“hi”" in remedies[1] and "Expect" in remedies[1]


# ---- what is told


def test_a_failing_row_tells_what_came_instead_and_when():
    test = """
        | 0 | Red ball | distance=0.2 | |
        | 2000 | Distance | | 0.2 |
        | 0 | Close | | 0.3 |
        | 0 | Said | | any |
        | 0 | Distance | | "0.2" |
    """
    first, second, third, fourth = ran(test).rows
    assert (first.got, first.hints) == ("no value arrived at 2000 ms", ("The expected value arrived at 0 ms.",))
    assert second.got == "0.2 at 0 ms from T!3"
    assert third.got == "no value arrived on “Said” in this test"
    assert fourth.hints == ("It is a number; write 0.2 without quotes to expect it.",)


def test_a_formula_that_fails_explains_why_nothing_came():
    rows = "| Red ball | map | 1 / redBall.x | Out |\n| Out | subscribe | | Print |"
    case = ran("| 0 | Red ball | x=0 | |\n| 0 | Out | | any |", rows)
    assert [f.row for f in case.faults] == ["T!2"]
    assert any("divides by zero" in hint for hint in case.rows[0].hints)


def test_a_send_that_fails_while_it_is_worked_out_fails_the_test():
    case = ran("| 0 | Distance | 1 / 0 | |\n| 0 | Distance | | nothing |")
    assert not case.passed
    assert list(case.broken) == [2]


def test_a_behaviour_that_is_switched_off_gives_nothing():
    book = play.rows("| Red ball | map | 1 | |\n| | subscribe | | Off |", sheet="A") + play.rows(
        "| Green ball | map | 2 | Out |\n| Out | subscribe | | Say |", sheet="B"
    )
    devices = "\n## Devices\n| Stream | Device | Name | State |\n|---|---|---|---|\n| Off | Behaviour | B | Off |\n"
    test = """
        | 0 | Green ball | | |
        | 0 | Out | | 2 |
        | 1000 | Red ball | | |
        | 2000 | Green ball | | |
        | 2100 | Out | | nothing |
        | 2200 | Out | 5 | |
        | 2200 | Say | | nothing |
    """
    checked = play.check(book + devices + sheet(test))
    assert not checked.report.errors
    assert [r.passed for r in run_tests(checked).cases[0].rows] == [True, True, True]


def test_a_timer_ticks_by_itself():
    devices = "\n## Devices\n| Stream | Device | Every |\n|---|---|---|\n| Clock | Timer | 2 s |\n"
    rows = "| Clock | map | clock.count | Count |\n| Count | subscribe | | Print |"
    test = """
        | 2000 | Count | | 1 |
        | 3900 | Count | | nothing |
        | 4000 | Count | | 2 |
        | 1 h | Count | | 1800 |
    """
    assert held(test, rows, devices) == [True] * 4


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_frames_in_which_nothing_happens_may_be_left_out(name, monkeypatch):
    checked = api.check(FOLDER / f"{name}.xlsx")
    quick = [case.events for case in run_tests(checked).cases]
    monkeypatch.setattr(FrameClock, "next_due", property(lambda self: self.us + 1))
    assert [case.events for case in run_tests(checked).cases] == quick


GAME = """
    | Cheer done | filter | cheerDone.completed | Cheered |
    | Start, Cheered | accumulate | IF(ISBLANK(start); total + 1; 1) | Step |
    | Step | filter | step <= ROWS(Parts) | |
    | | map | INDEX(Parts; value) | Part |
    | Part | map | part.ask | |
    | | subscribe | | Ask |
    | Touch, Part | filter | touch.zone = part.zone | Right |
    | Right, Part | once | | Solved |
    | Solved | map | PICK(["Yes!"; "Super!"]) | |
    | | subscribe | | Cheer |
    | Ask done, Touch, Part | timeout | 8 s | Quiet |
    | Quiet, Part | map | part.hint | |
    | | subscribe | | Help |
    | Step | filter | step = ROWS(Parts) + 1 | |
    | | subscribe | | Bye |
"""
GAME_SHEETS = """
## Parts
| Zone | Ask | Hint |
|---|---|---|
| Head | Where is my head? | It is at the top. |
| Left hand | Where is my hand? | I move it. |

## Devices
| Stream | Device | Text |
|---|---|---|
| Start | OperatorButton | |
| Touch | Touch | |
| Ask | Say | |
| Cheer | Say | |
| Help | Say | |
| Bye | SayParameter | Bye! |
"""


def test_a_whole_game():
    test = """
        | 0 | Touch | zone=Head | |
        | 100 | Cheer | | nothing |
        | 1 s | Start | | |
        | 1 s | Ask | | Where is my head? |
        | 3 s | Ask done | | |
        | 10900 | Help | | nothing |
        | 11 s | Help | | It is at the top. |
        | 12 s | Touch | zone=Left hand | |
        | 12100 | Cheer | | nothing |
        | 13 s | Touch | zone="Head" | |
        | 13 s | Cheer | | OR(value = "Yes!"; value = "Super!") |
        | 13200 | Touch | zone="Head" | |
        | 13300 | Cheer | | nothing |
        | 15 s | Cheer done | completed=FALSE | |
        | 15100 | Step | | nothing |
        | 16 s | Cheer done | | |
        | 16 s | Part | | zone=Left hand |
        | 16 s | Step | | 2 |
        | 20 s | Cheer done | | |
        | 20 s | Bye | | any |
        | 60 s | Ask | | nothing |
    """
    assert held(test, GAME, GAME_SHEETS) == [True] * 12
