"""Rows that multiply what they get: a run and a test end in words, soon, and without taking all memory."""

from __future__ import annotations

import json

import pytest
from play import check, example, play, rows

from rrp_sheets.checks import Checked
from rrp_sheets.engine.engine import EventEngine, FrameEngine
from rrp_sheets.engine.plan import make_plan
from rrp_sheets.engine.realtime import MOST_WAITING, EventQueue
from rrp_sheets.errors import RunBroken

DOUBLING_CIRCLE = """
| Red ball, Wait done | merge | | A |
| A | subscribe | 0 | Wait |
| A | subscribe | 0.001 | Wait |
"""
DOUBLING_ROWS = (
    "| Red ball | map | redBall.x | S0 |\n| Red ball | map | redBall.x | T0 |\n"
    + "".join(f"| S{i}, T{i} | merge | | S{i + 1} |\n| S{i}, T{i} | merge | | T{i + 1} |\n" for i in range(60))
    + "| S60 | subscribe | | Head tracker |\n"
)
TEST = """
## Test it
| Time (ms) | Stream | Send | Expect |
|---|---|---|---|
| 0 | Red ball | x=1 | |
| 3000 | Say | | nothing |
"""


def storm(checked: Checked, engine_type: type[FrameEngine] | type[EventEngine]) -> tuple[RunBroken, str, int]:
    """The error that ends it, its row, and how many values came before."""
    engine = engine_type(make_plan(checked))
    with pytest.raises(RunBroken) as caught:
        for frame in range(100):
            engine.settle(frame * 33_333, [("redball", example("Red ball"))] if frame == 0 else [])
    return caught.value, engine.row, sum(s.arrived for s in engine.streams.values())


@pytest.mark.slow
@pytest.mark.parametrize("engine", [FrameEngine, EventEngine])
@pytest.mark.parametrize("body", [DOUBLING_CIRCLE, DOUBLING_ROWS])
def test_values_that_double_end_the_run_soon(body: str, engine: type[FrameEngine] | type[EventEngine]) -> None:
    error, row, values = storm(check(rows(body)), engine)
    assert "multiply" in error.message
    assert error.remedy
    assert row.startswith("T!")
    assert values < 200_000


@pytest.mark.parametrize("body", [DOUBLING_CIRCLE, DOUBLING_ROWS])
def test_a_test_of_rows_that_double_fails_and_says_why(body: str) -> None:
    from rrp_sheets.testing.case_output import as_dict
    from rrp_sheets.testing.run import run_tests

    report = run_tests(check(rows(body, TEST)))
    assert not report.passed
    assert "multiply" in json.dumps(as_dict(report))


@pytest.mark.slow
def test_many_rows_on_one_stream_are_no_storm() -> None:
    body = "".join(f"| Red ball | map | redBall.x + {i} | S{i} |\n" for i in range(3000))
    played = play(
        rows(body + "| S7 | subscribe | | Head tracker |"),
        [(i, "Red ball", example("Red ball")) for i in range(25)],
        100,
    )
    assert len(played["S2999"]) == 25


def test_events_that_pile_up_end_the_run() -> None:
    queue = EventQueue()
    queue.begin()
    for i in range(MOST_WAITING):
        queue.event("redball", i)
    assert queue.take(0) is not None
    queue.event("redball", 0)
    queue.event("redball", 1)
    with pytest.raises(RunBroken, match="faster"):
        queue.take(0)


def test_a_test_that_would_take_a_day_of_frames_is_broken_off() -> None:
    from rrp_sheets.testing.case_output import as_dict
    from rrp_sheets.testing.run import run_tests

    circle = "| Red ball, Wait done | merge | | A |\n| A | subscribe | 0 | Wait |\n"
    report = run_tests(check(rows(circle, TEST.replace("3000 | Say", "86400000 | Wait"))))
    assert not report.passed
    assert "the test was stopped" in json.dumps(as_dict(report))
    assert len(report.cases[0].events) < 300_000
