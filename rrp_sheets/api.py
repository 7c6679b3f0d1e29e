"""Facade of the program for the command line, the web and notebooks.

>>> from rrp_sheets import api
>>> from rrp_sheets.resources import bundled
>>> api.check(bundled("workbooks", "simple-tracking.xlsx")).report.errors
[]
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from datetime import date
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rrp_sheets.checks import Checked
    from rrp_sheets.checks.fixing import CellChange
    from rrp_sheets.compare import Comparison
    from rrp_sheets.diagnostics import Report
    from rrp_sheets.formulas.trial import Answer
    from rrp_sheets.render.marble_diagram import MarbleDiagram
    from rrp_sheets.render.pack.make import Paper
    from rrp_sheets.replay import Replayed
    from rrp_sheets.runs import RunObserver, RunResult, RunSettings
    from rrp_sheets.runs.run_process import RunOutcome
    from rrp_sheets.services.bundle_packing import Packed
    from rrp_sheets.services.changes_drawn import Compared
    from rrp_sheets.services.edited_copies import CellSet, Renamed
    from rrp_sheets.services.posing import Posed
    from rrp_sheets.services.printing import Reader
    from rrp_sheets.testing import TestReport
    from rrp_sheets.workbook import Reading
    from rrp_sheets.workbook.edits import Edit
    from rrp_sheets.workbook.files import Edited

__all__ = [
    "RunSettings", "check", "convert", "diff", "diff_in_detail", "draw", "draw_marbles", "draw_tests", "edit",
    "explain", "export", "fix", "formula", "marbles", "mark", "new", "not_kept", "pack", "pose", "print_pack", "read",
    "rename", "replay", "run", "run_apart", "set_cell", "test",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    """Load `RunSettings` on first use, so that callers who only check need not load the engine."""
    if name == "RunSettings":
        from rrp_sheets.runs import RunSettings

        return RunSettings
    raise AttributeError(name)


# ---- workbooks and formulas
def read(path: Path | str) -> Reading:
    """Read a workbook: an .xlsx, a folder of CSV files, or a Markdown file.

    Raises:
        UnreadableFile: when it cannot be read at all, or is refused.
    """
    from rrp_sheets.workbook import read as read_workbook

    return read_workbook(Path(path))


def check(path: Path | str) -> Checked:
    """Read and check a workbook; everything that is wrong is in the result's `report`."""
    from rrp_sheets.checks import check_workbook

    reading = read(path)
    return check_workbook(reading.workbook, reading.report)


def new(path: Path | str, robot: str = "nao", template: str = "guided", language: str = "en") -> Path:
    """Make a workbook to start from, “guided” and “empty” in a language (`en`, `ja`).

    Raises:
        SheetsError: when the file exists already, or there is no such template.
    """
    from rrp_sheets.documents.copies import make_new
    from rrp_sheets.robots import load_robot

    return make_new(Path(path), load_robot(robot), template, language)


def convert(path: Path | str, target: Path | str, *, replace: bool = True) -> Path:
    """Write a workbook in another format: a styled .xlsx, a Markdown file (.md), or a folder of CSV files.

    Raises:
        SheetsError: when it cannot be written, or there is such a file and `replace` is False.
        UnreadableFile: when the workbook cannot be read.
    """
    from rrp_sheets.documents.copies import convert as convert_workbook
    from rrp_sheets.robots import load_robot

    return convert_workbook(Path(path), load_robot(), Path(target), replace=replace)


def not_kept(path: Path | str, target: Path | str) -> list[str]:
    """Return what `convert` to this target leaves out that people have written or set: comments, bold, colours."""
    from rrp_sheets.documents.copies import not_kept as found

    return found(Path(path), Path(target))


def edit(path: Path | str, edits: Sequence[Edit], *, expected_digest: str | None = None) -> Edited:
    """Change cells and rows of a workbook's file (`workbook.edits`), all or none, and leave all else as it is.

    Raises:
        SheetsError: when an edit cannot be done, somebody else has changed the file, or it cannot be written.
    """
    from rrp_sheets.workbook.files import edit as edit_file

    return edit_file(path, edits, expected_digest=expected_digest)


def fix(
    path: Path | str, target: Path | str, chosen: Mapping[str, str] | None = None
) -> tuple[list[CellChange], Checked]:
    """Write a copy of a workbook with all safe fixes in it; return what was changed, and the copy, checked.

    `chosen` names other fixes by the code of their findings: `{"LINT002": "throttle"}`.

    Raises:
        SheetsError: when no finding offers a chosen fix, or the copy would replace the workbook or cannot be written.
    """
    from rrp_sheets.services.edited_copies import fix_copy

    return fix_copy(Path(path), Path(target), chosen or {})


