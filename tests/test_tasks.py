"""The walkthrough and the Tracking task of the thesis, done in a real browser: by keyboard, mouse, touch, and by what a
screen reader knows of the page. Each from the shelf on, and each ends with a file that means what was wanted."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from chromium import CHROMIUM, TOKEN, GridPage, browsing, serving
from effort import Recorder
from tasks import TASKS, by_keyboard, by_mouse, check_meaning, texts

if not CHROMIUM:
    pytest.skip("there is no Chromium on this machine", allow_module_level=True)

from playwright.sync_api import expect

MOST_SECONDS = {"walkthrough": 35, "tracking": 75}  # the original software: 60 to 75, and 132 to 152


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with browsing() as found:
        yield found


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("books")


@pytest.fixture(scope="module")
def url(folder: Path) -> Iterator[str]:
    with serving(folder) as address:
        yield address


class Shelf(GridPage):
    """The shelf, from which a new workbook is made."""

    def __init__(self, browser: Any, url: str, recorder: Recorder | None = None, **context: Any) -> None:
        self.context = browser.new_context(**{"viewport": {"width": 1280, "height": 800}} | context)
        if recorder:
            recorder.watch(self.context)
        self.page = self.context.new_page()
        self.errors = []
        self.page.on("pageerror", lambda error: self.errors.append(str(error)))
        self.page.goto(f"{url}/?token={TOKEN}")

    def opened(self) -> None:
        """Wait for the new workbook's grid, ready to be typed into."""
        self.page.wait_for_selector("#listen[data-htmx-powered]", state="attached")
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
        make = self.page.get_by_role("button", name="Make it")
        field.tap() if touch else field.click()
        self.page.keyboard.type(name)
        self.page.get_by_role("combobox").select_option("empty")
        make.tap() if touch else make.click()
        self.opened()


def ends_well(page: Shelf, task: str, made: Path, tmp_path: Path) -> None:
    """No problem is shown, the diagram shows every row, and the file means what the task wants."""
    page.saved()
    for number in range(2, len(TASKS[task]) + 2):
        page.page.wait_for_selector(f"#diagram [data-row='{number}']", state="attached", timeout=15_000)
    expect(page.page.locator(".problems")).to_contain_text("no problems", timeout=15_000)
    check_meaning(task, made, tmp_path)
    page.close()


@pytest.mark.parametrize("task", TASKS)
def test_by_keyboard_alone_and_soon_enough(browser: Any, url: str, folder: Path, tmp_path: Path, task: str) -> None:
    recorder = Recorder()
    page = Shelf(browser, url, recorder)
    page.new_by_keyboard(f"{task} by keys")
    recorder.begin()
    by_keyboard(page, task)
    effort = recorder.effort()
    assert effort.points == 0 and effort.seconds <= MOST_SECONDS[task], effort
    ends_well(page, task, folder / f"{task} by keys.xlsx", tmp_path)


@pytest.mark.parametrize("task", TASKS)
def test_by_mouse(browser: Any, url: str, folder: Path, tmp_path: Path, task: str) -> None:
    page = Shelf(browser, url)
    page.new_by_mouse(f"{task} by mouse")
    by_mouse(page, task)
    ends_well(page, task, folder / f"{task} by mouse.xlsx", tmp_path)


def test_by_touch(browser: Any, url: str, folder: Path, tmp_path: Path) -> None:
    page = Shelf(browser, url, viewport={"width": 400, "height": 800}, has_touch=True, is_mobile=True)
    page.new_by_mouse("by touch", touch=True)
    by_mouse(page, "walkthrough", touch=True)
    ends_well(page, "walkthrough", folder / "by touch.xlsx", tmp_path)
