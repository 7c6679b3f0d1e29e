"""Workbooks with a test sheet, for the tests of tests."""

from __future__ import annotations

import play

from rrp_sheets.testing import run_tests

TRACKING = """
    | Red ball | map | redBall.distance | Distance |
    | Distance | filter | distance < 0.5 | Close |
    | Close | map | "It is close, at " & close | Words |
    | Words | subscribe | | Say |
    | Say done | map | sayDone.value | Said |
    | Said | subscribe | | Print |
"""


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
