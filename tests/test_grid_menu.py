"""The menu of cells and rows, filling, finding, and the line below the sheet."""

from __future__ import annotations

import pytest
from chromium import becomes, eventually, some
from grid_books import HEADER, Books, Shared

ROWS = [
    ["", "Red ball", "map", "redBall.distance", "Dist 2", "a note"], ["", "Dist 2", "filter", "dist2 < 1", "Close", ""],
    ["", "Close", "subscribe", "", "Nobody", ""],
]  # fmt: skip


@pytest.fixture
def grid(shelf: Books) -> Shared:
    opened = shelf.open({"T": [HEADER, *ROWS]})
    opened.checked()
    return opened


def do(grid: Shared, address: str, name: str, row: bool = False) -> None:
    """Press an item of the menu of a cell, or of the head of its row."""
    column = grid.page.locator(f"th[data-letter={address[0]}]").evaluate("head => head.cellIndex")
    cells = grid.page.locator(f"tr[aria-rowindex='{address[1:]}'] > *")
    cells.nth(0 if row else column).click(button="right")
    grid.page.get_by_role("menuitem", name=name, exact=False).click()


def column(grid: Shared, letter: str, count: int = 4) -> list[str]:
    return [grid.text(f"{letter}{row}") for row in range(2, 2 + count)]


def test_the_menu_of_a_cell_copies_cuts_pastes_and_clears(grid: Shared) -> None:
    do(grid, "F2", "Copy")
    do(grid, "F4", "Paste")
    becomes(lambda: column(grid, "F", 3), ["a note", "", "a note"])
    do(grid, "F2", "Cut")
    becomes(lambda: column(grid, "F", 3), ["", "", "a note"])
    do(grid, "F4", "Clear")
    becomes(lambda: column(grid, "F", 3), ["", "", ""])
    do(grid, "F3", "Paste")
    becomes(lambda: column(grid, "F", 3), ["", "a note", ""])
    grid.saved()


def test_the_menu_of_a_row_takes_the_whole_row(grid: Shared) -> None:
    do(grid, "A2", "Copy", row=True)
    do(grid, "A5", "Paste", row=True)
    becomes(lambda: (grid.text("B5"), grid.text("F5")), ("Red ball", "a note"))
    do(grid, "A2", "Delete rows", row=True)
    becomes(lambda: column(grid, "F"), ["", "", "a note", ""])


def test_the_menu_is_of_the_cell_that_was_pressed_unless_it_is_selected(grid: Shared) -> None:
    grid.go("B2")
    grid.press("Shift+ArrowDown", "Shift+ArrowRight")
    do(grid, "C3", "Copy")
    do(grid, "B5", "Paste")
    becomes(lambda: [grid.text(a) for a in ("B5", "C5", "B6", "C6")], ["Red ball", "map", "Dist 2", "filter"])
    do(grid, "F2", "Copy")
    becomes(lambda: grid.page.inner_text("#status"), "One cell copied.")


def test_a_column_is_made_as_wide_as_its_texts(grid: Shared) -> None:
    grid.go("F2")
    grid.write("a note that is longer than the column is wide, in one line of it")
    do(grid, "F2", "Fit column width")
    grid.status("Notes is now as wide as its longest text.")
    becomes(lambda: grid.page.locator("th[data-letter=F]").bounding_box()["width"] > 300, True)
    grid.page.locator("th[data-letter=D] .widen").dblclick(force=True)
    grid.status("Formula is now as wide as its longest text.")


def test_what_is_filled_comes_from_above_from_the_left_or_from_what_is_typed(grid: Shared) -> None:
    grid.go("F3")
    grid.press("Control+d")
    becomes(lambda: column(grid, "F"), ["a note", "a note", "", ""])
    grid.go("E4")
    grid.press("Shift+ArrowRight", "Control+r")
    becomes(lambda: grid.text("F4"), "Nobody")
    grid.go("F5")
    grid.press("Control+r")  # from E5, which is blank: nothing to be done
    grid.go("F2")
    grid.press("Shift+ArrowDown", "Shift+ArrowDown")
    grid.page.keyboard.type("all")
    grid.press("Control+Enter")
    becomes(lambda: column(grid, "F"), ["all", "all", "all", ""])
    becomes(lambda: grid.page.locator("td[aria-selected]").count(), 3)
    grid.press("Control+z")
    becomes(lambda: column(grid, "F"), ["a note", "a note", "Nobody", ""])
    grid.go("F2")
    grid.press("Control+d", "ArrowUp")  # there is a header above it
    becomes(lambda: grid.text("F2"), "a note")


def head(grid: Shared, row: int) -> tuple[float, float]:
    """The middle of the head of a row on the screen."""
    box = some(grid.page.locator(f"tr[aria-rowindex='{row}'] > th").bounding_box)
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def test_rows_are_selected_and_moved_by_dragging_their_heads(grid: Shared) -> None:
    mouse = grid.page.mouse
    mouse.move(*head(grid, 2))
    mouse.down()
    mouse.move(*head(grid, 3), steps=4)
    mouse.up()
    becomes(lambda: grid.page.locator("td[aria-selected]").count(), 12)
    mouse.move(*head(grid, 2))
    mouse.down()
    mouse.move(*head(grid, 5), steps=6)
    becomes(lambda: grid.page.locator("tr.drop-above").get_attribute("aria-rowindex"), "5")
    mouse.up()
    becomes(lambda: column(grid, "B"), ["Close", "Red ball", "Dist 2", ""])
    grid.press("Control+z")
    becomes(lambda: column(grid, "B"), ["Red ball", "Dist 2", "Close", ""])
    mouse.move(*head(grid, 3))  # a click on a head of several selected ones selects its row
    mouse.down()
    mouse.up()
    becomes(lambda: grid.page.locator("td[aria-selected]").count(), 6)
    becomes(lambda: grid.here, "A3")


