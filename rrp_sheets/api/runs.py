"""Running workbooks and their tests; exporting, replaying and packing recorded runs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from datetime import date
from pathlib import Path
from typing import TYPE_CHECKING

from rrp_sheets.api.workbooks import check, read

if TYPE_CHECKING:
    from rrp_sheets.checks import Checked
    from rrp_sheets.replay import Replayed
    from rrp_sheets.runs import RunObserver, RunResult, RunSettings
    from rrp_sheets.runs.run_process import RunOutcome
    from rrp_sheets.services.bundle.packing import Packed
    from rrp_sheets.testing import TestReport


def run(
    path: Path | str, settings: RunSettings | None = None, view: RunObserver | None = None
) -> tuple[Checked, RunResult | None]:
    """Check a workbook and run it on the simulated robot; no result when it has errors.

    Raises:
        UnreadableFile: when it cannot be read.
        MissingPart: when the simulator is not installed here.
    """
    from rrp_sheets.checks import check_workbook
    from rrp_sheets.runs import run as run_checked

    reading = read(path)
    checked = check_workbook(reading.workbook, reading.report)
    if checked.report.errors:
        return checked, None
    return checked, run_checked(reading, checked, settings, view)


def run_apart(path: Path | str, settings: RunSettings | None = None, view: RunObserver | None = None) -> RunOutcome:
    """Check a workbook and run it in a supervised process of its own, as the command line does.

    :func:`run` keeps everything in this process, where a notebook can look at it, but has to interrupt a row that never
    ends. Here a watchdog ends such a run, and memory is limited.

    Raises:
        UnreadableFile: when it cannot be read.
        MissingPart: when the simulator is not installed here.
        RunBroken: when the run broke off before it left anything.
    """
    from rrp_sheets.runs.run_process import run_apart as run_in_process

    return run_in_process(Path(path), settings, view)


def test(path: Path | str, stopped: Callable[[], bool] = lambda: False) -> tuple[Checked, TestReport | None]:
    """Run a workbook's test sheets in virtual time; no report when the workbook has errors.

    Args:
        path: of the workbook.
        stopped: polled; the tests stop when it returns True.

    Raises:
        UnreadableFile: when it cannot be read.
    """
    from rrp_sheets.testing import run_tests

    checked = check(path)
    if checked.report.errors:
        return checked, None
    return checked, run_tests(checked, stopped)


test.__test__ = False  # type: ignore[attr-defined]  # no test of pytest's


def export(runs: Sequence[Path | str], target: Path | str, *, streams: Sequence[str] = ()) -> list[str]:
    """Write recorded runs as a table (.xlsx, .csv; several in one) or as plots (.svg, .pdf, .png).

    Args:
        runs: folders of runs, or their traces.
        target: the file to write.
        streams: of plots, only these.

    Returns:
        Notes for the user.

    Raises:
        SheetsError: that cannot be made as such a file, or it cannot be written.
        UnreadableFile: when a run cannot be read.
    """
    from rrp_sheets.recording.exporting import export as export_runs

    return export_runs([Path(run) for run in runs], Path(target), streams)


def replay(trace: Path | str, other: Path | str | None = None) -> Replayed:
    """Replay a recorded run from its sensor values, without a robot, and compare it event by event.

    Args:
        trace: a run's folder, or its trace.jsonl.
        other: a workbook to play instead of the one that ran: what would have been different in that session.

    Raises:
        UnreadableFile: when the trace or a workbook cannot be read.
        SheetsError: when a workbook has errors, or the one that ran is not there and no other is named.
    """
    from rrp_sheets.replay import replay as replay_run

    return replay_run(Path(trace), None if other is None else Path(other))


def pack(
    path: Path | str, target: Path | str | None = None, *, runs: Sequence[str] = (), against: Path | str | None = None,
    today: date | None = None,
) -> Packed:  # fmt: skip
    """Make a bundle: a zip of a workbook and all that is needed to run it elsewhere.

    The same files give the same bytes on the same day.

    Args:
        path: of the workbook.
        target: the zip; the workbook's name with .zip in the current folder by default.
        runs: folders of runs to put in, or their names in `runs` beside the workbook.
        against: the approved version, for the printed list of changes.
        today: the day that is printed; by default that of the clock.

    Raises:
        UnreadableFile: when the workbook cannot be read.
        SheetsError: when there is no such run, or the bundle cannot be written.
    """
    from rrp_sheets.services.bundle.packing import pack_with_protocol

    made, approved = (None if p is None else Path(p) for p in (target, against))
    return pack_with_protocol(Path(path), made, runs, approved, today)
