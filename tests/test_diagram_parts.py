"""Parts of a long behaviour in the panel: the rows below a heading, or those around a row."""

from __future__ import annotations

import pytest
from chromium import becomes
from grid_books import HEADER, Books
from playwright.sync_api import expect

from rrp_sheets.graph import BehaviourGraph
from rrp_sheets.runs.check_worker import read_and_check
from rrp_sheets.web.diagram_parts import MOST_AROUND, part_of, parts
from rrp_sheets.workbook.files import make_workbook

CHAIN = [["", f"S{n - 1}" if n else "Red ball", "map", "1", f"S{n}", ""] for n in range(12)]
ROWS = [["# Looking", "", "", "", "", ""], *CHAIN[:5], ["# Waving", "", "", "", "", ""], *CHAIN[5:]]
HEADINGS = {3: "Looking", 9: "Waving"}


@pytest.fixture(scope="module")
def chain(tmp_path_factory: pytest.TempPathFactory) -> BehaviourGraph:
    path = tmp_path_factory.mktemp("parts") / "chain.xlsx"
    make_workbook({"T": [HEADER, *ROWS]}, path)
    return read_and_check(path)[1].graph.behaviours[0]


@pytest.mark.parametrize(("asked", "rows"), [
    ("", [*range(3, 8), *range(9, 16)]), ("below-3", range(3, 8)), ("below-9", range(9, 16)), ("around-5", range(3, 8)),
    ("around-3", range(3, 6)), ("around-99", range(13, 16)), ("around-x", range(3, 6)), ("below-4", [*range(3, 8), *range(9, 16)]),
])  # fmt: skip
def test_part_has_the_rows_of_its_name(chain: BehaviourGraph, asked: str, rows: list[int]) -> None:
    assert [step.number for step in part_of(chain, HEADINGS, asked)] == list(rows)


def test_what_hangs_together_with_all_is_cut(tmp_path) -> None:
    rows = [["", "Red ball", "map", "1", f"A{n}", ""] for n in range(200)]
    make_workbook({"T": [HEADER, *rows]}, tmp_path / "star.xlsx")
    (star,) = read_and_check(tmp_path / "star.xlsx")[1].graph.behaviours
    assert len(part_of(star, {}, "around-50")) == MOST_AROUND


def test_a_short_behaviour_is_not_divided(chain: BehaviourGraph) -> None:
    assert parts(chain.steps[:3], HEADINGS) == ()
    assert [value for value, _ in parts(chain.steps, HEADINGS)] == ["", "around", "below-3", "below-9"]


def test_of_a_sheet_too_large_to_draw_its_parts_are_offered(shelf: Books) -> None:
    rows = [["", "Red ball", "map", "1", f"A{n}", ""] for n in range(502)]
    grid = shelf.open(
        {"T": [HEADER, *CHAIN[:2], ["# Waving", "", "", "", "", ""], *rows[:3], ["# Looking", *[""] * 5], *rows[3:]]}
    )
    panel = grid.page.locator(".diagram-panel")
    expect(panel).to_contain_text("Too large to draw (over 500 rows). Split the sheet.")
    becomes(lambda: panel.locator("[data-part]").all_inner_texts(), ["Around this row", "Waving", "Looking"])
    panel.get_by_role("button", name="Waving").click()
    becomes(lambda: panel.locator("#diagram [data-row]").count(), 3)
    expect(grid.page.locator("#diagram-part")).to_be_focused()
    grid.page.select_option("#diagram-part", label="All rows")
    expect(panel).to_contain_text("Too large to draw")


def test_the_panel_shows_the_chosen_part_and_goes_along_with_the_cursor(shelf: Books) -> None:
    grid = shelf.open({"T": [HEADER, *ROWS]})
    grid.checked()
    drawn = "all => all.map((box) => Number(box.dataset.row))"

    def rows() -> list[int]:
        return sorted(grid.page.locator("#diagram [data-row]").evaluate_all(drawn))

    becomes(lambda: len(rows()), 12)
    grid.page.select_option("#diagram-part", label="Waving")
    becomes(rows, list(range(9, 16)))
    becomes(lambda: grid.page.locator("#row-words > [data-number]").count(), 7)
    grid.go("C5")
    grid.page.select_option("#diagram-part", label="Around this row")
    becomes(rows, list(range(3, 8)))
    grid.go("C12")
    becomes(rows, list(range(10, 15)))
