"""Tests inside workbooks: what their rows mean, what is wrong with them, and that every workbook's own tests hold."""

from __future__ import annotations

import dataclasses
import json
import time
from xml.etree import ElementTree as ET

import play
import pytest
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st

from rrp_sheets import api
from rrp_sheets.checks.expecting import half_of_last_digit
from rrp_sheets.checks.parts import fields, in_quotes, literal
from rrp_sheets.cli.test import command
from rrp_sheets.resources import bundled
from rrp_sheets.runtime.clock import FrameClock
from rrp_sheets.runtime.plan import make_plan
from rrp_sheets.testing import run_tests
from rrp_sheets.testing.holds import equal
from rrp_sheets.testing.judge import _Lane
from rrp_sheets.testing.junit import junit
from rrp_sheets.testing.run import run_case

TRACKING = """
    | Red ball | map | redBall.distance | Distance |
    | Distance | filter | distance < 0.5 | Close |
    | Close | map | "It is close, at " & close | Words |
    | Words | subscribe | | Say |
    | Say done | map | sayDone.value | Said |
    | Said | subscribe | | Print |
"""
FOLDER = bundled("workbooks")
NAMES = sorted(p.stem for p in FOLDER.glob("*.xlsx"))


def sheet(text, name="Test"):
    lines = [line.strip() for line in text.strip().splitlines()]
    return f"\n## {name}\n| Time (ms) | Stream | Send | Expect |\n|---|---|---|---|\n" + "\n".join(lines) + "\n"


def ran(test, rows=TRACKING, *more):
    checked = play.check(play.rows(rows, *more) + sheet(test))
    assert not checked.report.errors, [d.as_dict() for d in checked.report.errors]
    return run_tests(checked).cases[0]


def held(test, rows=TRACKING, *more):
    """For every row that expects: whether it holds."""
    return [r.passed for r in ran(test, rows, *more).rows]


def wrong(test, rows=TRACKING, *more):
    checked = play.check(play.rows(rows, *more) + sheet(test))
    return [(c, cell) for c, cell, s in checked.report.flatten(["code", "cell", "sheet"]) if s == "Test"]


# ---- what is sent


@pytest.mark.parametrize(
    ("send", "distance"),
    [
        ("", 0.5),
        ("distance=0.2", 0.2),
        ("distance = 0.2; colour=red", 0.2),
        ("x=1, distance=0.2", 0.2),
        ("distance=1/4", 0.25),
        ("Distance=0.2", 0.2),
        ("=distance=0.2", 0.2),
    ],
)
def test_a_sensor_is_sent_its_example_with_changes(send, distance):
    assert held(f"| 0 | Red ball | {send} | |\n| 0 | Distance | | {distance} |") == [True]


def test_an_example_follows_the_settings_of_the_device():
    devices = """
        ## Devices
        | Stream | Device | Zone | Words | Label |
        |---|---|---|---|---|
        | Left | Touch | Left hand | | |
        | Word | WordRecognized | | ja, nein | |
        | Go | OperatorButton | | | |
    """
    rows = """
        | Left, Word, Go | merge | | All |
        | Left | map | left.zone | Zone |
        | Word | map | word.word | Heard |
        | Go | map | go.label & go.count | Pressed |
        | Zone, Heard, Pressed, All | merge | | Every |
        | Every | subscribe | | Print |
    """
    test = """
        | 0 | Left | | |
        | 0 | Word | | |
        | 0 | Go | | |
        | 100 | Go | | |
        | 0 | Zone | | Left hand |
        | 0 | Heard | | ja |
        | 0 | Pressed | | Go1 |
        | 100 | Pressed | | Go2 |
    """
    assert held(test, rows, devices) == [True] * 4


def test_a_formula_is_sent_into_an_ordinary_stream_with_helpers_and_tables():
    rows = """
        | Red ball | map | redBall.distance | Distance |
        | Distance | filter | distance < 0.5 | Close |
        | Close | subscribe | | Say |
        | Distance | map | INDEX(Parts; 2).say | Part |
        | Part | subscribe | | Say |
    """
    parts = "\n## Parts\n| Say |\n|---|\n| head |\n| hand |\n"
    helpers = "\n## Helpers\n| Name | Inputs | Formula |\n|---|---|---|\n| Near | | 0.25 |\n"
    test = """
        | 0 | Distance | near / 2 | |
        | 0 | Close | | 0.125 |
        | 100 | Close | "anything" | |
        | 100 | Say | | anything |
        | 200 | Part | INDEX(Parts[Say]; 1) | |
        | 200 | Say | | head |
    """
    assert held(test, rows, helpers, parts) == [True] * 3


