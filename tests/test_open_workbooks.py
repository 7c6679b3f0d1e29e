"""Open workbooks: what is open, and what may happen to it while somebody begins a run or gives the file another name."""

from __future__ import annotations

import gc
import json
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from queue import SimpleQueue

import pytest

from rrp_sheets.errors import SheetsError
from rrp_sheets.runs.check_worker import CheckWorker
from rrp_sheets.web import workbook_session
from rrp_sheets.web.run_session import RunManager, RunOptions
from rrp_sheets.web.workbook_session import EventStream, OpenWorkbooks, Place, WorkbookSession
from rrp_sheets.workbook.files import make_workbook

HEADER = ["On", "Input streams", "Connector", "Formula", "Output stream", "Notes"]


@pytest.fixture(scope="module")
def book(tmp_path_factory: pytest.TempPathFactory) -> Path:
    rows = [HEADER, ["", "Red ball", "subscribe", "", "Print", ""]]
    return make_workbook({"T": rows}, tmp_path_factory.mktemp("open") / "b.xlsx")


@pytest.fixture
def open_workbooks(book: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[OpenWorkbooks]:
    """Nobody looks after the files but the test."""
    monkeypatch.setattr("rrp_sheets.web.workbook_session.POLL_EVERY", 3600)
    (tmp_path / book.name).write_bytes(book.read_bytes())
    with CheckWorker() as worker:
        made = OpenWorkbooks(tmp_path, worker)
        yield made
        made.close()


def test_no_run_begins_of_a_workbook_whose_file_has_another_name_by_then(open_workbooks: OpenWorkbooks) -> None:
    path = open_workbooks.folder / "b.xlsx"
    run_manager, session = RunManager(open_workbooks), open_workbooks.session(path)
    renaming, goes_on = threading.Event(), threading.Event()

    def rename() -> None:
        with open_workbooks.without(path.name):
            renaming.set()
            assert goes_on.wait(300)
            path.rename(open_workbooks.folder / "c.xlsx")

    told: list[str] = []

    def start() -> None:
        try:
            run_manager.start(session, path.name, RunOptions("Aya"))
        except SheetsError as error:
            told.append(error.message)

    threads = [threading.Thread(target=each) for each in (rename, start)]
    threads[0].start()
    assert renaming.wait(300)
    threads[1].start()
    threads[1].join(0.2)
    assert threads[1].is_alive(), "whether it can begin is known when the file has its new name"
    goes_on.set()
    for thread in threads:
        thread.join(300)
    assert told == ["This workbook was renamed or moved."] and run_manager.run is None


def test_nobody_opens_a_workbook_while_its_file_goes_away(open_workbooks: OpenWorkbooks) -> None:
    path = open_workbooks.folder / "b.xlsx"
    opened = threading.Event()

    def come() -> None:
        with pytest.raises(SheetsError):
            open_workbooks.session(path)
        opened.set()

    with open_workbooks.without(path.name):
        thread = threading.Thread(target=come)
        thread.start()
        assert not opened.wait(0.2)
        path.rename(open_workbooks.folder / "c.xlsx")
    assert opened.wait(300)
    thread.join(300)


def test_a_rename_that_fails_leaves_the_workbook_usable(open_workbooks: OpenWorkbooks) -> None:
    path = open_workbooks.folder / "b.xlsx"
    page = open_workbooks.session(path).join("a", "Aya")
    with pytest.raises(OSError, match="there is such a file"), open_workbooks.without(path.name):
        raise OSError("there is such a file")
    assert "event: reload" in page.take(str)
    assert "T" in open_workbooks.session(path).document.grids


def test_an_open_workbook_is_found_while_its_file_is_in_the_folder(open_workbooks: OpenWorkbooks) -> None:
    path, elsewhere = open_workbooks.folder / "b.xlsx", open_workbooks.folder.parent / "elsewhere.xlsx"
    assert open_workbooks.find(path.name) is None
    session = open_workbooks.session(path)
    assert open_workbooks.find(path.name) is session
    path.rename(elsewhere)
    assert open_workbooks.find(path.name) is None
    path.symlink_to(elsewhere)
    assert open_workbooks.find(path.name) is None
    path.unlink()
    elsewhere.rename(path)
    assert open_workbooks.find(path.name) is session


@pytest.mark.slow
@pytest.mark.parametrize("end", ["closed", "forgotten"])
def test_what_looks_after_the_files_ends(end: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rrp_sheets.web.workbook_session.POLL_EVERY", 0.01)
    before = set(threading.enumerate())
    open_workbooks: OpenWorkbooks | None = OpenWorkbooks(tmp_path, CheckWorker())
    (thread,) = set(threading.enumerate()) - before
    if end == "closed" and open_workbooks is not None:
        open_workbooks.close()
    open_workbooks = None
    gc.collect()
    thread.join(300)
    assert not thread.is_alive()


def first_cell(session: WorkbookSession) -> Place:
    return "T", session.document.grids["T"].rows[0], 5


def free_cells_told(listener: EventStream) -> list[str]:
    """The rows that the page was told, without a word of who is editing there."""
    told = [json.loads(m.partition("data: ")[2]) for m in listener.messages if "event: grid\n" in m]
    return [row["id"] for entry in told for row in entry["replace"] if "Aya" not in row["html"]]


def test_a_page_keeps_its_cell_when_its_older_stream_ends_before_the_new_one_has_begun(
    open_workbooks: OpenWorkbooks,
) -> None:
    session = open_workbooks.session(open_workbooks.folder / "b.xlsx")
    older = session.join("mine.1", "Aya")
    assert not session.lock("mine.1", "Aya", first_cell(session))
    session.end_streams("mine.1")
    session.leave(older)  # its thread notices the end
    newer = session.join("mine.1", "Aya")
    assert session.lock("other.1", "Ben", first_cell(session)) == "Aya"
    session.leave(newer)
    assert not session.lock("other.1", "Ben", first_cell(session))


def test_others_are_told_that_a_cell_is_free_which_was_left_open_for_long(
    open_workbooks: OpenWorkbooks, monkeypatch: pytest.MonkeyPatch
) -> None:
    session = open_workbooks.session(open_workbooks.folder / "b.xlsx")
    session.join("mine.1", "Aya")
    other = session.join("other.1", "Ben")
    session.lock("mine.1", "Aya", first_cell(session))
    session.poll()
    assert not free_cells_told(other)
    now = time.monotonic()
    monkeypatch.setattr(workbook_session.time, "monotonic", lambda: now + workbook_session.LOCK_SECONDS + 1)
    session.poll()
    assert free_cells_told(other) == [first_cell(session)[1]]
    assert not session.lock("other.1", "Ben", first_cell(session))


def test_pages_are_told_when_what_was_wrong_with_the_file_is_over(
    open_workbooks: OpenWorkbooks, monkeypatch: pytest.MonkeyPatch
) -> None:
    session = open_workbooks.session(open_workbooks.folder / "b.xlsx")
    checks: list[bool] = []
    monkeypatch.setattr(session, "check_soon", lambda: checks.append(True))
    page, whole = session.join("mine.1", "Aya"), session.document.path.read_bytes()
    written = session.document.path.with_suffix(".part")

    def told(contents: bytes) -> list[dict[str, str]]:
        page.messages.clear()
        written.write_bytes(contents)
        written.replace(session.document.path)  # at once
        session.poll()
        return [json.loads(m.partition("data: ")[2]) for m in list(page.messages) if "event: trouble\n" in m]

    (trouble,) = told(whole[: len(whole) // 2])
    assert "is damaged" in trouble["message"]
    assert told(whole[: len(whole) // 2]) == []
    late = session.join("late.1", "Cem")
    assert [m for m in late.messages if trouble["message"] in m], "a page that comes later is told, too"
    assert told(whole) == [{"message": "", "over": trouble["message"]}]
    assert checks  # what was checked and tested meanwhile was not the whole file


def test_pages_are_told_of_each_check_that_fails(
    open_workbooks: OpenWorkbooks, monkeypatch: pytest.MonkeyPatch
) -> None:
    session = open_workbooks.session(open_workbooks.folder / "b.xlsx")
    page = session.join("mine.1", "Aya")
    told: SimpleQueue[int] = SimpleQueue()

    def fails(*_: object) -> None:
        told.put(sum("event: trouble" in m and "process has ended" in m for m in list(page.messages)))
        raise SheetsError("The check's process has ended.")

    monkeypatch.setattr(workbook_session, "analyse", fails)
    for before in range(3):
        session.check_soon()
        assert told.get(timeout=300) == before
