"""Everything by two keys, as a switch gives them: Tab goes on, Enter chooses; a row, a run, its buttons, a touch, Stop."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from chromium import FLAGS_3D, becomes, eventually
from grid_books import EMPTY, Books
from playwright.sync_api import expect

pytest.importorskip("pybullet")
import panel as sessions
from panel import ended, running, trace

BOOKS = {"session.xlsx": sessions.SESSION, "empty.xlsx": EMPTY}
pytestmark = pytest.mark.usefixtures("unfilmed")
BROWSER_FLAGS = FLAGS_3D


@pytest.fixture(scope="module")
def switched(shelf: Books) -> Iterator[Books]:
    """Two keys are set in the menu of the page, which is remembered."""
    grid = shelf.open(EMPTY)
    menu = grid.page.locator(".page-menu")
    menu.locator("summary").press("Enter")
    menu.get_by_label("Two keys").press("Space")
    grid.page.keyboard.press("Escape")
    expect(menu.locator("summary")).to_be_focused()
    yield shelf
    grid.page.evaluate("localStorage.removeItem('twoKeys')")


def tab_to(page: Any, wanted: Any, most: int = 60) -> None:
    """Press Tab until something has the focus."""
    for _ in range(most):
        if wanted.evaluate("(one) => one === document.activeElement"):
            return
        page.keyboard.press("Tab")
    raise AssertionError(
        f"{wanted} is not reached by {most} times Tab: {page.evaluate('document.activeElement.outerHTML')[:200]}"
    )


def choose(page: Any, name: str) -> None:
    """Open the cell with the cursor, and take a suggestion."""
    page.keyboard.press("Enter")
    page.wait_for_selector("[role=option]")
    for _ in range(60):
        if page.locator("[role=option][aria-selected=true] .name").all_inner_texts() == [name]:
            break
        page.keyboard.press("Tab")
    page.keyboard.press("Enter")


def test_a_row_is_written_by_choosing(switched: Books) -> None:
    grid = switched.open(EMPTY)
    grid.checked()
    grid.go("B2")
    choose(grid.page, "Red ball")
    becomes(lambda: grid.here, "C2")
    choose(grid.page, "subscribe")
    grid.press("Tab")
    choose(grid.page, "Head tracker")
    eventually(lambda: grid.rows() == [("Red ball", "subscribe", "", "Head tracker")])


def test_after_the_last_suggestion_the_cell_stays_as_it_was(switched: Books) -> None:
    grid = switched.open({"T": [EMPTY["T"][0], ["", "Blue ball", "subscribe", "", "Head tracker", "kept"]]})
    grid.checked()
    grid.go("C2")
    grid.press("Enter")
    grid.page.wait_for_selector("[role=option]")
    count = grid.page.locator("[role=option]").count()
    chosen = grid.page.locator("[role=option][aria-selected=true]")
    for _ in range(count + 1):
        grid.press("Tab")
        if not chosen.count():
            break
    grid.wait_spoken("the cell stays as it was")
    grid.press("Enter")
    grid.expect("C2", "subscribe")
    becomes(lambda: grid.here, "D2")


def test_the_sheet_lets_go_and_begins_again_at_its_first_cell(switched: Books) -> None:
    grid = switched.open(EMPTY)
    grid.checked()
    grid.go("F2")
    grid.press("Tab")
    eventually(lambda: not grid.page.evaluate("document.activeElement.closest('[role=grid]')"))
    becomes(lambda: grid.here, "A2")


def test_a_menu_is_gone_through_by_tab(switched: Books) -> None:
    grid = switched.open(EMPTY)
    grid.page.locator("[data-do=rows]").press("Enter")
    items = grid.page.get_by_role("menu", name="Rows").get_by_role("menuitem")
    expect(items.first).to_be_focused()
    grid.press("Tab")
    expect(items.nth(1)).to_be_focused()
    for _ in range(items.count() - 1):
        grid.press("Tab")
    expect(items).to_have_count(0)


def test_lists_and_ticks_are_changed(switched: Books, url: str) -> None:
    page = switched.page
    page.goto(f"{url}/book/session.xlsx/run/Cheer")
    page.wait_for_selector("body[data-ready]", state="attached")
    speed = page.locator("#run-speed")
    speed.focus()
    page.keyboard.press("Enter")
    expect(speed).to_have_class("choosing")
    page.keyboard.press("Tab")
    expect(page.get_by_role("status").get_by_text("2×", exact=True)).to_be_attached()
    page.keyboard.press("Enter")
    expect(speed).to_have_value("2")
    for _ in range(3):  # to the first one after the last
        page.keyboard.press("Enter")
        page.keyboard.press("Tab")
        page.keyboard.press("Enter")
    expect(speed).to_have_value("0.5")
    page.keyboard.press("Enter")
    page.keyboard.press("Tab")
    page.keyboard.press("Escape")
    expect(speed).to_have_value("0.5")
    page.locator("[data-run=start]").focus()
    page.keyboard.press("Enter")
    tab_to(page, page.locator("#run-dialog [value=try]"))
    page.keyboard.press("Enter")
    expect(page.locator("#run-dialog [value=simulated]")).to_be_checked()
    page.keyboard.press("Escape")


@pytest.mark.slow
def test_a_session_is_run_touched_and_stopped(switched: Books, folder: Path, url: str) -> None:
    page = switched.page
    page.goto(f"{url}/book/session.xlsx/run/Cheer")
    page.wait_for_selector("#panels:not([aria-busy])", state="attached")
    page.wait_for_selector("body[data-ready]", state="attached")
    start = page.locator("[data-run=start]")
    start.focus()
    page.keyboard.press("Enter")
    expect(page.locator("#run-dialog [type=submit]")).to_be_focused()
    page.keyboard.press("Enter")
    running(page)
    expect(start).to_be_focused()
    button = page.locator("#press button").first
    tab_to(page, button)
    page.keyboard.press("Enter")
    expect(button).to_contain_text("pressed once")
    page.wait_for_selector("#robot3d[data-ready]")
    hand = page.get_by_role("button", name="Touch: Left hand")
    expect(hand).to_be_enabled()
    start.focus()
    tab_to(page, hand)
    page.keyboard.press("Enter")
    expect(page.locator("#log")).to_contain_text("Left hand")
    page.get_by_role("tab", name="Scene").press("Enter")
    height = page.locator("#things input[type=range]").nth(2)
    expect(height).to_have_value("0.4")
    height.focus()
    page.keyboard.press("Enter")
    page.keyboard.press("Tab")
    expect(height).not_to_have_value("0.4")
    page.keyboard.press("Enter")
    start.focus()
    tab_to(page, page.locator("[data-run=stop]"), 4)
    page.keyboard.press("Enter")
    ended(page)
    entries = trace(folder, "session")
    assert any("Left hand" in str(entry) for entry in entries)
    heights = [entry["detail"]["put"][2] for entry in entries if "put" in (entry.get("detail") or {})]
    assert heights and max(heights) > 0.4
