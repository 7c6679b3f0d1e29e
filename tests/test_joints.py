"""Joint commands: groups, lists, hands, coupled hips; what cannot be done is told, and nothing falls."""

from __future__ import annotations

import pytest

pytest.importorskip("pybullet")
pytest.importorskip("cv2")
from motion import ROBOT, Robot, use

LEGS = ROBOT.groups["legs"]


def joint(stream, name, speed=1.0):
    return use(stream, "SetJointPosition", joint=name, speed=speed)


def test_one_motor_moves_both_hips():
    robot = Robot([joint("legs", "Legs"), joint("left", "LHipYawPitch"), joint("right", "RHipYawPitch")])
    angles = [robot.body.start[name] for name in LEGS]
    angles[LEGS.index("LHipYawPitch")], angles[LEGS.index("RHipYawPitch")] = 0.1, -0.2
    robot.order(("legs", angles))
    robot.go(1.2, every=24)
    assert [h.text for h in robot.told] == [
        "LHipYawPitch: 0.1 → -0.2 rad, as one motor moves it together with RHipYawPitch."
    ]
    for name in ("LHipYawPitch", "RHipYawPitch"):
        assert robot.body.position(name) == pytest.approx(-0.2, abs=0.01)
    assert robot.dones("legs")[-1]["completed"] is True
    robot.order(("left", 0.2))
    robot.go(0.1, every=24)
    robot.order(("right", 0.0))  # the same motor: it replaces the other
    robot.go(0.8, every=24)
    assert [robot.dones(s)[-1]["completed"] for s in ("left", "right")] == [False, True]
    assert robot.body.position("LHipYawPitch") == pytest.approx(0.0, abs=0.01)


@pytest.mark.parametrize(
    "value", [float("nan"), float("inf"), -float("inf"), True, "left", [1, 2], None, [], (), 10**400]
)
def test_what_is_no_angle_is_told_and_moves_nothing(value):
    robot = Robot([joint("knee", "LKneePitch")])
    before = robot.joints()
    robot.order(("knee", value))
    robot.go(0.1, every=24)
    assert abs(robot.joints() - before).max() < 0.005
    assert [h.kind for h in robot.told] == ([] if value is None else ["error"])


def test_hands_go_from_closed_to_open_and_speed_is_a_share():
    robot = Robot([joint("hand", "LHand"), joint("arm", "RShoulderPitch", 0.1)])
    robot.order(("hand", 7), ("arm", 0.0))
    robot.go(1.0, every=24)
    assert [h.text for h in robot.told] == ["LHand: 7 → 1, its limit."]
    assert robot.body.position("LHand") == pytest.approx(1.0, abs=0.02)
    turned = robot.body.start["RShoulderPitch"] - robot.body.position("RShoulderPitch")
    assert 0.6 < turned < 0.1 * ROBOT.joints["rshoulderpitch"].max_velocity * 1.05
