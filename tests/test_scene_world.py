"""Effects of Scene rows in the simulated room: each kind of thing is seen, measured or felt."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("pybullet")
pytest.importorskip("cv2")

import numpy as np
from play import rows
from test_sim_run import RATE, ROBOT, scene_of

from rrp_sheets import api
from rrp_sheets.engine.scene import default_scene
from rrp_sheets.model.exchange import DeviceUse
from rrp_sheets.runs.run_data import RunSettings
from rrp_sheets.sim.process import Spec
from rrp_sheets.sim.world import SimWorld

EVERYTHING = """
| 0 | Table | appears | at 0.9, 0.5 height 30 cm |
| 0 | Red cup | appears | at 0.8, 0.5 on table |
| 0 | Box | appears | at 1, -0.6 size 20 cm |
| 0 | Wall | appears | at 2, 0 |
| 0 | Mia | enters | at 1.2, 0 standing height 110 cm voice child |
| 0 | Leo | enters | at 1.4, -0.3 |
| 0.5 | Red cup | moves | to 1, 0.4 on table in 0.5 s |
| 0.5 | Box | moves | to 1.5, -0.6 in 0.5 s |
| 0.5 | Table | moves | to 1.1, 0.5 in 0.5 s |
| 0.5 | Light | set to | 20 % in 1 s |
| 0.5 | Noise | set to | 60 % |
| 0.5 | Leo | looks away | |
| 1.2 | Wall | disappears | |
| 1.3 | Red ball | appears | at 0.5, 0, 0.4 |
| 1.4 | Red ball | moves | to 0.12, 0.05, 0.03 in 0.3 s |
| 2.2 | Red ball | moves | to 0.6, 0, 0.4 in 0.2 s |
| 2.5 | Mia | touches | Head for 1 s |
"""
SENSORS = (
    DeviceUse("touch", "Touch", "Touch", {}), DeviceUse("bumper", "Bumper", "Bumper", {"side": "Left"}),
    DeviceUse("sonar", "Sonar", "Sonar", {"side": "", "rate": 10.0}),
)  # fmt: skip


@pytest.fixture(scope="module")
def played() -> dict[str, Any]:
    """Four seconds of a room with everything: states, pictures and events."""
    world = SimWorld(Spec(ROBOT, sensors=SENSORS, scene=scene_of(EVERYTHING), frame_rate=RATE))
    found: dict[str, Any] = {"states": {}, "pictures": {}, "events": []}
    try:
        found["events"] += [(0.0, *e) for e in world.start().events]
        for frame in range(1, 4 * RATE):
            outcome = world.advance(frame * 1_000_000 // RATE, ())
            found["events"] += [(frame / RATE, *e) for e in outcome.events]
            if frame in (6, 57):
                found["states"][frame], found["pictures"][frame] = world.state(), world.sight.look()
        return found
    finally:
        world.close()


@pytest.mark.slow
def test_everything_stands_where_its_row_says(played: dict[str, Any]) -> None:
    before, after = played["states"][6], played["states"][57]
    assert before.things["Red cup"] == pytest.approx((0.8, 0.5, 0.3)) and after.things["Red cup"][2] == pytest.approx(
        0.3
    )
    assert after.things["Box"] == pytest.approx((1.5, -0.6, 0)) and after.things["Table"] == pytest.approx(
        (1.1, 0.5, 0)
    )
    assert before.things["Mia"] == pytest.approx((1.2, 0, 1.012)) and before.things["Leo"][2] == pytest.approx(0.62)
    assert "Wall" in before.things and "Wall" not in after.things
    looks = before.looks
    assert looks["Red cup"]["kind"] == "cup" and looks["Red cup"]["colour"] == "red"
    assert (looks["Mia"]["seated"], looks["Leo"]["seated"]) == (False, True)
    assert (looks["Leo"]["away"], after.looks["Leo"]["away"]) == (False, True)
    assert looks["Table"]["size"] == pytest.approx([0.4, 0.7, 0.3])


def test_light_and_noise_change_as_their_rows_say(played: dict[str, Any]) -> None:
    before, after = played["states"][6], played["states"][57]
    assert (before.light, before.noise) == (1.0, 0.0)
    assert (after.light, after.noise) == (pytest.approx(0.2), 0.6)
    assert played["pictures"][57].mean() < 0.6 * played["pictures"][6].mean()


def test_what_comes_against_the_foot_presses_its_bumper_until_it_goes(played: dict[str, Any]) -> None:
    bumper = [(t, v["pressed"]) for t, stream, v in played["events"] if stream == "bumper"]
    assert [pressed for _, pressed in bumper] == [True, False]
    assert 1.5 < bumper[0][0] < 1.8 and 2.2 < bumper[1][0] < 2.4


def test_a_touch_lasts_as_long_as_its_row_says(played: dict[str, Any]) -> None:
    head = [(t, v["pressed"]) for t, stream, v in played["events"] if stream == "touch" and v["zone"] == "Head"]
    assert head == [(2.5, True), (3.5, False)]


def test_a_picture_shows_table_box_and_wall(played: dict[str, Any]) -> None:
    picture = played["pictures"][6].astype(int)
    wood = (picture[:, :, 0] > 1.2 * picture[:, :, 2]) & (picture[:, :, 0] > 120)
    assert wood[:, : picture.shape[1] // 2].sum() > 300, "the table is to the left"
    wall, above = picture[100, 300], picture[5, 300]
    assert np.ptp(wall) < 12 and wall.mean() < above.mean() - 10, "the wall is grey, and the room behind it is pale"


@pytest.mark.parametrize(("how", "falls"), [("gently", False), ("hard", True)])
def test_a_gentle_push_is_borne_and_a_hard_one_is_not(how: str, falls: bool) -> None:
    world = SimWorld(Spec(ROBOT, scene=scene_of(f"| 0.2 | Mia | pushes | from the left {how} |")))
    try:
        world.start()
        world.advance(2_500_000, ())
        roll, pitch, _ = world.state().base[3:]
        assert (max(abs(roll), abs(pitch)) > math.radians(45)) is falls
    finally:
        world.close()


def test_the_default_scene_brings_something_near_the_sonar() -> None:
    actions = default_scene([DeviceUse("s", "Sonar", "Sonar", {})], ROBOT)
    assert {a.what for a in actions} == {"wall", "person"}
    both = default_scene([DeviceUse("s", "Sonar", "Sonar", {}), DeviceUse("f", "Face", "FaceDetection", {})], ROBOT)
    assert {a.what for a in both} == {"person"}


TALK = rows(
    """
