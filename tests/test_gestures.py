"""Gestures: smooth, within every limit, back to where they began, and stopped at any time without a jerk."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest

pytest.importorskip("pybullet")
pytest.importorskip("cv2")

from hypothesis import given, settings
from hypothesis import strategies as st
from play import check, rows
from test_sim_run import RED, scene_of

from rrp_sheets.model.exchange import Command, DeviceUse
from rrp_sheets.model.names import key
from rrp_sheets.robots import load_robot
from rrp_sheets.robots.catalogue import Keyframe, load_gestures
from rrp_sheets.robots.trajectory import MARGIN, JointLimits, Planner
from rrp_sheets.sim.body import STEP, Motion, Motions
from rrp_sheets.sim.process import Spec
from rrp_sheets.sim.world import SimWorld

ROBOT = load_robot()
LIMITS = JointLimits(ROBOT)
HOME = {j: float(a) for j, a in ROBOT.data["postures"]["StandInit"].items()}
EXPECTED = """Wave, Nod, Shake head, Bow, Point left, Point right, Raise hand, Arms up, Arms wide, Touch head, Clap, Shrug, Dance,
    I don't know, Thinking"""
JERK = 2.0  # rad/s in one step of the physics: more than that is a jump, not a brake
SHOW = DeviceUse("show", "Show", "Gesture", {"name": ""})
WAVE = DeviceUse("wave", "Wave", "Gesture", {"name": "Wave"})
NOD = DeviceUse("nod", "Nod", "Gesture", {"name": "Nod"})
TALKING, STILL = (
    DeviceUse("say", "Say", "SayInput", ROBOT.devices["sayinput"].with_defaults({"gestures": on}))
    for on in (True, False)
)


def sampled(frames, home=HOME, **how):
    """The plan's angles by joint, 240 times a second."""
    plan = Planner(ROBOT, home, home, **how).plan(frames)
    count = math.ceil(plan.length / STEP) + 1
    return {joint: [way.at(k * STEP) for k in range(count)] for joint, way in plan.ways.items()}


def assert_within_limits(ways):
    yaws = [angle for angle, _ in ways.get("HeadYaw", [])]
    for joint, samples in ways.items():
        fastest = ROBOT.joints[key(joint)].max_velocity
        for k, (angle, speed) in enumerate(samples):
            low, high = LIMITS.of(joint, yaws[k] if yaws else 0.0)
            assert low - 1e-6 <= angle <= high + 1e-6, (joint, k * STEP)
            assert abs(speed) <= fastest, (joint, k * STEP)
        for (a, u), (b, v) in pairwise(samples):
            assert abs(b - a) <= fastest * STEP * 1.001  # no jump: it goes no faster than it says
            assert abs(v - u) < JERK, joint


# ---- the robot's own


def test_the_gestures_that_a_therapist_expects_are_there():
    assert {key(name) for name in EXPECTED.split(",")} <= set(ROBOT.motions)
    assert all(len(g.help) > 8 and not g.help.endswith(".") for g in ROBOT.motions.values())


@pytest.mark.slow
@pytest.mark.parametrize("name", ROBOT.gestures)
def test_a_gesture_keeps_the_limits_and_comes_back(name):
    gesture = ROBOT.motions[key(name)]
    plan = Planner(ROBOT, HOME, HOME).plan(gesture.timed())
    assert not plan.clamped and not plan.slowed, "the data itself is within the limits"
    assert 1.2 < plan.length < 11
    ways = sampled(gesture.timed())
    assert_within_limits(ways)
    for joint, samples in ways.items():
        assert samples[0][0] == samples[-1][0] == HOME[joint] and samples[-1][1] == 0


@pytest.mark.parametrize("tempo", [40, 200])
def test_a_dance_keeps_the_limits_at_any_tempo(tempo):
    dance = ROBOT.motions["dance"]
    assert_within_limits(sampled(dance.timed(tempo)))
    beats = [f.at for f in dance.timed(tempo)]
    assert beats[1] - beats[0] == pytest.approx(60 / tempo)


angles = st.fixed_dictionaries(
    {}, optional={j: st.floats(-4, 4) for j in ("HeadYaw", "HeadPitch", "LElbowRoll", "RHand")}
)


@pytest.mark.slow
@given(st.lists(st.tuples(st.floats(0.01, 2), angles), min_size=1, max_size=6), st.floats(-2, 2), st.floats(0.05, 1))
def test_no_keyframes_whatever_lead_beyond_the_limits(lines, yaw, share):
    at, frames = 0.0, []
    for gap, joints in lines:
        at += gap
        frames.append(Keyframe(at, joints))
    low, high = LIMITS.of("HeadPitch", yaw)
    ways = sampled(frames, {**HOME, "HeadYaw": yaw, "HeadPitch": min(max(0.0, low), high)}, share=share)
    for joint, samples in ways.items():
        j = ROBOT.joints[key(joint)]
        assert all(j.lower - 1e-6 <= a <= j.upper + 1e-6 for a, _ in samples)
        assert max(abs(v) for _, v in samples) <= share * j.max_velocity * MARGIN * 1.01


