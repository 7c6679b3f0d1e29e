"""Pages at 200 and 400 % zoom, by touch, and in the reader's own colours: nothing is cut off, everything is large enough."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from chromium import PAGES, becomes, eventually
from grid_books import EMPTY, HEADER, ROWS
from playwright.sync_api import expect

from rrp_sheets.resources import bundled
from rrp_sheets.workbook.files import make_workbook

TABLE = {"T": [HEADER, *ROWS], "Test": [["Time (ms)", "Stream", "Send", "Expect"], ["0", "Red ball", "distance=1", ""]]}
PAGES_ = {
    "workbooks": "/", "sheet": "/book/b.xlsx", "empty sheet": "/book/empty.xlsx", "test sheet": "/book/b.xlsx/sheet/Test",
    "tutorial": "/book/tutorial.xlsx", "run": "/book/b.xlsx/run", "runs": "/runs", "versions": "/book/b.xlsx/versions",
    "compare": "/compare?first=book/b.xlsx&second=book/empty.xlsx", "print": "/book/b.xlsx/print", "nothing": "/book/none.xlsx",
}  # fmt: skip
ZOOMS = {200: (640, 450), 400: (320, 256)}
"""A window of 1280 × 900 (of 1024, as WCAG has it) at so many per cent, in CSS pixels."""
# what ends right of the page and is in nothing that scrolls
BEYOND = """() => { const scrolls = (one) => { for (let up = one.parentElement; up && up !== document.body; up = up.parentElement)
      if (getComputedStyle(up).overflowX !== "visible") return true; return false; };
    return [...document.querySelectorAll("body *")].filter((one) => one.checkVisibility() && !scrolls(one) && getComputedStyle(one).position !== "fixed"
      && one.getBoundingClientRect().right > document.documentElement.clientWidth + 1).map((one) => one.outerHTML.slice(0, 100)); }"""
# what one presses and is smaller than so many pixels; a link in a sentence, a cell, and a title that fills its card are not
SMALL = """(least) => [...document.querySelectorAll("a[href], button:not(:disabled), select, summary, [role=tab]")].filter((one) => {
    const { width, height } = one.getBoundingClientRect();
    return one.checkVisibility() && width > 0 && (width < least || height < least) && !one.closest("[role=grid], p, dd, h3, svg, .only-spoken, .skip, .help-ways");
  }).map((one) => one.outerHTML.slice(0, 160))"""


@pytest.fixture(scope="module")
def books(folder: Path) -> Path:
    make_workbook(TABLE, folder / "b.xlsx")
    make_workbook(EMPTY, folder / "empty.xlsx")
    shutil.copy(bundled("templates", "workbooks", "tutorial.xlsx"), folder)
    return folder


@pytest.fixture(scope="module")
def page(books: Path, browser: Any, url: str) -> Iterator[Any]:
    opened = PAGES.take(browser, url, base_url=url)
    yield opened
    PAGES.put_back(opened)


def show(page: Any, name: str, size: tuple[int, int]) -> None:
    page.set_viewport_size({"width": size[0], "height": size[1]})
    page.goto(PAGES_[name])
    if page.locator("#panels").count():
        page.wait_for_selector("body[data-words] #panels:not([aria-busy])", state="attached")


@pytest.mark.slow
@pytest.mark.parametrize("zoom", ZOOMS)
@pytest.mark.parametrize("name", PAGES_)
def test_nothing_is_beyond_the_edge_nor_too_small(name: str, zoom: int, page: Any) -> None:
    show(page, name, ZOOMS[zoom])
    becomes(lambda: page.evaluate(BEYOND), [])
    becomes(lambda: page.evaluate("document.documentElement.scrollWidth <= document.documentElement.clientWidth"), True)
    becomes(lambda: page.evaluate(SMALL, 24), [])


@pytest.mark.slow
def test_a_cell_is_written_and_a_suggestion_seen_at_400_per_cent(page: Any) -> None:
    show(page, "empty sheet", ZOOMS[400])
    page.locator("[role=grid] td.inputs").first.click(position={"x": 3, "y": 3})
    page.keyboard.type("red b")
    option = page.locator("[role=option]").first
    expect(option).to_be_in_viewport()
    page.keyboard.press("ArrowDown")
    page.keyboard.press("Enter")
    page.keyboard.press("Enter")
    page.wait_for_selector("body:not([data-saving])")


@pytest.mark.slow
def test_stop_stays_in_sight_at_400_per_cent(page: Any) -> None:
    show(page, "run", ZOOMS[400])
    page.evaluate(
        "document.querySelector('.problems')?.scrollIntoView(); window.scrollTo(0, document.body.scrollHeight)"
    )
    expect(page.locator("#runbar .stop")).to_be_in_viewport()


@pytest.fixture
def finger(books: Path, browser: Any, url: str) -> Iterator[Any]:
    """A page on a phone."""
    opened = PAGES.take(
        browser, url, base_url=url, viewport={"width": 400, "height": 800}, has_touch=True, is_mobile=True
    )
    yield opened
    PAGES.put_back(opened)


@pytest.mark.slow
def test_what_a_finger_presses_is_44_pixels_large(finger: Any) -> None:
    for name in PAGES_:
        show(finger, name, (400, 800))
        becomes(lambda: finger.evaluate(SMALL, 44), [], name)
        becomes(lambda: finger.evaluate(BEYOND), [], name)


@pytest.mark.slow
def test_in_the_colours_of_the_reader_nothing_is_told_by_a_fill_alone(page: Any) -> None:
    page.emulate_media(forced_colors="active")
    show(page, "tutorial", (1280, 900))
    edged = "(one) => ['borderTopWidth', 'outlineWidth'].some((side) => parseFloat(getComputedStyle(one)[side]) > 0)"
    for selector in ("#runbar .button", ".stop", ".places [aria-current]", ".chip", "#lesson .button"):
        eventually(lambda selector=selector: page.locator(selector).first.evaluate(edged), selector)
    page.locator("[data-run=start]").focus()
    page.keyboard.press("Tab")
    focused = "parseFloat(getComputedStyle(document.activeElement).outlineWidth)"
    becomes(lambda: page.evaluate(focused), 3)
    page.emulate_media(forced_colors="none")
