"""A name that is changed in the cell that gives it is changed in all cells that have it, as one step."""

from __future__ import annotations

from typing import Any

import pytest
from chromium import becomes, eventually
from grid_books import Books, Shared
from slow_answers import SlowAnswers

from rrp_sheets.workbook import read

HEADER = ["Input streams", "Connector", "Formula", "Output stream"]
ROWS = [
    ["Red ball", "map", "redBall.distance", "Distance"], ["Distance", "filter", "distance < limit", "Close"],
    ["Distance, Close", "combineLatest", "distance - close", "Both"], ["Both", "subscribe", "", "Talk"],
]  # fmt: skip
BOOK = {
    "T": [HEADER, *ROWS],
    "Devices": [["Stream", "Device", "Notes"], ["Talk", "Say", ""]],
    "Helpers": [["Name", "Inputs", "Formula"], ["limit", "", "0.5"]],
    "Test": [
        ["Time (ms)", "Stream", "Send", "Expect"],
        ["0", "Red ball", "distance=1", ""],
        ["0", "Distance", "", "1"],
    ],
}


def rows(grid: Shared) -> list[tuple[str, str, str, str]]:
    return [tuple(row) for row in grid.rows()]


def change(grid: Shared, address: str, text: str, key: str = "Enter") -> None:
    grid.go(address)
    grid.press("F2", "Control+a")
    grid.write(text, key)


@pytest.fixture
def grid(shelf: Books) -> Shared:
    opened = shelf.open(BOOK, sheet="T")
    opened.checked()
    return opened


def test_enter_renames_a_stream_everywhere_and_one_undo_takes_it_back(grid: Shared) -> None:
    before = grid.rows()
    change(grid, "D2", "Ball far")
    becomes(lambda: grid.page.inner_text("#status"), "“Distance” is now “Ball far” in 6 cells.")
    assert grid.rows() == [
        ("Red ball", "map", "redBall.distance", "Ball far"), ("Ball far", "filter", "ballFar < limit", "Close"),
        ("Ball far, Close", "combineLatest", "ballFar - close", "Both"), before[3],
    ]  # fmt: skip
    assert [row.stream.text for row in read(grid.path).workbook.tests[0].rows] == ["Red ball", "Ball far"]
    grid.expect("A3", "Ball far")
    grid.page.get_by_role("button", name="Undo", exact=True).last.click()
    eventually(lambda: grid.rows() == before)
    assert [row.stream.text for row in read(grid.path).workbook.tests[0].rows] == ["Red ball", "Distance"]


def test_what_is_typed_before_the_answer_goes_where_it_goes_after_it(grid: Shared) -> None:
    with SlowAnswers(grid.page) as late:
        change(grid, "D2", "Ball far")
        grid.press("ArrowLeft")
        grid.write("ballFar < 1")
        late.release()
    becomes(lambda: rows(grid)[1], ("Ball far", "filter", "ballFar < 1", "Close"))
    grid.expect("C3", "ballFar < 1")


def test_what_was_renamed_is_taken_back_by_its_buttons_only_while_it_is_the_newest_change(grid: Shared) -> None:
    change(grid, "D2", "Ball far")
    undo = grid.page.locator(".status-line").get_by_role("button", name="Undo")
    undo.wait_for()
    grid.go("C3")
    grid.write("ballFar < 2")
    grid.saved()
    undo.click()
    grid.page.get_by_text("You have changed something else since.").wait_for()
    becomes(lambda: rows(grid)[1], ("Ball far", "filter", "ballFar < 2", "Close"))


def test_only_this_cell_is_changed_when_that_is_wanted(grid: Shared) -> None:
    change(grid, "D2", "Ball far")
    grid.page.get_by_role("button", name="Only this cell").click()
    becomes(lambda: rows(grid)[:2], [(*ROWS[0][:3], "Ball far"), tuple(ROWS[1])])
    grid.press("Control+z")
    becomes(lambda: rows(grid)[0], tuple(ROWS[0]))
    change(grid, "D2", "Elsewhere", "Control+Enter")
    becomes(lambda: rows(grid)[:2], [(*ROWS[0][:3], "Elsewhere"), tuple(ROWS[1])])
    becomes(lambda: grid.here, "D3")


def test_a_name_that_is_taken_or_was_there_twice_is_changed_in_its_cell_only(grid: Shared) -> None:
    change(grid, "D2", "Close")
    becomes(lambda: rows(grid)[:2], [(*ROWS[0][:3], "Close"), tuple(ROWS[1])])
    change(grid, "D2", "Distance")
    # of two rows that give “Close” the other one is not renamed
    becomes(lambda: rows(grid)[:2], [tuple(row) for row in ROWS[:2]])


def test_what_a_row_sends_and_what_it_hears_are_no_names_of_its_own(grid: Shared) -> None:
    change(grid, "D5", "Print")
    change(grid, "A3", "Red ball")
    becomes(lambda: [row[3] for row in rows(grid)], ["Distance", "Close", "Both", "Print"])
    assert [row[0] for row in rows(grid)] == ["Red ball", "Red ball", "Distance, Close", "Both"]
    assert read(grid.path).workbook.devices[0].stream.text == "Talk"


@pytest.mark.parametrize(("sheet", "cell", "new", "changed"), [
    ("Devices", "A2", "Voice", (3, 3, "Voice")), ("Helpers", "A2", "nearest", (1, 2, "distance < nearest")),
])  # fmt: skip
def test_a_device_and_a_helper_are_renamed_in_the_rows(
    shelf: Books, sheet: str, cell: str, new: str, changed: tuple[int, int, Any]
) -> None:
    grid = shelf.open(BOOK, sheet=sheet)
    grid.checked()
    change(grid, cell, new)
    row, column, text = changed
    becomes(lambda: grid.rows()[row][column], text)
    grid.expect(cell, new)


def test_a_name_that_was_typed_over_is_used_everywhere_by_the_fix_of_the_first_row_without_it(grid: Shared) -> None:
    change(grid, "D2", "Ball far", "Control+Enter")
    grid.saved()
    grid.page.wait_for_selector("[data-fix=use-new-name]", state="attached")
    grid.go("A3")
    grid.press("Control+.", "Enter")
    becomes(
        lambda: [(row[0], row[2]) for row in rows(grid)],
        [
            ("Red ball", "redBall.distance"),
            ("Ball far", "ballFar < limit"),
            ("Ball far, Close", "ballFar - close"),
            ("Both", ""),
        ],
    )