def test_an_end_tells_what_was_commanded_and_can_be_changed():
    test = """
        | 0 | Red ball | distance=0.25 | |
        | 0 | Say | | It is close, at 0.25 |
        | 2000 | Say done | | |
        | 2000 | Said | | It is close, at 0.25 |
        | 2000 | Say done | | completed=TRUE; seconds=2 |
        | 3000 | Say done | completed=FALSE; value="other" | |
        | 3000 | Said | | other |
        | 3000 | Say done | | completed=FALSE |
    """
    assert held(test) == [True] * 5


def test_ends_that_no_row_reads_may_be_sent():
    rows = "| Red ball | map | redBall.distance | Distance |\n| Distance | subscribe | | Say |"
    assert held("| 0 | Red ball | | |\n| 100 | Say done | | |\n| 100 | Say done | | any |", rows) == [True]


def test_wait_ends_by_itself_and_say_does_not():
    rows = """
        | Red ball | map | "2 s" | |
        | | subscribe | | Wait |
        | Red ball | map | "hello" | |
        | | subscribe | | Say |
        | Wait done, Say done | merge | | Ended |
        | Ended | subscribe | | Print |
    """
    test = """
        | 0 | Red ball | | |
        | 2000 | Ended | | value.completed |
        | 60 s | Ended | | nothing |
    """
    assert held(test, rows) == [True, True]


def test_what_ends_the_run_is_told():
    rows = """
        | Red ball | map | redBall.distance | Distance |
        | Distance | filter | distance < 0.2 | |
        | | subscribe | | End run |
        | Distance | subscribe | | Print |
    """
    case = ran("| 0 | Red ball | distance=0.1 | |\n| 1000 | Red ball | | |\n| 1000 | Distance | | any |", rows)
    assert not case.passed
    assert "had ended the run" in " ".join(case.rows[0].hints)


# ---- what is expected


@pytest.mark.parametrize(
    ("value", "expect", "holds"),
    [
        ("0.5", "0.5", True),
        ("0.5", "0.50000000001", True),
        ("0.5", "0.5001", False),
        ("0.54", "≈0.5", True),
        ("0.56", "≈0.5", False),
        ("0.54", "≈0.50", False),
        ("0.56", "≈0.5 ± 0.1", True),
        ("20.4", "~20", True),
        ("0.1 + 0.2 - 0.3", "0", True),
        ('"Hello"', "Hello", True),
        ('"Hello"', '"Hello"', True),
        ('"Hello"', "hello", True),
        ('"Hello "', "Hello", True),
        ('"Hello "', '"Hello"', False),
        ('"Hello"', "“Hello”", True),
        ('"He said ""no"""', 'He said "no"', True),
        ('"5"', "5", False),
        ('"5"', '"5"', True),
        ("5", '"5"', False),
        ("TRUE", "true", True),
        ("TRUE", "FALSE", False),
        ("BLANK", "blank", True),
        ("BLANK", "any", True),
        ("BLANK", '"blank"', False),
        ("[1, 2]", "(1, 2)", True),
        ("[1, 2]", "[1, 3]", False),
        ("0.6", ">0.5", True),
        ("0.6", "> 0.5", True),
        ("0.4", ">0.5", False),
        ("0.4", "<> 0.5", True),
        ("0.5", "≠0.5", False),
        ("0.5", "≤ 0.5", True),
        ("0.5", "AND(value > 0.4; value < 0.6)", True),
        ("0.5", "ISNUMBER(value)", True),
        ("0.5", "out > 0.4", True),
        ("0.5", "out = 0.5", True),
        ("0.5", "value = 0.4", False),
        ('"red"', '<> "blue"', True),
        ('"abc"', ">0.5", False),
        ('"The value is low"', "The value is low", True),
        ('"はい、「そう」です"', "はい、「そう」です", True),
        ('"a" & "b"', '"a" & "b"', True),
        ('"= 5"', '"= 5"', True),
        ("5", "=5", True),
    ],
)
def test_expecting(value, expect, holds):
    rows = f"| Red ball | map | {value} | Out |\n| Out | subscribe | | Print |"
    assert held(f"| 0 | Red ball | | |\n| 0 | Out | | {expect} |", rows) == [holds]


