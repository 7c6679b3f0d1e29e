"""A sheet of more than a thousand rows: all of it can be reached, read and changed, wherever its bodies begin."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from chromium import GridPage, becomes, eventually
from grid_books import HEADER

from rrp_sheets.workbook import read

COUNT = 1_300
NOTED = {f"T{number}": f"note {number}" for number in range(2, COUNT + 2)}
CHAIN = [["", "Red ball", "map", "redBall.distance", "S2", "note 2"]] + [
    ["", f"S{number - 1}", "map", f"value + {number}", f"S{number}", f"note {number}"] for number in range(3, COUNT + 2)
]
CHAIN[51 - 2][1] = "Nobody"  # row 51 is the last of the first body
BOOKS = {"long.xlsx": {"T": [HEADER, *CHAIN]}}
ROWS = "[...document.querySelectorAll('[role=grid] tbody > tr')]"


@pytest.fixture(scope="module")
def grid(browser: Any, url: str) -> Any:
    opened = GridPage(browser, url, "long.xlsx")
    opened.page.wait_for_selector("body[data-ready]")
    opened.page.wait_for_function("() => document.getElementById('panels').ariaBusy !== 'true'")
    yield opened
    opened.close()


def held(grid: GridPage, folder: Path) -> list[str]:
    """The notes from top to bottom: the same in the page, by the cells' numbers, and in the file."""
    grid.saved()
    eventually(
        lambda: grid.page.evaluate(
            f"{ROWS}.every((r, i) => r.cells[0].textContent === String(i + 2) && r.ariaRowIndex === String(i + 2))"
        )
    )
    eventually(
        lambda: grid.page.evaluate(
            "[...document.querySelectorAll('tbody')].every((b) => b.rows.length > 0 && b.rows.length <= 100)"
        )
    )

    def shown() -> list[str]:
        return list(grid.page.evaluate(f"{ROWS}.map((r) => r.querySelector('.notes').dataset.v ?? '')"))

    kept = {row.number: row.notes for row in read(folder / "long.xlsx").workbook.behaviours[0].rows}
    becomes(lambda: shown()[: max(kept) - 1], [kept.get(number, "") for number in range(2, max(kept) + 1)])
    eventually(lambda: not any(shown()[max(kept) - 1 :]))
    return shown()


@pytest.mark.slow
def test_all_rows_are_there_and_the_last_is_changed_as_the_first(grid: GridPage, folder: Path) -> None:
    assert held(grid, folder)[:COUNT] == list(NOTED.values())
    grid.go("F2")
    grid.press("Control+End")
    becomes(lambda: grid.here, f"F{COUNT + 1}")
    grid.write("the last")
    grid.press("Control+Home", "Control+ArrowDown", "Control+ArrowDown")
    assert held(grid, folder)[COUNT - 1] == "the last"


@pytest.mark.slow
def test_rows_move_across_the_bodies(grid: GridPage, folder: Path) -> None:
    grid.go("F51")
    grid.press("Alt+ArrowDown")
    grid.page.wait_for_function("() => document.querySelector('#formula-bar b').textContent === 'F52'")
    assert held(grid, folder)[48:52] == ["note 50", "note 52", "note 51", "note 53"]
    grid.press("Alt+ArrowUp")
    grid.page.wait_for_function("() => document.querySelector('#formula-bar b').textContent === 'F51'")
    assert held(grid, folder)[48:52] == ["note 50", "note 51", "note 52", "note 53"]


@pytest.mark.slow
def test_a_selection_grows_by_keys_across_the_bodies(grid: GridPage) -> None:
    grid.go("F45")
    grid.press(*["Shift+ArrowDown"] * 12)
    selected = grid.page.locator("td[aria-selected]")
    becomes(selected.count, 13)
    becomes(lambda: selected.last.evaluate("e => e.parentElement.cells[0].textContent"), "57")


@pytest.mark.slow
def test_many_rows_come_and_go(grid: GridPage, folder: Path) -> None:
    before = held(grid, folder)
    grid.go("F52")
    grid.cell("F202").click(modifiers=["Shift"])
    grid.press("Control+-")
    grid.page.wait_for_selector("#status:has-text('151 rows are deleted')")
    assert held(grid, folder) == before[:50] + before[201:]
    eventually(lambda: grid.page.evaluate("document.activeElement.closest('td') !== null"))
    grid.press("Control+z")
    grid.page.wait_for_selector("#status:has-text('are back')")
    assert held(grid, folder) == before
    eventually(lambda: grid.page.evaluate("document.activeElement.closest('td') !== null"))
    grid.press("Control+y")
    grid.page.wait_for_selector("#status:has-text('were deleted')")
    grid.press("Control+z")
    grid.page.wait_for_selector("#status:has-text('are back')")


def test_a_message_at_the_end_of_a_body_is_seen_whole(grid: GridPage) -> None:
    grid.go("B51")
    message = grid.page.locator("td.at .mend").first
    message.wait_for()
    seen = """e => { const box = e.getBoundingClientRect();
      return [box.top + 2, box.bottom - 2].every((y) => e.contains(document.elementFromPoint(box.left + 8, y))); }"""
    eventually(lambda: message.evaluate(seen))
