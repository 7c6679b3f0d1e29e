"""Empty states: what an empty sheet, and an empty list, say, and the button that does the next thing."""

from __future__ import annotations

from pathlib import Path

import pytest
from browser import get, post, visit
from chromium import eventually
from grid_books import EMPTY, HEADER, ROWS, TRACKING, Books
from playwright.sync_api import expect

from rrp_sheets.workbook import read
from rrp_sheets.workbook.files import make_workbook

SHEETS = {
    "T": [HEADER, [""] * 6],
    "Devices": [["Stream", "Device", "Notes"], [""] * 3],
    "Helpers": [["Name", "Inputs", "Formula", "Notes"], [""] * 4],
    "Scene": [["Time (s)", "Thing", "Does", "Value"], [""] * 4],
    "Test": [["Time (ms)", "Stream", "Send", "Expect"], [""] * 4],
}


def test_a_first_row_is_inserted_by_one_click_and_taken_back_by_one_undo(shelf: Books) -> None:
    grid = shelf.open(EMPTY)
    grid.checked()
    grid.page.get_by_role("button", name="Insert an example").click()
    grid.expect("B2", "Red ball")
    grid.expect("E2", "Head tracker")
    expect(grid.page.locator(".first-row")).to_have_count(0)
    expect(grid.page.locator("#diagram svg")).to_be_visible()
    assert grid.rows() == [("Red ball", "subscribe", "", "Head tracker")]
    grid.press("Control+z")
    expect(grid.page.locator(".first-row")).to_be_visible()
    eventually(lambda: grid.rows() == [])


@pytest.mark.parametrize(
    "sheet", ["Devices", *(pytest.param(n, marks=pytest.mark.slow) for n in SHEETS if n != "Devices")]
)
def test_the_example_of_each_kind_of_sheet_has_no_error(sheet: str, shelf: Books) -> None:
    grid = shelf.open(SHEETS, sheet=sheet)
    grid.checked()
    grid.page.get_by_role("button", name="Insert an example").click()
    expect(grid.page.locator(".first-row")).to_have_count(0)
    grid.saved()
    assert not read(grid.path).report.errors
    expect(grid.page.locator(".problems .is-error")).to_have_count(0)


def test_comments_alone_leave_a_sheet_empty(shelf: Books) -> None:
    grid = shelf.open({"T": [HEADER, ["# Notes", *[""] * 5], *[[""] * 6] * 3]})
    grid.page.get_by_role("button", name="Insert an example").click()
    grid.expect("B3", "Red ball")


def test_a_behaviour_without_a_test_offers_one(shelf: Books) -> None:
    grid = shelf.open(TRACKING)
    grid.page.get_by_role("button", name="Add a test").click()
    grid.page.get_by_role("dialog").get_by_role("button", name="Add", exact=True).click()
    grid.page.wait_for_selector("[role=grid].of-test")
    expect(grid.page.locator(".first-row")).to_contain_text("A row sends a value")


def test_lists_without_anything_say_the_next_step(tmp_path: Path) -> None:
    client = visit(tmp_path)
    assert "Create a first workbook" in get(client, "/").text
    assert "No recordings yet" in get(client, "/runs").text
    made = post(client, "/shelf/new", name="First workbook", template="guided")
    assert made.headers["HX-Redirect"] == "/book/First%20workbook.xlsx"
    assert "Save a first version" in get(client, "/book/First workbook.xlsx/versions").text
    assert "Go to the run panel" in get(client, "/runs?book=First workbook.xlsx").text


def test_a_sheet_with_rows_offers_no_example(tmp_path: Path) -> None:
    make_workbook({"T": [HEADER, *ROWS]}, tmp_path / "full.xlsx")
    assert "data-first-row" not in get(visit(tmp_path), "/book/full.xlsx").text
