"""No limb goes through another: in postures, gestures, on the way between postures, while it points and walks.

Left out are neighbours: a link and the next one towards the torso that has a shape of its own, as joints lie within the
shapes there (the upper arm in the torso's side, the thigh in the hip, the head on the neck). All other pairs count.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping

import pytest

pytest.importorskip("pybullet")
import numpy as np
import pybullet
from pybullet_utils.bullet_client import BulletClient

from rrp_sheets.model.names import key
from rrp_sheets.robots import load_robot
from rrp_sheets.robots.trajectory import Planner
from rrp_sheets.sim.actuators.tracker import Pointing
from rrp_sheets.sim.body import Body
from rrp_sheets.sim.gait import STEP_TIME, FootPlace, Gait, Legs, Standing

ROBOT = load_robot()
HOME = {joint: float(angle) for joint, angle in ROBOT.data["postures"]["StandInit"].items()}
DEEP = 0.003  # m: where shapes are simpler than what is seen, they may touch a little
EVERY = 0.1  # s, between two looks


class Shapes:
    """The robot's shapes, put into poses without physics."""

    def __init__(self) -> None:
        self._b = BulletClient(connection_mode=pybullet.DIRECT)
        self._b.createMultiBody(0, self._b.createCollisionShape(pybullet.GEOM_PLANE))
        self.body = Body(self._b, ROBOT)
        self._names = {i: name for name, i in self.body.links.items()} | {-1: "torso"}
        parents = {i: self._b.getJointInfo(self.body.id, i)[16] for i in self.body.links.values()}
        solid = [i for i in self._names if self._b.getCollisionShapeData(self.body.id, i)]
        neighbours = set()
        for link in solid:
            above = parents.get(link, -1)
            while above not in solid:
                above = parents[above]
            neighbours.add(frozenset((link, above)))
        self._pairs = [p for p in itertools.combinations(sorted(solid), 2) if frozenset(p) not in neighbours]
        assert len(self._pairs) > 70

    def inside(self, pose: Mapping[str, float]) -> list[tuple[str, str, float]]:
        """Links that are inside each other in a pose, with the depth (mm)."""
        for joint, angle in (HOME | dict(pose)).items():
            self._b.resetJointState(self.body.id, self.body.index[joint], angle)
        found = []
        for one, other in self._pairs:
            near = self._b.getClosestPoints(self.body.id, self.body.id, -DEEP, one, other)
            found += [(self._names[one], self._names[other], round(-1000 * p[8], 1)) for p in near if p[8] < -DEEP]
        return found

    def check(self, poses: Iterable[tuple[object, Mapping[str, float]]]) -> None:
        """No pose has a limb in another."""
        wrong = [(what, *pair) for what, pose in poses for pair in self.inside(pose)]
        assert wrong == []


@pytest.fixture(scope="module")
def shapes():
    return Shapes()


def plan_of(frames, home):
    plan = Planner(ROBOT, home, home).plan(frames)
    for k in range(math.ceil(plan.length / EVERY) + 1):
        yield round(k * EVERY, 1), {joint: way.at(min(k * EVERY, plan.length))[0] for joint, way in plan.ways.items()}


def test_the_check_sees_an_arm_in_the_body(shapes):
    through = shapes.inside({"LShoulderPitch": 1.0, "LShoulderRoll": -0.3, "LElbowRoll": -1.5, "LElbowYaw": 0.0})
    assert ("torso", "l_wrist") in {tuple(pair[:2]) for pair in through}


def test_postures_and_the_ways_between_them(shapes):
    postures = ROBOT.data["postures"]
    shapes.check(postures.items())
    ways = [("StandInit", "Crouch"), *((by, name) for name, by in ROBOT.data["posture_ways"].items())]
    for one, other in ways:
        between = [
            {j: postures[one][j] + part * (postures[other][j] - postures[one][j]) for j in HOME}
            for part in np.linspace(0.1, 0.9, 5)
        ]
        shapes.check(((one, other, n), pose) for n, pose in enumerate(between))


@pytest.mark.slow
@pytest.mark.parametrize("name", ROBOT.gestures)
def test_gestures(shapes, name):
    shapes.check(((name, t), pose) for t, pose in plan_of(ROBOT.motions[key(name)].timed(), HOME))


def test_arms_that_point_anywhere_and_the_head_at_its_limits(shapes):
    pointing = Pointing(shapes.body)
    shapes.inside({})
    poses = []
    for yaw, up in itertools.product(np.linspace(-math.pi, math.pi, 17), (-0.8, -0.3, 0.1, 0.6, 1.2)):
        target = np.array([math.cos(yaw), math.sin(yaw), 0.42 + up])
        look = max(-2.0, min(2.0, float(yaw)))
        low, high = shapes.body.limits("HeadPitch", look)
        pitch = min(max(-up, low), high)
        poses.append(
            ((round(float(yaw), 1), up), {**pointing.joints("L", target), "HeadYaw": look, "HeadPitch": pitch})
        )
        poses.append((("R", yaw, up), pointing.joints("R", target)))
        poses.append((("both", yaw, up), {**pointing.joints("R", target), **pointing.joints("L", target)}))
    shapes.check(poses)


def test_legs_that_walk_and_turn(shapes):
    standing = Standing(
        np.array([0.0097, 0.0, 0.3204]), 0.1, {s: np.array([0.0, y, 0.04519]) for s, y in (("L", 0.05), ("R", -0.05))}
    )
    for way in ((0.2, 0, 0), (-0.1, 0.1, 0), (0, -0.1, 0), (0, 0, 1.2), (0, 0, -1.2)):
        gait, poses = Gait(Legs(ROBOT.data["legs"]), standing, FootPlace(0, 0, 0)), []
        gait.go(FootPlace(*way))
        while not gait.beside:
            poses.append(((way, len(poses)), gait.step(STEP_TIME / 12)[2]))
        assert len(poses) > 24
        shapes.check(poses)
