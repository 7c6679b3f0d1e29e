"""The simulated robot acts: everything here goes through the engine's door, `SimulatedWorld`."""

from __future__ import annotations

import math
import wave
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("pybullet")
pytest.importorskip("cv2")
import numpy as np
from PIL import Image
from processes import end_simulator

from rrp_sheets.diagnostics.report import Report
from rrp_sheets.drivers.simulated import SimulatedWorld
from rrp_sheets.model.exchange import Command, DeviceUse, Notice, SceneAction
from rrp_sheets.model.values import to_json
from rrp_sheets.model.workbook import Address, Cell, SceneRow
from rrp_sheets.robots import load_robot
from rrp_sheets.scene.scene_sheet import parse_scene

ROBOT = load_robot()
RATE = 30  # frames a second
RED = DeviceUse("redball", "Red ball", "RedBall", {"rate": 10})
FACE = DeviceUse("face", "Face", "FaceDetection", {"rate": 2})


def scene_of(table: str) -> tuple[SceneAction, ...]:
    rows = []
    for number, line in enumerate((row for row in table.strip().splitlines()), start=2):
        texts = [c.strip() for c in line.strip().strip("|").split("|")]
        rows.append(SceneRow(*(Cell(t, Address("Scene", number, c)) for c, t in enumerate(texts, start=1))))
    report = Report()
    scene = parse_scene(rows, report, ROBOT)
    assert not len(report)
    return scene


@dataclass
class Played:
    events: list[tuple[float, str, Any]] = field(default_factory=list)
    happenings: list[tuple[float, Notice]] = field(default_factory=list)
    states: dict[int, Any] = field(default_factory=dict)  # by whole second

    def said(self, kind: str) -> list[str]:
        return [h.text for _, h in self.happenings if h.kind == kind]


