"""Walking: guided, with feet that step and neither slide nor sink; it stops before what is in its way."""

from __future__ import annotations

import math

import pytest

pytest.importorskip("pybullet")
pytest.importorskip("cv2")
import numpy as np
from motion import RED, Robot, use

from rrp_sheets.model.exchange import SceneAction

WALK = use("walk", "Walk")


class Feet:
    """Watches the feet: how far a standing sole slides, how deep one sinks, how high one is lifted."""

    def __init__(self, robot: Robot) -> None:
        self.robot, self.slides, self.sinks, self.lifted = robot, 0.0, 0.0, 0.0
        self._planted: dict[str, np.ndarray] = {}

    def look(self) -> None:
        for side in "LR":
            ends = self.robot.ends(side)
            self.sinks = max(self.sinks, -float(ends[:, 2].min()))
            self.lifted = max(self.lifted, float(ends[:, 2].min()))
            if side == self.robot.stance.swings:
                self._planted.pop(side, None)
            before = self._planted.setdefault(side, ends)
            self.slides = max(self.slides, float(np.abs(ends - before)[:, :2].max()))


@pytest.mark.slow
@pytest.mark.parametrize("way", [(0.15, 0.0, 0.0), (-0.08, 0.04, 0.0), (0.0, 0.0, -0.7)])
def test_it_gets_where_it_is_sent_with_steps(way):
    robot = Robot([WALK])
    goal, feet = robot.stance.middle.plus(*way), Feet(robot)
    robot.order(("walk", way))
    while not robot.dones("walk") and robot.steps < 240 * 8:
        robot.go(1 / 60, feet.look)
    robot.go(0.8)
    here = robot.stance.middle
    assert math.hypot(here.x - goal.x, here.y - goal.y) < 0.004
    assert here.yaw == pytest.approx(goal.yaw, abs=0.01)
    assert feet.lifted > 0.01
    assert (feet.slides < 0.002, feet.sinks < 0.0005) == (True, True)
    assert [d["completed"] for d in robot.dones("walk")] == [True]
    assert not robot.stance.guided  # it stands on its own again
    before = robot.joints()
    robot.go(1.0)
    assert np.abs(robot.joints() - before).max() < 0.01
    assert robot.body.tilt()[0] == pytest.approx(0, abs=0.01)


def test_it_can_be_stopped_and_sent_elsewhere_in_the_midst_of_a_step():
    robot = Robot([WALK])
    robot.order(("walk", (1, 0, 0)))
    robot.go(1.1)
    robot.order(("walk", (0, 0, 0.5)))  # another one replaces it
    robot.go(0.5)
    robot.order(("walk", (0, 0, 0.5)))  # the same again lets it go on
    robot.go(2)
    assert [d["completed"] for d in robot.dones("walk")] == [False, False, True]
    assert robot.body.tilt()[2] == pytest.approx(0.5, abs=0.02)
    robot.order(("walk", (1, 0, 0)))
    robot.go(0.9)
    robot.order(("walk", None))
    assert robot.dones("walk")[-1]["completed"] is False
    robot.go(1.2)
    assert robot.stance.upright
    assert np.abs(robot.ends("L")[:, 2]).max() < 0.001
    assert np.abs(robot.ends("R")[:, 2]).max() < 0.001


@pytest.mark.parametrize(
    ("thing", "values"),
    [
        ("Wall", {"at": (0.5, 0.0), "size": (2.0, 0.8)}),
        pytest.param("Anna", {"at": (0.6, 0.05, 0.6)}, marks=pytest.mark.slow),
    ],
)
def test_it_stops_before_what_is_in_its_way(thing, values):
    kind = "wall" if thing == "Wall" else "person"
    robot = Robot([WALK], scene=[SceneAction(0, thing, "appear", values, kind=kind)])
    robot.order(("walk", (1, 0, 0)))
    robot.go(5, every=8)
    assert [d["completed"] for d in robot.dones("walk")] == [False]
    assert [(h.kind, h.row) for h in robot.told] == [("note", "Test!2")]
    assert f"{thing} is in the way" in robot.told[0].text
    assert 0.1 < robot.body.torso().position[0] < 0.4
    robot.order(("walk", (-0.1, 0, 0)))  # away from it
    robot.until_done("walk", 2.5, every=8)
    assert robot.dones("walk")[-1]["completed"] is True


def test_what_it_cannot_walk_is_told():
    robot = Robot([WALK])
    for value in ((float("nan"), 0, 0), (1, 2, 3, 4), "hello", (float("inf"), 0), True, (0, 0, 0)):
        robot.told.clear()
        robot.world._told.clear()
        robot.order(("walk", value))
        assert [h.kind for h in robot.told] == ["error"], value
    assert len(robot.dones("walk")) == 6
    robot.order(("walk", (99, -99, 0)))
    assert [h.text for h in robot.told if h.kind == "clamp"] == ["Walk: Forward: 99 → 3 m, its limit."]
    robot.order(("walk", None))


@pytest.mark.slow
def test_it_gets_up_from_the_floor_before_it_walks():
    robot = Robot([WALK, use("posture", "Posture", name="LyingBack", speed=1.0)])
    robot.order(("posture", 1))
    while not robot.dones("posture"):
        robot.go(0.2, every=48)
    robot.order(("walk", (0.07, 0, 0)))
    steepest, before = 0.0, robot.body.torso().position
    while len(robot.dones("walk")) < 1 and robot.steps < 240 * 20:
        robot.go(0.05, every=12)
        here = robot.body.torso().position
        steepest, before = max(steepest, float(np.linalg.norm(here - before)) / 0.05), here
    assert robot.dones("walk")[-1]["completed"] is True
    assert robot.stance.on_feet
    assert steepest < 0.9  # m/s: it gets up, it does not jump up


def test_it_stands_up_to_walk_and_trackers_know_where_they_look_afterwards():
    ball = SceneAction(0, "Red ball", "appear", {"at": (1.2, -0.3, 0.45), "size": 0.06, "colour": "red"})
    knees = use("knees", "SetJointPosition", joint="LKneePitch", speed=0.5)
    robot = Robot([WALK, knees, use("head", "Tracker", mode="Head")], [RED], [ball])
    robot.order(("knees", 1.4))
    robot.go(1.5, every=8)
    assert not robot.stance.upright
    robot.order(("walk", (0.1, 0, 0.6)), ("head", 1))
    robot.until_done("walk", 6, every=8)
    robot.go(0.7, every=8)
    assert robot.dones("walk")[-1]["completed"] is True
    camera = robot.body.camera()
    towards = np.array([1.2, -0.3, 0.45]) - camera.position
    assert float(camera.rotation[:, 0] @ towards) > math.cos(0.06) * float(np.linalg.norm(towards))
    turned = robot.body.tilt()[2]
    assert turned == pytest.approx(0.6, abs=0.01)
