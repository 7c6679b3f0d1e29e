"""Commands that say what is wrong with a workbook: `check`, and `test`, which runs its tests."""

from __future__ import annotations

import json
import re
import shutil
import signal
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Any

import click

from rrp_sheets.cli.language import readers_language, speak, spoken, translated
from rrp_sheets.cli.main import INTERRUPTED, UNREADABLE, handle_signals
from rrp_sheets.cli.terminal import WorkbookArgument, opened, print_notes, quoted, say, styled, usage_error
from rrp_sheets.texts import LANGUAGES, N_, counted, sentences

if TYPE_CHECKING:
    from rrp_sheets.checks import Checked
    from rrp_sheets.checks.fixing import CellChange
    from rrp_sheets.diagnostics import Diagnostic
    from rrp_sheets.testing import CaseResult, TestReport

_SEVERITIES = {"error": (N_("error"), "red"), "warning": (N_("warning"), "yellow"), "info": (N_("info"), "blue")}
_FIX = re.compile(r"(?P<code>[A-Za-z]+\d{3})(:(?P<fix>[\w-]+))?")


class _Choice(click.ParamType):  # type: ignore[type-arg]  # generic for its stubs only, not when it runs
    """`LINT002:throttle`: that fix of the findings LINT002; without it, the fix of findings that have only one."""

    name = "CODE:FIX"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[str, str]:
        match = _FIX.fullmatch(str(value))
        if not match:
            message = N_("“{text}” names no fix. Write a code and a fix, for example LINT002:throttle.", text=value)
            self.fail(translated(message), param, ctx)
        return match["code"].upper(), (match["fix"] or "").casefold()


@click.command(name="check")
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--json", "as_json", is_flag=True, help="print findings and example values as JSON")
@click.option(
    "--language",
    type=click.Choice(list(LANGUAGES)),
    default=None,
    help="the language  [default: your computer's, then the Protocol's]",
)
@click.option("--report", "out", type=click.Path(path_type=Path), help="write a copy (.xlsx) with the findings in it")
@click.option("--fix", "mended", type=click.Path(path_type=Path), help="write a corrected copy, and say what changed")
@click.option("--apply", "chosen", type=_Choice(), multiple=True,
              help="with --fix: also this fix that needs your choice, such as LINT002:throttle")  # fmt: skip
def check_command(
    file: Path, as_json: bool, language: str | None, out: Path | None, mended: Path | None,
    chosen: tuple[tuple[str, str], ...],
) -> None:  # fmt: skip
    """Check FILE: show each problem with its cell and how to fix it.

    With --fix a corrected copy is written, with every fix that leaves no doubt. Problems and exit code are then those
    of the copy.

    Exit code: 0 no errors, 1 errors, 2 the file cannot be read.
    """
    from rrp_sheets import api
    from rrp_sheets.diagnostics.report import MORE_LATER, UnreadableWorkbook, checks_wait

    if chosen and mended is None:
        raise usage_error(N_("--apply goes with --fix OUT: the corrected copy."))
    if len(dict(chosen)) < len(chosen):
        raise usage_error(N_("--apply takes one fix for a code; apply the other one to the copy afterwards."))
    changes: list[CellChange] = []
    speak(language or "en")
    try:
        file = opened(file)
        if mended is None:
            checked = api.check(file)
        else:
            changes, checked = api.fix(file, mended, dict(chosen))
    except UnreadableWorkbook as error:
        if not as_json:
            raise
        entry = error.finding.as_dict(language or "en")
        click.echo(json.dumps({"findings": [entry], "complete": False, "examples": {}}, ensure_ascii=False, indent=2))
        sys.exit(2)
    report = checked.report
    language = language or checked.run.language
    speak(language)
    if out is not None:
        api.mark(mended or file, out, report, spoken())
    if as_json:
        findings = [d.as_dict(language) for d in report]
        found = {"findings": findings, "complete": not checks_wait(report), "examples": _examples(checked)}
        if mended is not None:
            found["changes"] = [asdict(c) for c in changes]
        click.echo(json.dumps(found, ensure_ascii=False, indent=2))
    else:
        if mended is not None:
            print_changes(changes, mended)
        print_findings(report)
        say(sentences(verdict(report), MORE_LATER if checks_wait(report) else ""))
        if out is not None:
            say(N_("Created {path}. The problems are next to their rows and listed on its last sheet.", path=out))
    sys.exit(1 if report.errors else 0)


def _examples(checked: Checked) -> dict[str, Any]:
    """Return the value that each row gives for the examples of its inputs, by sheet and row."""
    from rrp_sheets.checks.check import row_examples
    from rrp_sheets.model.values import show, to_json

    return {
        ref: {"value": to_json(fact.example), "shown": show(fact.example), "kind": fact.known.kind,
              "unit": fact.known.unit, "sure": fact.sure}
        for ref, fact in row_examples(checked).items()
    }  # fmt: skip