def test_fields_of_a_record_are_expected():
    test = """
        | 0 | Red ball | distance=0.2; x=0.11 | |
        | 0 | Red ball | | distance=0.2; x=≈0.1; colour=red |
        | 0 | Distance | | value * 10 > 1 |
        | 100 | Red ball | distance=0.2 | |
        | 100 | Red ball | | value.distance < 0.3 |
        | 200 | Red ball | distance=0.2 | |
        | 200 | Red ball | | distance=0.3 |
    """
    assert held(test) == [True, True, True, False]


def test_one_frame_of_tolerance_and_no_more():
    test = """
        | 1000 | Red ball | | |
        | {at} | Distance | | any |
    """
    assert [held(test.format(at=at)) for at in (933, 934, 1000, 1033, 1034)] == [
        [False], [True], [True], [True], [False],
    ]  # fmt: skip


def test_each_value_counts_for_one_row_in_whatever_order_the_rows_stand():
    rows = """
        | Red ball, Green ball | merge | | Both |
        | Both | map | value.distance | Out |
        | Out | subscribe | | Print |
    """
    sends = "| 0 | Green ball | distance=2 | |\n| 0 | Red ball | distance=1 | |\n"
    assert held(sends + "| 0 | Out | | any |\n| 0 | Out | | 1 |", rows) == [True, True]
    assert held(sends + "| 0 | Out | | 2 |\n| 0 | Out | | 1 |", rows) == [True, True]
    assert held(sends + "| 0 | Out | | >0 |\n| 0 | Out | | <2 |", rows) == [True, True]
    assert held(sends + "| 0 | Out | | 1 |\n| 0 | Out | | 1 |", rows) == [True, False]
    assert held(sends + "| 0 | Out | | any |\n| 0 | Out | | any |\n| 0 | Out | | any |", rows) == [True, True, False]


def test_nothing_counts_from_the_row_before():
    sends = "| 0 | Red ball | | |\n| 1000 | Red ball | | |\n"
    assert held(sends + "| 900 | Distance | | nothing |") == [False]  # what the row before sends counts
    assert held(sends + "| 500 | Close | | nothing |\n| 900 | Distance | | nothing |") == [True, True]
    assert held(sends + "| 2000 | Distance | | nothing |") == [False]
    assert held(sends + "| 1000 | Distance | | any |\n| 2000 | Distance | | nothing |") == [True, True]
    assert held(sends + "| 1000 | Distance | | any |\n| 1000 | Distance | | nothing |") == [True, True]
    assert held("| 100 | Distance | | nothing |") == [True]


def test_nothing_goes_by_time_and_not_by_the_place_in_the_sheet():
    test = """
        | 2100 | Green ball | | |
        | 2000 | Red ball | | |
        | 2000 | Distance | | any |
        | 2200 | Distance | | nothing |
    """
    rows = """
        | Red ball, Green ball | merge | | Any |
        | Any | subscribe | | Print |
        | Red ball | map | redBall.distance | Distance |
        | Distance | subscribe | | Say |
    """
    assert held(test, rows) == [True, True]
    assert held(test.replace("| 2100 | Green", "| 2100 | Red"), rows) == [True, False]


def test_nothing_or_blank_lets_a_stop_pass():
    rows = "| Red ball | map | IF(redBall.distance < 1; redBall.distance; BLANK) | Out |\n| Out | subscribe | | Say |"
    test = "| 0 | Red ball | distance={d} | |\n| 100 | Say | | {expect} |"
    assert held(test.format(d=2, expect="nothing or blank"), rows) == [True]
    assert held(test.format(d=2, expect="nothing"), rows) == [False]
    assert held(test.format(d=0.5, expect="nothing or blank"), rows) == [False]


def test_a_value_in_place_of_another_is_told_once():
    test = """
        | 0 | Red ball | distance=0.2 | |
        | 0 | Distance | | 0.3 |
        | 100 | Distance | | nothing |
    """
    assert held(test) == [False, True]


def test_streams_of_two_behaviours_with_one_name():
    book = play.rows("| Red ball | map | 1 | Out |\n| Out | subscribe | | Print |", sheet="A") + play.rows(
        "| Red ball | map | 2 | Out |\n| Out | subscribe | | Say |", sheet="B"
    )
    checked = play.check(book + sheet("| 0 | Red ball | | |\n| 0 | Out | | 1 |"))
    (finding,) = checked.report.errors
    assert (finding.code, finding.address.cell) == ("TEST003", "B3")
    assert "A!Out" in finding.remedy
    good = play.check(book + sheet("| 0 | Red ball | | |\n| 0 | A!Out | | 1 |\n| 0 | b ! out | | 2 |"))
    assert run_tests(good).passed


