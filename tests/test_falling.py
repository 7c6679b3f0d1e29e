"""Nothing falls by itself; what is pushed over lies, says so, and its motors rest. Stop ends every motion at once."""

from __future__ import annotations

import json

import pytest

pytest.importorskip("pybullet")
pytest.importorskip("cv2")
import numpy as np
from motion import RED, ROBOT, Robot, use

from rrp_sheets import api
from rrp_sheets.model.exchange import SceneAction
from rrp_sheets.resources import bundled

BALL = SceneAction(0, "Red ball", "appear", {"at": (0.8, 0.3, 0.45), "size": 0.06, "colour": "red"})
TILT = use("tilt", "Orientation", rate=10)
POSTURE, GESTURE = use("posture", "Posture", speed=1.0), use("gesture", "Gesture")


def upright(robot: Robot) -> float:
    """Vertical part of the torso's axis: 1 is upright."""
    return float(robot.body.torso().rotation[2, 2])


def test_a_hard_push_makes_it_fall_and_its_motors_rest():
    devices = (use("arm", "SetJointPosition", joint="LShoulderPitch"), use("walk", "Walk"), use("say", "SayInput"),
               use("head", "Tracker", mode="Head"))  # fmt: skip
    robot = Robot(devices, [TILT, RED], [BALL])
    robot.order(("head", 1), ("walk", (0.5, 0, 0)))
    robot.go(0.9, every=8)
    robot.world.falling.push((0, -60, 0))
    robot.go(1.5, every=8)
    assert robot.body.fallen and upright(robot) < 0.5
    falls = [h for h in robot.told if "has fallen" in h.text]
    assert [(h.kind, "run again" in h.text) for h in falls] == [("error", True)]
    tilts = [v for name, v in robot.events if name == "tilt"]
    assert [v["fallen"] for v in (tilts[0], tilts[-1])] == [False, True]
    assert [robot.dones(s)[-1]["completed"] for s in ("head", "walk")] == [False, False]
    robot.go(1, every=8)
    before = robot.joints()
    for _ in range(3):
        robot.order(("arm", -1.0), ("walk", (0.5, 0, 0)), ("say", "Ouch"))
        robot.go(0.3, every=8)
    assert np.abs(robot.joints() - before).max() < 0.05  # nothing moves it
    assert [h.row for h in robot.told if "lies on the floor" in h.text] == ["Test!2", "Test!3"]  # told once for each
    assert len(robot.dones("arm")) == 3 and not any(d["completed"] for d in robot.dones("arm"))
    assert "Ouch" in [h.text for h in robot.told if h.kind == "say"]  # it can still speak
    ends = np.array([robot.ends(side) for side in "LR"])
    assert ends[:, :, 2].min() > -0.02  # limbs lie on the floor
    robot.world.stop()
    assert upright(robot) < 0.5  # and it is not lifted up by stopping


@pytest.mark.parametrize("posture", ["", "Sit"])
def test_a_gentle_push_does_not(posture):
    robot = Robot([POSTURE, GESTURE], [TILT])
    if posture:
        robot.order(("posture", posture))
        robot.until_done("posture", 6, every=24)
        assert robot.dones("posture")[-1]["completed"] is True
    before = robot.joints()
    robot.world.falling.push((8, 5, 0))
    robot.go(2, every=24)
    assert not robot.body.fallen and robot.told == []
    assert np.abs(robot.joints() - before).max() < 0.02
    robot.order(("gesture", "Nod"))
    robot.until_done("gesture", 2.5, every=24)
    assert robot.dones("gesture")[-1]["completed"] is True
    assert (upright(robot) < 0.95) == bool(posture)  # and it sits as before


@pytest.mark.slow
def test_postures_rest_on_the_floor_and_let_it_stand_up_again():
    robot = Robot([POSTURE, use("walk", "Walk")])
    lying = set(ROBOT.data["posture_leans"])
    for name in ("Crouch", "Sit", "LyingBack", "LyingBelly", "StandInit"):
        done = len(robot.dones("posture"))
        robot.order(("posture", name))
        while len(robot.dones("posture")) == done:
            robot.go(0.2, every=48)
        assert robot.dones("posture")[-1]["completed"] is True, name
        lowest = min(
            low for link in (-1, *robot.body.links.values())
            if (low := _lowest(robot, link)) is not None
        )  # fmt: skip
        assert -0.006 < lowest < 0.006, name  # on the floor: neither in it nor above it
        assert (upright(robot) < 0.2) == (name in lying), name
        robot.go(0.3, every=72)
        assert abs(robot.body.torso().rotation[2, 1]) < 0.01, name  # no tilt to a side
    robot.order(("walk", (0, 0, 0.3)))
    robot.until_done("walk", 3, every=48)
    assert robot.dones("walk")[-1]["completed"] is True
    assert robot.told == []


