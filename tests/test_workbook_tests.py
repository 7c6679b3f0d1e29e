"""Tests inside workbooks: what their rows send and expect."""

from __future__ import annotations

import play
import pytest
from tested import held, ran, sheet

from rrp_sheets.testing import run_tests

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
    assert "ended the run" in " ".join(case.rows[0].hints)


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
