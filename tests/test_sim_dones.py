"""The end of every command of the simulated robot, and who may move what (design: 4-streams)."""

from __future__ import annotations

from typing import Any

import pytest

pytest.importorskip("pybullet")
pytest.importorskip("cv2")

from test_sim_run import RED, ROBOT, scene_of

from rrp_sheets.drivers.simulated import SimulatedWorld
from rrp_sheets.model.exchange import DONE, Command, DeviceUse

RATE = 30
BALL = "| 0 | Red ball | appears | at 1, 0.3, 0.45 |"
SAY = DeviceUse("say", "Say", "SayInput", {})
OTHER = DeviceUse("other", "Other", "SayParameter", {"text": "Good bye"})
EYES = DeviceUse("eyes", "Eyes", "EyeLedColor", {})
PRINT = DeviceUse("print", "Print", "Print", {})
YAW = DeviceUse("yaw", "Yaw", "SetJointPosition", {"joint": "HeadYaw"})
PITCH = DeviceUse("pitch", "Pitch", "SetJointPosition", {"joint": "HeadPitch"})
HEAD = DeviceUse("head", "Head", "SetJointPosition", {"joint": "Head"})
TRACK = DeviceUse("track", "Track", "Tracker", {"mode": "Head"})
ARM = DeviceUse("arm", "Arm", "Tracker", {"mode": "Move", "effector": "Left arm"})
WAVE = DeviceUse("wave", "Wave", "Gesture", {"name": "Wave"})