def found(grid: Shared) -> list[str]:
    return [text.split()[0] for text in grid.page.locator("#found .hit").all_inner_texts()]


def test_found_cells_are_listed_by_letters_whole_cells_or_names(grid: Shared) -> None:
    grid.press("Control+f")
    field = grid.page.locator("#find-bar [name=find]")
    field.fill("dist2")
    becomes(lambda: found(grid), ["D3"])
    grid.page.get_by_label("Stream name").check()
    becomes(lambda: found(grid), ["E2", "B3", "D3"])
    grid.page.get_by_role("button", name="Replace all").click()
    becomes(
        lambda: grid.page.inner_text("#status"), "To change a name, use “Rename everywhere” in the menu of its cell."
    )
    grid.page.get_by_label("Stream name").uncheck()
    field.fill("CLOSE")
    becomes(lambda: found(grid), ["E3", "B4"])
    grid.page.get_by_label("Match case").check()
    becomes(lambda: found(grid), [])
    field.fill("note")
    becomes(lambda: found(grid), ["F2"])
    grid.page.get_by_label("Whole cell").check()
    becomes(lambda: found(grid), [])
    field.fill("a note")
    becomes(lambda: found(grid), ["F2"])
    grid.page.locator("#found .hit").click()
    becomes(lambda: grid.here, "F2")
    grid.page.locator("#find-bar [name=by]").fill("another")
    grid.page.get_by_role("button", name="Replace", exact=True).click()
    becomes(lambda: grid.text("F2"), "another")
    becomes(lambda: found(grid), [])
    field.press("Escape")
    becomes(lambda: grid.page.locator("#find-bar").is_visible(), False)
    becomes(lambda: grid.page.locator("#found").is_visible(), False)


def test_the_line_below_the_sheet_counts_and_leads_to_the_problems(grid: Shared) -> None:
    becomes(lambda: grid.page.inner_text("#counts"), "3 rows")
    grid.go("B2")
    grid.press("Shift+ArrowDown", "Shift+ArrowRight")
    becomes(lambda: grid.page.inner_text("#counts"), "3 rows · 4 cells selected")
    eventually(lambda: grid.page.inner_text("#problem-steps span") == "1 cell with problems")
    grid.press("F8")
    becomes(lambda: grid.here, "E4")
    grid.go("D5")
    grid.type("(")
    becomes(lambda: grid.page.inner_text("#counts"), "4 rows")
    eventually(lambda: grid.page.inner_text("#problem-steps span")[0] > "1")
    grid.go("A2")
    grid.press("Shift+F8")  # from the first to the last
    eventually(lambda: grid.here[1:] == "5")
    grid.press("F8")
    becomes(lambda: grid.here, "E4")
    grid.page.get_by_role("button", name="Previous").click()
    eventually(lambda: grid.here[1:] == "5")


def test_the_steps_from_problem_to_problem_go_through_the_errors_first(shelf: Books) -> None:
    lines = [("Red ball", "sample", "3", "A"), ("A", "map", "(1", "B"), ("B", "subscribe", "", "Print"), ("",) * 4,
             ("A", "map", "2)", "C"), ("C", "subscribe", "", "Print")]  # fmt: skip
    grid = shelf.open({"T": [HEADER, *(["", *line, ""] for line in lines)]})
    grid.checked()
    becomes(lambda: grid.page.inner_text("#counts"), "5 rows")  # the blank one is none
    told = "#problem-steps span"
    becomes(lambda: grid.page.inner_text(told), "3 cells with problems")
    grid.go("A2")
    steps = [("D3", "Error 1 of 2"), ("D6", "Error 2 of 2"), ("D2", "Warning 1 of 1")]
    for place, text in [*steps, steps[0]]:
        grid.press("F8")
        becomes(lambda: (grid.here, grid.page.inner_text(told)), (place, text))
    for place, text in [steps[2], steps[1]]:
        grid.press("Shift+F8")
        becomes(lambda: (grid.here, grid.page.inner_text(told)), (place, text))
    grid.go("A4")
    becomes(lambda: grid.page.inner_text(told), "3 cells with problems")
    grid.press("Shift+F8")
    becomes(lambda: grid.here, "D3")


def test_a_row_and_its_sentence_show_each_other(grid: Shared) -> None:
    words = grid.page.locator("#row-words > [data-number]")
    becomes(lambda: [int(n) for n in words.evaluate_all("all => all.map((one) => one.dataset.number)")], [2, 3])
    grid.go("C3")
    becomes(lambda: grid.page.locator("#row-words .here").get_attribute("data-number"), "3")
    grid.page.locator("tr[aria-rowindex='2'] td").nth(2).hover()
    becomes(lambda: grid.page.locator("#row-words .pointed").get_attribute("data-number"), "2")
    words.nth(1).hover()
    becomes(lambda: grid.page.locator("tr.pointed").get_attribute("aria-rowindex"), "3")
    words.nth(0).locator("a").click()
    eventually(lambda: grid.here[1:] == "2")
