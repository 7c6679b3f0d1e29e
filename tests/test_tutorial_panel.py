"""A workbook's tests in the grid: run in a process of their own, also while some rows have errors; shown in words."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from rrp_sheets.documents import Document
from rrp_sheets.documents.document import Journal
from rrp_sheets.documents.grid import CellText
from rrp_sheets.errors import SheetsError
from rrp_sheets.testing.run import in_order, run_tests
from rrp_sheets.texts import translate
from rrp_sheets.web import workbook_tests as module
from rrp_sheets.web.row_renderer import RowRenderer
from rrp_sheets.web.workbook_tests import Tester, WorkbookTests, panel_of
from rrp_sheets.workbook import read
from rrp_sheets.workbook.files import make_workbook

HEADER = ["Input streams", "Connector", "Formula", "Output stream"]
TIMES = ["Time (ms)", "Stream", "Send", "Expect", "Notes"]
GOOD = [["Red ball", "map", "redBall.distance", "Distance"], ["Distance", "subscribe", "", "Print"]]
HOLDS = [["0", "Red ball", "distance=2", "", ""], ["0", "Print", "", "2", "it is told"]]
FAILS = [["0", "Red ball", "distance=2", "", ""], ["0", "Print", "", "3", ""]]


def book(path: Path, rows: list[list[str]], **tests: list[list[str]]) -> Path:
    make_workbook({"Talk": [HEADER, *rows], **{n: [TIMES, *t] for n, t in tests.items()}}, path)
    return path


def outcome(path: Path) -> tuple[dict[str, bool], list[int], tuple[str, ...]]:
    part = in_order(read(path))
    assert part.checked is not None
    cases = run_tests(part.checked).cases
    return {c.case.name: c.passed for c in cases}, [a.row for a in part.rows], part.waiting


def test_rows_in_order_are_tested_while_another_has_an_error(tmp_path: Path) -> None:
    wrong = ["Red ball", "map", "redBall.distence", "Other"]
    path = book(tmp_path / "b.xlsx", [*GOOD, wrong, ["Other", "subscribe", "", "Say"]], A=HOLDS, B=FAILS)
    assert outcome(path) == ({"A": True, "B": False}, [4], ())


def test_what_follows_from_a_row_with_an_error_is_left_out_with_it(tmp_path: Path) -> None:
    """A blank input means the row above: with the row left out alone, it would take another stream, and seem to hold."""
    chain = [["Red ball", "map", "2 +", ""], ["", "map", "value", "Got"], ["Got", "subscribe", "", "Print"]]
    path = book(tmp_path / "b.xlsx", [["Red ball", "map", "redBall.distance", ""], *chain], A=HOLDS)
    assert outcome(path)[0] == {"A": False}


def test_a_test_with_an_error_of_its_own_waits(tmp_path: Path) -> None:
    path = book(tmp_path / "b.xlsx", GOOD, A=HOLDS, B=[["0", "Nothing like it", "", "3", ""]])
    assert outcome(path) == ({"A": True}, [], ("B",))


def test_errors_of_the_whole_workbook_come_first(tmp_path: Path) -> None:
    sheets = {"Talk": [HEADER, *GOOD], "A": [TIMES, *HOLDS], "Devices": [["Stream", "Device"], ["X", "No such device"]]}
    make_workbook(sheets, tmp_path / "b.xlsx")
    assert in_order(read(tmp_path / "b.xlsx")).checked is None


# ---- in a process of their own


@pytest.fixture(scope="module")
def tester() -> Iterator[Tester]:
    made = Tester()
    yield made
    made.close()


class Page:
    """Somebody who looks at a workbook's tests."""

    def __init__(self, path: Path, tester: Tester) -> None:
        self.document = Document(path, Journal(path.parent))
        assert self.document.reading, ()
        self.news: list[str] = []
        self.told = threading.Semaphore(0)
        self.tests = WorkbookTests(self.document, tester, self.tell, lambda: True)

    def tell(self, news: str) -> None:
        self.news.append(news)
        self.told.release()

    def run(self, *, asked: bool = False, told: int = 1) -> None:
        self.tests.soon(asked=asked)
        for _ in range(told):
            assert self.told.acquire(timeout=300)

    def set(self, sheet: str, cell: tuple[int, int], text: str) -> None:
        row = self.document.grids[sheet].rows[cell[0] - 2]
        self.document.set_cells("Aya", sheet, [CellText(row, cell[1], text, None)])


@pytest.fixture
def page(tmp_path: Path, tester: Tester) -> Callable[..., Page]:
    return lambda rows, **tests: Page(book(tmp_path / "b.xlsx", rows, **tests), tester)


def test_what_holds_and_what_does_not_is_told_and_marked(page: Callable[..., Page]) -> None:
    here = page(GOOD, A=HOLDS, B=FAILS)
    here.run()
    panel = panel_of(here.tests, here.document, "Talk")
    assert panel is not None and panel.count == "1 of 2 tests passed" and panel.first == "B"
    assert [(m.at, m.stream, m.expected, m.got) for m in panel.missed] == [
        ("at 0 ms", "Print", "3", "2 at 0 ms from Talk!3")
    ]
    assert [(line.sheet, line.sign, line.words) for line in panel.lines] == [
        ("A", "✓", "passed"), ("B", "✗", "failed"),
    ]  # fmt: skip
    grid = here.document.grids["B"]
    assert here.tests.marks("B") == {grid.rows[1]: "2 at 0 ms from Talk!3"}
    here.set("B", (3, 4), "2")
    here.run()
    assert here.news[-1] == "B now passes. All 2 tests passed." and here.tests.marks("B") == {grid.rows[1]: ""}
    assert panel_of(here.tests, here.document, "Talk").done  # type: ignore[union-attr]
    here.set("Talk", (2, 3), "redBall.distance + 1")
    here.run()
    assert here.news[-1] == "A now fails. B now fails. 0 of 2 tests passed."


