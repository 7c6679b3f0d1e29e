"""Bold, fills and wrapping of cells in the grid, as the file has them and as people set them."""

from __future__ import annotations

from typing import Any

import openpyxl
import pytest
from chromium import becomes, violations_by_look
from grid_books import Books, Shared
from playwright.sync_api import expect


@pytest.fixture
def grid(shelf: Books) -> Shared:
    opened = shelf.open()
    opened.checked()
    return opened


def cell(grid: Shared, address: str) -> Any:
    """The cell as openpyxl reads it."""
    grid.saved()
    return openpyxl.load_workbook(grid.path)["T"][address]


def classes(grid: Shared, name: str) -> list[str]:
    """Addresses of the cells with a class."""
    script = """(name) => [...document.querySelectorAll(`td.${name}`)].map((cell) =>
        cell.closest("table").tHead.rows[0].cells[cell.cellIndex].dataset.letter + cell.parentElement.cells[0].textContent)"""
    return list(grid.page.evaluate(script, name))


def fill(grid: Shared, name: str) -> None:
    grid.page.locator("td[aria-selected=true], td:focus").first.click(button="right")
    grid.page.get_by_role("menuitem", name="Fill colour …").click()
    grid.page.get_by_role("menuitem", name=name, exact=True).click()


def test_bold_is_set_and_taken_from_all_selected_cells_and_undone(grid: Shared) -> None:
    grid.go("B2")
    grid.press("Shift+ArrowDown", "Control+b")
    becomes(lambda: classes(grid, "bold"), ["B2", "B3"])
    becomes(lambda: [cell(grid, a).font.b for a in ("B2", "B3", "B4")], [True, True, False])
    grid.go("B3")
    grid.press("Control+b")
    becomes(lambda: classes(grid, "bold"), ["B2"])
    grid.go("B2")
    grid.press("Shift+ArrowDown", "Control+b")  # one of them has it: both get it
    becomes(lambda: classes(grid, "bold"), ["B2", "B3"])
    grid.press("Control+z")
    becomes(lambda: classes(grid, "bold"), ["B2"])
    grid.status("Undone: format of 2 cells from B2 on.")
    grid.press("Control+z", "Control+z")
    becomes(lambda: classes(grid, "bold"), [])
    becomes(lambda: cell(grid, "B2").font.b, False)


def test_fills_are_chosen_by_name_and_all_else_of_the_format_stays(grid: Shared) -> None:
    before = cell(grid, "D3")
    grid.go("D3")
    fill(grid, "Green")
    becomes(lambda: classes(grid, "tint-green"), ["D3"])
    after = cell(grid, "D3")
    assert (after.fill.patternType, after.fill.fgColor.rgb) == ("solid", "FFE2EFDA")
    assert (after.number_format, after.font.name, after.alignment.wrap_text) == (
        before.number_format, before.font.name, before.alignment.wrap_text,
    )  # fmt: skip
    assert after.value == before.value
    fill(grid, "No fill")
    becomes(lambda: classes(grid, "tint-green"), [])
    becomes(lambda: cell(grid, "D3").fill.patternType, None)


def test_a_text_is_cut_where_wrapping_is_taken_away(grid: Shared) -> None:
    grid.go("F3")
    grid.write("a long note " * 12)
    grid.go("F3")
    tall = grid.page.locator("td.notes").nth(1)
    becomes(lambda: tall.bounding_box()["height"] > 50, True)
    grid.page.locator("td:focus").click(button="right")
    grid.page.get_by_role("menuitem", name="Wrap text").click()
    becomes(lambda: classes(grid, "unwrapped"), ["F3"])
    becomes(lambda: cell(grid, "F3").alignment.wrap_text, False)
    grid.go("A2")
    becomes(lambda: tall.bounding_box()["height"] < 50, True)
    grid.press("Control+z")
    becomes(lambda: classes(grid, "unwrapped"), [])


def test_looks_of_the_file_are_shown_and_go_with_rows(shelf: Books) -> None:
    path = shelf.file()
    book = openpyxl.load_workbook(path)
    book["T"]["B2"].font = openpyxl.styles.Font(bold=True)
    book["T"]["C3"].fill = openpyxl.styles.PatternFill("solid", fgColor="FFFF00")
    book["T"]["D3"].fill = openpyxl.styles.PatternFill("solid", fgColor=openpyxl.styles.colors.Color(theme=4, tint=0.6))
    book.save(path)
    grid = shelf.open(path=path)
    grid.checked()
    becomes(lambda: [classes(grid, name) for name in ("bold", "tint-yellow", "tint-blue")], [["B2"], ["C3"], ["D3"]])
    grid.go("B3")
    grid.press("Alt+ArrowUp")
    becomes(lambda: [classes(grid, name) for name in ("bold", "tint-yellow")], [["B3"], ["C2"]])
    grid.press("Control+-")
    becomes(lambda: [classes(grid, name) for name in ("bold", "tint-yellow")], [["B2"], []])
    grid.press("Control+z")
    becomes(lambda: [classes(grid, name) for name in ("bold", "tint-yellow", "tint-blue")], [["B3"], ["C2"], ["D2"]])
    becomes(lambda: (cell(grid, "C2").fill.fgColor.rgb, cell(grid, "B3").font.b), ("FFFFFF00", True))
    grid.go("B4")
    grid.press("Control++")  # looks like the row above
    becomes(lambda: classes(grid, "bold"), ["B3", "B4"])
    becomes(lambda: cell(grid, "B4").font.b, True)


def test_others_see_a_look_at_once_and_a_typed_text_keeps_it(shelf: Books) -> None:
    aya, mika = shelf.two()
    aya.checked()
    aya.go("F3")
    aya.press("Control+b")
    becomes(lambda: classes(mika, "bold"), ["F3"])
    mika.go("F3")
    mika.write("another note")
    becomes(lambda: cell(aya, "F3").value, "another note")
    assert cell(aya, "F3").font.b
    becomes(lambda: (classes(aya, "bold"), aya.text("F3")), (["F3"], "another note"))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["Yellow", "Green", "Blue", "Red", "Purple", "Grey"])
def test_every_text_is_read_on_every_fill(grid: Shared, name: str) -> None:
    grid.go("A2")
    grid.press("Control+a")
    fill(grid, name)
    becomes(lambda: len(classes(grid, f"tint-{name.lower()}")) > 18, True)
    grid.go("A2")
    grid.saved()
    expect(grid.page.locator("#status")).not_to_contain_text("not")
    assert violations_by_look(grid.page, [("light", 1280), ("dark", 1280)], without=[".diagram"]) == {}
