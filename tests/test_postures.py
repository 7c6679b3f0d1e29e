"""Postures: taken by way of those between, held without falling, told when they are over."""

from __future__ import annotations

import math

import pytest

pytest.importorskip("pybullet")
pytest.importorskip("cv2")

from rrp_sheets.model.exchange import Command, DeviceUse
from rrp_sheets.robots import load_robot
from rrp_sheets.robots.trajectory import route
from rrp_sheets.sim.process import Spec
from rrp_sheets.sim.world import SimWorld

ROBOT = load_robot()
FRAME = 33_333
NOD = DeviceUse("n", "Nod", "Gesture", {"name": "Nod"})


class Stage:
    """A world with a posture actuator, frame by frame."""

    def __init__(self, *uses, speed=0.5):
        posture = DeviceUse("p", "Pose", "Posture", {"name": "", "speed": speed})
        uses = (posture, *uses)
        self.world = SimWorld(Spec(ROBOT, actuators=uses, dones={u.stream: f"{u.stream} done" for u in uses}))
        self.frame = 0
        self.told = []
        self.fastest = {}
        self.joints = self.world.state().joints

    def go(self, frames, *commands):
        """The done events of so many frames, as (stream, value, completed, seconds)."""
        dones = []
        for _ in range(frames):
            self.frame += 1
            outcome = self.world.advance(self.frame * FRAME, commands)
            commands = ()
            self.told += [(n.kind, n.text) for n in outcome.notices]
            dones += [(s.removesuffix(" done"), v["value"], v["completed"], v["seconds"]) for s, v in outcome.events]
            joints = self.world.state().joints
            for joint, angle in joints.items():
                speed = abs(angle - self.joints[joint]) / (FRAME / 1e6)
                self.fastest[joint] = max(self.fastest.get(joint, 0.0), speed)
            self.joints = joints
        return dones

    def take(self, name):
        """Take a posture; the seconds that it took."""
        for _ in range(300):
            dones = self.go(1, *([Command("p", name)] if name else []))
            name = None
            if dones:
                ((_, _, completed, seconds),) = dones
                assert completed
                return seconds
        raise AssertionError("it never ends")


@pytest.fixture
def stage():
    made = []

    def make(*uses, **how):
        made.append(Stage(*uses, **how))
        return made[-1]

    yield make
    for one in made:
        one.world.close()


def assert_taken(stage, name):
    joints = stage.world.state().joints
    for joint, angle in ROBOT.data["postures"][name].items():
        assert joints[joint] == pytest.approx(angle, abs=0.07), (name, joint)


@pytest.mark.slow
def test_it_sits_down_and_stands_up_again(stage):
    s = stage()
    height = s.world.state().base[2]
    assert 1.5 < s.take("sit") < 6
    assert_taken(s, "Sit")
    assert s.world.state().base[2] < height - 0.12
    for joint in ROBOT.joints.values():
        assert s.fastest[joint.name] <= 0.5 * joint.max_velocity * 1.1, joint.name
    s.take("Stand init")
    assert_taken(s, "StandInit")
    state = s.world.state()
    assert state.base[2] == pytest.approx(height, abs=0.005)
    assert max(abs(a) for a in state.base[3:5]) < math.radians(8)
    feet = [s.world.body.sole(side) for side in "LR"]
    assert all(abs(foot.position[2]) < 0.008 and foot.rotation[2, 2] > 0.99 for foot in feet)


@pytest.mark.slow
def test_it_lies_down_and_does_not_sink_in(stage):
    s = stage(speed=1.0)
    s.take("LyingBelly")
    assert_taken(s, "LyingBelly")
    state = s.world.state()
    assert 0.02 < state.base[2] < 0.15
    assert s.world.body.torso().rotation[2, 2] == pytest.approx(0, abs=0.35)  # the torso lies
    assert s.take("LyingBelly") < 0.6  # there already


@pytest.mark.slow
def test_a_faster_speed_is_faster(stage):
    slow, fast = stage(speed=0.2), stage(speed=1.0)
    assert slow.take("Crouch") > 1.5 * fast.take("Crouch")


@pytest.mark.slow
def test_another_posture_on_the_way_and_blank(stage):
    s = stage(NOD)
    assert s.go(20, Command("p", "Sit")) == []
    ((stream, value, completed, _),) = s.go(10, Command("p", "Stand"))
    assert (stream, value, completed) == ("p", "Sit", False)
    ((stream, value, completed, _),) = s.go(1, Command("p", None))
    assert (stream, value, completed) == ("p", "Stand", False)
    held = s.world.state().joints
    s.go(15)
    assert s.world.state().joints == pytest.approx(held, abs=0.15)
    dones = s.go(6, Command("p", "Sit")) + s.go(5, Command("n", True))  # the head is taken from it
    assert [d[:3] for d in dones] == [("p", "Sit", False)]
    assert s.told == []


@pytest.mark.parametrize(
    ("value", "words"),
    [
        ("Sti", "Did you mean Sit?"),
        ("Zzzzz", "There are: Stand, StandInit"),
        (7, "name of a posture"),
        ("", "There are"),
    ],
)
def test_what_is_no_posture_is_told(stage, value, words):
    s = stage()
    ((_, _, completed, seconds),) = s.go(1, Command("p", value))
    assert (completed, seconds) == (False, 0) and words in s.told[0][1]


@pytest.mark.slow
@pytest.mark.parametrize("name", ROBOT.postures)
def test_every_posture_is_reached_from_every_other_by_way_of_crouching(name):
    ways = ROBOT.data["posture_ways"]
    for now in ROBOT.postures:
        found = route(now, name, ways)
        assert found[-1] == name and now not in found[:-1] and len(found) <= 4
        standing = {n for n in ROBOT.postures if n not in ways}
        if (now in standing) != (name in standing):
            assert "Crouch" in (now, *found)


@pytest.mark.soak
@pytest.mark.parametrize("name", ROBOT.postures)
def test_every_posture_is_taken_and_left(stage, name):
    s = stage()
    s.take(name)
    assert_taken(s, name)
    s.go(60)
    assert_taken(s, name)
    s.take("StandInit")
    assert_taken(s, "StandInit")
