"""Time that the tasks of the thesis take a practised person, by the keystroke-level model, from the keys and clicks that the
page received; and how many times as long it took in the original software (measured with the same model)."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from chromium import GridPage, browsing, serving
from effort import Effort, Recorder
from tasks import TASKS, by_keyboard, by_mouse, check_meaning

from rrp_sheets import api

ORIGINAL = {"walkthrough": (60, 75), "tracking": (132, 152)}  # seconds, at best and as its editor leads one
MOST = {"walkthrough": 35, "tracking": 75}
WAYS = {"keyboard": by_keyboard, "mouse, and names typed": by_mouse}


def measure(browser: Any, url: str, folder: Path, task: str, way: str) -> Effort:
    """Do a task in a new workbook without rows."""
    name = f"{task} {way.split(',', maxsplit=1)[0]}.xlsx"
    api.new(folder / name, template="empty")
    recorder = Recorder()
    page = GridPage(browser, url, name, recorder=recorder)
    page.page.wait_for_selector("body[data-ready]")
    recorder.begin()
    WAYS[way](page, task)
    page.saved()
    effort = recorder.effort()
    page.close()
    (folder / "check").mkdir(exist_ok=True)
    check_meaning(task, folder / name, folder / "check")
    return effort


@pytest.mark.parametrize("task", TASKS)
def test_effort(tmp_path: Path, task: str) -> None:
    best, usual = ORIGINAL[task]
    with serving(tmp_path) as url, browsing() as browser:
        efforts = {way: measure(browser, url, tmp_path, task, way) for way in WAYS}
    print(f"\n{task} (original {best} to {usual} s):")
    for way, effort in efforts.items():
        print(
            f"  by {way}: {effort}; the original takes {best / effort.seconds:.1f} to {usual / effort.seconds:.1f} times as long"
        )
    assert efforts["keyboard"].seconds <= MOST[task]