def test_the_head_nods_less_while_it_turns_past_a_shoulder():
    ways = sampled([Keyframe(1, {"HeadYaw": 0.0, "HeadPitch": 0.29}), Keyframe(3, {"HeadYaw": 2.0, "HeadPitch": 0.29})])
    high = LIMITS.of("HeadPitch", 1.5)[1]
    assert high < 0.29 < min(LIMITS.of("HeadPitch", yaw)[1] for yaw in (0.0, 2.0)), "both ends alone allow it"
    assert max(angle for angle, _ in ways["HeadPitch"]) <= high + 0.001


# ---- interrupted


@pytest.fixture(scope="module")
def body():
    world = SimWorld(Spec(ROBOT))
    yield world.body
    world.close()


@settings(max_examples=15)
@given(st.lists(st.tuples(st.sampled_from(ROBOT.gestures), st.integers(1, 500), st.booleans()), min_size=1, max_size=4))
def test_a_gesture_can_be_stopped_at_any_time_without_a_jerk(body, plays):
    motions, joints = Motions(), list(HOME)
    for joint, angle in HOME.items():
        body.put(joint, angle)
    at = dict(HOME)
    speed = dict.fromkeys(joints, 0.0)

    def step():
        motions.step()
        body.step()
        for joint in joints:
            now = body.set_point(joint)
            j = ROBOT.joints[key(joint)]
            v = (now - at[joint]) / STEP
            assert j.lower - 1e-6 <= now <= j.upper + 1e-6, joint
            assert abs(v) <= j.max_velocity * 1.001 and abs(v - speed[joint]) < JERK, joint
            at[joint], speed[joint] = now, v

    for name, steps, home in plays:
        motion = Motion(body, ROBOT.motions[key(name)].timed())
        motions.begin(motion)
        for _ in range(steps):
            step()
        motion.halt(home=home)
    for _ in range(1200):
        step()
        if not body.moving():
            break
    assert not body.moving()
    if all(home for *_, home in plays):
        assert at == pytest.approx(HOME, abs=1e-4)


# ---- in the simulator


