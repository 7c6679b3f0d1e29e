"""Trackers point at what they follow (figures over long courses: benchmarks/bench_motion.py), whatever else it does."""

from __future__ import annotations

import math

import pytest

pytest.importorskip("pybullet")
pytest.importorskip("cv2")
import numpy as np
from motion import RED, Robot, use

from rrp_sheets.model.exchange import SceneAction

HAND = np.array([0.058, 0.0, -0.012])  # m: where the fingers begin, in the wrist's frame


def ball(*at, to=None, seconds=2.0):
    shown = [SceneAction(0, "Red ball", "appear", {"at": at, "size": 0.06, "colour": "red"})]
    return shown + ([SceneAction(500_000, "Red ball", "move", {"to": to, "seconds": seconds})] if to else [])


def off(one, other):
    """The angle between two directions, degrees."""
    return math.degrees(math.acos(min(1.0, float(one @ other / np.linalg.norm(one) / np.linalg.norm(other)))))


def arm_off(robot, side, target):
    shoulder, wrist = (robot.body.link(name) for name in (f"{side}Shoulder", f"{side.lower()}_wrist"))
    return off(wrist.position + wrist.rotation @ HAND - shoulder.position, target - shoulder.position)


def head_off(robot, target):
    camera = robot.body.camera()
    return off(camera.rotation[:, 0], target - camera.position)


def target(robot):
    return np.array(robot.world.stage.balls["redball"].path.at(robot.world.stage.us))


def follow(robot, *streams, seconds, each=lambda: None):
    """Send each tracker an event with every detection."""
    for _ in range(round(seconds * 10)):
        robot.order(*((s, True) for s in streams))
        robot.go(0.1, each, every=24)


@pytest.mark.slow
def test_head_and_both_arms_point_at_a_ball_that_moves():
    arms = use("arms", "Tracker", mode="Move", effector="Both arms")
    robot = Robot([use("head", "Tracker", mode="Head"), arms], [RED], ball(0.8, 0.0, 0.45, to=(0.7, 0.15, 0.35)))
    wrong = []

    def look():
        if robot.steps > 360:
            wrong.append((head_off(robot, target(robot)), *(arm_off(robot, s, target(robot)) for s in "LR")))

    follow(robot, "head", "arms", seconds=3, each=look)
    assert len(wrong) > 12
    assert np.max(wrong, axis=0)[:2].max() < 4.0
    assert np.max(wrong, axis=0)[2] < 8.0  # the right arm is at its limit across the body


def test_one_arm_hands_over_to_the_other_and_is_lowered():
    arm, head = use("arm", "Tracker", mode="Move", effector="Nearest arm"), use("head", "Tracker", mode="Head")
    robot = Robot([arm, head], [RED], ball(0.8, 0.25, 0.45, to=(0.8, -0.3, 0.45), seconds=1.5))
    up = []

    def look():
        up.append("".join(s for s in "LR" if robot.body.position(f"{s}ShoulderPitch") < 0.7))

    follow(robot, "arm", "head", seconds=4.5, each=look)
    changes = [one for one, other in zip(up, ["-", *up], strict=False) if one != other]
    assert changes in (["", "L", "LR", "R"], ["L", "LR", "R"])  # never none on the way
    assert arm_off(robot, "R", target(robot)) < 3.0
    robot.order(("arm", None))
    robot.go(2, every=48)
    assert robot.body.position("RShoulderPitch") == pytest.approx(robot.body.start["RShoulderPitch"], abs=0.02)
    assert head_off(robot, target(robot)) < 3.0  # the head goes on


@pytest.mark.slow
def test_it_points_while_it_sits_and_nothing_turns_it_then():
    body = use("body", "Tracker", mode="Whole body")
    arm = use("arm", "Tracker", mode="Move", effector="Right arm")
    posture = use("posture", "Posture", name="Sit", speed=1.0)
    robot = Robot([posture, body, arm], [RED], ball(0.7, -0.25, 0.3))
    robot.order(("posture", 1))
    while not robot.dones("posture"):
        robot.go(0.2, every=48)
    height = robot.body.torso().position[2]
    follow(robot, "body", "arm", seconds=2)
    assert head_off(robot, target(robot)) < 3.0
    assert arm_off(robot, "R", target(robot)) < 4.0
    assert robot.body.torso().position[2] == pytest.approx(height, abs=0.003)
    assert robot.body.tilt()[2] == pytest.approx(0.0, abs=0.05)


def test_the_whole_body_turns_by_stepping_and_stands_when_it_looks_ahead():
    robot = Robot([use("body", "Tracker", mode="Whole body")], [RED], ball(0.9, 0.75, 0.45))
    slides, lifted = [], []
    planted = {}

    def look():
        for side in "LR":
            ends = robot.ends(side)
            lifted.append(ends[:, 2].min())
            if side == robot.stance.swings:
                planted.pop(side, None)
            slides.append(np.abs(ends - planted.setdefault(side, ends))[:, :2].max())

    robot.body.put("HeadYaw", 0.5)
    robot.go(0.1)
    for _ in range(8):
        robot.order(("body", True))
        robot.go(0.5, look, every=4)
    assert robot.body.tilt()[2] == pytest.approx(math.atan2(0.75, 0.9), abs=0.15)
    assert abs(robot.body.position("HeadYaw")) < 0.2
    assert max(lifted) > 0.01
    assert max(slides) < 0.002
    assert not robot.stance.stepping
    assert head_off(robot, target(robot)) < 3.0