def play(
    actuators: Sequence[DeviceUse],
    commands: Mapping[float, Sequence[tuple[str, Any]]] | Callable[[str, Any], Sequence[tuple[str, Any]]],
    seconds: float,
    *,
    scene: str = "| 0 | Red ball | appears | at 1, 0, 0.4 |",
    sensors: Sequence[DeviceUse] = (RED,),
    out: Path | None = None,
    film: bool = False,
    before_stop: Callable[[SimulatedWorld], None] | None = None,
) -> Played:
    """Run a world; `commands` come at times, or are the answer to each event."""
    world = SimulatedWorld(ROBOT, sensors, actuators, scene_of(scene), frame_rate=RATE, out=out, film=film)
    played, streams = Played(), tuple(s.stream for s in sensors)
    try:
        arrivals = world.start()
        for frame in range(1, round(seconds * RATE) + 1):
            played.events += [((frame - 1) / RATE, s, v) for s, v in arrivals.events]
            if callable(commands):
                pairs = [pair for s, v in arrivals.events for pair in commands(s, v)]
            else:
                pairs = [pair for t, many in commands.items() if round(t * RATE) == frame - 1 for pair in many]
            orders = [Command(stream, value, "Test!4", streams) for stream, value in pairs]
            arrivals = world.advance(frame * 1_000_000 // RATE, orders)
            played.happenings += [(frame / RATE, h) for h in arrivals.notices]
            if frame % RATE == 0:
                played.states[frame // RATE] = world.state()
        if before_stop is not None:
            before_stop(world)
    finally:
        (world.stop if film else partial(end_simulator, world))()  # only the film wants the robot at its rest
    return played


def tracker(mode: str, effector: str = "None") -> DeviceUse:
    return DeviceUse("tracker", "Tracker", "Tracker", {"mode": mode, "effector": effector})


def follow(stream: str, value: Any) -> list[tuple[str, Any]]:
    return [("tracker", True)]


@pytest.mark.slow
def test_it_stands_still() -> None:
    joint = DeviceUse("knee", "Knee", "JointPosition", {"joint": "LKneePitch"})
    played = play((), {}, 5, sensors=(joint,), scene="")
    first, last = played.states[1].base, played.states[5].base
    assert np.allclose(first, last, atol=5e-4)
    assert abs(last[3]) < 0.01
    assert [v for _, _, v in played.events] == [pytest.approx(0.7, abs=0.01)]  # once at the start, then no change


@pytest.mark.slow
def test_the_head_follows_a_moving_ball() -> None:
    scene = """
    | 0 | Red ball | appears | at 1, 0, 0.45 |
    | 1 | Red ball | moves | to 0.7, 0.6, 0.5 in 2 s |
    | 4 | Red ball | moves | to 0.7, -0.6, 0.3 in 3 s |"""
    played = play((tracker("Head"),), follow, 8, scene=scene)
    left, right = played.states[4], played.states[8]
    assert left.joints["HeadYaw"] == pytest.approx(math.atan2(0.6, 0.65), abs=0.1)
    assert right.joints["HeadYaw"] == pytest.approx(-math.atan2(0.6, 0.65), abs=0.1)
    assert left.joints["HeadPitch"] < right.joints["HeadPitch"]
    seen = [v for t, _, v in played.events if t > 0.5]
    assert len(seen) >= 74  # hardly a picture without the ball
    assert all(abs(v.get("x")) < 0.2 for v in seen)
    assert np.allclose(left.base, right.base, atol=2e-3)


@pytest.mark.slow
def test_blank_lets_the_ball_go() -> None:
    scene = """
    | 0 | Red ball | appears | at 1, 0.3, 0.45 |
    | 2 | Red ball | moves | to 1, -0.2, 0.45 in 1 s |"""
    played = play((tracker("Head"),), {0.1: [("tracker", 1)], 1.5: [("tracker", None)]}, 4, scene=scene)
    assert played.states[2].joints["HeadYaw"] > 0.25
    assert played.states[4].joints["HeadYaw"] == pytest.approx(played.states[2].joints["HeadYaw"], abs=0.01)


@pytest.mark.slow
def test_the_whole_body_turns_after_the_ball() -> None:
    scene = """
    | 0 | Red ball | appears | at 0.9, 0, 0.4 |
    | 1 | Red ball | circles | radius 0.9 period 16 s around 0, 0, 0.4 flat |"""
    played = play((tracker("Whole body"),), follow, 6, scene=scene)
    yaws = [played.states[s].base[5] for s in range(1, 7)]
    assert yaws[-1] > 1.2  # of 1.96 rad that the ball has gone
    assert yaws == sorted(yaws)
    assert abs(played.states[6].joints["HeadYaw"]) < 0.6
    assert all(0.3 < s.base[2] < 0.34 and abs(s.base[3]) < 0.05 for s in played.states.values())


@pytest.mark.slow
@pytest.mark.parametrize(
    ("place", "value", "arms"),
    [("0.8, 0.4, 0.4", True, "L"), ("0.8, -0.4, 0.4", True, "R"), ("0.8, 0.3, 0.4", "right", "R"),
     ("0.8, -0.3, 0.4", 0.4, "L")],
)  # fmt: skip
def test_the_nearest_or_chosen_arm_points(place: str, value: Any, arms: str) -> None:
    played = play(
        (tracker("Move", "Nearest arm"),), lambda s, v: [("tracker", value)], 2,
        scene=f"| 0 | Red ball | appears | at {place} |",
    )  # fmt: skip
    joints = played.states[2].joints
    raised = "".join(s for s in "LR" if joints[f"{s}ShoulderPitch"] < 0.6 and joints[f"{s}Hand"] > 0.8)
    assert raised == arms
    assert abs(joints["HeadYaw"]) < 0.02  # only the arm moves
    assert abs(played.states[2].base[3]) < 0.02


@pytest.mark.slow
def test_eyes_shine_in_the_picture() -> None:
    eyes = (
        DeviceUse("eyes", "Eyes", "EyeLedColor"),
        DeviceUse("dim", "Dim", "EyeBrightness", {"colour": ""}),
        DeviceUse("fixed", "Fixed", "EyeColor", {"colour": "blue"}),
    )
    pictures: list[Any] = []
    commands = {0.1: [("eyes", "green")], 0.5: [("dim", 0.25), ("eyes", 7)], 1: [("dim", 3)], 1.5: [("fixed", 1)]}
    played = play(eyes, commands, 2, sensors=(), scene="", before_stop=lambda w: pictures.append(w.watch()))
    assert played.states[1].eyes == (0.0, 0.25, 0.0)
    assert played.states[2].eyes == (0.0, 0.0, 1.0)
    red, green, blue = (pictures[0][:, :, c].astype(int) for c in range(3))
    assert ((blue > 150) & (red < 90) & (green < 90)).sum() > 60  # pixels
    assert "colour" in played.said("error")[0]
    assert played.said("clamp") == ["Brightness: 3 → 1, its limit."]


def test_speech_is_audio_and_queues_one(tmp_path: Path) -> None:
    pytest.importorskip("espeakng_loader")
    say = DeviceUse("say", "Say", "SayInput", {"language": "en", "speed": 150, "volume": 100})
    other = DeviceUse("other", "Other", "SayParameter", {"text": "Good bye", "language": "en"})
    commands = {
        0: [("say", "Hello, I am a robot.")], 0.1: [("say", "never heard"), ("other", 1)], 2.3: [("say", 42)],
        2.5: [("say", True)], 3.3: [("say", "A long sentence that is stopped before its end.")], 3.8: [("say", None)],
    }  # fmt: skip
    played = play((say, other), commands, 4, sensors=(), scene="", out=tmp_path)
    assert played.said("say") == [
        "Hello, I am a robot.", "Good bye", "42", "A long sentence that is stopped before its end.",
    ]  # fmt: skip
    assert len(played.said("error")) == 1
    lengths = []
    for file in sorted(tmp_path.glob("say-*.wav")):
        with wave.open(str(file)) as sound:
            lengths.append(sound.getnframes() / sound.getframerate())
    assert len(lengths) == 4
    starts = [t for t, h in played.happenings if h.kind == "say"]
    assert starts[1] - starts[0] == pytest.approx(lengths[0], abs=0.05)  # one after the other
    assert 1.0 < lengths[0] < 2.5
    assert lengths[3] == pytest.approx(0.5, abs=0.05)  # cut where it was stopped


def test_japanese_is_the_same_in_every_run(tmp_path: Path) -> None:
    say = DeviceUse("say", "Say", "SayInput", {"language": "ja", "speed": 150, "volume": 100})
    commands = {0: [("say", "赤いボールを見て。")], 2.5: [("say", "3回、上手にできました！")]}
    runs = []
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        played = play((say,), commands, 3, sensors=(), scene="", out=tmp_path / name)
        assert played.said("say") == ["赤いボールを見て。", "3回、上手にできました！"]
        runs.append([file.read_bytes() for file in sorted((tmp_path / name).glob("say-*.wav"))])
    assert len(runs[0]) == 2 and runs[0] == runs[1]


@pytest.mark.slow
def test_joints_move_and_limits_are_told() -> None:
    names = ("HeadYaw", "HeadPitch", "LArm", "LKneePitch")
    devices = [DeviceUse(n, n, "SetJointPosition", {"joint": n, "speed": 0.5}) for n in names]
    commands = {
        0.1: [("HeadYaw", 1.5)], 0.5: [("HeadPitch", 0.5)], 1: [("LArm", (0.5, 0.8, -1, -0.5, 0, 1))],
        1.5: [("LArm", 1), ("HeadYaw", "left")], 2: [("LKneePitch", 5)],
    }  # fmt: skip
    played = play(devices, commands, 4, sensors=(), scene="")
    last = played.states[4]
    assert last.joints["HeadYaw"] == pytest.approx(1.5, abs=0.01)
    assert last.joints["HeadPitch"] == pytest.approx(0.206, abs=0.02)  # less than 0.515: the head is turned
    assert last.joints["LShoulderRoll"] == pytest.approx(0.8, abs=0.01)
    assert abs(last.base[3]) < 0.05  # it does not fall, even on one leg
    assert last.base[2] == pytest.approx(0.32, abs=0.02)
    clamps = played.said("clamp")
    assert clamps[0].startswith("HeadPitch: 0.5 → 0.20")
    assert clamps[1].startswith("LKneePitch: 5 → 2.113")
    assert len(played.said("error")) == 2
    assert all(h.row == "Test!4" for _, h in played.happenings)


def test_faces_are_new_then_remembered() -> None:
    scene = """
    | 0 | Person | is seen | 1, , 2 |
    | 1 | Person | is seen | 2, Emma, 0.6 |
    | 2.5 | Lea | enters | at 1.2, 0.1 |
    | 3 | Lea | looks away | |"""
    remember = DeviceUse("remember", "Remember", "RememberFace", {"name": ""})

    def answer(stream: str, value: Any) -> list[tuple[str, Any]]:
        return [("remember", value)] if value.get("recognized new face") else []

    played = play((remember,), answer, 4, scene=scene, sensors=(FACE,))
    faces = [(t, v) for t, _, v in played.events]
    first = [v for t, v in faces if v.get("id") == 1]
    assert first[0].get("new") is True
    assert first[0].get("recognized_new_face") is False
    assert first[-1].get("name") == "Guest 1"
    assert first[-1].get("recognised") is True
    emma = [v for t, v in faces if v.get("id") == 2]
    assert emma[0].get("name") == "Emma"
    assert emma[0].get("new") is False
    assert max(t for t, v in faces if v.get("id") == 1) < 2.1
    lea = [t for t, v in faces if v.get("id") == 3]
    assert lea
    assert max(lea) < 3.1


def run_once() -> list[Any]:
    scene = "| 0 | Red ball | appears | at 0.8, 0.2, 0.4 |\n| 0 | Red ball | circles | radius 0.3 period 3 s |"
    played = play((tracker("Whole body", "Nearest arm"),), follow, 2, scene=scene)
    return [(t, s, to_json(v)) for t, s, v in played.events] + [repr(played.states)]


@pytest.mark.slow
def test_two_runs_are_equal_to_the_last_digit() -> None:
    """However busy the machine is: test_run.py."""
    assert run_once() == run_once()


@pytest.mark.slow
def test_larger_priority_wins() -> None:
    devices = (
        DeviceUse("head", "Head", "Tracker", {"mode": "Head", "effector": "None"}),
        DeviceUse("joint", "Joint", "SetJointPosition", {"joint": "HeadYaw"}),
        DeviceUse("say", "Say", "SayInput", {}),
        DeviceUse("alarm", "Alarm", "SayInput", {}),
    )
    world = SimulatedWorld(ROBOT, (RED,), devices, scene_of("| 0 | Red ball | appears | at 1, 0.3, 0.45 |"))
    world.start()
    first = [Command("head", 1, "A!2", ("redball",), 1.0), Command("say", "A long calm sentence.", "A!3")]
    told = list(world.advance(500_000, first).notices)
    second = [Command("joint", -1, "A!4"), Command("alarm", "Stop!", "A!5", (), 2.0), Command("say", "No", "A!6")]
    told += world.advance(1_500_000, second).notices
    yaw = world.state().joints["HeadYaw"]
    end_simulator(world)
    assert yaw > 0.2
    assert [(h.kind, h.row) for h in told] == [("say", "A!3"), ("error", "A!4"), ("say", "A!5"), ("error", "A!6")]


def test_a_tracker_without_anything_seen_says_so() -> None:
    joint = DeviceUse("yaw", "Head yaw", "JointPosition", {"joint": "HeadYaw"})
    played = play((tracker("Head"),), {0.1: [("tracker", 1)]}, 0.5, sensors=(joint,))
    assert "nothing to follow" in played.said("error")[0]


@pytest.mark.slow
def test_the_film_and_the_strip_are_written(tmp_path: Path) -> None:
    scene = "| 0 | Red ball | appears | at 0.7, 0.1, 0.4 |\n| 1 | Operator | presses | Start |"
    played = play((tracker("Head"),), follow, 2, scene=scene, out=tmp_path, film=True)
    assert played.said("note") == ["Operator presses Start: no sensor of this workbook notices it."]
    with Image.open(tmp_path / "film.gif") as film, Image.open(tmp_path / "strip.png") as strip:
        assert getattr(film, "n_frames", 1) >= 6
        assert strip.width > 4 * strip.height
        colours = np.asarray(film.convert("RGB")).reshape(-1, 3).astype(int)
    assert ((colours[:, 0] > 150) & (colours[:, 1] < 60) & (colours[:, 2] < 60)).sum() > 100  # the ball
    assert (tmp_path / "film.gif").stat().st_size < 1_000_000
