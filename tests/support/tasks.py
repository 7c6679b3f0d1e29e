"""The tasks that the original software was measured with, and how one does them in the grid by each kind of hand.

The walkthrough of the thesis: a red ball, its distance, a close one, a tracker. Its Tracking task: three ranges, in
which the head follows, head and body follow, and the arm points.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from chromium import GridPage

from rrp_sheets import api
from rrp_sheets.workbook.files import make_workbook
from rrp_sheets.workbook.template import empty_sheets

HEADER = ["Input streams", "Connector", "Formula", "Output stream"]
WALKTHROUGH = [
    ["Red ball", "map", "redBall.distance", "Distance"],
    ["Distance", "filter", "distance < 0.5", "Close"],
    ["Close", "subscribe", "", "Head tracker"],
]
TRACKING = [
    ["Red ball", "map", "redBall.distance", "Distance"],
    ["Distance", "filter", "distance >= 1.5", "Far"],
    ["Far", "subscribe", "", "Head tracker"],
    ["Distance", "filter", "0.6 <= distance < 1.5", "Middle"],
    ["Middle", "subscribe", "", "Head and body tracker"],
    ["Distance", "filter", "distance < 0.6", "Close"],
    ["Close", "subscribe", "", "Arm tracker"],
]
TASKS = {"walkthrough": WALKTHROUGH, "tracking": TRACKING}
# What a practised person types: the beginning of a name and Tab where it is suggested, ↓ and Enter for a name that is
# proposed (↵), nothing where the input is what the row above gives; in each cell, and Tab or Enter after it.
KEYS = {
    "walkthrough": [
        ["re", "m", "r⇥.d⇥", "d↵"],
        ["", "f", "d⇥<0.5", "Close"],
        ["", "su", "", "h"],
    ],
    "tracking": [
        ["re", "m", "r⇥.d⇥", "d↵"],
        ["", "f", "d⇥>=1.5", "Far"],
        ["", "su", "", "h"],
        ["d", "f", "0.6<=d⇥<1.5", "Middle"],
        ["", "su", "", "head a"],
        ["d", "f", "d⇥<0.6", "Close"],
        ["", "su", "", "a"],
    ],
}  # fmt: skip
# The same by mouse: what is offered (→) is clicked, typed is only what nobody could offer.
CLICKS = {
    "walkthrough": [
        ["→Red ball", "→map", "→redBall.distance", "→Distance"],
        ["", "→filter", "d⇥<0.5", "Close"],
        ["", "→subscribe", "", "→Head tracker"],
    ],
    "tracking": [
        ["→Red ball", "→map", "→redBall.distance", "→Distance"],
        ["", "→filter", "d⇥>=1.5", "Far"],
        ["", "→subscribe", "", "→Head tracker"],
        ["→Distance", "→filter", "0.6<=d⇥<1.5", "Middle"],
        ["", "→subscribe", "", "→Head and body tracker"],
        ["→Distance", "→filter", "d⇥<0.6", "Close"],
        ["", "→subscribe", "", "→Arm tracker"],
    ],
    "a touch is answered": [["hand→Left hand touch", "→subscribe", "", "wave→Wave"]],
}  # fmt: skip
TRACKING_TEST = [
    ["Time (ms)", "Stream", "Send", "Expect"],
    ["0", "Red ball", "distance=2", ""],
    ["0", "Head tracker", "", "2"],
    ["0", "Head and body tracker", "", "nothing"],
    ["0", "Arm tracker", "", "nothing"],
    ["1000", "Red ball", "distance=1", ""],
    ["1000", "Head and body tracker", "", "1"],
    ["1000", "Head tracker", "", "nothing"],
    ["2000", "Red ball", "distance=0.3", ""],
    ["2000", "Arm tracker", "", "0.3"],
    ["2000", "Head and body tracker", "", "nothing"],
]
WALKTHROUGH_TEST = [
    ["Time (ms)", "Stream", "Send", "Expect"],
    ["0", "Red ball", "distance=0.8", ""],
    ["0", "Head tracker", "", "nothing"],
    ["1000", "Red ball", "distance=0.3", ""],
    ["1000", "Head tracker", "", "0.3"],
]
TESTS = {"walkthrough": WALKTHROUGH_TEST, "tracking": TRACKING_TEST}


def check_meaning(task: str, made: Path, folder: Path) -> None:
    """Assert that a workbook is in order, means what the task wants, and does it: `rrp-sheets diff` and `test`."""
    assert not list(api.check(made).report)
    sheets = empty_sheets()
    sheets["Tracking"] += [[*row, "", ""] for row in TASKS[task]]
    comparison = api.diff(make_workbook(sheets, folder / "meant.xlsx"), made)
    assert comparison.same, comparison.changes
    tested = api.convert(made, folder / "tested.md")
    test = "\n".join(f"| {' | '.join(row)} |" for row in [TESTS[task][0], ["---"] * 4, *TESTS[task][1:]])
    tested.write_text(f"{tested.read_text(encoding='utf-8')}\n\n## Test\n\n{test}\n", encoding="utf-8")
    _, report = api.test(tested)
    assert report is not None and report.cases and report.passed


def by_keyboard(page: GridPage, task: str) -> None:
    """Fill the rows from the cell on which the page opens, with the keyboard alone."""
    press_rows(page, KEYS[task])


def press_rows(page: GridPage, rows: Sequence[Sequence[str]]) -> None:
    """Fill rows as `KEYS` says, from the cell with the cursor on."""
    for row in rows:
        for place, text in enumerate(row):
            press(page, text)
            page.press("Enter" if place == len(row) - 1 else "Tab")


def press(page: GridPage, text: str) -> None:
    """Type a text, with Tab for a name that is suggested (⇥), ↓ and Enter for one that is proposed (↵)."""
    for part in re.split("([⇥↵])", text):
        if part == "⇥":
            page.press("Tab")
        elif part == "↵":
            page.press("ArrowDown")
            page.press("Enter")
        else:
            page.page.keyboard.type(part)


def by_mouse(page: GridPage, task: str, *, touch: bool = False) -> None:
    """Fill the rows as `CLICKS` says, by clicking or tapping each cell."""
    for i, row in enumerate(CLICKS[task]):
        for header, text in zip(HEADER, row, strict=True):
            if not text:
                continue
            cell = page.cell(f"{_letter(page, header)}{i + 2}")
            if touch:
                if cell.get_attribute("aria-selected") != "true":
                    cell.tap(position={"x": 8, "y": 8})
                cell.tap(position={"x": 8, "y": 8})
            else:
                cell.dblclick(position={"x": 8, "y": 8})
            typed, _, name = text.partition("→")
            press(page, typed)
            if name:
                choose(page, name, touch=touch)
    last = page.cell(f"{_letter(page, 'Connector')}{len(CLICKS[task]) + 2}")
    last.tap() if touch else last.click()


def choose(page: GridPage, text: str, *, touch: bool = False) -> None:
    """Take a suggestion by clicking on it."""
    name = page.page.locator(".name", has_text=re.compile(f"^{re.escape(text)}$"))
    option = page.page.locator("[role=option]", has=name)
    option.tap() if touch else option.click()


def _letter(page: GridPage, header: str) -> str:
    script = "name => document.querySelector(`thead th[data-name='${name}']`).dataset.letter"
    return str(page.page.evaluate(script, header))


def texts(page: Any) -> list[list[str]]:
    """Texts of the cells of the grid, row by row."""
    script = "() => [...document.querySelectorAll('tbody tr')].map(r => [...r.querySelectorAll('[data-v]')].map(c => c.dataset.v))"
    return [row for row in page.evaluate(script) if row]
