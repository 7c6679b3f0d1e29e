"""Prints a workbook's file: read, checked, tested and compared, as ethics pack or as information sheet."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import Literal

from rrp_sheets import __version__
from rrp_sheets.checks import Checked, check_workbook
from rrp_sheets.compare import Change, compare
from rrp_sheets.compare.as_text import place, value
from rrp_sheets.compare.side import open_checked
from rrp_sheets.errors import SheetsError
from rrp_sheets.model.names import key
from rrp_sheets.render.pack import Changes, Pack, Print, TestSheetResult, VersionDifference, make_pack
from rrp_sheets.render.pack.make import Paper, Pictures, set_pack
from rrp_sheets.render.pack.participants import ParticipantSheet, make_sheet, set_sheet
from rrp_sheets.render.texts import Texts, texts
from rrp_sheets.robots import Robot
from rrp_sheets.robots.trajectory import BodyPose
from rrp_sheets.testing import CaseResult, run_tests
from rrp_sheets.testing.case_output import failure_lines
from rrp_sheets.texts import N_, translate
from rrp_sheets.workbook import Reading, read
from rrp_sheets.workbook.files import refuse_workbook, write_atomically

MOST_ROWS = 1_000  # a hundred and fifty pages; no board reads more, and Typst takes half a gigabyte for them
MOST_CHANGES = 500
_MOST_LINES = 6  # about one failed test
_LONGEST = 20.0  # s that all tests may take
Reader = Literal["board", "participants"]
_MARKS = {"added": "added", "changed": "changed", "on": "changed", "off": "changed", "moved": "moved"}


class HasErrors(SheetsError):
    """The workbook has errors, and no draft is wanted; `checked` has them."""

    def __init__(self, checked: Checked) -> None:
        super().__init__(
            N_("The workbook has errors: it cannot run, and a board cannot judge it. Nothing was printed."),
            N_("Correct them, or print a draft of it (--draft)."),
        )
        self.checked = checked


@dataclass(frozen=True)
class Printed:
    """A pack that was made: the workbook, checked; the PDF; what it lacks (a font, say), in words."""

    checked: Checked
    data: bytes
    notes: list[str]


@dataclass(frozen=True)
class Gathered:
    """Contents of a pack that is not set yet: the workbook, checked; all texts; its diagrams by their files' names."""

    checked: Checked
    pack: Pack
    pictures: Pictures


def print_pack(
    path: Path, target: Path, *, against: Path | None = None, paper: Paper = "a4", language: str = "",
    draft: bool = False, today: date | None = None, reader: Reader = "board",
    gathered: Callable[[Checked], None] = lambda checked: None,
) -> Printed:  # fmt: skip
    """Make the pack, or the sheet for participants, and write it; see `api.print_pack` and `make`."""
    refuse_workbook(target, path)
    if against is not None:
        refuse_workbook(target, against)
    if reader == "participants":
        made = make_for_participants(path, paper=paper, language=language, draft=draft, today=today, gathered=gathered)
    else:
        made = make(path, against=against, paper=paper, language=language, draft=draft, today=today, gathered=gathered)
    write_atomically(target, made.data)
    return made


def make(
    path: Path, *, against: Path | None = None, paper: Paper = "a4", language: str = "", draft: bool = False,
    today: date | None = None, gathered: Callable[[Checked], None] = lambda checked: None,
) -> Printed:  # fmt: skip
    """Make the pack of a workbook's file as a PDF; `gathered` is called with the checked workbook before it is set.

    Raises:
        SheetsError: see `gather`; or the PDF cannot be set.
    """
    found = gather(path, against=against, language=language, draft=draft, today=today)
    gathered(found.checked)
    data, notes = set_pack(found.pack, found.pictures, paper)
    return Printed(found.checked, data, notes)


def make_for_participants(
    path: Path, *, paper: Paper = "a4", language: str = "", draft: bool = False, today: date | None = None,
    gathered: Callable[[Checked], None] = lambda checked: None,
) -> Printed:  # fmt: skip
    """Make the information sheet for participants as a PDF of one page; it raises what `make` raises."""
    checked, sheet = gather_sheet(path, language=language, draft=draft, today=today)
    gathered(checked)
    data, notes = set_sheet(sheet, paper)
    return Printed(checked, data, notes)


def gather(
    path: Path, *, against: Path | None = None, language: str = "", draft: bool = False, today: date | None = None
) -> Gathered:
    """Collect the contents of the pack of a workbook's file.

    Raises:
        UnreadableFile: one of the workbooks cannot be read.
        HasErrors: the workbook has errors and no draft is wanted.
        SheetsError: it has too many rows.
    """
    reading, checked = _checked(path, draft)
    words = texts(language or checked.run.language)
    tests, note = _tested(checked, words)
    changes = _changes((reading, checked), against, words) if against is not None else None
    pack, pictures = make_pack(
        reading, checked, _print(path, today), language=words.language, tests=tests, tests_note=note, changes=changes,
        draft=draft, draw_poses=_draw_poses,
    )  # fmt: skip
    return Gathered(checked, pack, pictures)


