"""Columns of a table renamed in the grid: header, formulas that read it, undo, others' pages."""

from __future__ import annotations

import openpyxl
import pytest
from chromium import becomes
from grid_books import Books, Shared
from playwright.sync_api import expect

from rrp_sheets.workbook import read

HEADER = ["Input streams", "Connector", "Formula", "Output stream"]
BOOK = {
    "T": [
        HEADER, ["Red ball", "map", "INDEX(Parts; 1).zone", "Where"],
        ["Red ball", "map", "zoneOf(PICK(Parts))", "What"], ["Where", "map", "where + SUM(Parts[Zone])", "All"],
    ],
    "Helpers": [["Name", "Inputs", "Formula"], ["zone of", "row", "row.zone"]],
    "Parts": [["Ask", "Zone"], ["Where is my head?", "1"], ["And my hand?", "2"]],
}  # fmt: skip


@pytest.fixture
def grid(shelf: Books) -> Shared:
    opened = shelf.open(BOOK, sheet="Parts")
    opened.checked()
    return opened


def formulas(grid: Shared) -> list[str]:
    grid.saved()
    book = read(grid.path).workbook
    return [*(r.formula.text for r in book.behaviours[0].rows), *(h.formula.text for h in book.helpers)]


def header(grid: Shared) -> object:
    grid.saved()
    return openpyxl.load_workbook(grid.path)["Parts"]["B1"].value


def heads(grid: Shared) -> list[str]:
    return list(grid.page.locator("thead th[data-c] .title").all_inner_texts())


def test_a_column_is_renamed_where_it_certainly_is_read_and_where_that_is_ticked(grid: Shared) -> None:
    before = formulas(grid)
    grid.page.locator("thead th[data-letter=B] .title").dblclick()
    field = grid.page.get_by_label("New name")
    expect(field).to_have_value("Zone")
    field.fill("Touch zone")
    rows = grid.page.locator(".renaming li")
    becomes(lambda: [" ".join(text.split()) for text in rows.all_inner_texts()], [
        "B1 Zone Touch zone", "C2 INDEX(Parts; 1).zone INDEX(Parts; 1).touchZone",
        "C4 where + SUM(Parts[Zone]) where + SUM(Parts[Touch zone])", "Helpers C2 row.zone row.touchZone",
    ])  # fmt: skip
    outlined = grid.page.locator("thead th.will-change, #tabs .will-change")
    expect(outlined).to_have_text(["BZone", "T"])
    grid.page.locator(".renaming input[type=checkbox]").check()
    expect(outlined).to_have_text(["BZone", "T", "Helpers"])
    grid.page.get_by_role("button", name="Rename", exact=True).click()
    grid.status("The column “Zone” is now “Touch zone”, also in 3 rows that read it.")
    expect(outlined).to_have_count(0)
    wanted = ["INDEX(Parts; 1).touchZone", before[1], "where + SUM(Parts[Touch zone])", "row.touchZone"]
    becomes(lambda: (header(grid), formulas(grid)), ("Touch zone", wanted))
    becomes(lambda: heads(grid), ["Ask", "Touch zone"])
    grid.go("B2")
    grid.press("Control+z")
    becomes(lambda: (header(grid), formulas(grid)), ("Zone", before))
    becomes(lambda: heads(grid), ["Ask", "Zone"])
    grid.status("the column is “Zone” again")


def test_by_keys_and_without_the_uncertain_places(grid: Shared) -> None:
    before = formulas(grid)
    grid.page.locator("thead th[data-letter=A]").focus()
    grid.page.keyboard.press("ArrowRight")
    grid.page.keyboard.press("F2")
    expect(grid.page.get_by_label("New name")).to_be_focused()
    grid.page.keyboard.insert_text("Number")
    grid.page.keyboard.press("Enter")
    becomes(lambda: header(grid), "Number")
    wanted = ["INDEX(Parts; 1).number", before[1], "where + SUM(Parts[Number])", before[3]]
    becomes(lambda: formulas(grid), wanted)
    grid.write("3")  # the grid has the focus again
    grid.saved()


def test_a_name_that_another_column_has_is_refused(grid: Shared) -> None:
    grid.go("B2")
    grid.page.locator("td:focus").click(button="right")
    grid.page.get_by_role("menuitem", name="Rename column …").click()
    grid.page.get_by_label("New name").fill("ask")
    expect(grid.page.locator(".renaming .told")).to_have_text(
        "The table has a column “ask” already. Choose another name."
    )
    grid.page.keyboard.press("Enter")
    grid.press("Escape")
    becomes(lambda: header(grid), "Zone")


@pytest.mark.slow
def test_others_see_the_new_header_at_once(shelf: Books) -> None:
    path = shelf.file(BOOK)
    aya, mika = (shelf.open(path=path, sheet="Parts", name=name) for name in ("Aya", "Mika"))
    aya.checked()
    aya.go("B2")
    aya.page.locator("td:focus").click(button="right")
    aya.page.get_by_role("menuitem", name="Rename column …").click()
    aya.page.get_by_label("New name").fill("Number")
    aya.page.get_by_role("button", name="Rename", exact=True).click()
    becomes(lambda: heads(mika), ["Ask", "Number"])
    mika.go("B2")
    mika.write("7")
    becomes(lambda: openpyxl.load_workbook(path)["Parts"]["B2"].value, "7")


@pytest.mark.slow
def test_a_behaviour_has_no_columns_to_rename(shelf: Books) -> None:
    grid = shelf.open(BOOK, sheet="T")
    grid.go("C2")
    grid.page.locator("td:focus").click(button="right")
    expect(grid.page.get_by_role("menuitem", name="Copy")).to_be_visible()
    expect(grid.page.get_by_role("menuitem", name="Rename column …")).to_have_count(0)
