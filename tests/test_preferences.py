"""Settings in the menu of each page: less motion. It is remembered, holds on every page, and the system may wish it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from chromium import PAGES, becomes
from grid_books import TRACKING
from playwright.sync_api import expect
from run_panel import BOOK, Panel

from rrp_sheets.workbook.files import make_workbook

ROOT = "document.documentElement.dataset.calm"


@pytest.fixture(scope="module")
def page(folder: Any, browser: Any, url: str) -> Iterator[Any]:
    make_workbook(TRACKING, folder / "t.xlsx")
    opened = PAGES.take(browser, url, base_url=url)
    yield opened
    PAGES.put_back(opened)


def test_it_is_remembered_and_holds_on_every_page(page: Any) -> None:
    page.goto("/")
    becomes(lambda: page.evaluate(ROOT), "no")
    page.click(".page-menu summary")
    page.get_by_label("Less motion").check()
    for address in ("/runs", "/book/t.xlsx", "/help"):
        page.goto(address)
        becomes(lambda: page.evaluate(ROOT), "yes", address)
    page.click(".page-menu summary")
    expect(page.get_by_label("Less motion")).to_be_checked()
    page.get_by_label("Less motion").uncheck()
    becomes(lambda: page.evaluate(ROOT), "no")


def test_the_wish_of_the_system_stands_above_it(page: Any) -> None:
    page.goto("/")
    page.emulate_media(reduced_motion="reduce")
    becomes(lambda: page.evaluate(ROOT), "yes")
    page.click(".page-menu summary")
    expect(page.get_by_label("Less motion")).to_be_disabled()
    page.emulate_media(reduced_motion="no-preference")
    becomes(lambda: page.evaluate(ROOT), "no")


def test_the_menu_closes_when_one_goes_elsewhere(page: Any) -> None:
    page.goto("/")
    menu = page.locator(".page-menu")
    menu.locator("summary").click()
    page.locator("h1").click()
    expect(menu).not_to_have_attribute("open", "")
    menu.locator("summary").press("Enter")
    page.keyboard.press("Escape")
    expect(menu).not_to_have_attribute("open", "")
    expect(menu.locator("summary")).to_be_focused()


def test_during_a_run_nothing_flashes_or_fades(browser: Any, url: str, folder: Any) -> None:
    make_workbook(BOOK, folder / "b.xlsx")
    panel = Panel(browser, url, reduced_motion="reduce")
    page = panel.page
    panel.run()
    moving = """() => [...document.querySelectorAll("*")].map((one) => getComputedStyle(one))
      .filter((style) => parseFloat(style.transitionDuration) > 0 || style.animationName !== "none").length"""
    becomes(lambda: page.evaluate(moving), 0)
    panel.run("paused")  # its clock stands still
    panel.live(t=2.4, rows={page.locator("tbody tr").first.get_attribute("id"): {"v": "1", "at": 1.1, "n": 1}})
    age = page.locator("tbody tr").first.locator(".live .age")
    expect(age).to_have_text("1 s")
    tint = """() => { const [row] = document.querySelectorAll("tbody tr.lit");
      return getComputedStyle(row.querySelector("td.example")).backgroundColor === getComputedStyle(document.body).backgroundColor; }"""
    panel.live(t=2.4, rows={page.locator("tbody tr").first.get_attribute("id"): {"v": "2", "at": 2.4, "n": 2}})
    page.wait_for_selector("tbody tr.lit")
    becomes(lambda: page.evaluate(tint), True)
    assert not panel.errors
    PAGES.put_back(page)