def gather_sheet(
    path: Path, *, language: str = "", draft: bool = False, today: date | None = None
) -> tuple[Checked, ParticipantSheet]:
    """Collect the contents of the information sheet of a workbook's file; it raises what `gather` raises."""
    reading, checked = _checked(path, draft)
    words = texts(language or checked.run.language)
    return checked, make_sheet(reading, checked, _print(path, today), language=words.language, draft=draft)


def _draw_poses(robot: Robot, strips: Sequence[Sequence[BodyPose]]) -> Sequence[Sequence[str]]:
    """Draw the robot's gestures; where the simulator is not installed, they have words only."""
    try:
        from rrp_sheets.sim.poses import draw_poses
    except ImportError:
        return [() for _ in strips]
    return draw_poses(robot, strips)


def _print(path: Path, today: date | None) -> Print:
    return Print(path.name, (today or date.today()).isoformat(), __version__)


def _checked(path: Path, draft: bool) -> tuple[Reading, Checked]:
    """Read and check a workbook to be printed; refuse one with too many rows, or with errors unless as a draft."""
    reading = read(path)
    checked = check_workbook(reading.workbook, reading.report)
    if checked.report.errors and not draft:
        raise HasErrors(checked)
    rows = sum(len(b.rows) for b in checked.workbook.behaviours)
    if rows > MOST_ROWS:
        message = N_("The workbook has {n:,} rows; at most {most:,} can be printed.", n=rows, most=MOST_ROWS)
        raise SheetsError(message, N_("Split it into several workbooks."))
    return reading, checked


def _tested(checked: Checked, words: Texts) -> tuple[list[TestSheetResult], str]:
    if not checked.workbook.tests:
        return [], words.get("pack.open.tests_none")
    if checked.report.errors:
        return [], words.get("pack.open.tests_errors")
    end = time.monotonic() + _LONGEST
    report = run_tests(checked, lambda: time.monotonic() > end)
    note = words.get("pack.open.tests_late", seconds=f"{_LONGEST:g}") if report.stopped else ""
    return [_result(case, words) for case in report.cases], note


def _result(case: CaseResult, words: Texts) -> TestSheetResult:
    failed, every = len(case.failed_rows) + len(case.broken), len(case.rows) + len(case.broken)
    entry = "idle" if case.idle else "holds_not" if failed else "holds_one" if every == 1 else "holds"
    counted = words.get(f"pack.open.{entry}", n=every, failed=failed)
    lines = [] if case.passed else [translate(line, words.language) for line in failure_lines(case)]
    more = [words.get("pack.more", n=len(lines) - _MOST_LINES)] if len(lines) > _MOST_LINES else []
    return TestSheetResult(case.case.name, case.passed, counted, (*lines[:_MOST_LINES], *more))


def _changes(mine: tuple[Reading, Checked], against: Path, words: Texts) -> Changes:
    """Return the differences from the approved version, with the marks of changed rows."""
    approved = open_checked(against)
    found = compare(approved, mine)
    version = approved[1].workbook.protocol.text("Version")
    intro = "pack.changes.intro" if version else "pack.changes.intro_no_version"
    marks: dict[str, dict[int, str]] = {}
    for change in found.effects:
        if change.part == "row" and change.rows[1] and change.kind in _MARKS:
            marks.setdefault(key(change.sheet), {}).setdefault(change.rows[1], _MARKS[change.kind])
    many = "pack.changes.same" if found.same else f"pack.changes.{'one' if len(found.effects) == 1 else 'many'}"
    left = max(len(found.effects), len(found.others)) - MOST_CHANGES
    return Changes(
        intro=words.get(intro, name=against.name, version=version),
        digest=found.first.digest,
        verdict=words.get(many, n=len(found.effects)),
        effects=tuple(_one(change, words) for change in found.effects[:MOST_CHANGES]),
        others=tuple(_one(change, words) for change in found.others[:MOST_CHANGES]),
        left_out=words.get("pack.more", n=f"{left:,}") if left > 0 else "",
        marks=marks,
    )


def _one(change: Change, words: Texts) -> VersionDifference:
    kind = change.kind if change.kind in ("added", "removed", "moved") else "changed" if change.effect else "other"

    def say(text: str) -> str:
        return translate(text, words.language)

    before, after = (value(say(text)) if text else "" for text in (change.before, change.after))
    if change.kind in ("on", "off"):
        before, after = map(say, (N_("off"), N_("on")) if change.kind == "on" else (N_("on"), N_("off")))
    elif change.kind == "moved" and not change.before and change.rows[0] != change.rows[1]:
        before, after = (words.get("behaviour.row", n=row) for row in change.rows)
    what = f"{say(change.what)}: " if change.what and change.kind == "changed" else ""
    return VersionDifference(
        kind, say(place(change)), what + before if before else "", what + after if after else "", say(change.note)
    )
