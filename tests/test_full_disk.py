"""A disk that is full and a folder that may not be written: an edit that cannot be stored is told, and nothing is lost."""

from __future__ import annotations

import json
import random
import shutil
import sys
from pathlib import Path
from typing import Any

import forked
import pytest
from chromium import becomes, listening, some
from test_killed_server import HEADER, NOTES, Served

from rrp_sheets import api
from rrp_sheets.model.run_files import RecordedNotice
from rrp_sheets.recording.trace_reader import TraceReader
from rrp_sheets.resources import bundled
from rrp_sheets.workbook.files import make_workbook, read_sheets

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="limits of Unix")
LIMIT = 120_000  # bytes of a file; the workbook has more, the journal at first less
FULL = (
    "import resource, signal\n"
    "signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
    f"resource.setrlimit(resource.RLIMIT_FSIZE, ({LIMIT}, {LIMIT}))\n"
    "from rrp_sheets.cli.main import main\nmain()\n"
)


@pytest.fixture(scope="module")
def begun(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a workbook whose journal is there already."""
    place = tmp_path_factory.mktemp("begun")
    letters = random.Random(1)
    notes = ["".join(letters.choices("abcdefghijklmnopqrstuvwxyz", k=1_500)) for _ in range(200)]
    path = make_workbook({"T": [HEADER, *[["", "", "", "", "", note] for note in notes]]}, place / "b.xlsx")
    assert path.stat().st_size > 1.3 * LIMIT
    with Served(place) as server:
        assert server.put(0, "stored")
    return place


@pytest.fixture
def folder(begun: Path, tmp_path: Path) -> Path:
    """That folder, for one test."""
    return Path(shutil.copytree(begun, tmp_path, dirs_exist_ok=True))


@pytest.mark.slow
def test_with_a_full_disk_nothing_is_lost_and_everyone_is_told(folder: Path) -> None:
    before = (folder / "b.xlsx").read_bytes()
    with Served(folder, FULL) as server:
        told = {server.answer(row % 20, f"edit {row}").get("message", "stored") for row in range(15)}
        assert told and all("cannot be written" in str(words) for words in told), told
        assert "was not saved" in str(server.answer(0, "x" * 30_000, cells=6)["message"])  # no room in the journal
        assert "stored" in server.get("book/b.xlsx") and "T" in server.get("")
        notice = server.form("book/b.xlsx/versions/keep", {"title": "full"})
        assert "is-error" in notice and "Traceback" not in notice
        assert "is-error" in server.form("shelf/copy", {"book": "b.xlsx"})
        assert "is-error" in server.form("shelf/upload", {}, before)
    assert (folder / "b.xlsx").read_bytes() == before
    assert sorted(p.name for p in folder.iterdir()) == [".rrp-sheets", "b.xlsx"]
    with Served(folder) as server:  # there is room again
        assert server.put(1, "goes on")
    cells = read_sheets(folder / "b.xlsx")[0].cells
    assert (cells[2, NOTES].typed, cells[3, NOTES].typed) == ("stored", "goes on")
    assert not any("edit" in cells[row, NOTES].typed[:4] for row in range(2, 30)), (
        "what was told as not stored came back"
    )


@pytest.mark.slow
def test_the_page_tells_that_an_edit_was_not_stored_and_stays_usable(browser: Any, folder: Path) -> None:
    with Served(folder, FULL) as server:
        page = server.page(browser, "book/b.xlsx")
        listening(page)
        cell = (
            page.locator("tbody tr").nth(2).locator("td").last
        )  # of the whole sheet: more bodies of rows may come yet
        was = some(lambda: cell.get_attribute("data-v"))
        cell.click(position={"x": 3, "y": 3})
        page.keyboard.type("not stored")
        page.keyboard.press("Enter")
        page.wait_for_selector("text=cannot be written")
        page.reload()
        listening(page)
        becomes(lambda: cell.get_attribute("data-v"), was)


def test_what_cannot_be_kept_of_a_run_is_told_and_the_rest_is_whole(tmp_path: Path) -> None:
    book, out = bundled("workbooks") / "simple-tracking.xlsx", tmp_path / "run"
    command = ["run", str(book), "--fast", "--for", "12s", "--out", str(out)]
    small = FULL.replace(
        str(LIMIT), "66_000"
    )  # less than the pictures of 12 s, more than any other (robot.toml: 62 kB)
    done = forked.run([sys.executable, "-c", small, *command], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    notes = [e.text for e in TraceReader(out) if isinstance(e, RecordedNotice) and e.kind == "note"]
    assert [note.split(" cannot be saved (")[0] for note in notes] == ["What the camera sees", "The film"]
    assert all(note in done.stdout for note in notes)
    assert not {"camera.zip", "film.gif", "strip.png"} & {path.name for path in out.iterdir()}
    assert json.loads((out / "poses.jsonl").read_text(encoding="utf-8").splitlines()[-1])["t"] > 7
    assert api.replay(out).same


@pytest.mark.slow
def test_a_folder_on_a_medium_that_is_read_only_can_be_looked_at(tmp_path: Path) -> None:
    make_workbook({"T": [HEADER, ["", "", "", "", "", "start"]]}, tmp_path / "b.xlsx")
    (tmp_path / ".rrp-sheets").write_text("in the way, also of root", encoding="utf-8")
    with Served(tmp_path) as server:
        assert "This workbook is read-only" in server.get("book/b.xlsx")
        assert "You cannot change this workbook here" in str(server.answer(0, "x")["message"])
