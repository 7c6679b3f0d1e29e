"""Reading, checking, changing and comparing workbooks, and trying formulas."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rrp_sheets.checks import Checked
    from rrp_sheets.checks.fixing import CellChange
    from rrp_sheets.compare import Comparison
    from rrp_sheets.diagnostics import Report
    from rrp_sheets.formulas.trial import Answer
    from rrp_sheets.services.changes_drawn import Compared
    from rrp_sheets.services.edited_copies import CellSet
    from rrp_sheets.services.posing import Posed
    from rrp_sheets.workbook import Reading
    from rrp_sheets.workbook.editing import Edited
    from rrp_sheets.workbook.edits import Edit


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


def new(path: Path | str, robot: str = "nao", template: str = "guided") -> Path:
    """Make a workbook to start from; raises SheetsError when the file exists already, or the template does not."""
    from rrp_sheets.documents.copies import make_new
    from rrp_sheets.robots import load_robot

    return make_new(Path(path), load_robot(robot), template)


def convert(path: Path | str, target: Path | str, *, replace: bool = True) -> Path:
    """Write a workbook in another format: a styled .xlsx, a Markdown file (.md), or a folder of CSV files.

    Raises:
        SheetsError: when it cannot be written, or there is such a file and `replace` is False.
        UnreadableFile: when the workbook cannot be read.
    """
    from rrp_sheets.documents.copies import convert as convert_workbook
    from rrp_sheets.robots import load_robot

    return convert_workbook(Path(path), load_robot(), Path(target), replace=replace)


def edit(path: Path | str, edits: Sequence[Edit], *, expected_digest: str | None = None) -> Edited:
    """Change cells and rows of a workbook's file (`workbook.edits`), all or none, and leave all else as it is.

    Raises:
        SheetsError: when an edit cannot be done, somebody else has changed the file, or it cannot be written.
    """
    from rrp_sheets.workbook.editing import edit as edit_file

    return edit_file(path, edits, expected_digest=expected_digest)


def fix(
    path: Path | str, target: Path | str, chosen: Mapping[str, str] | None = None
) -> tuple[list[CellChange], Checked]:
    """Write a copy of a workbook with all safe fixes in it; `chosen` names others: `{"LINT002": "throttle"}`.

    Returns:
        What was changed, and the copy, checked.

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
        at: s from the gesture's beginning; None: 1 s after its last keyframe.
        picture: where to store a picture of that pose.

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
