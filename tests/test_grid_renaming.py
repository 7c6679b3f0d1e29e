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
    becomes(lambda: grid.page.inner_text("#status"), "“Distance” is now “Ball far” in 4 rows.")
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
    ("Devices", "A2", "Voice", (3, 3, "Voice")),
    pytest.param("Helpers", "A2", "nearest", (1, 2, "distance < nearest"), marks=pytest.mark.slow),
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


# ---- offered, and looked at first


def offered(grid: Shared) -> list[str]:
    return [text.split("\n")[0] for text in grid.page.locator(".editor .choice").all_inner_texts()]


def begin(grid: Shared, address: str, text: str) -> None:
    """Type a text over that of a cell, and stay in it."""
    grid.go(address)
    grid.press("F2", "Control+a")
    grid.page.keyboard.insert_text(text)


def cell(grid: Shared, address: str) -> Any:
    column, row = address[0], address[1:]
    at = grid.page.locator(f"th[data-letter={column}]").evaluate("head => head.cellIndex")
    return grid.page.locator(f"tr[aria-rowindex='{row}'] > *").nth(at)


def listed(grid: Shared) -> list[str]:
    return [" ".join(text.split()) for text in grid.page.locator(".renaming li").all_inner_texts()]


def test_the_editor_says_what_enter_does_with_a_changed_name_only_where_it_is_used(grid: Shared) -> None:
    begin(grid, "D2", "Ball far")
    three = ["Rename, also in 2 rows that use it", "Change this cell only", "Show the cells first"]
    becomes(lambda: offered(grid), three)
    grid.press("Control+a")
    grid.page.keyboard.insert_text("distance")  # the same name
    becomes(lambda: offered(grid), [])
    grid.press("Escape", "Escape")
    begin(grid, "A4", "Ball far, Close")
    becomes(lambda: offered(grid), ["Change this cell only", "Rename “Distance” in all cells"])
    grid.press("Control+a")
    grid.page.keyboard.insert_text("Both, Close")  # another stream
    becomes(lambda: offered(grid), [])
    grid.press("Escape", "Escape", "Escape")
    begin(grid, "D4", "All")
    becomes(lambda: offered(grid)[:1], ["Rename, also in the row that uses it"])
    grid.press("Escape")
    begin(grid, "D5", "Print")  # an actuator
    becomes(lambda: offered(grid), ["Change this cell only", "Rename “Talk” in all cells"])
    grid.page.get_by_role("button", name="Change this cell only").click()
    becomes(lambda: grid.rows()[3][3], "Print")
    begin(grid, "D5", "Talk")
    becomes(lambda: offered(grid), [])


def outlined(grid: Shared) -> list[str]:
    """The addresses of the outlined cells, and the names of the outlined tabs."""
    return list(grid.page.evaluate(
        """() => [...document.querySelectorAll(".will-change")].map((one) => one.dataset.sheet ?? (one.matches("th")
            ? `${one.dataset.letter}1` : `${one.closest("table").tHead.rows[0].cells[one.cellIndex].dataset.letter}${one.parentElement.cells[0].textContent}`)).sort()"""
    ))  # fmt: skip


def test_the_places_of_a_name_are_outlined_while_its_change_is_offered_or_asked(grid: Shared) -> None:
    places = ["A3", "A4", "C3", "C4", "D2", "Test"]
    begin(grid, "D2", "Ball far")
    becomes(lambda: outlined(grid), places)
    grid.page.keyboard.insert_text("ther")
    becomes(lambda: offered(grid)[0], "Rename, also in 2 rows that use it")
    assert outlined(grid) == places
    grid.press("Control+a")
    grid.page.keyboard.insert_text("distance")  # the same name
    becomes(lambda: outlined(grid), [])
    grid.page.keyboard.insert_text(" 2")
    becomes(lambda: outlined(grid), places)
    grid.press("Control+Shift+Enter")
    grid.page.locator(".renaming li").first.wait_for()
    becomes(lambda: outlined(grid), places)
    grid.page.get_by_label("New name").fill("Close")  # a name that is taken
    becomes(lambda: outlined(grid), [])
    grid.page.get_by_label("New name").fill("Near")
    becomes(lambda: outlined(grid), places)
    grid.press("Escape")  # back to the text, where it is offered again
    grid.page.locator(".editor textarea").wait_for()
    becomes(lambda: outlined(grid), places)
    grid.press("Enter")
    becomes(lambda: grid.page.inner_text("#status"), "“Distance” is now “distance 2” in 4 rows.")
    becomes(lambda: outlined(grid), [])


