"""`rrp-sheets test FILE`."""

from __future__ import annotations

import json
import signal
import sys
import threading
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Any

import click

from rrp_sheets.cli.main import INTERRUPTED, UNREADABLE
from rrp_sheets.cli.terminal import WorkbookArgument, print_notes, say, speak, translated
from rrp_sheets.texts import N_

if TYPE_CHECKING:
    from rrp_sheets.testing import CaseResult, TestReport

NO_TESTS = 5


@click.command(name="test")
@click.argument("file", type=WorkbookArgument())
@click.option("--json", "as_json", is_flag=True, help="print the results as JSON")
@click.option("--junit", type=click.Path(path_type=Path), help="write the results as JUnit XML into this file")
@click.option("--marbles", type=click.Path(path_type=Path),
              help="draw what came on the streams, as .svg, .pdf or .png")  # fmt: skip
def test_command(file: Path, as_json: bool, junit: Path | None, marbles: Path | None) -> None:
    """Run the test sheets of FILE: what they send goes in, what they expect must come out.

    Every sheet with the headers Time (ms), Stream, Send and Expect is a test. It runs without robot and simulator, as
    fast as the machine can. What does not hold is shown with its cell, what came instead, and the marble diagram.

    Exit code: 0 all tests hold, 1 some do not, 2 the file cannot be read or has errors, 5 it has no tests or they
    expect nothing, 130 stopped with Ctrl-C.
    """
    from rrp_sheets import api
    from rrp_sheets.cli.check import print_findings
    from rrp_sheets.workbook.atomic import refuse_workbook, write_atomically

    if junit is not None:
        refuse_workbook(junit, file)
    with _StopOnInterrupt() as stop:
        checked, report = api.test(file, stop.asked)
    speak(checked.run.language)
    if report is None:
        print_findings(checked.report.errors, err=True)
        say(N_("The workbook has errors, so its tests are not run."), err=True)
        if as_json:
            click.echo(json.dumps({"findings": [d.as_dict() for d in checked.report]}, ensure_ascii=False))
        sys.exit(UNREADABLE)
    if as_json:
        from rrp_sheets.testing.case_output import as_dict

        click.echo(json.dumps(as_dict(report), ensure_ascii=False, indent=2))
    else:
        _show(report)
    if junit is not None:
        from rrp_sheets.testing.case_output import junit as as_junit

        write_atomically(junit, as_junit(report))
    if marbles is not None and report.cases:
        print_notes(api.draw_tests(report, marbles))
        say(N_("Drawn: {path}", path=marbles), err=True)
    sys.exit(_code(report))


def _code(report: TestReport) -> int:
    if report.stopped:
        return INTERRUPTED
    if all(c.idle for c in report.cases):
        return NO_TESTS
    return 0 if report.passed else 1


def _show(report: TestReport) -> None:
    if not report.checked.tests:
        say(N_("This workbook has no tests."), err=True)
        click.echo(f"  → {translated(N_('Add a sheet with the headers Time (ms), Stream, Send, Expect.'))}", err=True)
        return
    for result in report.cases:
        _show_case(report, result)
    failed = sum(not c.passed for c in report.cases)
    count = sum(not c.idle for c in report.cases)
    seconds = sum(c.seconds for c in report.cases)
    if report.stopped:
        words = N_("Stopped: {n} of {of} tests were run.")
        say(N_(words, n=len(report.cases), of=len(report.checked.tests)), err=True)
    elif failed:
        words = N_("{failed} of {n} tests fail ({seconds:.2f} s).")
        one = N_("{failed} of {n} test fails ({seconds:.2f} s).")
        say(N_(words if count > 1 else one, failed=failed, n=count, seconds=seconds))
    elif count:
        words = N_("{n} tests hold ({seconds:.2f} s).") if count > 1 else N_("{n} test holds ({seconds:.2f} s).")
        say(N_(words, n=count, seconds=seconds))


def _show_case(report: TestReport, result: CaseResult) -> None:
    from rrp_sheets.render.marble_diagram import marble_text
    from rrp_sheets.testing.case_output import around_failures, counted, failure_lines, fault_lines

    sign, colour = ("–", "yellow") if result.idle else ("✓", "green") if result.passed else ("✗", "red")
    click.echo(f"{click.style(sign, fg=colour, bold=True)} {result.case.name}: {translated(counted(result))}")
    faults = fault_lines(result)
    if not result.passed:
        for line in failure_lines(result):
            click.echo(f"  {translated(line)}")
        for line in marble_text(around_failures(report.checked, result), width=_columns()):
            click.echo(f"    {line}")
    for line in faults[:10]:
        click.echo(f"  {click.style('formula', fg='yellow')} {translated(line)}")


def _columns() -> int:
    import shutil

    return max(60, min(160, shutil.get_terminal_size((110, 24)).columns - 4))


class _StopOnInterrupt:
    """Lets Ctrl-C stop the tests and show those that are over; a second one ends everything at once."""

    def __init__(self) -> None:
        self._asked = False
        self._main = threading.current_thread() is threading.main_thread()
        self._before: Any = None

    def __enter__(self) -> _StopOnInterrupt:
        if self._main:
            self._before = signal.signal(signal.SIGINT, self._ask)
        return self

    def __exit__(self, *error: object) -> None:
        if self._main:
            signal.signal(signal.SIGINT, self._before)

    def _ask(self, number: int, frame: FrameType | None) -> None:
        if self._asked:
            raise KeyboardInterrupt
        self._asked = True

    def asked(self) -> bool:
        """Return whether Ctrl-C was pressed."""
        return self._asked
