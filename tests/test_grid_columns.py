"""Look of the grid: letters, headers, widths, icons; and the panel beside it."""

from __future__ import annotations

import re

import pytest
from chromium import becomes, eventually, some
from grid_books import HEADER, Books, Shared

from rrp_sheets.connectors import connectors
from rrp_sheets.web.statics import icons

SHEETS = {
    "T": [
        HEADER,
        ["", "Red ball", "map", "redBall.distance", "Distance", "a note that is longer than its column is wide"],
    ],
    "Scene": [["Time (s)", "Thing", "Does", "Value", "Notes"], ["1", "Red ball", "appears", "at 1, 0.2, 0.4", ""]],
    "Try": [["Time (ms)", "Stream", "Send", "Expect", "Notes"], ["0", "Red ball", "distance=1", "", ""]],
    "Devices": [["Stream", "Device", "Fixed minimum", "Notes"], ["Gaze", "Head yaw", "", ""]],
}
HEADS = """() => [...document.querySelectorAll("thead th")].map(h => {
    const title = h.querySelector(".title");
    return [h.querySelector(".letter").textContent, title.textContent, title.scrollWidth <= title.clientWidth + 1];
})"""


def width(grid: Shared, letter: str) -> int:
    """A column's width."""
    return int(grid.page.evaluate("l => document.querySelector(`th[data-letter='${l}']`).offsetWidth", letter))


@pytest.mark.slow
def test_letters_stand_over_the_headers_and_no_header_is_cut(shelf: Books) -> None:
    for sheet in SHEETS:
        grid = shelf.open(SHEETS, sheet=sheet)
        heads = some(lambda: grid.page.evaluate(HEADS))
        letters = [letter for letter, title, _ in heads if title != "Example"]
        assert letters == ["", *"ABCDEFGH"[: len(letters) - 1]]
        assert [title for _, title, whole in heads if not whole] == []
        for letter in letters[1:] if sheet == "T" else letters[-1:]:
            grid.go(f"{letter}2")
            becomes(lambda: grid.here, f"{letter}2")


@pytest.mark.slow
def test_columns_and_the_panel_beside_the_grid_are_made_wider_by_mouse_and_keys_and_stay_so(shelf: Books) -> None:
    grid = shelf.open(SHEETS, sheet="T")
    before = width(grid, "F"), width(grid, "B")
    box = grid.page.locator("th[data-letter=F] .widen").bounding_box()
    grid.page.locator("th[data-letter=F] .widen").scroll_into_view_if_needed()
    box = grid.page.locator("th[data-letter=F] .widen").bounding_box()
    grid.page.mouse.move(box["x"] + 4, box["y"] + 9)
    grid.page.mouse.down()
    grid.page.mouse.move(box["x"] - 56, box["y"] + 9, steps=4)
    grid.page.mouse.up()
    assert width(grid, "F") == before[0] - 60
    grid.go("B2")
    grid.press("Alt+ArrowRight", "Alt+ArrowRight", "Alt+ArrowLeft")
    assert width(grid, "B") == before[1] + 8
    grid.wait_spoken(f"Input streams is {before[1] + 8} wide")
    edge = grid.page.locator("th[data-letter=B] .widen")
    edge.focus()
    grid.press("ArrowRight")
    eventually(lambda: width(grid, "B") == before[1] + 16 == int(edge.get_attribute("aria-valuenow")))
    grid.page.locator("th[data-letter=F] .widen").dblclick()
    fits = "c => { const r = document.createRange(); r.selectNodeContents(c); return r.getBoundingClientRect().height < 20; }"
    eventually(lambda: grid.page.evaluate(fits, grid.cell("F2").element_handle()) and width(grid, "F") > before[0])
    widths = [width(grid, letter) for letter in "ABCDEF"]
    again = shelf.open(path=grid.path, sheet="T")
    assert [width(again, letter) for letter in "ABCDEF"] == widths
    grid = shelf.open(SHEETS, sheet="T")
    assert width(grid, "F") == before[0]  # of another workbook
    bar, wide = grid.page.locator(".splitter"), "document.getElementById('panels').offsetWidth"
    at_first = some(lambda: grid.page.evaluate(wide))
    box = bar.bounding_box()
    grid.page.mouse.move(box["x"] + 4, 400)
    grid.page.mouse.down()
    grid.page.mouse.move(box["x"] - 96, 400, steps=4)
    grid.page.mouse.up()
    eventually(lambda: abs(grid.page.evaluate(wide) - at_first - 100) <= 8)
    dragged = some(lambda: grid.page.evaluate(wide))
    bar.focus()
    grid.press("ArrowRight", "ArrowRight")
    becomes(lambda: grid.page.evaluate(wide), dragged - 32)
    grid = shelf.open(path=grid.path, sheet="T")
    becomes(lambda: grid.page.evaluate(wide), dragged - 32)
    grid.page.locator(".splitter").dblclick()
    becomes(lambda: grid.page.evaluate(wide), at_first)


def test_every_connector_has_the_icon_of_the_diagram() -> None:
    sheet = icons().decode()
    for connector in connectors():
        (drawn,) = re.findall(rf'id="i-{connector.name}" [^>]*>(.*)</symbol>', sheet)
        assert drawn == connector.icon.replace('class="f"', 'fill="currentColor" stroke="none"')


@pytest.mark.slow
def test_a_comment_in_the_first_column_is_seen(shelf: Books) -> None:
    grid = shelf.open({"T": [HEADER, ["# what follows is only for visitors", *[""] * 5]]})
    seen = "c => { const w = c.querySelector('.word').getBoundingClientRect(); return [w.height < 20, w.width > 150]; }"
    becomes(lambda: grid.page.evaluate(seen, grid.cell("A2").element_handle()), [True, True])
    becomes(lambda: grid.page.locator("tbody input").count(), 0)


@pytest.mark.slow
def test_a_flagged_connector_of_the_longest_name_stands_on_one_line(shelf: Books) -> None:
    rows = [["", "Red ball", "map", "redBall.x", "A", ""], ["", "Red ball", "map", "redBall.y", "B", ""],
            ["", "A, B", "combineLatest", "a + c", "C", ""], ["", "C", "subscribe", "", "Say", ""]]  # fmt: skip
    grid = shelf.open({"T": [HEADER, *rows]})
    grid.page.wait_for_selector("td.flagged")
    grid.go("C4")
    high = "c => c.querySelector('.word').getBoundingClientRect().height"
    eventually(lambda: grid.page.evaluate(high, grid.cell("C4").element_handle()) < 20)


@pytest.mark.slow
def test_a_large_diagram_is_first_seen_where_something_is_in_it(shelf: Books) -> None:
    rows = [
        ["", "Red ball", "map", f"redBall.distance + {n}", f"A very long name of a stream {n}", ""] for n in range(9)
    ]
    grid = shelf.open({"T": [HEADER, ["", "# the first row has no box", "", "", "", ""], *rows]}, sheet="T")

    def is_in_sight() -> bool:
        frame, box = (
            grid.page.locator(part).first.bounding_box() for part in ("#diagram", "#diagram [role=button].here")
        )
        whole = grid.page.evaluate("document.querySelector('#diagram').scrollWidth") > 1.5 * frame["width"]
        return whole and frame["x"] <= box["x"] and box["x"] + box["width"] <= frame["x"] + frame["width"]

    eventually(is_in_sight)