@pytest.mark.parametrize("rows", [[], HOLDS[:1]])
def test_a_test_that_checks_nothing_has_not_failed(page: Callable[..., Page], rows: list[list[str]]) -> None:
    here = page(GOOD, A=rows)
    here.run()
    panel = panel_of(here.tests, here.document, "A")
    assert panel is not None and panel.count == "Test checks nothing" and not panel.missed
    assert translate(panel.count, "ja") == "このテストは何も確かめません"


def test_a_test_that_errors_keep_from_running_has_not_failed(page: Callable[..., Page]) -> None:
    here = page(GOOD, A=HOLDS)
    here.run()
    here.set("Talk", (2, 3), "redBall.distence")
    here.run()
    panel = panel_of(here.tests, here.document, "Talk")
    assert panel is not None and panel.count == "Test not run" and panel.first == ""
    assert panel.notes == ("Not run, because of errors in Talk row 2.",)
    assert [(line.sign, line.words) for line in panel.lines] == [("!", "not run because of errors")]
    assert here.tests.marks("A") == {} and not any("fails" in news for news in here.news)


def test_of_several_tests_those_that_pass_are_counted_beside_errors(page: Callable[..., Page]) -> None:
    wrong = ["Red ball", "map", "redBall.distence", "Other"]
    here = page([*GOOD, wrong, ["Other", "subscribe", "", "Say"]], A=HOLDS, B=[*HOLDS, ["1", "Say", "", "2", ""]])
    here.run()
    panel = panel_of(here.tests, here.document, "Talk")
    assert panel is not None and panel.count == "1 of 2 tests passed"
    assert panel.notes == ("Tests with the sign ! were not run, because of errors in Talk row 4.",)


def test_what_came_is_shown_as_text(page: Callable[..., Page]) -> None:
    rows = [["Red ball", "map", '"<script>alert(1)</script>"', "Distance"], GOOD[1]]
    here = page(rows, A=HOLDS)
    here.run()
    renderer = RowRenderer(here.document.grids["A"])
    renderer._verdicts = here.tests.marks("A")
    html = str(renderer.rows(0, 10))
    assert "failed;" in html and "&lt;script&gt;" in html and "<script>" not in html


def test_of_a_long_test_some_rows_are_told_and_all_are_marked(page: Callable[..., Page]) -> None:
    both = (("Print", "", "3", ""), ("Red ball", "distance=2", "", ""))
    many = [[str(10 * (n // 2)), *both[n % 2]] for n in range(2_000)]
    here = page(GOOD, A=many)
    here.run(asked=True, told=2)
    found = here.tests.results.of("A")
    assert found is not None and len(found.missed) == 200 and found.left_out == 800 and len(found.marks) == 1_000


def test_tests_that_take_long_are_run_only_when_asked(
    page: Callable[..., Page], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "QUICK", 0.0)
    here = page(GOOD, A=HOLDS, B=FAILS)
    here.run()
    assert [t.state for t in here.tests.results.tests] == ["late", "late"]
    here.run()
    assert here.tests.results.stale
    panel = panel_of(here.tests, here.document, "Talk")
    assert panel is not None and any("Press Run tests" in note for note in panel.notes)
    here.run(asked=True, told=2)
    assert [t.state for t in here.tests.results.tests] == ["passes", "fails"] and not here.tests.results.stale


def test_a_test_that_does_not_end_is_ended_and_said(
    page: Callable[..., Page], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    here = page(GOOD, A=HOLDS)
    with monkeypatch.context() as patched:
        patched.setattr(module, "GRACE", 0.0)
        patched.setattr(module, "START", 0.0)
        alone = Tester()
        with pytest.raises(SheetsError, match="did not end"):
            alone.run(here.document.path, 0.001)
    assert alone.run(here.document.path, 5).tests[0][1] == {3: ""}, "the next time another process does it"
    alone.close()
    with pytest.raises(SheetsError, match="being ended"):
        alone.run(here.document.path, 5)


def test_when_their_process_is_killed_that_is_said_and_the_next_check_runs_them_again(
    page: Callable[..., Page], tester: Tester
) -> None:
    here = page(GOOD, A=HOLDS)
    here.run()
    assert tester.pid is not None
    os.kill(tester.pid, signal.SIGSTOP)  # so that it is in the middle of them
    here.run(asked=True)
    assert here.tests.results.running
    os.kill(tester.pid, signal.SIGKILL)
    assert here.told.acquire(timeout=300)
    panel = panel_of(here.tests, here.document, "Talk")
    assert panel is not None and not panel.running and not panel.lines
    assert panel.notes[0].startswith("The tests were ended: they ended unexpectedly (signal 9). Press Run tests")
    assert here.tests.marks("A") == {}
    here.run()  # as after the next check: nobody has asked for it
    assert [t.state for t in here.tests.results.tests] == ["passes"] and not here.tests.results.stale


def test_tests_run_again_when_a_file_that_was_read_half_written_is_whole(page: Callable[..., Page]) -> None:
    here = page(GOOD, A=HOLDS)
    whole = here.document.path.read_bytes()
    here.document.path.write_bytes(whole[: len(whole) // 2])
    here.run()
    panel = panel_of(here.tests, here.document, "Talk")
    assert panel is not None and "is damaged" in panel.notes[0] and not panel.lines
    here.document.path.write_bytes(whole)
    here.run()
    panel = panel_of(here.tests, here.document, "Talk")
    assert panel is not None and panel.count == "Test passed" and not panel.notes
