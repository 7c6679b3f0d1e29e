"""Gestures in the grid: Play shows one on the robot's model, Pose writes the robot's joints into a row."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from chromium import FLAGS_3D, becomes, eventually
from grid_books import HEADER, Books, Shared
from panel import run, running

from rrp_sheets.workbook import read

GESTURES = [
    ["Name", "Time (s)", "RShoulderPitch", "HeadYaw", "HeadPitch", "Notes"],
    ["Greet", "0.8", "-0.6", "20°", "", ""],
    ["Greet", "4", "-0.5", "", "", "down again"],
    ["", "", "", "", "", ""],
    ["Sulk", "1", "", "", "0.4", ""],
]
SHEETS = {
    "T": [HEADER, ["", "Timer", "subscribe", '"Greet"', "Gesture", ""]],
    "Devices": [["Stream", "Device", "Name", "Every"], ["Timer", "Timer", "", "60 s"], ["Greet them", "Gesture", "Greet", ""]],
    "Gestures": GESTURES,
}  # fmt: skip


def keyframes(shared: Shared) -> list[tuple[str, str, dict[str, str]]]:
    shared.saved()
    found = read(shared.path).workbook.gestures
    return [(g.name.text, g.time.text, {k: c.text for k, c in g.joints.items()}) for g in found]


def angles(page: Any) -> dict[str, float]:
    return json.loads(page.get_attribute("#gesture-view canvas", "data-angles"))


@pytest.fixture
def drawing(folder: Path, url: str, browsers: Any) -> Iterator[Books]:
    """The same in a browser that draws the robot."""
    found = Books(folder, url, browsers.browser(FLAGS_3D))
    yield found
    found.close()


def test_a_gesture_is_played_on_the_robots_model(drawing: Books) -> None:
    grid = drawing.open(SHEETS, sheet="Gestures")
    grid.go("B2")
    grid.page.evaluate(
        """() => { window.lowest = 9; window.pictures = new Set();
          new MutationObserver(() => {
              const { angles = "{}", drawn } = document.querySelector("#gesture-view[data-playing] canvas")?.dataset ?? {};
              window.lowest = Math.min(window.lowest, JSON.parse(angles).RShoulderPitch ?? 9);
              if (drawn) window.pictures.add(drawn); })
            .observe(document.body, { subtree: true, attributeFilter: ["data-angles", "data-drawn"] }); }"""
    )
    grid.page.click("[data-pose=play]")
    grid.page.wait_for_selector("#gesture-view[data-ready]")
    becomes(lambda: grid.page.inner_text("#gesture-title"), "Greet")
    grid.page.wait_for_function("() => window.lowest < 0")  # the arm was up, also if only a moment of it was drawn
    grid.page.wait_for_selector("#gesture-view:not([data-playing])")
    assert angles(grid.page)["RShoulderPitch"] == pytest.approx(1.4)  # back where it began
    eventually(lambda: grid.page.evaluate("window.pictures.size") > 2)  # while it played
    assert not grid.faults()
    grid.page.click("[data-pose=close]")
    grid.go("C4")
    grid.page.keyboard.press("ArrowDown")
    grid.page.click("[data-pose=play]")
    grid.page.wait_for_selector("#gesture-title:has-text('Sulk')")
    grid.page.click("[data-pose=close]")
    assert not grid.errors


def test_pose_writes_the_start_posture_below_the_row_and_is_taken_back(shelf: Books) -> None:
    grid = shelf.open(SHEETS, sheet="Gestures")
    before = keyframes(grid)
    grid.go("B3")
    grid.page.click("[data-pose=take]")
    grid.status("now in this keyframe")
    now = keyframes(grid)
    assert now[2] == ("Greet", "5", {"rshoulderpitch": "1.4", "headyaw": "0", "headpitch": "0"})
    assert now[:2] + now[3:] == before
    grid.page.click("[data-do=undo]")
    grid.page.wait_for_function("() => ![...document.querySelectorAll('tbody td')].some((c) => c.textContent === '5')")
    assert keyframes(grid) == before


def test_a_sheet_without_joints_is_told_what_it_lacks(shelf: Books) -> None:
    grid = shelf.open({**SHEETS, "Gestures": [["Name", "Time (s)", "Notes"], ["Greet", "1", ""]]}, sheet="Gestures")
    grid.go("A2")
    grid.page.click("[data-pose=take]")
    grid.status("RShoulderPitch")
    grid.page.click("[data-pose=play]")
    grid.status("no gesture in this row yet")


@pytest.mark.slow
def test_cells_say_what_their_joint_can_do_and_names_are_offered(shelf: Books) -> None:
    grid = shelf.open(SHEETS, sheet="Gestures")
    grid.checked()
    assert "Greet" in grid.offered("A5", "Gr")
    grid.go("D4")
    grid.press("F2")
    grid.page.wait_for_selector("text=/-2.09 .* to 2.09/")
    grid.press("Escape")
    devices = shelf.open(SHEETS, sheet="Devices", path=grid.path)
    devices.checked()
    assert "Sulk" in devices.offered("C3", "Su") and "Thinking" in devices.offered("C3", "Thi")


@pytest.mark.slow
def test_pose_takes_the_joints_of_the_robot_that_runs(shelf: Books) -> None:
    sheets = {**SHEETS, "T": [HEADER, ["", "Timer", "subscribe", "0.7", "Turn", ""]],
              "Devices": [["Stream", "Device", "Joint", "Every"], ["Timer", "Timer", "", "0.2 s"], ["Turn", "Set joint position", "HeadYaw", ""]]}  # fmt: skip
    grid = shelf.open(sheets, sheet="Gestures")
    grid.checked()
    run(grid.page)
    running(grid.page)
    grid.page.evaluate(
        "document.addEventListener('rrp:live', ({ detail }) => { window.robot = detail.robot ?? window.robot; })"
    )
    grid.page.wait_for_function("() => window.robot?.joints.HeadYaw > 0.67")
    grid.go("A5")
    grid.page.click("[data-pose=take]")
    grid.status("now in this keyframe")
    assert float(keyframes(grid)[-1][2]["headyaw"]) == pytest.approx(0.7, abs=0.05)
    grid.page.click("[data-run=stop]")
    grid.page.wait_for_selector("body[data-run=ended]")
    (run_folder,) = (shelf.folder / "runs").iterdir()
    eventually((run_folder / "film.gif").is_file, "a run that is started from a page makes a film")
