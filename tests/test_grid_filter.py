"""The filter of the grid: rows by the values of a column, rows with problems; hidden rows stay as they are."""

from __future__ import annotations

from pathlib import Path

import pytest
from chromium import becomes, eventually
from grid_books import HEADER, Books, Shared
from grid_books import ROWS as TRACKED
from playwright.sync_api import expect

NOTES = ["red", "blue", "red", "", "Blue", "red"]
ROWS = [["", "Red ball", "map", "redBall.distance", f"S{number}", note] for number, note in enumerate(NOTES, 2)]
BROKEN = [TRACKED[0], ["", "Distance", "filter", "nobody < 0.5", "Close ball", "near"], TRACKED[2]]


@pytest.fixture
def grid(shelf: Books) -> Shared:
    opened = shelf.open({"T": [HEADER, *ROWS]})
    opened.checked()
    return opened


def choose(grid: Shared, column: str, *values: str) -> None:
    """Let the filter of a column show the rows with some values alone."""
    grid.page.get_by_role("button", name=f"Filter {column}").click()
    box = grid.page.get_by_role("dialog", name=f"Filter {column}")
    box.get_by_label("Select all").uncheck()
    for value in values:
        box.get_by_label(value, exact=False).check()
    box.get_by_role("button", name="Apply filter").click()
    expect(box).to_have_count(0)


def numbers(grid: Shared, count: int = 6) -> list[int]:
    """The numbers of the filled rows that are shown."""
    return [
        number
        for number in range(2, 2 + count)
        if grid.page.locator(f"tr[aria-rowindex='{number}']").evaluate("row => row.getClientRects().length > 0")
    ]


def notes(grid: Shared, count: int = 6) -> list[str]:
    return [grid.text(f"F{row}") for row in range(2, 2 + count)]


def test_the_values_of_a_column_choose_the_rows(grid: Shared) -> None:
    button = grid.page.get_by_role("button", name="Filter Notes")
    button.press("Alt+ArrowDown")
    box = grid.page.get_by_role("dialog", name="Filter Notes")
    expect(box.locator(".filter-values label")).to_have_text(["blue2", "red3", "(Blank)1"])
    box.get_by_label("red").uncheck()
    expect(box.get_by_label("Select all")).not_to_be_checked()
    box.get_by_label("(Blank)").uncheck()
    box.get_by_role("button", name="Apply filter").click()
    becomes(lambda: numbers(grid), [3, 6])
    expect(grid.page.locator("#counts")).to_have_text("2 of 6 rows shown")
    expect(grid.page.get_by_role("button", name="Filter Notes (now filtered)")).to_be_visible()
    assert grid.faults() == []
    choose(grid, "Output stream", "S6")
    becomes(lambda: numbers(grid), [6])
    grid.page.get_by_role("button", name="Show all").click()
    becomes(lambda: numbers(grid), [2, 3, 4, 5, 6, 7])
    expect(grid.page.locator("#counts")).to_have_text("6 rows")


def test_what_is_searched_for_is_what_the_filter_shows(grid: Shared) -> None:
    grid.go("E2")
    grid.press("Control+Shift+L")
    box = grid.page.get_by_role("dialog", name="Filter Output stream")
    expect(box.get_by_label("Search the values")).to_be_focused()
    grid.page.keyboard.type("nowhere")
    expect(box.get_by_role("button", name="Apply filter")).to_be_disabled()
    expect(box).to_contain_text("No value has this text.")
    box.get_by_label("Search the values").fill("s7")
    grid.press("Enter")
    becomes(lambda: numbers(grid), [7])
    expect(grid.page.locator("td.at")).to_be_focused()
    becomes(lambda: grid.here, "E7")
    grid.press("Control+Shift+L")
    assert grid.faults() == []
    grid.press("Escape")
    expect(box).to_have_count(0)
    becomes(lambda: numbers(grid), [7])


