"""Time that the tasks of the thesis take a practised person, by the keystroke-level model, from the keys and clicks that the
page received; and how many times as long it took in the original software (measured with the same model)."""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from chromium import GridPage, browsing, serving
from effort import Effort, Recorder
from tasks import TASKS, by_keyboard, by_mouse, check_meaning

from rrp_sheets import api
from rrp_sheets.workbook.files import make_workbook
from rrp_sheets.workbook.template import empty_sheets

ORIGINAL = {"walkthrough": (60, 75), "tracking": (132, 152)}  # seconds, at best and as its editor leads one
MOST = {"walkthrough": (24, 50), "tracking": (58, 105)}  # seconds by each of the ways
MOST_OTHERS = {"a touch is answered": 30, "a stream of five rows is renamed": 6}
WAYS = {"keyboard": by_keyboard, "mouse, and names typed": by_mouse}


def measure(browser: Any, url: str, book: Path, do: Callable[[GridPage], None]) -> Effort:
    """Do something in a workbook, from the cell on which its page opens."""
    recorder = Recorder()
    page = GridPage(browser, url, book.name, recorder=recorder)
    page.page.wait_for_selector("body[data-ready]")
    recorder.begin()
    do(page)
    page.saved()
    page.close()
    return recorder.effort()


@pytest.mark.parametrize("task", TASKS)
def test_effort(tmp_path: Path, task: str) -> None:
    best, usual = ORIGINAL[task]
    efforts = {}
    (tmp_path / "check").mkdir()
    with serving(tmp_path) as url, browsing() as browser:
        for way, fill in WAYS.items():
            book = api.new(tmp_path / f"{task} {way.split(',', maxsplit=1)[0]}.xlsx", template="empty")
            efforts[way] = measure(browser, url, book, partial(fill, task=task))
            check_meaning(task, book, tmp_path / "check")
    print(f"\n{task} (original {best} to {usual} s):")
    for (way, effort), most in zip(efforts.items(), MOST[task], strict=True):
        print(
            f"  by {way}: {effort}, at most {most} s; "
            f"the original takes {best / effort.seconds:.1f} to {usual / effort.seconds:.1f} times as long"
        )
    assert all(effort.seconds <= most for effort, most in zip(efforts.values(), MOST[task], strict=True))


def test_effort_of_what_the_original_does_not_offer(tmp_path: Path) -> None:
    touch = api.new(tmp_path / "touch.xlsx", template="empty")
    sheets = empty_sheets()
    sheets["Tracking"] += [["Red ball", "map", "redBall.distance", "Far", "", ""]]
    sheets["Tracking"] += [["Far", "filter", f"far < {n}", f"Below {n}", "", ""] for n in range(1, 6)]
    named = make_workbook(sheets, tmp_path / "named.xlsx")

    def rename(page: GridPage) -> None:
        page.go("D2")
        page.press("F2", "Control+a")
        page.page.keyboard.type("Gap")
        page.press("Enter")

    with serving(tmp_path) as url, browsing() as browser:
        efforts = {
            "a touch is answered": measure(browser, url, touch, partial(by_mouse, task="a touch is answered")),
            "a stream of five rows is renamed": measure(browser, url, named, rename),
        }
    for what, effort in efforts.items():
        print(f"\n{what}: {effort}, at most {MOST_OTHERS[what]} s")
    behaviour = api.read(touch).workbook.behaviours[0]
    assert [i.text for i in behaviour.rows[0].inputs] == ["Left hand touch"]
    assert all(i.text == "Gap" for row in api.read(named).workbook.behaviours[0].rows[1:] for i in row.inputs)
    assert all(effort.seconds <= MOST_OTHERS[what] for what, effort in efforts.items())
