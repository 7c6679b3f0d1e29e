"""Several ranges of cells at once: selected with Ctrl, cleared, filled, copied, and counted."""

from __future__ import annotations

import pytest
from chromium import becomes
from grid_books import HEADER, Books, Shared
from playwright.sync_api import expect

ROWS = [["", "Red ball", "map", "redBall.distance", f"S{number}", f"note {number}"] for number in range(2, 7)]


@pytest.fixture
def grid(shelf: Books) -> Shared:
    opened = shelf.open({"T": [HEADER, *ROWS]})
    opened.checked()
    return opened


def add(grid: Shared, address: str, to: str = "") -> None:
    """Select a further cell with Ctrl, or a range by dragging."""
    grid.page.keyboard.down("Control")
    if to:
        grid.cell(address).hover(position={"x": 5, "y": 5})
        grid.page.mouse.down()
        grid.cell(to).hover(position={"x": 9, "y": 9})
        grid.page.mouse.up()
    else:
        grid.go(address)
    grid.page.keyboard.up("Control")


def selected(grid: Shared) -> list[str]:
    """The addresses of the selected cells."""
    found = grid.page.locator("td[aria-selected=true]").evaluate_all(
        "cells => cells.map((c) => c.closest('table').tHead.rows[0].cells[c.cellIndex].dataset.letter + c.parentElement.cells[0].textContent)"
    )
    return [str(one) for one in found]


def notes(grid: Shared) -> list[str]:
    return [grid.text(f"F{row}") for row in range(2, 7)]


def clipboard(grid: Shared) -> str:
    return str(grid.page.evaluate("navigator.clipboard.readText()"))


def test_delete_clears_all_ranges_in_one_step(grid: Shared) -> None:
    grid.go("F2")
    add(grid, "F4", "F5")
    add(grid, "D2")
    becomes(lambda: selected(grid), ["D2", "F2", "F4", "F5"])
    expect(grid.page.locator("#counts")).to_have_text("5 rows · 4 cells selected")
    grid.press("Delete")
    becomes(lambda: (notes(grid), grid.text("D2")), (["", "note 3", "", "", "note 6"], ""))
    grid.press("Control+z")
    becomes(lambda: (notes(grid), grid.text("D2")), ([f"note {n}" for n in range(2, 7)], "redBall.distance"))
    grid.go("F2")
    becomes(lambda: selected(grid), ["F2"])


def test_ctrl_enter_and_a_single_value_fill_all_ranges(grid: Shared) -> None:
    grid.go("F2")
    add(grid, "F5", "F6")
    grid.page.keyboard.type("same")
    grid.press("Control+Enter")
    becomes(lambda: notes(grid), ["same", "note 3", "note 4", "same", "same"])
    becomes(lambda: selected(grid), ["F2", "F5", "F6"])
    grid.page.evaluate("navigator.clipboard.writeText('other')")
    grid.press("Control+v")
    becomes(lambda: notes(grid), ["other", "note 3", "note 4", "other", "other"])
    grid.page.evaluate("navigator.clipboard.writeText('a\\tb')")
    grid.press("Control+v")
    grid.status("Select one block of cells to paste into.")
    becomes(lambda: notes(grid), ["other", "note 3", "note 4", "other", "other"])


def test_ctrl_d_fills_each_range_from_its_own_first_row(grid: Shared) -> None:
    grid.go("F2")
    grid.press("Shift+ArrowDown")
    add(grid, "F5", "F6")
    grid.press("Control+d")
    becomes(lambda: notes(grid), ["note 2", "note 2", "note 4", "note 5", "note 5"])
    grid.press("Control+z")
    becomes(lambda: notes(grid), [f"note {n}" for n in range(2, 7)])


def test_ranges_of_the_same_rows_or_columns_are_copied_together(grid: Shared) -> None:
    grid.go("F5")
    add(grid, "F2")
    grid.press("Control+c")
    grid.status("2 cells copied.")
    becomes(lambda: clipboard(grid), "note 2\nnote 5\n")
    grid.go("E3")
    add(grid, "B3", "C3")
    grid.press("Control+c")
    becomes(lambda: clipboard(grid), "Red ball\tmap\tS3\n")
    add(grid, "F6")
    grid.press("Control+x")
    grid.status("Several selections can be copied together only if they are in the same rows or in the same columns.")
    becomes(lambda: (clipboard(grid), grid.text("F6")), ("Red ball\tmap\tS3\n", "note 6"))


def test_a_second_press_deselects_and_rows_are_deleted_together(grid: Shared) -> None:
    grid.go("F2")
    add(grid, "F4")
    add(grid, "F6")
    add(grid, "F4")
    becomes(lambda: selected(grid), ["F2", "F6"])
    add(grid, "F6")
    becomes(lambda: (selected(grid), grid.here), (["F2"], "F2"))
    head = grid.page.locator("th.number")
    head.nth(2).click()
    head.nth(4).click(modifiers=["Control"])
    grid.press("Control++")
    grid.status("Select one block of rows first.")
    grid.press("Control+-")
    becomes(lambda: notes(grid), ["note 2", "note 4", "note 6", "", ""])
    grid.press("Control+z")
    becomes(lambda: notes(grid), [f"note {n}" for n in range(2, 7)])


def test_further_ranges_are_selected_by_keys(grid: Shared) -> None:
    grid.go("F2")
    grid.press("Control+Shift+F8", "ArrowDown", "ArrowDown", "Shift+ArrowDown")
    becomes(lambda: selected(grid), ["F2", "F4", "F5"])
    expect(grid.page.locator("#counts")).to_have_text("5 rows · Add to selection · 3 cells selected")
    grid.press("Escape", "Delete")
    becomes(lambda: notes(grid), ["", "note 3", "", "", "note 6"])
    grid.press("ArrowDown")
    becomes(lambda: selected(grid), ["F6"])