def test_keys_go_from_shown_row_to_shown_row(grid: Shared) -> None:
    grid.go("F3")
    choose(grid, "Notes", "red")
    becomes(lambda: grid.here, "F4")  # row 3, where the cursor was, is hidden
    grid.press("ArrowUp")
    becomes(lambda: grid.here, "F2")
    grid.press("ArrowUp")
    becomes(lambda: grid.here, "F2")
    grid.press("Enter", "Enter")
    becomes(lambda: grid.here, "F7")
    grid.press("Control+Home")
    becomes(lambda: grid.here, "A2")
    grid.press("Control+ArrowDown", "Control+End")
    becomes(lambda: grid.here, "F7")
    grid.press("Control+Home", "F8")
    becomes(lambda: grid.here, "E2")
    grid.press("F8")
    becomes(lambda: grid.here, "E4")


def test_edits_leave_hidden_rows_as_they_are(grid: Shared) -> None:
    choose(grid, "Notes", "red")
    grid.go("F2")
    grid.press("Control+Shift+ArrowDown", "Shift+ArrowUp", "Shift+ArrowDown")
    grid.page.keyboard.type("new")
    grid.press("Control+Enter")
    becomes(lambda: notes(grid), ["new", "blue", "new", "", "Blue", "new"])
    expect(grid.page.locator("#counts")).to_contain_text("3 of 6 rows shown")  # none goes while one works
    grid.press("Delete")
    becomes(lambda: notes(grid), ["", "blue", "", "", "Blue", ""])
    grid.press("Control+z", "Control+z")
    becomes(lambda: notes(grid), ["red", "blue", "red", "", "Blue", "red"])
    grid.go("E2")
    grid.page.evaluate("navigator.clipboard.writeText('A\\nB\\nC\\nD')")
    grid.press("Control+v")
    becomes(lambda: [grid.text(f"E{row}") for row in range(2, 9)], ["A", "S3", "B", "S5", "S6", "C", "D"])
    grid.go("F2")
    grid.press("Shift+ArrowDown", "Shift+ArrowDown", "Control+c")
    grid.status("3 cells copied.")
    becomes(lambda: grid.page.evaluate("navigator.clipboard.readText()"), "red\nred\nred\n")


def test_the_handle_fills_shown_rows_alone(grid: Shared) -> None:
    choose(grid, "Notes", "red")
    grid.go("E2")  # its warning hangs over the cells below
    grid.page.locator(".fill-handle").hover()
    grid.page.mouse.down()
    grid.cell("E4").hover(position={"x": 5, "y": 9}, force=True)
    grid.cell("E7").hover(position={"x": 5, "y": 9}, force=True)
    grid.page.mouse.up()
    becomes(lambda: [grid.text(f"E{row}") for row in range(2, 9)], ["S2", "S3", "S2", "S5", "S6", "S2", ""])
    grid.press("Control+z")
    becomes(lambda: [grid.text(f"E{row}") for row in range(2, 9)], ["S2", "S3", "S4", "S5", "S6", "S7", ""])


@pytest.mark.slow
def test_a_sheet_of_ones_own_is_filtered_too(shelf: Books) -> None:
    grid = shelf.open({"T": [HEADER, *ROWS], "Mine": [["a title"], ["x"], ["y"], ["x"]]}, sheet="Mine")
    grid.page.get_by_role("button", name="Filter A").click()
    grid.page.get_by_role("checkbox", name="x").uncheck()
    grid.page.get_by_role("button", name="Apply filter").click()
    expect(grid.page.locator("#counts")).to_have_text("2 of 4 rows shown")


@pytest.mark.slow
def test_rows_are_moved_and_deleted_around_hidden_ones(grid: Shared) -> None:
    choose(grid, "Notes", "red")
    grid.go("E7")
    grid.press("Alt+ArrowUp")
    becomes(lambda: [grid.text(f"E{row}") for row in range(2, 8)], ["S2", "S3", "S7", "S4", "S5", "S6"])
    grid.go("E2")
    grid.press("Alt+ArrowDown")
    becomes(lambda: [grid.text(f"E{row}") for row in range(2, 8)], ["S3", "S7", "S2", "S4", "S5", "S6"])
    grid.go("E3")
    grid.press("Shift+ArrowDown", "Shift+ArrowDown", "Control+-")
    becomes(lambda: [grid.text(f"E{row}") for row in range(2, 6)], ["S3", "S5", "S6", ""])
    grid.press("Control+z")
    becomes(lambda: [grid.text(f"E{row}") for row in range(2, 8)], ["S3", "S7", "S2", "S4", "S5", "S6"])


