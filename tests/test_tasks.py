"""The walkthrough and the Tracking task of the thesis, done in a real browser: by keyboard, mouse, touch, and by what a
screen reader knows of the page. Each from the shelf on, and each ends with a file that means what was wanted."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
from chromium import PAGES, GridPage, becomes, eventually, frames, listening, until
from effort import Recorder
from playwright.sync_api import expect
from tasks import HEADER, KEYS, TASKS, WALKTHROUGH, by_mouse, check_meaning, press_rows

from rrp_sheets.workbook.files import make_workbook

MOST_SECONDS = {"walkthrough": 24, "tracking": 58}  # the original software: 60 to 75, and 132 to 152


class Shelf(GridPage):
    """The shelf, from which a new workbook is made."""

    def __init__(self, browser: Any, url: str, recorder: Recorder | None = None, **context: Any) -> None:
        self.page = PAGES.take(browser, url, **context)
        self.context, self.errors = self.page.context, self.page.problems
        if recorder:
            PAGES.spoil(self.page)
            recorder.watch(self.context)
        self.page.goto(url)

    def opened(self) -> None:
        """Wait for the new workbook's grid, ready to be typed into."""
        listening(self.page)
        self.page.wait_for_selector("body[data-ready]")

    def tab_to(self, name: str) -> None:
        """Press Tab until the thing with that name has the focus."""
        for _ in range(30):
            self.press("Tab")
            script = (
                "() => { const e = document.activeElement; return (e.labels?.[0] ?? e).innerText || e.ariaLabel || '' }"
            )
            if self.page.evaluate(script).startswith(name):
                return
        raise AssertionError(f"no Tab leads to {name}")

    def new_by_keyboard(self, name: str) -> None:
        self.tab_to("New workbook")
        self.type(name, "Tab")
        self.type("empty", "Tab")
        self.press("Enter")
        self.opened()

    def new_by_mouse(self, name: str, *, touch: bool = False) -> None:
        field = self.page.get_by_label("New workbook")
        make = self.page.get_by_role("button", name="Create", exact=True)
        field.tap() if touch else field.click()
        self.page.keyboard.type(name)
        self.page.get_by_role("combobox").select_option("empty")
        make.tap() if touch else make.click()
        self.opened()


def ends_well(page: Shelf, task: str, made: Path, tmp_path: Path) -> None:
    """No problem is shown, the diagram shows every row, and the file means what the task wants."""
    page.saved()
    for number in range(2, len(TASKS[task]) + 2):
        page.page.wait_for_selector(f"#diagram [data-row='{number}']", state="attached")
    expect(page.page.locator(".problems")).to_contain_text("no problems")
    check_meaning(task, made, tmp_path)
    page.close()
    made.unlink()  # the next test's shelf would draw it