def test_a_stream_without_a_name_is_called_by_its_row():
    rows = "| Red ball | map | 7 | |\n| | subscribe | | Say |"
    checked = play.check(play.rows(rows) + sheet("| 0 | Red ball | | |\n| 0 | T!#2 | | 7 |"))
    ref = checked.graph.behaviours[0].steps[0].number
    good = play.check(play.rows(rows) + sheet(f"| 0 | Red ball | | |\n| 0 | T!#{ref} | | 7 |"))
    assert run_tests(good).passed


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
    assert (first.got, first.hints) == ("nothing came at 2000 ms", ("It came at 0 ms.",))
    assert second.got == "0.2 at 0 ms from T!3"
    assert third.got == "nothing came on “Said” in the whole test"
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


@pytest.mark.parametrize(("test", "code"), [(GOOD, 0), (BAD, 1), ("| x | Red ball | | |", 2), ("", 5)])
def test_exit_codes(book, test, code):
    assert CliRunner().invoke(command, [str(book(test))]).exit_code == code


def test_the_output_names_cell_value_and_draws_the_streams(book):
    out = CliRunner().invoke(command, [str(book("| 0 | Red ball | distance=0.2 | |\n| 0 | Say | | Hello |"))]).output
    assert "✗ Test: 1 of 1 row does not hold" in out
    two = CliRunner().invoke(command, [str(book(BAD + "\n| 1 | Say | | nothing |"))]).output
    assert "✗ Test: 1 of 2 rows does not hold" in two
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


def test_ten_thousand_rows_with_times_in_any_order_are_quick():
    rows = [f"| {(i * 7919) % 10000 * 40} | Red ball | distance={i / 1e5} | |" for i in range(5000)]
    rows += [f"| {(i * 7919) % 10000 * 40} | Distance | | {i / 1e5} |" for i in range(4999)]
    checked = play.check(play.rows(TRACKING) + sheet("\n".join(rows)))
    assert not checked.report.errors
    began = time.perf_counter()
    report = run_tests(checked)
    assert report.passed
    assert time.perf_counter() - began < 10


def test_ten_thousand_rows_at_one_time_and_none_that_holds_end():
    rows = ["| 0 | Red ball | | |"] * 3000 + ["| 0 | Distance | | >1 |"] * 3000 + ["| 0 | Distance | | any |"] * 3000
    checked = play.check(play.rows(TRACKING) + sheet("\n".join(rows)))
    began = time.perf_counter()
    results = run_tests(checked).cases[0].rows
    assert sum(r.passed for r in results) == 3000
    assert time.perf_counter() - began < 30


def test_a_day_of_waiting_takes_no_time():
    began = time.perf_counter()
    assert held("| 23 h | Red ball | | |\n| 23 h | Distance | | any |\n| 24 h | Distance | | nothing |") == [True, True]
    assert time.perf_counter() - began < 5


# ---- the workbooks


FAILS_ON_PURPOSE = {
    "complex-tracking": [("Test old angle", "Arm tracker", 3000)],
    "debugging-exercise": [
        ("Test", "Eye brightness", 500), ("Test", "Eye brightness", 1000), ("Test", "Eye brightness", 1500),
    ],
}  # fmt: skip


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


@pytest.mark.parametrize("number", [1, 2])
def test_either_fix_of_the_stale_combination_makes_its_test_hold(number, tmp_path):
    mended = tmp_path / "mended.xlsx"
    api.fix(FOLDER / "complex-tracking.xlsx", mended, {"LINT001": number})
    _, report = api.test(mended)
    assert report.passed and len(report.cases) == 2


def test_the_workbook_that_new_makes_has_a_test_that_holds(tmp_path):
    _, report = api.test(api.new(tmp_path / "mine.xlsx"))
    assert report.passed and report.cases


@pytest.mark.parametrize("name", NAMES)
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


def test_thousands_of_expectations_at_one_time_are_judged_at_once(book):
    count = 4_900
    path = book("| 0 | Red ball | distance=0.2 | |\n" * count + "| 0 | Say | | any |\n" * count)
    began = time.process_time()
    _, report = api.test(path)
    assert report is not None and report.passed and len(report.cases[0].rows) == count
    assert time.process_time() - began < 8  # s; looking at every event for every row takes much longer


def test_the_free_events_of_a_window_are_those_that_no_row_has_taken():
    lane = _Lane([], [], {})
    for event in (3, 1, 2, 7, 3, 8):
        lane.take(event, 0)
        left = [i for i in range(10) if i not in lane.taken]
        assert list(lane.free(range(10))) == left and list(lane.free(range(2, 8))) == [i for i in left if 2 <= i < 8]
