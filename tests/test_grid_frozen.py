"""The first columns of the grid, and its header, stay in sight while it is scrolled."""

from __future__ import annotations

import pytest
from chromium import becomes, eventually
from grid_books import HEADER, Books, Shared
from playwright.sync_api import expect

ROWS = [["", "Red ball", "map", "redBall.distance", f"S{number}", "a note " * 9] for number in range(2, 60)]
SHEETS = {"T": [HEADER, *ROWS, ["", "# A comment that runs on through the cells beside it", "", "", "", ""]],
          "Devices": [["Stream", "Device", "Notes"], ["Gaze", "Head yaw", "n"]]}  # fmt: skip


@pytest.fixture
def grid(shelf: Books) -> Shared:
    opened = shelf.open(SHEETS, sheet="T")
    opened.checked()
    return opened


def scrolled(grid: Shared, left: int = 300, top: int = 200) -> None:
    grid.page.locator("#grid-scroll").evaluate(f"e => e.scrollTo({left}, {top})")


def offset(grid: Shared, column: int, row: int = 8) -> int:
    """The place of a cell to the right of the table's left edge, in pixels."""
    script = "(cell, left) => Math.round(cell.getBoundingClientRect().left - document.getElementById('grid-scroll').getBoundingClientRect().left)"
    return int(grid.page.locator(f"tr[aria-rowindex='{row}'] > *").nth(column).evaluate(script))


def on_top(grid: Shared, column: int, row: int = 12) -> bool:
    """True when nothing lies above a cell."""
    script = """cell => { const { left, top } = cell.getBoundingClientRect();
        return cell.contains(document.elementFromPoint(left + 5, top + 5)); }"""
    return bool(grid.page.locator(f"tr[aria-rowindex='{row}'] > *").nth(column).evaluate(script))


def test_the_switch_and_the_inputs_stay_while_the_sheet_is_scrolled(grid: Shared) -> None:
    scrolled(grid)
    becomes(lambda: [offset(grid, column) for column in (0, 1, 2)], [0, 40, 80])
    becomes(lambda: [offset(grid, column, 1) for column in (0, 1, 2)], [0, 40, 80])
    assert all(on_top(grid, column) for column in (0, 1, 2))
    assert offset(grid, 3) < 0
    grid.go("F20")
    grid.press("ArrowLeft", "ArrowLeft", "ArrowLeft")  # to a cell that is not below those that stay
    becomes(lambda: grid.here, "C20")
    eventually(lambda: on_top(grid, 3, 20))
    grid.page.locator("tr[aria-rowindex='59']").scroll_into_view_if_needed()
    scrolled(grid, 300, 9999)
    assert offset(grid, 2, 60) < 80  # the comment goes with the cells that it runs on through


def test_a_cell_that_stays_is_edited_where_it_is_seen(grid: Shared) -> None:
    scrolled(grid)
    grid.cell("B10").dblclick(position={"x": 3, "y": 3})
    field = grid.page.locator(".editor textarea")
    expect(field).to_be_focused()
    becomes(lambda: grid.page.locator("#grid-scroll").evaluate("e => e.scrollLeft > 100"), True)
    places = [grid.cell("B10"), field]
    becomes(lambda: abs(places[0].bounding_box()["x"] - places[1].bounding_box()["x"]) < 2, True)
    scrolled(grid, 120)
    becomes(lambda: abs(places[0].bounding_box()["x"] - places[1].bounding_box()["x"]) < 2, True)
    grid.press("Escape")


@pytest.mark.slow
def test_what_stays_takes_at_most_half_of_the_width(grid: Shared) -> None:
    grid.page.set_viewport_size({"width": 400, "height": 800})
    scrolled(grid)
    becomes(lambda: [offset(grid, column) for column in (0, 1)], [0, 40])
    becomes(lambda: offset(grid, 2) < 40, True)  # of two columns there is not enough room
    assert grid.faults() == []


@pytest.mark.slow
def test_a_wide_first_column_does_not_stay(shelf: Books) -> None:
    grid = shelf.open(SHEETS, sheet="Devices")
    grid.checked()
    grid.page.set_viewport_size({"width": 400, "height": 800})
    head = grid.page.locator("[role=grid]")
    expect(head).to_have_class("edit-grid of-devices frozen-1")
    grid.go("A2")
    for _ in range(8):
        grid.press("Alt+ArrowRight")
    expect(head).to_have_class("edit-grid of-devices")