def test_a_filter_is_applied_again_when_that_is_asked_for(grid: Shared) -> None:
    choose(grid, "Notes", "red")
    again = grid.page.get_by_role("button", name="Apply again")
    expect(again).to_be_hidden()
    grid.go("F4")
    grid.write("green")
    becomes(lambda: numbers(grid), [2, 4, 7])
    expect(again).to_be_visible()
    grid.press("Control+Alt+l")
    becomes(lambda: numbers(grid), [2, 7])
    expect(again).to_be_hidden()
    grid.press("Control+z")  # what is undone is shown
    becomes(lambda: (numbers(grid), grid.text("F4")), ([2, 4, 7], "red"))


def test_rows_with_problems(shelf: Books) -> None:
    grid = shelf.open({"T": [HEADER, *BROKEN]})
    grid.checked()
    becomes(lambda: grid.page.locator("td.is-error").count(), 1)
    grid.page.get_by_role("button", name="Show only these").click()
    becomes(lambda: numbers(grid, 3), [3])
    expect(grid.page.get_by_role("button", name="Show only these")).to_be_hidden()
    grid.go("D3")
    grid.write("distance < 0.5")
    expect(grid.page.locator("#problem-steps")).to_be_hidden()
    becomes(lambda: numbers(grid, 3), [3])  # mended, and still there
    grid.press("Control+Alt+l")
    grid.status("No row matches this filter.")
    becomes(lambda: numbers(grid, 3), [3])
    grid.page.get_by_role("button", name="Show all").click()
    choose(grid, "Notes", "near")
    becomes(lambda: numbers(grid, 3), [3])


@pytest.mark.slow
def test_others_see_all_rows_and_their_new_rows_are_shown(shelf: Books) -> None:
    aya, mika = shelf.two()
    choose(aya, "Notes", "near")
    becomes(lambda: numbers(aya, 3), [3])
    becomes(lambda: numbers(mika, 3), [2, 3, 4])
    mika.go("F5")
    mika.write("far")
    becomes(lambda: aya.text("F5"), "far")
    becomes(lambda: numbers(aya, 4), [3, 5])
    mika.go("F2")
    mika.write("hidden from Aya")
    becomes(lambda: aya.text("F2"), "hidden from Aya")
    becomes(lambda: numbers(aya, 4), [3, 5])


@pytest.mark.slow
def test_a_long_sheet_is_filtered_at_once_and_as_a_whole(shelf: Books, tmp_path: Path) -> None:
    rows = [["", "Red ball", "map", "redBall.distance", f"S{n}", f"note {n % 50}"] for n in range(2, 5_002)]
    grid = shelf.open({"T": [HEADER, *rows]})
    choose(grid, "Notes", "note 7")  # perhaps while most rows are still on their way
    grid.page.wait_for_selector("body[data-ready]")
    expect(grid.page.locator("#counts")).to_have_text("100 of 5000 rows shown")
    eventually(lambda: grid.page.locator("#grid-scroll").evaluate("e => e.scrollHeight < 8000"))
    session = grid.page.context.new_cdp_session(grid.page)
    session.send(
        "Performance.enable", {"timeDomain": "threadTicks"}
    )  # time of the processor, whatever else it has to do

    def spent() -> float:
        found = {one["name"]: one["value"] for one in session.send("Performance.getMetrics")["metrics"]}
        return float(found["ScriptDuration"] + found["LayoutDuration"] + found["RecalcStyleDuration"])

    script = """() => {
        document.querySelector(".filter-box [type=submit]").click();
        document.getElementById("grid-scroll").getBoundingClientRect();
    }"""
    took = []
    for _ in range(3):
        grid.page.get_by_role("button", name="Show all").click()
        grid.page.get_by_role("button", name="Filter Output stream").click()
        grid.page.get_by_label("Search the values").fill("S12")
        before = spent()
        grid.page.evaluate(script)
        took.append(spent() - before)
    expect(grid.page.locator("#counts")).to_have_text("111 of 5000 rows shown")
    assert min(took) < 0.2, took