def mark(path: Path | str, target: Path | str, report: Report, language: str = "en") -> Path:
    """Write an .xlsx copy of a workbook in which its findings stand beside their rows; the original stays as it is.

    Raises:
        SheetsError: when the copy cannot be written, or its name is taken by another file.
    """
    from rrp_sheets.services.edited_copies import write_marked

    return write_marked(Path(path), Path(target), report, language)


def set_cell(path: Path | str, cell: str, value: str, sheet: str = "") -> CellSet:
    """Put a typed text into a cell (`Tracking!C5`, or `C5` of a sheet), and check the workbook; see `edit`."""
    from rrp_sheets.services.edited_copies import set_cell as set_one

    return set_one(Path(path), cell, value, sheet)


def rename(
    path: Path | str, old: str, new: str, sheet: str = "", also: Sequence[str] = (), *, preview: bool = False
) -> Renamed:
    """Give a stream, a helper or a column another name in all cells that have it, and check the workbook; see `edit`.

    `sheet` (or the old name as `Tracking!Far`, `Parts[Zone]`) says where the name is given; `also` are cells
    (`Helpers!C2`) that only perhaps read the column. With `preview` nothing is written.
    """
    from rrp_sheets.services.edited_copies import rename as rename_all

    return rename_all(Path(path), old, new, sheet, also, preview=preview)


def pose(
    path: Path | str, name: str, joints: Sequence[str] = (), *, posture: str = "", at: float | None = None,
    picture: Path | str | None = None,
) -> Posed:  # fmt: skip
    """Let the simulated robot take a pose, and write its joints as a keyframe into the workbook's Gestures sheet.

    Args:
        path: of the workbook.
        name: of the gesture; it may be new.
        joints: joints to move, as `RShoulderPitch=-60°` or `LElbowRoll=-0.5` (rad).
        posture: to begin with; else the gesture's last keyframe, or the start posture.
        at: s from the gesture's beginning; a keyframe of that time is replaced. None: 1 s after its last one.
        picture: where to store a picture of that pose (.png).

    Raises:
        SheetsError: a joint, an angle or the posture is not known, or the file cannot be written.
        MissingPart: when the simulator is not installed here.
    """
    from rrp_sheets.services.posing import pose as write_pose

    return write_pose(
        Path(path), name, joints, posture=posture, at=at, picture=None if picture is None else Path(picture)
    )


def diff(first: Path | str, second: Path | str) -> Comparison:
    """Compare two workbooks of any formats by what they mean; `same` tells whether they have the same behaviour.

    Raises:
        UnreadableFile: when one of them cannot be read at all.

    >>> from rrp_sheets.resources import bundled
    >>> diff(bundled("workbooks", "greeter.xlsx"), bundled("workbooks", "source", "greeter.md")).same
    True
    """
    from rrp_sheets.compare import compare
    from rrp_sheets.compare.side import open_checked

    return compare(open_checked(Path(first)), open_checked(Path(second)))


def diff_in_detail(first: Path | str, second: Path | str) -> Compared:
    """Compare as `diff` does, and add the rows of the changed behaviours and pictures of them (`svg`, `html`)."""
    from rrp_sheets.services.changes_drawn import compared

    return compared(Path(first), Path(second))


def formula(text: str, inputs: Mapping[str, Any] | None = None) -> Answer:
    """Evaluate a formula with inputs given as JSON values; an object is a payload record.

    >>> formula("IF(x > 3; 1; 0)", {"x": 5}).value
    1
    """
    from rrp_sheets.formulas.trial import try_formula

    return try_formula(text, inputs or {})


# ---- drawings, explanations, prints
def draw(path: Path | str, target: Path | str, behaviour: str = "", language: str = "") -> tuple[Checked, list[str]]:
    """Draw a workbook's behaviours (or one of them) into an .svg, .pdf, .png or .dot file.

    Returns the checked workbook, and what the picture lacks (a font, say), in words.
    """
    from rrp_sheets.render.output import draw as draw_checked

    checked = check(path)
    return checked, draw_checked(checked, Path(target), behaviour, language)