def test_the_cells_can_be_looked_at_before_they_change(grid: Shared) -> None:
    before = grid.rows()
    begin(grid, "D2", "Ball far")
    becomes(lambda: len(offered(grid)), 3)
    grid.press("Control+Shift+Enter")
    cells = [
        "D2 Distance Ball far", "A3 Distance Ball far", "C3 distance < limit ballFar < limit",
        "A4 Distance, Close Ball far, Close", "C4 distance - close ballFar - close", "B3 Distance Ball far",
    ]  # fmt: skip
    becomes(lambda: listed(grid), cells)
    becomes(lambda: grid.page.locator(".renaming h3").all_inner_texts(), ["T", "Test"])
    grid.press("Escape")  # back to the text
    becomes(lambda: grid.page.locator(".editor textarea").input_value(), "Ball far")
    assert grid.rows() == before
    grid.press("Control+Shift+Enter")
    becomes(lambda: listed(grid), cells)
    grid.page.get_by_label("New name").fill("Close")
    becomes(lambda: grid.page.inner_text(".renaming .told"), "A stream is already called “Close”. Choose another name.")
    grid.press("Enter")  # does nothing
    grid.page.get_by_label("New name").fill("How far")
    grid.press("Enter")
    becomes(lambda: grid.page.inner_text("#status"), "“Distance” is now “How far” in 4 rows.")
    assert [row[0] for row in grid.rows()] == ["Red ball", "How far", "How far, Close", "Both"]
    grid.press("Control+z")
    becomes(grid.rows, before)


def test_the_menu_renames_one_of_the_streams_that_a_row_hears(grid: Shared) -> None:
    cell(grid, "A4").click(button="right")
    grid.page.get_by_role("menuitem", name="Rename everywhere").click()
    grid.page.locator(".renaming select").select_option("Close")
    becomes(lambda: grid.page.get_by_label("New name").input_value(), "Close")
    grid.page.get_by_label("New name").fill("Near")
    becomes(lambda: len(listed(grid)), 3)
    grid.press("Enter")
    becomes(lambda: [row[0] for row in rows(grid)][2], "Distance, Near")
    assert (rows(grid)[1][3], rows(grid)[2][2]) == ("Near", "distance - near")
    cell(grid, "B4").click(button="right")
    grid.page.get_by_role("menuitem", name="Copy").wait_for()
    becomes(lambda: grid.page.get_by_role("menuitem", name="Rename everywhere").count(), 0)


@pytest.mark.slow
def test_a_stream_that_a_test_names_is_renamed_from_there(shelf: Books) -> None:
    grid = shelf.open({**BOOK, "Two": [HEADER, ["Red ball", "map", "1", "Distance"]]}, sheet="Two")
    grid.checked()
    change(grid, "D2", "Other")
    becomes(lambda: read(grid.path).workbook.behaviours[1].rows[0].output.text, "Other")
    assert read(grid.path).workbook.behaviours[0].rows[0].output.text == "Distance"
    grid = shelf.open(path=grid.path, sheet="T")
    grid.checked()
    begin(grid, "A4", "Ball far, Close")
    becomes(lambda: len(offered(grid)), 2)
    grid.press("Control+Shift+Enter")
    becomes(lambda: len(listed(grid)), 6)
    grid.press("Enter")
    becomes(lambda: rows(grid)[2], ("Ball far, Close", "combineLatest", "ballFar - close", "Both"))
    assert rows(grid)[0][3] == "Ball far"


def test_what_is_offered_stays_in_sight_on_a_phone(grid: Shared) -> None:
    grid.page.set_viewport_size({"width": 400, "height": 800})
    begin(grid, "D2", "Ball far")
    becomes(lambda: len(offered(grid)), 3)
    box = grid.page.locator(".editor .signature")
    eventually(lambda: (at := box.bounding_box())["x"] >= 0 and at["x"] + at["width"] <= 400)
    grid.page.set_viewport_size({"width": 1280, "height": 900})
