"""Finding and replacing in all sheets of a workbook."""

from __future__ import annotations

from typing import Any

import pytest
from chromium import becomes, listening, until
from grid_books import HEADER, Books, Shared
from playwright.sync_api import expect

from rrp_sheets.workbook import read

DISTANCE = "redBall.distance"
SHEETS = {
    "First": [HEADER, ["", "Red ball", "map", DISTANCE, "Dist", "a red note"], ["", "Dist", "filter", "dist < 1", "Close", "blue"]],
    "Second": [HEADER, ["", "Red ball", "map", DISTANCE, "Far", "RED"], ["", "Red ball", "map", "redBall.yaw", "Yaw", ""]],
    "Devices": [["Stream", "Device", "Notes"], ["Gaze", "Head yaw", "red again"]],
}  # fmt: skip


@pytest.fixture
def grid(shelf: Books) -> Shared:
    opened = shelf.open(SHEETS, sheet="First")
    opened.checked()
    return opened


def search(grid: Shared, text: str, scope: str = "All sheets") -> None:
    grid.press("Control+f")
    grid.page.locator("#find-bar [name=find]").fill(text)
    grid.page.locator("#find-bar [name=scope]").select_option(scope)


def hits(grid: Shared) -> list[str]:
    return [str(text).strip() for text in grid.page.locator("#found li").all_inner_texts()]


def notes(grid: Shared) -> dict[str, list[str]]:
    """The notes of each sheet, as the file has them."""
    grid.saved()
    places = {"First": [(2, 6), (3, 6)], "Second": [(2, 6), (3, 6)], "Devices": [(2, 3)]}
    sheets = {sheet.name: sheet.cells for sheet in read(grid.path).sheets}
    return {
        name: [str(sheets[name][at].text) if at in sheets[name] else "" for at in mine] for name, mine in places.items()
    }


def test_what_is_found_is_listed_by_sheet_and_leads_there(grid: Shared) -> None:
    grid.go("F3")
    search(grid, "red")
    wanted = ["First", "B2 Red ball", "D2 redBall.distance", "F2 a red note", "Second", "B2 Red ball", "D2 redBall.distance", "F2 RED", "B3 Red ball",
              "D3 redBall.yaw", "Devices", "C2 red again"]  # fmt: skip
    becomes(lambda: hits(grid), wanted)
    expect(grid.page.locator("#find-bar .found")).to_have_text("9 cells")
    assert grid.faults() == []
    grid.page.get_by_role("button", name="C2 red again").click()
    grid.page.wait_for_url("**/sheet/Devices#*")
    listening(grid.page)
    becomes(lambda: grid.here, "C2")
    becomes(lambda: hits(grid)[:2], ["Devices", "C2 red again"])
    grid.page.locator("#find-bar [name=find]").press("Enter")  # the last of this sheet: on to the next one
    grid.page.wait_for_url("**/sheet/First#*")
    becomes(lambda: grid.here, "B2")


def test_all_sheets_are_replaced_in_one_step(grid: Shared) -> None:
    search(grid, "red")
    grid.page.locator("#find-bar [name=sameCase]").check()
    grid.page.locator("#find-bar [name=by]").fill("green")
    grid.page.get_by_role("button", name="Replace all").click()
    grid.status("Replaced in 2 cells of First, 2 cells of Second, 1 cell of Devices. Press Ctrl+Z to undo.")
    becomes(lambda: notes(grid)["Devices"], ["green again"])
    grid.page.locator("#find-bar [name=find]").press("Escape")
    grid.press("Control+z")
    becomes(lambda: notes(grid), {"First": ["a red note", "blue"], "Second": ["RED", ""], "Devices": ["red again"]})


def test_cells_are_replaced_also_when_the_list_is_made_anew_meanwhile(grid: Shared) -> None:
    search(grid, "red")
    becomes(lambda: len(hits(grid)), 12)
    asked: list[Any] = []

    def held(route: Any) -> None:
        asked.append(route)

    grid.page.route("**/texts", held)
    grid.page.locator("#find-bar [name=by]").fill("green")
    grid.page.get_by_role("button", name="Replace all").click()
    until(grid.page, lambda: len(asked) == 1)
    grid.page.locator("#find-bar [name=sameCase]").check()
    until(grid.page, lambda: len(asked) == 2)
    for route in asked[:]:
        route.continue_()
    grid.page.unroute("**/texts", held)
    grid.status("Replaced in 2 cells of First, 2 cells of Second, 1 cell of Devices. Press Ctrl+Z to undo.")


def test_a_name_is_found_in_all_sheets_and_only_renamed(grid: Shared) -> None:
    search(grid, "Red ball")
    grid.page.get_by_label("Stream name").check()
    becomes(
        lambda: [hit for hit in hits(grid) if hit.startswith("D")],
        [f"D2 {DISTANCE}", f"D2 {DISTANCE}", "D3 redBall.yaw"],
    )
    grid.page.get_by_role("button", name="Replace all").click()
    grid.status("To change a name, use “Rename everywhere” in the menu of its cell.")


def test_hidden_rows_are_not_replaced(grid: Shared) -> None:
    grid.page.get_by_role("button", name="Filter Notes").click()
    grid.page.get_by_role("checkbox", name="a red note").uncheck()
    grid.page.get_by_role("checkbox", name="blue").check()
    grid.page.get_by_role("button", name="Apply filter").click()
    search(grid, "map")
    grid.page.locator("#find-bar [name=by]").fill("filter")
    expect(grid.page.locator("#counts")).to_have_text("1 of 2 rows shown")
    becomes(lambda: hits(grid), ["Second", "C2 map", "C3 map"])
    grid.page.get_by_role("button", name="Replace all").click()
    grid.status("Replaced in 2 cells of Second. Press Ctrl+Z to undo.")
    becomes(lambda: [row.connector.text for row in read(grid.path).workbook.behaviours[0].rows], ["map", "filter"])


def test_what_somebody_changed_meanwhile_is_not_overwritten(grid: Shared) -> None:
    def meanwhile(route: Any) -> None:
        answer = route.fetch()
        text = answer.text().replace("red again", "red before")  # as if it had been that a moment ago
        route.fulfill(response=answer, body=text)

    grid.page.route("**/texts", meanwhile)
    search(grid, "red before")
    becomes(lambda: hits(grid), ["Devices", "C2 red before"])
    grid.page.locator("#find-bar [name=by]").fill("x")
    grid.page.get_by_role("button", name="Replace all").click()
    expect(grid.page.locator("#status.is-error")).to_contain_text("Devices, row 2")
    grid.page.unroute_all(behavior="wait")  # one may be on its way
    becomes(lambda: notes(grid)["Devices"], ["red again"])