def explain(path: Path | str, behaviour: str = "", language: str = "") -> tuple[str, Checked]:
    """Explain in plain words what a workbook does: `language` is en or ja, by default that of its Protocol."""
    from rrp_sheets.render.output import explain as explain_checked

    checked = check(path)
    return explain_checked(checked, behaviour, language), checked


def print_pack(
    path: Path | str, target: Path | str, *, against: Path | str | None = None, paper: Paper = "a4",
    language: str = "", draft: bool = False, today: date | None = None, reader: Reader = "board",
) -> list[str]:  # fmt: skip
    """Print a workbook for an ethics board, as an accessible PDF that is the same for the same workbook and day.

    Args:
        path: of the workbook.
        target: the PDF.
        against: the approved version, to say what has changed since.
        paper: `a4` or `letter`.
        language: en or ja; by default what its Protocol says.
        draft: mark every page as a draft; the workbook may have errors then.
        today: the day that is printed; by default that of the clock.
        reader: `board`, or `participants` for an information sheet of one page in plain language.

    Returns:
        What the PDF lacks (a font, say), in words.

    Raises:
        UnreadableFile: when one of the workbooks cannot be read.
        SheetsError: when the workbook has errors and no draft is wanted, or the PDF cannot be made or written.
    """
    from rrp_sheets.services.printing import print_pack as print_file

    approved = None if against is None else Path(against)
    made = print_file(
        Path(path), Path(target), against=approved, paper=paper, language=language, draft=draft, today=today,
        reader=reader,
    )  # fmt: skip
    return made.notes


def marbles(
    path: Path | str, *, behaviour: str = "", window: tuple[int | None, int | None] = (None, None),
    streams: Sequence[str] = (),
) -> tuple[Checked | None, list[MarbleDiagram] | None]:  # fmt: skip
    """Return marble diagrams of the streams of a recorded run, or of a workbook's tests.

    Args:
        path: a run's folder, a trace, or a workbook with tests.
        behaviour: only this one.
        window: from when to when, in microseconds.
        streams: only these, by name.

    Returns:
        The workbook when it is one, and the diagrams; none of a workbook that has errors or no tests.

    Raises:
        UnreadableFile: when it cannot be read.
        SheetsError: when there is no such behaviour, stream or time in it.
    """
    from rrp_sheets import __version__
    from rrp_sheets.model.run_files import Stamp
    from rrp_sheets.recording.marbles import is_trace, stamped, stamped_scores
    from rrp_sheets.render.marble_diagram import chosen
    from rrp_sheets.testing.case_output import scores

    if is_trace(Path(path)):
        return None, chosen(stamped_scores(Path(path)), behaviour, window, streams)
    checked, report = test(path)
    if report is None or not report.cases:
        return checked, None
    stamp = Stamp(Path(path).name, read(path).digest, __version__, language=checked.run.language)
    found = [score for case in report.cases for score in scores(checked, case)]
    return checked, chosen(stamped(found, stamp), behaviour, window, streams)


def draw_marbles(scores: Sequence[MarbleDiagram], target: Path | str) -> list[str]:
    """Draw marble diagrams into an .svg, .pdf, .png or .txt file; return what the picture lacks, in words."""
    from rrp_sheets.render.output import write_marbles

    return write_marbles(scores, target)


def draw_tests(report: TestReport, target: Path | str) -> list[str]:
    """Draw marble diagrams of a workbook's tests into a file; return what the picture lacks, in words."""
    from rrp_sheets.testing.case_output import scores

    return draw_marbles([s for case in report.cases for s in scores(report.checked, case)], target)


# ---- runs, tests, recordings
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
    from rrp_sheets.engine.run_events import RunObserver
    from rrp_sheets.runs.run_process import RunProcess

    return RunProcess(Path(path), settings).listen(view or RunObserver())


def test(path: Path | str, stopped: Callable[[], bool] = lambda: False) -> tuple[Checked, TestReport | None]:
    """Run a workbook's test sheets in virtual time, until `stopped` returns True; no report when it has errors.

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
    """Write recorded runs as a table (.xlsx, .csv; several in one) or as plots (.svg, .pdf, .png); return notes on it.

    Args:
        runs: folders of runs, or their traces; several only for a table. What else `runs/*` names is left out.
        target: the file to write.
        streams: of plots, only these.

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
    from rrp_sheets.services.bundle_packing import pack_with_protocol

    made, approved = (None if p is None else Path(p) for p in (target, against))
    return pack_with_protocol(Path(path), made, runs, approved, today)