def print_changes(changes: Sequence[CellChange], mended: Path) -> None:
    """Print what was changed, cell by cell."""
    for c in changes:
        what = N_("inserted: {text}", text=c.new) if c.old is None else quoted(c.old, c.new)
        say(styled(N_("changed"), fg="green", bold=True), c.code, c.place, what)
    say(N_("Created {path}.", path=mended) if changes else N_("Nothing to change; {path} is a copy.", path=mended))


def print_findings(findings: Iterable[Diagnostic], err: bool = False) -> None:
    """Print findings as people read them."""
    for d in findings:
        place = f"{d.address}: " if d.address else ""
        word, colour = _SEVERITIES[d.severity.value]
        say(styled(word, fg=colour, bold=True), f"{d.code} {place}{translated(d.message)}", err=err)
        say("  →", d.remedy, err=err)
        for fix in d.fixes if len(d.fixes) > 1 else (f for f in d.fixes if not f.safe):
            say(f"    --apply {d.code}:{fix.id} ", fix.title, err=err)


def verdict(findings: Iterable[Diagnostic]) -> str:
    """The findings counted, in words: `2 errors, 1 warning`."""
    kinds = [d.severity.value for d in findings]
    counts = {kind: kinds.count(kind) for kind in ("error", "warning")}
    return N_("{before}.", before=counted(counts)) if any(counts.values()) else counted(counts)


NO_TESTS = 5


@click.command(name="test")
@click.argument("file", type=WorkbookArgument())
@click.option("--json", "as_json", is_flag=True, help="print the results as JSON")
@click.option("--junit", type=click.Path(path_type=Path), help="write the results as JUnit XML into this file")
@click.option("--marbles", type=click.Path(path_type=Path),
              help="draw the values of the streams, as .svg, .pdf or .png")  # fmt: skip
def test_command(file: Path, as_json: bool, junit: Path | None, marbles: Path | None) -> None:
    """Run the test sheets of FILE: send values, and compare what comes out with what is expected.

    Every sheet with the headers Time (ms), Stream, Send and Expect is a test. Tests need no robot and no simulator. A
    failed test is shown with its cell, what came instead, and the marble diagram.

    Exit code: 0 all tests passed, 1 some failed, 2 the file cannot be read or has errors, 5 there are no tests or they
    expect nothing, 130 stopped with Ctrl-C.
    """
    from rrp_sheets import api
    from rrp_sheets.testing import case_output
    from rrp_sheets.workbook.files import refuse_workbook, write_atomically

    if junit is not None:
        refuse_workbook(junit, file)
    with _interrupted() as stopped:
        checked, report = api.test(file, stopped)
    speak(checked.run.language)
    if report is None:
        print_findings(checked.report.errors, err=True)
        say(N_("The workbook has errors, so its tests are not run."), err=True)
        if as_json:
            click.echo(json.dumps({"findings": [d.as_dict() for d in checked.report]}, ensure_ascii=False))
        sys.exit(UNREADABLE)
    if as_json:
        click.echo(json.dumps(case_output.as_dict(report), ensure_ascii=False, indent=2))
    else:
        _show(report)
    if junit is not None:
        write_atomically(junit, case_output.junit(report))
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
        say("  →", N_("Add a sheet with the headers Time (ms), Stream, Send, Expect."), err=True)
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
        words = N_("{n} tests passed ({seconds:.2f} s).") if count > 1 else N_("{n} test passed ({seconds:.2f} s).")
        say(N_(words, n=count, seconds=seconds))


def _show_case(report: TestReport, result: CaseResult) -> None:
    from rrp_sheets.render.marble_diagram import marble_text
    from rrp_sheets.testing.case_output import around_failures, counted, failure_lines, fault_lines

    sign, colour = ("–", "yellow") if result.idle else ("✓", "green") if result.passed else ("✗", "red")
    say(click.style(sign, fg=colour, bold=True), N_("{name}: {found}", name=result.case.name, found=counted(result)))
    if not result.passed:
        for line in failure_lines(result):
            say(" ", line)
        width = max(60, min(160, shutil.get_terminal_size((110, 24)).columns - 4))
        for line in marble_text(around_failures(report.checked, result, readers_language()), width=width):
            click.echo(f"    {line}")
    for line in fault_lines(result)[:10]:
        say(" ", styled(N_("formula"), fg="yellow"), line)


@contextmanager
def _interrupted() -> Iterator[Callable[[], bool]]:
    """Let Ctrl-C stop the tests and show those that are over; a second one ends everything at once."""
    asked = False

    def ask(number: int, frame: FrameType | None) -> None:
        nonlocal asked
        if asked:
            raise KeyboardInterrupt
        asked = True

    before = signal.getsignal(signal.SIGINT)
    handle_signals(ask, "SIGINT")
    try:
        yield lambda: asked
    finally:
        handle_signals(before, "SIGINT")