| Start, Touch | merge | | Cue |
| Cue | map | "Yes?" | Words |
| Words | subscribe | | Ask |
""",
    """
## Devices
| Stream | Device | Label | Zone |
|---|---|---|---|
| Start | Operator button | Start | |
| Touch | Touch | | Head |
| Ask | Say | | |
""",
    """
## Scene
| Time (s) | Thing | Does | Value |
|---|---|---|---|
| 0.5 | Operator | presses | Start |
| Ask done + 0.5 | Mia | touches | Head for 0.2 s |
| + 0.5..0.7 | Red ball | appears | at 0.8..1.2, 0, 0.4 |
| Ask done + 60 | Red ball | disappears | |
| Ask done + 1 | Mia | says | never |
""",
)


def run_of(folder: Path, seed: int, name: str) -> list[dict[str, Any]]:
    (folder / "talk.md").write_text(TALK, encoding="utf-8")
    settings = RunSettings(seconds=3.6, fast=True, out=folder / name, seed=seed, film=False)
    api.run(folder / "talk.md", settings)
    return [json.loads(line) for line in (folder / name / "trace.jsonl").read_text(encoding="utf-8").splitlines()]


def test_rows_answer_what_the_robot_does_the_same_in_every_run_of_a_seed(tmp_path: Path) -> None:
    one, same = (run_of(tmp_path, 1, name) for name in "ab")
    dones = [line["t"] for line in one if line.get("stream") == "Ask done"]
    touched = [line["t"] for line in one if line.get("stream") == "Touch"]
    assert touched == [pytest.approx(dones[0] + 0.5, abs=0.04), pytest.approx(dones[0] + 0.7, abs=0.04)]
    (drawn,) = [line for line in one if "Random numbers" in str(line.get("text"))]
    assert (drawn["t"], drawn["row"]) == (0.0, "Scene!4")
    assert drawn["text"].startswith("Random numbers of this run: at ") and ", time 0." in drawn["text"]
    left = [line["row"] for line in one if "never happened" in str(line.get("text"))]
    assert left == ["Scene!6"], "its turn has not come: the row above waits a minute"
    assert one[1:] == same[1:] and one[0]["seed"] == 1