class Watched:
    """Result of a world without a scene: the ends of commands, the notices, and the joints of every frame."""

    def __init__(self, devices, commands, frames):
        self.short, self.told, self.joints = [], [], []
        world = SimWorld(Spec(ROBOT, actuators=devices, dones={d.stream: f"{d.stream}done" for d in devices}))
        try:
            for frame in range(frames):
                orders = [
                    Command(s, v, f"T!{n}", (), (*more, 0.0)[0])
                    for n, (s, v, *more) in enumerate(commands.get(frame, []), 2)
                ]
                outcome = world.advance((frame + 1) * 1_000_000 // 30, orders)
                self.told += [n.kind for n in outcome.notices if n.kind != "say"]
                self.short += [(s.removesuffix("done"), v["value"], v["completed"]) for s, v in outcome.events]
                self.joints.append(world.state().joints)
        finally:
            world.close()


@pytest.fixture(scope="module")
def waved():
    return Watched((WAVE, NOD), {0: [("wave", 1), ("nod", 1)], 20: [("wave", 2)]}, 130)


@pytest.mark.slow
def test_one_done_event_for_each_command(waved):
    assert waved.short == [("wave", 1, False), ("nod", 1, True), ("wave", 2, True)]


def test_the_hand_goes_up_waves_and_comes_back(waved):
    lifted = [joints["RShoulderPitch"] for joints in waved.joints]
    swings = [joints["RShoulderRoll"] for joints in waved.joints[30:75]]
    assert min(lifted) < -0.9 and max(swings) - min(swings) > 0.3
    assert waved.joints[-1] == pytest.approx(HOME, abs=0.02)


def test_the_same_again_lets_it_go_on(waved):
    """The second command came in the middle of the first wave: the arm is not sent to begin anew."""
    lifted = [joints["RShoulderPitch"] for joints in waved.joints[18:26]]
    assert lifted == sorted(lifted, reverse=True)


@pytest.mark.slow
def test_the_same_again_while_the_arm_goes_back_is_made_again(waved):
    """It began as the arm returned: a wave of its own, at whose end it is completed, and back where it was at first."""
    end = max(
        n for n, joints in enumerate(waved.joints) if abs(joints["RShoulderPitch"] - HOME["RShoulderPitch"]) > 0.2
    )
    again = Watched((WAVE,), {0: [("wave", 1)], end: [("wave", 2)]}, end + 130)
    assert again.short == [("wave", 1, False), ("wave", 2, True)]
    assert min(joints["RShoulderPitch"] for joints in again.joints[end + 15 :]) < -0.9
    assert again.joints[-1] == pytest.approx(HOME, abs=0.02)


@pytest.mark.slow
def test_a_gesture_gives_way_to_a_larger_priority_and_is_refused_below_it():
    turn = DeviceUse("turn", "Turn", "SetJointPosition", {"joint": "HeadYaw", "speed": 0.3})
    p = Watched((NOD, turn), {0: [("nod", 1)], 6: [("turn", 0.5, 1.0)], 8: [("nod", 2)]}, 55)
    assert p.short == [("nod", 1, False), ("turn", 0.5, True), ("nod", 2, True)]  # yaw and pitch are two joints
    head = DeviceUse("head", "Head", "SetJointPosition", {"joint": "Head", "speed": 0.1})
    p = Watched((NOD, head), {0: [("nod", 1)], 6: [("head", [0.5, 0.1], 1.0)], 8: [("nod", 2)]}, 50)
    assert p.short == [("nod", 1, False), ("nod", 2, False), ("head", [0.5, 0.1], True)]
    assert p.told == ["error"]


@pytest.mark.slow
def test_blank_brings_the_arm_back():
    p = Watched((WAVE,), {0: [("wave", 1)], 30: [("wave", None)]}, 97)
    assert p.short == [("wave", 1, False)]
    assert p.joints[30]["RShoulderPitch"] < 0 and p.joints[-1] == pytest.approx(HOME, abs=0.02)


@pytest.mark.parametrize(
    ("value", "kind", "words"),
    [
        ("Wve", "error", "Wave"),
        ("raise arm", "error", "Raise hand"),
        ("Zzzz", "error", "Nod"),
        (3, "error", ""),
        ("nod", "", ""),
        ("  I DON'T know", "", ""),
    ],
)
def test_a_value_names_the_gesture(value, kind, words):
    world = SimWorld(Spec(ROBOT, actuators=(DeviceUse("g", "Show", "Gesture", {"name": "", "times": 1}),)))
    try:
        outcome = world.advance(100_000, [Command("g", value, "T!2")])
        assert [n.kind for n in outcome.notices] == ([kind] if kind else [])
        assert all(words in n.text for n in outcome.notices)
        assert ("head" in world.state().driving) == (not kind)
    finally:
        world.close()


@pytest.mark.parametrize(("y", "side"), [pytest.param(0.4, "L", marks=pytest.mark.slow), (-0.4, "R")])
def test_it_points_at_what_is_seen_with_the_nearer_arm(y, side):
    scene = scene_of(f"| 0 | Red ball | appears | at 1, {y}, 0.45 |")
    world = SimWorld(
        Spec(ROBOT, (RED,), (DeviceUse("g", "Show", "Gesture", {"name": ""}),), scene, dones={"g": "gdone"})
    )
    try:
        events = [e for n in range(10) for e in world.advance((n + 1) * 33_333, ()).events]
        seen = ROBOT.devices["redball"].payload.make(**events[-1][1])
        world.advance(400_000, [Command("g", seen, "T!2", ("redball",))])
        world.advance(1_900_000, ())
        shoulder = world.body.link(f"{side}Shoulder").position
        finger = world.body.link(f"{side}Fingers").position
        ball = [1, y, 0.45]
        along = (finger - shoulder) / math.dist(finger, shoulder)
        wanted = (ball - shoulder) / math.dist(ball, shoulder)
        assert float(along @ wanted) > 0.985  # within 10°
        world.advance(3_300_000, ())
        assert world.state().joints == pytest.approx(HOME, abs=0.02)
    finally:
        world.close()


def test_while_it_talks_the_free_arms_move_and_give_way():
    text = "This sentence is so long that the arms have time to move."
    p = Watched((TALKING, WAVE), {0: [("say", text)], 30: [("wave", 1)]}, 165)
    left = [joints["LShoulderPitch"] for joints in p.joints]
    right = [joints["RShoulderPitch"] for joints in p.joints]
    assert HOME["LShoulderPitch"] - min(left) > 0.2
    assert min(right[:30]) > 0.9 and min(right) < -0.9  # small while it talks; then the wave has the arm
    assert sorted(p.short) == [("say", text, True), ("wave", 1, True)]
    assert p.joints[-1] == pytest.approx(HOME, abs=0.02)
    silent = Watched((STILL,), {0: [("say", text)]}, 45)
    assert all(abs(j["LShoulderPitch"] - HOME["LShoulderPitch"]) < 0.02 for j in silent.joints)


def test_resources_of_gestures_are_those_of_their_joints():
    uses = {name: ROBOT.devices["gesture"].resources_for({"name": name}) for name in ROBOT.gestures}
    assert uses["Wave"] == {"right arm"} and uses["Shrug"] == {"head", "left arm", "right arm"}
    assert "legs" in uses["Bow"] and "legs" in uses["Dance"]


def test_a_robot_without_a_file_of_gestures_has_none(tmp_path):
    assert load_gestures(tmp_path / "gestures.toml", ["HeadYaw"]) == ({}, ())


def test_a_gesture_in_a_workbook_runs_without_a_finding():
    assert check(rows('| Touch | subscribe | "Wave" | Gesture |')).report.flatten(["code"]) == []