def _lowest(robot: Robot, link: int) -> float | None:
    """Height of a link's shape above the floor, m; None of one that has none."""
    near = robot.body._b.getClosestPoints(robot.body.id, 0, 1.0, link, -1)
    return min((p[8] for p in near), default=None)


@pytest.mark.slow
def test_stop_ends_every_motion_within_a_tenth_of_a_second():
    devices = (use("say", "SayInput"), use("walk", "Walk"), use("arm", "Tracker", mode="Move", effector="Left arm"),
               use("head", "Tracker", mode="Head"), use("wave", "Gesture", name="Wave"))  # fmt: skip
    scene = (BALL, SceneAction(100_000, "Red ball", "circle", {"radius": 0.3, "period": 3.0}))
    for after in (0.72, 0.95):  # at other moments of a step, and of a gesture
        robot = Robot(devices, [RED], scene)
        robot.order(("say", "A long sentence that goes on and on, until somebody stops it."))
        robot.order(("walk", (1, 0.2, 0)), ("arm", 1), ("head", 1), ("wave", 1))
        robot.go(after, every=8)
        assert robot.world.voice.saying and robot.stance.walking and robot.body.moving()
        world, poses, passed = robot.world, [], []

        def moved(poses=poses, passed=passed, world=world, robot=robot, move=world._move):
            move()
            passed.append(bool(world.voice.saying))
            if len(poses) < 230:
                poses.append(np.concatenate([robot.joints(), robot.body.torso().position]))

        world._move = moved
        world.stop()
        assert not any(passed)  # silent at once
        held = np.array(poses[24:])  # from a tenth of a second on, for the second that it holds
        assert np.abs(held - held[-1]).max() < 0.012
        assert robot.body.limp and robot.body.torso().position[2] < 0.26  # crouched, motors off


def test_what_a_behaviour_has_moved_goes_back_when_it_is_switched_off():
    left, right = (use(s, "SetJointPosition", joint=f"{s.upper()}ShoulderPitch", speed=0.6) for s in "lr")
    robot = Robot([left, right, use("knee", "SetJointPosition", joint="RKneePitch", speed=0.6)])
    robot.order(("l", 0.0), ("r", 0.0), ("knee", 1.2))
    robot.go(1.2, every=24)
    robot.order(("r", 0.4))  # goes on moving this one
    robot.order(("l", None), ("knee", None), ("r", None), release=True)
    robot.go(0.3, every=24)
    start = robot.body.start
    assert 0.1 < robot.body.position("LShoulderPitch") < 1.2  # smoothly
    robot.go(2, every=24)
    assert robot.body.position("LShoulderPitch") == pytest.approx(start["LShoulderPitch"], abs=0.02)
    assert robot.body.position("RKneePitch") == pytest.approx(start["RKneePitch"], abs=0.02)
    assert robot.body.position("RShoulderPitch") == pytest.approx(0.4, abs=0.02)
    assert upright(robot) > 0.98


@pytest.mark.soak
@pytest.mark.parametrize("book", sorted(p.name for p in bundled("workbooks").glob("*.xlsx")))
def test_nothing_falls_in_any_workbook(book, tmp_path):
    _, result = api.run(
        bundled("workbooks", book), api.RunSettings(seconds=60, fast=True, out=tmp_path / "o", film=False)
    )
    if result is None:
        pytest.skip("a workbook with mistakes")
    lines = [json.loads(line) for line in (tmp_path / "o" / "trace.jsonl").read_text().splitlines()]
    assert not [line for line in lines if "has fallen" in str(line.get("text", ""))]


@pytest.mark.soak
def test_no_gesture_makes_it_fall():
    robot = Robot([GESTURE])
    least = 1.0
    for name in ROBOT.gestures:
        done = len(robot.dones("gesture"))
        robot.order(("gesture", name))
        while len(robot.dones("gesture")) == done:
            robot.go(0.2, every=24)
            least = min(least, upright(robot))
        assert robot.dones("gesture")[-1]["completed"] is True, name
        for side in "LR":
            assert robot.ends(side)[:, 2].min() > -0.001, name
        assert upright(robot) > 0.99, name
    assert least > 0.7  # bowing
