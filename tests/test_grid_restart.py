"""A grid whose server is killed and started again on the same port: nothing typed is lost, nothing is made twice."""

from __future__ import annotations

import signal
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from chromium import becomes, listening, until
from grid_books import Books
from playwright.sync_api import expect
from test_killed_server import HEADER, NOTES, Served

from rrp_sheets.workbook.files import make_workbook, read_sheets

ROWS = 6
pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="kills a server as Unix does")


class Restarted:
    """A server that can be killed and started again on the same port, and a page of it."""

    def __init__(self, folder: Path, browser: Any) -> None:
        self.path = make_workbook({"T": [HEADER, *[["", "", "", "", "", f"start {n}"] for n in range(ROWS)]]},
                                  folder / "b.xlsx")  # fmt: skip
        self.folder = folder
        self.server = Served(folder)
        self.port = self.server.home.rpartition(":")[2]
        self.page = self.server.page(browser, "book/b.xlsx")
        self.page.on("dialog", lambda dialog: dialog.accept())  # leave the page although something is not saved
        listening(self.page)

    def kill(self) -> None:
        self.page.evaluate("document.body.dataset.old = ''")
        self.server.process.send_signal(signal.SIGKILL)
        self.server.process.wait()

    def loaded_again(self) -> None:
        """Wait until the page has been loaded again since the server was killed."""
        expect(self.page.locator("body[data-old]")).to_have_count(0)
        listening(self.page)

    def start(self, *options: str) -> None:
        self.server.__exit__()
        self.server = Served(self.folder, options=["--port", self.port, *options])

    def cell(self, row: int) -> Any:
        return self.page.locator(f"tbody tr:has(th.number:text-is('{row}')) td").last

    def type(self, row: int, text: str) -> None:
        self.cell(row).click(position={"x": 3, "y": 3})
        self.page.keyboard.type(text)
        self.page.keyboard.press("Enter")

    def notes(self) -> dict[int, str]:
        """Notes in the file, by row."""
        cells = read_sheets(self.path)[0].cells
        return {row: cell.typed for (row, column), cell in sorted(cells.items()) if column == NOTES and row > 1}

    def saved(self) -> None:
        expect(self.page.locator("#saved")).to_have_text("Saved")
        expect(self.page.locator(".unsent")).to_have_count(0)


@pytest.fixture
def at(tmp_path: Path, browser: Any) -> Iterator[Restarted]:
    made = Restarted(tmp_path, browser)
    yield made
    made.page.context.close()
    made.server.__exit__()


def insert_above(at: Restarted, row: int) -> None:
    at.cell(row).click(position={"x": 3, "y": 3})
    at.page.click("[data-do=rows]")
    at.page.get_by_role("menuitem", name="Insert above").click()


@pytest.mark.slow
def test_what_is_typed_while_the_server_is_away_is_saved_in_order_when_it_is_back(at: Restarted) -> None:
    insert_above(at, 3)
    at.saved()
    at.type(3, "first")
    at.saved()
    at.kill()
    at.type(4, "second")
    expect(at.page.locator("#saved")).to_have_text("Saving …")
    expect(at.page.locator(".unsent")).to_contain_text("It keeps your changes")
    expect(at.page.locator("#saved")).to_have_text("Not saved")
    at.type(ROWS + 8, "third")
    at.type(4, "fourth")
    expect(at.page.locator(".unsent b")).to_have_text("3 changes are not saved.")
    at.page.get_by_role("button", name="Show changes").click()
    expect(at.page.get_by_label("Changes that are not saved").locator("textarea")).to_have_value(
        f"F4: second\nF{ROWS + 8}: third\nF4: fourth"
    )
    at.page.get_by_role("button", name="Close").last.click()
    at.start()
    at.saved()
    notes = at.notes()
    assert (notes[3], notes[4], notes[ROWS + 8]) == ("first", "fourth", "third") and notes[5] == "start 2"
    at.loaded_again()
    expect(at.cell(4)).to_have_attribute("data-v", "fourth")
    expect(at.page.locator("#formula-bar b")).to_have_text("F5")  # where the cursor was
    at.type(5, "goes on")
    at.saved()
    assert at.notes()[5] == "goes on"


def test_an_edit_whose_answer_was_lost_is_made_once(at: Restarted) -> None:
    def lose(route: Any) -> None:
        at.server.send(route.request.url.removeprefix(f"{at.server.home}/"), route.request.post_data.encode(),
                       {"Content-Type": "application/json"})  # fmt: skip
        route.abort()

    for action in ("cells", "insert"):
        at.page.route(f"**/{action}", lose)
    at.type(2, "of the page")
    until(at.page, lambda: at.notes()[2] == "of the page")
    insert_above(at, 4)
    expect(at.page.locator("#saved")).to_have_text("Not saved")
    at.kill()
    at.page.unroute("**/cells")
    at.page.unroute("**/insert")
    at.server.__exit__()
    at.server = Served(at.folder, options=["--port", at.port])
    at.saved()
    at.loaded_again()
    assert at.notes()[2] == "of the page"
    assert list(at.notes().values()).count("start 5") == 1 and max(at.notes()) <= ROWS + 2


@pytest.mark.slow
def test_what_is_not_saved_is_sent_by_the_page_that_is_loaded_again(at: Restarted) -> None:
    at.page.route("**/cells", lambda route: route.abort())
    at.type(2, "kept over a reload")
    expect(at.page.locator(".unsent")).to_contain_text("It keeps your changes")
    at.kill()
    at.start()
    at.page.unroute("**/cells")
    at.page.reload()
    at.saved()
    assert at.notes()[2] == "kept over a reload"


@pytest.mark.slow
def test_a_browser_that_is_signed_out_keeps_its_edits_until_it_is_let_in(at: Restarted) -> None:
    at.kill()
    at.type(2, "typed when signed out")
    at.start("--sign-out")
    expect(at.page.locator(".unsent")).to_contain_text("This browser is signed out.")
    expect(at.page.locator("#saved")).to_have_text("Not saved")
    with at.page.expect_response("**/cells") as again:
        at.page.locator(".unsent").get_by_role("button", name="Try again").click()
    assert again.value.status == 403
    expect(at.page.locator(".unsent")).to_contain_text("This browser is signed out.")
    line = at.page.locator("#line-lost")
    expect(line.get_by_role("button", name="Try again")).to_be_visible()  # it is not tried for ever
    at.page.context.add_cookies([{"name": c.name, "value": c.value, "url": at.server.home} for c in at.server.jar])
    line.get_by_role("button", name="Try again").click()
    at.saved()
    expect(line).to_be_empty()
    assert at.notes()[2] == "typed when signed out"


@pytest.mark.slow
def test_what_the_server_does_not_take_any_more_can_be_copied_and_discarded(shelf: Books) -> None:
    grid = shelf.open()
    page = grid.page
    page.route("**/cells", lambda route: route.abort())
    grid.go("F2")
    grid.type("for the clipboard")
    grid.path.unlink()
    page.unroute("**/cells")
    expect(page.locator(".unsent")).to_contain_text("renamed or moved")
    page.get_by_role("button", name="Show changes").click()
    page.get_by_role("button", name="Copy").click()
    expect(page.get_by_role("button", name="Copied")).to_be_visible()
    becomes(lambda: page.evaluate("navigator.clipboard.readText()"), "F2: for the clipboard")
    page.get_by_role("button", name="Discard changes").click()
    expect(page.get_by_role("heading", level=1)).to_have_text("There is nothing here")
