"""Drawing, explaining and printing workbooks, and marble diagrams of their streams."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import date
from pathlib import Path
from typing import TYPE_CHECKING

from rrp_sheets.api.runs import test
from rrp_sheets.api.workbooks import check, read

if TYPE_CHECKING:
    from rrp_sheets.checks import Checked
    from rrp_sheets.render.marble_diagram import MarbleDiagram
    from rrp_sheets.render.pack.make import Paper
    from rrp_sheets.testing import TestReport


def draw(path: Path | str, target: Path | str, behaviour: str = "", language: str = "") -> tuple[Checked, list[str]]:
    """Draw a workbook's behaviours (or one of them) into an .svg, .pdf, .png or .dot file.

    Returns:
        The checked workbook, and what the picture lacks (a font, say), in words.
    """
    from rrp_sheets.documents.drawings import draw as draw_checked

    checked = check(path)
    return checked, draw_checked(checked, Path(target), behaviour, language)


def explain(path: Path | str, behaviour: str = "", language: str = "") -> tuple[str, Checked]:
    """Explain in plain words what a workbook does: `language` is en or ja, by default that of its Protocol."""
    from rrp_sheets.documents.drawings import explain as explain_checked

    checked = check(path)
    return explain_checked(checked, behaviour, language), checked


def print_pack(
    path: Path | str, target: Path | str, *, against: Path | str | None = None, paper: Paper = "a4",
    language: str = "", draft: bool = False, today: date | None = None,
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

    Returns:
        What the PDF lacks (a font, say), in words.

    Raises:
        UnreadableFile: when one of the workbooks cannot be read.
        SheetsError: when the workbook has errors and no draft is wanted, or the PDF cannot be made or written.
    """
    from rrp_sheets.services.printing import print_pack as print_file

    approved = None if against is None else Path(against)
    made = print_file(
        Path(path), Path(target), against=approved, paper=paper, language=language, draft=draft, today=today
    )
    return made.notes


def marbles(
    path: Path | str,
    *,
    behaviour: str = "",
    window: tuple[int | None, int | None] = (None, None),
    streams: Sequence[str] = (),
) -> tuple[Checked | None, list[MarbleDiagram] | None]:
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
    from rrp_sheets.testing.output import scores

    checked, report = None, None
    if is_trace(Path(path)):
        found = stamped_scores(Path(path))
    else:
        checked, report = test(path)
        if report is None or not report.cases:
            return checked, None
        stamp = Stamp(Path(path).name, read(path).digest, __version__)
        found = stamped([score for case in report.cases for score in scores(checked, case)], stamp)
    return checked, chosen(found, behaviour, window, streams)


def draw_marbles(scores: Sequence[MarbleDiagram], target: Path | str) -> list[str]:
    """Draw marble diagrams into an .svg, .pdf, .png or .txt file; return what the picture lacks, in words."""
    from rrp_sheets.render.output import write_marbles

    return write_marbles(scores, target)


def draw_tests(report: TestReport, target: Path | str) -> list[str]:
    """Draw marble diagrams of a workbook's tests into a file; return what the picture lacks, in words."""
    from rrp_sheets.testing.output import scores

    return draw_marbles([s for case in report.cases for s in scores(report.checked, case)], target)
