"""The next run may begin when the robot is at rest; table and diagram of the one before are written meanwhile."""

from __future__ import annotations

import errno
import time
from pathlib import Path

import pytest
from panel import HEADER

from rrp_sheets.checks import check_workbook
from rrp_sheets.engine.run_events import RunObserver
from rrp_sheets.errors import RunBroken, SheetsError
from rrp_sheets.help.connectors import ScriptedWorld
from rrp_sheets.runs.check_worker import CheckWorker
from rrp_sheets.runs.run_data import RunSettings, Summary
from rrp_sheets.runs.running import run
from rrp_sheets.web.run_session import RunManager, RunOptions, failure_notice
from rrp_sheets.web.workbook_session import EventStream, OpenWorkbooks
from rrp_sheets.workbook import read
from rrp_sheets.workbook.files import make_workbook

ROWS = [
    HEADER,
    ["", "Red ball", "map", "redBall.distance", "Distance", ""],
    ["", "Distance", "subscribe", "", "Print", ""],
]


class Watching(RunObserver):
    """State of the folder when the robot was at rest."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.files: set[str] = set()
        self.end = ""
        self.summary = Summary()

    def rested(self, summary: Summary, broken: RunBroken | None) -> None:
        """It is."""
        assert broken is None
        self.summary = summary
        self.files = {path.name for path in self.folder.iterdir()}
        self.end = (self.folder / "trace.jsonl").read_text(encoding="utf-8").splitlines()[-1]


def test_at_rest_everything_is_recorded_and_the_files_come_after(tmp_path: Path) -> None:
    make_workbook({"T": ROWS}, tmp_path / "b.xlsx")
    reading = read(tmp_path / "b.xlsx")
    checked = check_workbook(reading.workbook, reading.report)
    view = Watching(tmp_path / "run")
    settings = RunSettings(seconds=0.3, fast=True, out=view.folder)
    result = run(reading, checked, settings, view, world=lambda *_: ScriptedWorld([]))
    assert '"ended":"time"' in view.end.replace(" ", "") and view.summary == result.summary
    assert not {"run.xlsx", "diagram.svg"} & view.files and {"run.xlsx", "diagram.svg"} <= result.files.keys()


def test_the_next_run_is_not_disturbed_by_the_end_of_the_one_before(tmp_path: Path) -> None:
    make_workbook({"T": ROWS}, tmp_path / "b.xlsx")
    open_workbooks = OpenWorkbooks(tmp_path, CheckWorker())
    run_manager, session = RunManager(open_workbooks), open_workbooks.session(tmp_path / "b.xlsx")
    page = Ear(session.join("a", "Aya"))
    first = run_manager.start(session, "b.xlsx", RunOptions("Aya", speed=0))
    page.until('"phase":"running"')
    first.restart("Ben")
    heard = page.until('"phase":"ended"') + page.until('"phase":"running"')
    assert '"words":"Stopped by Ben at ' in heard and f'"folder":"{first.folder}"' in heard
    second = run_manager.run
    assert second is not None and second is not first and second.is_going and second.run_state.speed == 0
    until = time.monotonic() + 300
    while not (tmp_path / "runs" / first.folder / "diagram.svg").is_file():
        assert time.monotonic() < until
        page.until("event: live")
    assert run_manager.now()["id"] == second.id
    second.stop("Aya")
    heard = page.until('"phase":"ended"')
    assert first.id not in heard and second.id in heard


class Ear:
    """Takes what a page is told, until some words come; what came after them is for the next time."""

    def __init__(self, page: EventStream) -> None:
        self.page = page
        self.told = ""

    def until(self, words: str) -> str:
        until = time.monotonic() + 90
        while words not in self.told:
            assert time.monotonic() < until, self.told[-2000:]
            self.told += self.page.take(str)
        end = self.told.index(words) + len(words)
        heard, self.told = self.told[:end], self.told[end:]
        return heard


def test_a_run_for_which_there_is_no_room_leaves_no_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    make_workbook({"T": ROWS}, tmp_path / "b.xlsx")
    reading = read(tmp_path / "b.xlsx")
    checked = check_workbook(reading.workbook, reading.report)

    def full(source: Path, target: Path) -> None:
        target.touch()
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("rrp_sheets.recording.folder.shutil.copyfile", full)
    with pytest.raises(SheetsError, match="No space left on device") as caught:
        run(reading, checked, RunSettings(fast=True), world=lambda *_: ScriptedWorld([]))
    assert list((tmp_path / "runs").iterdir()) == [], "it would be told for ever that it cannot be read"
    assert failure_notice(caught.value)["remedy"] == "Make room.", "no option of the command line in the browser"
    (kept := tmp_path / "kept").mkdir()
    (kept / "mine.txt").touch()
    with pytest.raises(SheetsError, match="No space left on device"):
        run(reading, checked, RunSettings(fast=True, out=kept), world=lambda *_: ScriptedWorld([]))
    assert (kept / "mine.txt").exists(), "a folder that was there stays"
