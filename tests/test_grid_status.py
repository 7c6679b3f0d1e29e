"""The status line: a message goes after a time, a warning later, an error or one with buttons when it is closed or an edit is made."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from chromium import PAGES, GridPage, leave, listening, set_clock
from grid_books import TRACKING
from playwright.sync_api import expect

BOOKS = {"a.xlsx": TRACKING}


class Timed(GridPage):
    """A grid whose clock stands still but for `passes`."""

    def __init__(self, page: Any) -> None:
        self.page, self.context, self.errors = page, page.context, page.problems
        self.line = self.page.locator("#status")
        self._opened = 0

    def open(self, url: str) -> None:
        """Open the grid anew."""
        self._opened += 1
        self.page.clock.resume()
        leave(self.page, url)
        self.page.goto(f"{url}/book/a.xlsx")
        listening(self.page)
        self.page.wait_for_selector("body[data-ready][data-words]")
        self.page.clock.pause_at(self._opened * 10**9)

    def passes(self, seconds: float) -> None:
        self.page.clock.run_for(round(seconds * 1000))


@pytest.fixture(scope="module")
def timed(browser: Any, url: str) -> Iterator[Timed]:
    page = PAGES.take(browser, url)
    set_clock(page, time=0)
    made = Timed(page)
    yield made
    made.close()


@pytest.fixture
def grid(timed: Timed, url: str) -> Timed:
    timed.open(url)
    return timed


@pytest.mark.slow
def test_a_message_goes_by_itself_and_the_next_one_has_its_whole_time(grid: Timed) -> None:
    grid.go("C2")
    grid.press("Control+c")
    expect(grid.line).to_have_text("One cell copied.")
    grid.passes(5)
    expect(grid.line).to_have_text("One cell copied.")
    grid.press("Control+c")
    grid.passes(5)
    expect(grid.line).to_have_text("One cell copied.")
    grid.passes(2)
    expect(grid.line).to_be_empty()
    expect(grid.page.get_by_role("button", name="Close the message")).to_be_hidden()


@pytest.mark.slow
def test_it_stays_while_the_pointer_or_the_focus_is_on_it(grid: Timed) -> None:
    grid.page.evaluate("navigator.clipboard.writeText('a\\tb\\tc')")
    grid.go("F2")
    grid.press("Control+v")
    words = "2 columns did not fit and were skipped."
    expect(grid.page.locator("#status.is-warning")).to_have_text(words)
    grid.passes(10)
    grid.line.hover()
    grid.passes(600)
    expect(grid.line).to_have_text(words)
    button = grid.page.get_by_role("button", name="Close the message")
    button.focus()
    grid.page.mouse.move(5, 5)
    grid.passes(600)
    expect(grid.line).to_have_text(words)
    grid.cell("F2").focus()
    grid.passes(5)
    expect(grid.line).to_have_text(words)
    grid.passes(5)
    expect(grid.line).to_be_empty()


@pytest.mark.slow
def test_an_error_stays_until_it_is_closed_or_something_else_is_done(grid: Timed) -> None:
    grid.page.route("**/cells", lambda route: route.fulfill(json={"message": "Not now."}))
    grid.go("F2")
    grid.write("x")
    error = grid.page.locator("#status.is-error")
    expect(error).to_have_text("Not now.")
    expect(grid.line).to_have_role("status")
    grid.passes(3600)
    expect(error).to_have_text("Not now.")
    grid.page.keyboard.press("Escape")  # what could not be stored is offered in a dialog
    grid.page.get_by_role("button", name="Close the message").click()
    expect(grid.line).to_be_empty()
    expect(grid.page.locator("[role=gridcell]:focus")).to_have_count(1)
    grid.go("F3")
    grid.write("y")
    expect(error).to_have_text("Not now.")
    grid.page.unroute("**/cells")
    grid.page.keyboard.press("Escape")
    grid.go("F4")
    grid.write("z")  # this is done, and the error is still to be read
    expect(error).to_have_text("Not now.")
    grid.passes(6)
    expect(grid.line).to_be_empty()


def test_a_message_with_buttons_stays_until_it_is_closed_or_an_edit_is_made(grid: Timed) -> None:
    undo = grid.page.locator(".status-line").get_by_role("button", name="Undo")
    for name in ("Far", "Further"):
        grid.go("E2")
        grid.write(name)
        expect(grid.line).to_contain_text(f"is now “{name}” in")
        grid.passes(3600)
        expect(undo).to_be_visible()
        if name == "Far":
            grid.page.get_by_role("button", name="Close the message").click()
            expect(undo).to_have_count(0)
    grid.go("A4")
    grid.press("Control++")  # one that is no change of cells
    grid.passes(6)
    expect(undo).to_have_count(0)
    expect(grid.line).to_be_empty()


@pytest.mark.slow
def test_an_error_goes_when_what_was_wrong_is_over(grid: Timed, folder: Path) -> None:
    path = folder / "a.xlsx"
    whole = path.read_bytes()
    error = grid.page.locator("#status.is-error")
    for wrong, words in ((lambda: path.write_bytes(whole[: len(whole) // 2]), "is damaged"), (path.unlink, "a.xlsx")):
        wrong()
        expect(error).to_contain_text(words)
        path.write_bytes(whole)
        expect(grid.line).to_be_empty()