class Play:
    """What a world gave: done events as (frame, stream, value, completed, seconds), and what was told."""

    def __init__(
        self, devices: tuple[DeviceUse, ...], commands: dict[int, list[tuple]], frames: int, scene: str = BALL
    ):
        self.dones: list[tuple[int, str, Any, bool, float]] = []
        self.events: list[tuple[int, str, Any]] = []
        self.told: list[tuple[int, str, str]] = []
        dones = {f"{d.stream}done": d.stream for d in devices}
        world = SimulatedWorld(ROBOT, (RED,), devices, scene_of(scene), dones=dones, frame_rate=RATE)
        try:
            world.start()
            for frame in range(1, frames + 1):
                orders = [
                    Command(stream, value, f"T!{n}", ("redball",), (*more, 0.0)[0])
                    for n, (stream, value, *more) in enumerate(commands.get(frame - 1, []), start=2)
                ]
                arrivals = world.advance(frame * 1_000_000 // RATE, orders)
                self.told += [(frame, h.kind, h.row) for h in arrivals.happenings if h.kind != "say"]
                for stream, value in arrivals.events:
                    if stream in dones:
                        assert value.type is DONE
                        got = (frame, stream, value.get("value"), value.get("completed"), value.get("seconds"))
                        self.dones.append(got)
            self.state = world.state()
        finally:
            world.stop()

    @property
    def short(self) -> list[tuple[str, Any, bool]]:
        return [(stream.removesuffix("done"), value, completed) for _, stream, value, completed, _ in self.dones]


def test_what_is_done_at_once_is_done_in_the_next_frame():
    p = Play((EYES, PRINT), {3: [("eyes", "red"), ("print", 7), ("eyes", "no colour"), ("eyes", None)]}, 10)
    assert p.dones == [
        (4, "eyesdone", "red", True, 0.0), (4, "printdone", 7, True, 0.0), (4, "eyesdone", "no colour", False, 0.0),
    ]  # fmt: skip


def test_a_sentence_is_done_when_its_audio_is():
    p = Play((SAY,), {0: [("say", "Hello, I am a robot.")]}, 90)
    ((frame, _, value, completed, seconds),) = p.dones
    assert (value, completed) == ("Hello, I am a robot.", True)
    assert 1.0 < seconds < 2.5 and frame == pytest.approx(seconds * RATE, abs=1.1)


def test_the_voice_queues_one_and_a_newer_one_takes_its_place():
    p = Play((SAY, OTHER), {0: [("say", "First.")], 3: [("say", "Second."), ("other", 1)]}, 120)
    assert p.short == [("say", "Second.", False), ("say", "First.", True), ("other", 1, True)]
    assert p.dones[0][4] == 0.0  # it never began


def test_a_larger_priority_interrupts_and_a_smaller_one_is_refused():
    p = Play(
        (SAY, OTHER), {0: [("say", "A long calm sentence.", 1)], 5: [("say", "Small.", 0)], 9: [("other", 1, 2)]}, 90
    )
    assert p.short == [("say", "Small.", False), ("say", "A long calm sentence.", False), ("other", 1, True)]
    assert p.told == [(6, "error", "T!2")]


def test_blank_ends_what_its_stream_says_and_has_waiting_and_starts_nothing():
    p = Play((SAY,), {0: [("say", "First sentence."), ("say", "Second.")], 9: [("say", None)], 12: [("say", None)]}, 60)
    assert p.short == [("say", "Second.", False), ("say", "First sentence.", False)]
    assert p.dones[1][4] == pytest.approx(9 / RATE, abs=0.01)


def test_blank_for_one_stream_lets_the_other_speak():
    p = Play((SAY, OTHER), {0: [("say", "A first long sentence."), ("other", 1)], 6: [("say", None)]}, 90)
    assert p.short == [("say", "A first long sentence.", False), ("other", 1, True)]


def test_a_joint_is_done_when_it_is_there():
    p = Play((YAW, PITCH), {0: [("yaw", 1.0), ("pitch", 0.2)]}, 60)
    assert sorted(p.short) == [("pitch", 0.2, True), ("yaw", 1.0, True)]  # two joints of the head do not conflict
    assert all(0.2 < seconds < 1.5 for *_, seconds in p.dones)
    assert p.state.joints["HeadYaw"] == pytest.approx(1.0, abs=0.03)


def test_a_newer_command_for_the_same_joint_replaces():
    p = Play((YAW, HEAD), {0: [("yaw", 1.0)], 6: [("head", (-0.5, 0.0))]}, 90)
    assert p.short == [("yaw", 1.0, False), ("head", (-0.5, 0.0), True)]


def test_blank_stops_a_joint():
    p = Play((YAW,), {0: [("yaw", 1.5)], 5: [("yaw", None)], 40: [("yaw", None)]}, 60)
    assert p.short == [("yaw", 1.5, False)] and 0.05 < p.state.joints["HeadYaw"] < 1.2


def test_a_tracker_that_is_fed_again_and_again_is_one_command():
    p = Play((TRACK,), {**{f: [("track", f)] for f in range(0, 60, 3)}, 70: [("track", None)]}, 80)
    assert p.short == [("track", 57, False)]
    assert p.dones[0][4] == pytest.approx(70 / RATE, abs=0.01)


def test_an_outranked_tracker_resumes():
    feed = {f: [("track", 1)] for f in range(0, 90, 3)}
    p = Play((TRACK, YAW), {**feed, 31: [("yaw", -1.0, 5)]}, 90)
    assert p.short == [("yaw", -1.0, True)]  # the tracker's command goes on: it is not done
    assert p.state.joints["HeadYaw"] == pytest.approx(0.29, abs=0.08)  # it looks at the ball again
    assert p.told == []


def test_at_equal_priority_a_joint_replaces_a_tracker():
    p = Play((TRACK, YAW), {0: [("track", 1)], 30: [("yaw", -1.0)]}, 80)
    assert p.short == [("track", 1, False), ("yaw", -1.0, True)]
    assert p.state.joints["HeadYaw"] == pytest.approx(-1.0, abs=0.03)


def test_a_tracker_of_smaller_priority_waits_and_is_told_once():
    feed = {f: [("track", 1)] for f in range(3, 60, 3)}
    p = Play((TRACK, HEAD), {0: [("head", (-1.2, 0.1), 5)], **feed}, 90)
    assert p.told == [(4, "error", "T!2")] and p.short == [("head", (-1.2, 0.1), True)]
    assert p.state.joints["HeadYaw"] > 0.2


def test_a_tracker_that_gets_no_more_events_gives_way_to_another_mode():
    feed = {f: [("arm", 1)] for f in range(45, 80, 3)}
    p = Play((TRACK, ARM), {0: [("track", 1)], **feed}, 80)
    assert p.short == [("track", 1, False)]


def test_what_the_simulator_lacks_is_told_once_and_done_at_once():
    p = Play((WAVE,), {0: [("wave", 1)], 5: [("wave", 2)], 9: [("wave", None)]}, 12)
    assert p.dones == [(1, "wavedone", 1, False, 0.0), (6, "wavedone", 2, False, 0.0)]
    assert p.told == [(1, "note", "T!2")]


def test_two_plays_are_equal():
    commands = {0: [("say", "One."), ("say", "Two."), ("track", 1)], 20: [("yaw", 1, 2)], 25: [("eyes", "red")]}
    first, second = (Play((SAY, TRACK, YAW, EYES), commands, 60) for _ in range(2))
    assert first.dones == second.dones and len(first.dones) == 4
