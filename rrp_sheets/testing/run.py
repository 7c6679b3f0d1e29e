"""Runs the tests of a checked workbook."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from rrp_sheets.checks import Checked
from rrp_sheets.checks.tests import Case
from rrp_sheets.engine.plan import Plan, make_plan
from rrp_sheets.engine.trace import stream_label
from rrp_sheets.errors import SheetsError
from rrp_sheets.testing.judge import judge, seconds
from rrp_sheets.testing.play import Player
from rrp_sheets.testing.results import CaseResult, RowResult


@dataclass(frozen=True)
class TestReport:
    """The results of a workbook's tests.

    Attributes:
        checked: the workbook.
        cases: a result for every test sheet that was run.
        stopped: whether somebody stopped it before all of them were.
    """

    __test__ = False  # no test of pytest's

    checked: Checked
    cases: tuple[CaseResult, ...]
    stopped: bool = False

    @property
    def passed(self) -> bool:
        """Whether every test holds."""
        return all(c.passed for c in self.cases)


def run_tests(checked: Checked, stopped: Callable[[], bool] = lambda: False) -> TestReport:
    """Run every test sheet of a workbook in virtual time, each from a fresh start.

    Args:
        checked: it must have no errors.
        stopped: asked after every frame.

    Raises:
        SheetsError: when the workbook has errors.
    """
    if checked.report.errors:
        raise SheetsError("This workbook has errors, so its tests cannot run.", "See `rrp-sheets check`.")
    cases = tuple(_cases(checked, stopped))
    return TestReport(checked, cases, stopped())


def _cases(checked: Checked, stopped: Callable[[], bool]) -> Iterator[CaseResult]:
    plan = make_plan(checked)
    for case in checked.tests:
        result = run_case(plan, case, stopped)
        if stopped():
            return
        yield result


def run_case(plan: Plan, case: Case, stopped: Callable[[], bool] = lambda: False) -> CaseResult:
    """Run one test."""
    began = time.perf_counter()
    player = Player(plan, case, plan.checked.run.seed)
    player.play(stopped)
    names = {s.id: stream_label(s) for s in plan.checked.graph.streams.values()}
    rows = judge(case, player.events, player.faults, player.frames, names)
    rows = tuple(_explained(r, player) for r in rows)
    took = time.perf_counter() - began
    return CaseResult(case, rows, tuple(player.events), tuple(player.faults), player.ended_us, took, player.broken)


def _explained(result: RowResult, player: Player) -> RowResult:
    """A result with the reasons that only the run knows."""
    if result.passed:
        return result
    row, hints = result.row, list(result.hints)
    if row.why_silent:
        hints.append(f"Nothing ever comes there: {row.why_silent}.")
    if player.ended_by and row.time_us > player.ended_us:
        hints.append(f"{player.ended_by} had ended the run at {seconds(player.ended_us)}.")
    return RowResult(row, False, result.event, result.got, tuple(hints))