@pytest.mark.slow
@pytest.mark.parametrize("task", [pytest.param("walkthrough", marks=pytest.mark.soak), "tracking"])
def test_by_keyboard_alone_and_soon_enough(browser: Any, url: str, folder: Path, tmp_path: Path, task: str) -> None:
    """The first rows of Tracking take the keys of the walkthrough, and must be as quick.

    `make soak` types the walkthrough itself.
    """
    recorder = Recorder()
    page = Shelf(browser, url, recorder)
    page.new_by_keyboard(f"{task} by keys")
    recorder.begin()
    first = len(TASKS["walkthrough"])
    press_rows(page, KEYS[task][:first])
    effort = recorder.effort()
    assert effort.points == 0 and effort.seconds <= MOST_SECONDS["walkthrough"], effort
    press_rows(page, KEYS[task][first:])
    effort = recorder.effort()
    assert effort.points == 0 and effort.seconds <= MOST_SECONDS[task], effort
    ends_well(page, task, folder / f"{task} by keys.xlsx", tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("task", ["walkthrough", pytest.param("tracking", marks=pytest.mark.soak)])
def test_by_mouse(browser: Any, url: str, folder: Path, tmp_path: Path, task: str) -> None:
    page = Shelf(browser, url)
    page.new_by_mouse(f"{task} by mouse")
    by_mouse(page, task)
    ends_well(page, task, folder / f"{task} by mouse.xlsx", tmp_path)


@pytest.mark.slow
def test_by_touch(browser: Any, url: str, folder: Path, tmp_path: Path) -> None:
    page = Shelf(browser, url, viewport={"width": 400, "height": 800}, has_touch=True, is_mobile=True)
    page.new_by_mouse("by touch", touch=True)
    becomes(lambda: page.page.evaluate("scrollY"), 0)  # the page has not jumped to its tabs, which are below
    by_mouse(page, "walkthrough", touch=True)
    ends_well(page, "walkthrough", folder / "by touch.xlsx", tmp_path)


@pytest.mark.slow
def test_two_quick_taps_open_a_cell_only_when_it_is_the_same(browser: Any, url: str, folder: Path) -> None:
    make_workbook({"T": [HEADER, *([""] * 4 for _ in range(80))]}, folder / "taps.xlsx")
    page = GridPage(browser, url, "taps.xlsx", has_touch=True)
    box = page.cell("D5").bounding_box()
    at = box["x"] + 8, box["y"] + 8
    page.page.touchscreen.tap(*at)
    page.page.evaluate("height => { document.getElementById('grid-scroll').scrollTop += height; }", box["height"])
    page.page.touchscreen.tap(*at)
    expect(page.page.locator("#formula-bar b")).to_have_text("D6")
    frames(page.page, 2)
    eventually(lambda: not page.page.locator(".editor").count())
    page.page.touchscreen.tap(*at)
    expect(page.page.locator(".editor textarea")).to_be_focused()
    page.close()
    (folder / "taps.xlsx").unlink()


def test_by_what_a_screen_reader_knows_alone(browser: Any, url: str, folder: Path, tmp_path: Path) -> None:
    """Everything is found by its role and name, and after each key the focused thing says where one is."""
    page = Shelf(browser, url)
    tree, focused = page.page, page.page.locator(":focus")
    tree.get_by_role("textbox", name="New workbook").focus()
    page.type("by ear", "Tab")
    page.type("empty", "Tab")
    expect(tree.get_by_role("button", name="Create", exact=True)).to_be_focused()
    page.press("Enter")
    page.opened()
    expect(tree.get_by_role("grid", name="Tracking")).to_be_visible()
    assert focused.aria_snapshot().startswith('- \'gridcell "Input streams, row 2: blank"')
    for number, row in enumerate(WALKTHROUGH, start=2):
        for header, text in zip(HEADER, row, strict=True):
            until(tree, lambda h=header, n=number: f'gridcell "{h}, row {n}: ' in focused.aria_snapshot())
            if not text:
                page.press("Tab")
                continue
            page.page.keyboard.type(text[:2])
            field = tree.get_by_role("textbox", name=f"{header}, row {number}")
            expect(field).to_be_focused()
            if header == "Connector" or (header == "Input streams" and number == 2) or row[1] == "subscribe":
                chosen = tree.get_by_role("listbox", name="Suggestions").get_by_role("option", selected=True)
                while not chosen.count() or text not in chosen.inner_text():
                    page.press("ArrowDown")  # each is read out, with its help
            else:
                page.page.keyboard.type(text[2:])
            page.press("Enter" if header == HEADER[-1] else "Tab")
    expect(tree.get_by_role("gridcell", name="Output stream, row 4: Head tracker")).to_be_visible()
    expect(tree.get_by_role("region", name="Problems").get_by_text("no problems")).to_be_visible()
    ends_well(page, "walkthrough", folder / "by ear.xlsx", tmp_path)


@pytest.mark.slow
def test_a_mistake_is_heard_and_mended_at_its_cell(browser: Any, url: str, folder: Path) -> None:
    """A wrong name is told with its cell; the link leads there, and the cell says what is wrong with it."""
    page = Shelf(browser, url)
    page.new_by_keyboard("mistake")
    tree, focused = page.page, page.page.locator(":focus")
    for text in ("Red ball", "map", "redBall.distence"):
        page.type(text, "Tab")
    page.type("Distance")
    problems = tree.get_by_role("region", name="Problems")
    expect(problems.get_by_role("link", name="Tracking!C2")).to_be_visible()
    problems.get_by_role("link", name="Tracking!C2").focus()
    page.press("Enter")
    cell = tree.get_by_role("gridcell", name="Formula, row 2:")
    expect(cell).to_be_focused()
    expect(cell).to_have_attribute("aria-invalid", "true")
    expect(cell).to_have_accessible_description(re.compile("distence.*distance", re.DOTALL))
    page.type("redBall.distance")
    expect(problems.get_by_role("link", name="Tracking!C2")).to_have_count(0)
    expect(cell).not_to_have_attribute("aria-invalid", "true")
    assert 'gridcell "Formula, row 3: blank"' in focused.aria_snapshot()
    page.close()
