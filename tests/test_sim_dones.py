"""The end of every command of the simulated robot, and who may move what."""

from __future__ import annotations

import json
from typing import Any

import pytest

pytest.importorskip("pybullet")
pytest.importorskip("cv2")

from play import rows
from processes import end_simulator
from test_sim_run import RED, ROBOT, scene_of

from rrp_sheets import api
from rrp_sheets.drivers.simulated import SimulatedWorld
from rrp_sheets.model.exchange import DONE, Command, DeviceUse
from rrp_sheets.sim.actuators import ACTUATORS
from rrp_sheets.sim.process import Spec
from rrp_sheets.sim.sensors import SENSORS
from rrp_sheets.sim.world import SimWorld

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


class Play:
    """Result of a world: done events as (frame, stream, value, completed, seconds), and notices."""

    def __init__(
        self, devices: tuple[DeviceUse, ...], commands: dict[int, list[tuple]], frames: int, scene: str = BALL
    ):
        self.dones: list[tuple[int, str, Any, bool, float]] = []
        self.events: list[tuple[int, str, Any]] = []
        self.told: list[tuple[int, str, str]] = []
        dones = {f"{d.stream}done": d.stream for d in devices}
        sees = any(d.device == "Tracker" for d in devices)  # else pictures are half of the time
        world = SimulatedWorld(
            ROBOT, (RED,) if sees else (), devices, scene_of(scene if sees else ""), dones=dones, frame_rate=RATE
        )
        try:
            world.start()
            for frame in range(1, frames + 1):
                orders = [
                    Command(stream, value, f"T!{n}", ("redball",), (*more, 0.0)[0])
                    for n, (stream, value, *more) in enumerate(commands.get(frame - 1, []), start=2)
                ]
                arrivals = world.advance(frame * 1_000_000 // RATE, orders)
                self.told += [(frame, h.kind, h.row) for h in arrivals.notices if h.kind != "say"]
                for stream, value in arrivals.events:
                    if stream in dones:
                        assert value.type is DONE
                        got = (frame, stream, value.get("value"), value.get("completed"), value.get("seconds"))
                        self.dones.append(got)
            self.state = world.state()
        finally:
            end_simulator(world)

    @property
    def short(self) -> list[tuple[str, Any, bool]]:
        return [(stream.removesuffix("done"), value, completed) for _, stream, value, completed, _ in self.dones]


def test_what_is_done_at_once_is_done_in_the_next_frame():
    p = Play((EYES, PRINT), {3: [("eyes", "red"), ("print", 7), ("eyes", "no colour"), ("eyes", None)]}, 10)
    assert p.dones == [
        (4, "eyesdone", "red", True, 0.0), (4, "printdone", 7, True, 0.0), (4, "eyesdone", "no colour", False, 0.0),
    ]  # fmt: skip


def test_a_sentence_is_done_when_its_audio_is():
    p = Play((SAY,), {0: [("say", "Hello, I am a robot.")]}, 55)
    ((frame, _, value, completed, seconds),) = p.dones
    assert (value, completed) == ("Hello, I am a robot.", True)
    assert 1.0 < seconds < 2.5 and frame == pytest.approx(seconds * RATE, abs=1.1)


@pytest.mark.slow
def test_the_voice_queues_one_and_a_newer_one_takes_its_place():
    p = Play((SAY, OTHER), {0: [("say", "First.")], 3: [("say", "Second."), ("other", 1)]}, 50)
    assert p.short == [("say", "Second.", False), ("say", "First.", True), ("other", 1, True)]
    assert p.dones[0][4] == 0.0  # it never began


def test_a_larger_priority_interrupts_and_a_smaller_one_is_refused():
    p = Play(
        (SAY, OTHER), {0: [("say", "A long calm sentence.", 1)], 5: [("say", "Small.", 0)], 9: [("other", 1, 2)]}, 45
    )
    assert p.short == [("say", "Small.", False), ("say", "A long calm sentence.", False), ("other", 1, True)]
    assert p.told == [(6, "error", "T!2")]


def test_blank_ends_what_its_stream_says_and_has_waiting_and_starts_nothing():
    p = Play((SAY,), {0: [("say", "First sentence."), ("say", "Second.")], 9: [("say", None)], 12: [("say", None)]}, 30)
    assert p.short == [("say", "Second.", False), ("say", "First sentence.", False)]
    assert p.dones[1][4] == pytest.approx(9 / RATE, abs=0.01)


def test_blank_for_one_stream_lets_the_other_speak():
    p = Play((SAY, OTHER), {0: [("say", "A first long sentence."), ("other", 1)], 6: [("say", None)]}, 40)
    assert p.short == [("say", "A first long sentence.", False), ("other", 1, True)]


@pytest.mark.slow
def test_a_joint_is_done_when_it_is_there():
    p = Play((YAW, PITCH), {0: [("yaw", 1.0), ("pitch", 0.2)]}, 60)
    assert sorted(p.short) == [("pitch", 0.2, True), ("yaw", 1.0, True)]  # two joints of the head do not conflict
    assert all(0.2 < seconds < 1.5 for *_, seconds in p.dones)
    assert p.state.joints["HeadYaw"] == pytest.approx(1.0, abs=0.03)


@pytest.mark.slow
def test_a_newer_command_for_the_same_joint_replaces():
    p = Play((YAW, HEAD), {0: [("yaw", 1.0)], 6: [("head", (-0.5, 0.0))]}, 70)
    assert p.short == [("yaw", 1.0, False), ("head", (-0.5, 0.0), True)]


def test_blank_stops_a_joint():
    p = Play((YAW,), {0: [("yaw", 1.5)], 5: [("yaw", None)], 20: [("yaw", None)]}, 35)
    assert p.short == [("yaw", 1.5, False)] and 0.05 < p.state.joints["HeadYaw"] < 1.2


@pytest.mark.slow
def test_a_tracker_that_is_fed_again_and_again_is_one_command():
    p = Play((TRACK,), {**{f: [("track", f)] for f in range(0, 36, 3)}, 45: [("track", None)]}, 55)
    assert p.short == [("track", 33, False)]
    assert p.dones[0][4] == pytest.approx(45 / RATE, abs=0.01)


@pytest.mark.slow
def test_an_outranked_tracker_resumes():
    feed = {f: [("track", 1)] for f in range(0, 90, 3)}
    p = Play((TRACK, YAW), {**feed, 31: [("yaw", -1.0, 5)]}, 90)
    assert p.short == [("yaw", -1.0, True)]  # the tracker's command goes on: it is not done
    assert p.state.joints["HeadYaw"] == pytest.approx(0.29, abs=0.08)  # it looks at the ball again
    assert p.told == []


@pytest.mark.slow
def test_at_equal_priority_a_joint_replaces_a_tracker():
    p = Play((TRACK, YAW), {0: [("track", 1)], 30: [("yaw", -1.0)]}, 80)
    assert p.short == [("track", 1, False), ("yaw", -1.0, True)]
    assert p.state.joints["HeadYaw"] == pytest.approx(-1.0, abs=0.03)


@pytest.mark.slow
def test_a_tracker_of_smaller_priority_waits_and_is_told_once():
    feed = {f: [("track", 1)] for f in range(3, 60, 3)}
    p = Play((TRACK, HEAD), {0: [("head", (-1.2, 0.1), 5)], **feed}, 90)
    assert p.told == [(4, "error", "T!2")] and p.short == [("head", (-1.2, 0.1), True)]
    assert p.state.joints["HeadYaw"] > 0.2


@pytest.mark.slow
def test_a_tracker_that_gets_no_more_events_gives_way_to_another_mode():
    feed = {f: [("arm", 1)] for f in range(45, 80, 3)}
    p = Play((TRACK, ARM), {0: [("track", 1)], **feed}, 80)
    assert p.short == [("track", 1, False)]


def test_every_device_of_the_catalogue_has_a_class_in_the_simulator():
    simulated = {d.name: d.kind for d in ROBOT.devices.values() if d.simulated and not d.engine}
    assert simulated == dict.fromkeys(SENSORS, "sensor") | dict.fromkeys(ACTUATORS, "actuator")


def test_what_the_simulator_lacks_is_told_once_and_done_at_once(monkeypatch):
    monkeypatch.delitem(ACTUATORS, "Print")
    world = SimWorld(Spec(ROBOT, actuators=(PRINT,), dones={"print": "printdone"}))
    try:
        first = world.advance(33_333, [Command("print", 1, "T!2")])
        second = world.advance(66_667, [Command("print", 2, "T!2"), Command("print", None, "T!2")])
    finally:
        world.close()
    ends = [(v["value"], v["completed"], v["seconds"]) for one in (first, second) for _, v in one.events]
    assert ends == [(1, False, 0.0), (2, False, 0.0)]
    assert [(n.kind, n.row) for n in (*first.notices, *second.notices)] == [("note", "T!2")]


@pytest.mark.slow
def test_rows_that_command_each_other_in_a_circle_do_not_send_a_growing_value(tmp_path):
    book = rows(
        "| Start, Say done | subscribe | | Say |\n| Start, Wait done | merge | | M |\n| M | timestamp | | T |\n"
        "| T | map | (t, 1) | |\n| | subscribe | | Wait |",
        "\n## Devices\n| Stream | Device | Label | Text | Time |\n|---|---|---|---|---|\n"
        "| Start | OperatorButton | Go | | |\n| Say | SayParameter | | A | |\n| Wait | Wait | | | 50 ms |\n"
        "\n## Scene\n| Time (s) | Thing | Does | Value |\n|---|---|---|---|\n| 0 | Operator | presses | Go |\n"
        "\n## Protocol\n| Field | Value |\n|---|---|\n| Time limit | 2.5 s |\n",
    )
    lines = trace_of(tmp_path, book)
    assert len(lines) > 100 and max(len(line) for line in lines[1:-1]) < 400


@pytest.mark.slow
def test_two_plays_are_equal():
    commands = {0: [("say", "One."), ("say", "Two."), ("track", 1)], 20: [("yaw", 1, 2)], 25: [("eyes", "red")]}
    first, second = (Play((SAY, TRACK, YAW, EYES), commands, 60) for _ in range(2))
    assert first.dones == second.dones and len(first.dones) == 4


def trace_of(folder: Any, book: str) -> list[str]:
    (folder / "book.md").write_text(book, encoding="utf-8")
    _, result = api.run(folder / "book.md", api.RunSettings(fast=True, film=False, out=folder / "run", seed=1))
    assert result is not None
    return (result.folder / "trace.jsonl").read_text(encoding="utf-8").splitlines()


SEQUENCE = rows(
    """
    | Start | subscribe | | First |
    | First done | filter | firstDone.completed | |
    | | subscribe | | Pause |
    | pause_done | subscribe | | Second |
    | Start | subscribe | 0.3 | Head yaw to |
    | Second DONE | map | secondDone.seconds | Took |
    | Took | subscribe | | Print |
    | Took | subscribe | | Last |
    | Last done, Pause done | subscribe | | Print |
    """,
    """
    ## Devices
    | Stream | Device | Label | Text | Joint | Time |
    |---|---|---|---|---|---|
    | Start | OperatorButton | Go | | | |
    | First | SayParameter | | First. | | |
    | Second | SayParameter | | And second. | | |
    | Pause | Wait | | | | 500 ms |
    | Head yaw to | SetJointPosition | | | HeadYaw | |
    | Last | SayParameter | | This sentence is cut off by the end of the run, which comes before its end. | | |
    """,
    "\n## Scene\n| Time (s) | Thing | Does | Value |\n|---|---|---|---|\n| 0.1 | Operator | presses | go |\n",
    "\n## Protocol\n| Field | Value |\n|---|---|\n| Time limit | 2.8 s |\n",
)


@pytest.fixture(scope="module")
def sequence(tmp_path_factory):
    """The lines of its trace."""
    return trace_of(tmp_path_factory.mktemp("sequence"), SEQUENCE)


@pytest.mark.slow
def test_a_sequence_through_done_streams_runs_and_its_trace_is_the_same_again(tmp_path, sequence):
    first, second = sequence, trace_of(tmp_path, SEQUENCE)
    assert first[1:] == second[1:]
    lines = [json.loads(line) for line in first[1:-1]]
    dones = [(e["stream"], e["value"]["completed"]) for e in lines if e.get("stream", "").endswith("done")]
    assert dones == [("First done", True), ("Pause done", True), ("Second done", True), ("Last done", False)]
    times = {e["stream"]: e["t"] for e in lines if "stream" in e and "value" in e}
    assert times["Pause"] >= times["First done"] and times["Pause done"] == pytest.approx(
        times["Pause"] + 0.5, abs=0.04
    )
    took = next(e["value"] for e in lines if e.get("stream") == "T!Took")
    assert times["Second done"] - times["Second"] == pytest.approx(took, abs=0.07)


def test_the_end_of_the_run_ends_what_is_still_going_on(sequence):
    lines = [json.loads(line) for line in sequence]
    (last,) = [e for e in lines if e.get("stream") == "Last done" and "value" in e]
    assert last["value"]["completed"] is False and last["t"] == pytest.approx(2.8, abs=0.05)
    assert lines[-1]["events"]["Last done"] == 1
    assert not [e for e in lines if e.get("stream") == "Print" and e["t"] == last["t"]]  # no row reacts any more
