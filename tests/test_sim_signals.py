"""Actions of people in the Scene sheet, as the simulated sensors give them: presses, touches, words, tilt."""

from __future__ import annotations

from typing import Any

import pytest

pytest.importorskip("pybullet")
pytest.importorskip("cv2")

from play import findings, rows
from processes import end_simulator
from test_sim_run import RATE, RED, ROBOT, play, scene_of

from rrp_sheets.drivers.simulated import SimulatedWorld
from rrp_sheets.engine.scene import default_scene
from rrp_sheets.model.exchange import DeviceUse, SceneAction
from rrp_sheets.model.values import Record


def given(sensors: tuple[DeviceUse, ...], scene: str, seconds: float = 3, **more: Any) -> tuple[list[tuple], list[str]]:
    """(time, stream, fields…) of every event, and the notes."""
    played = play(more.pop("actuators", ()), more.pop("commands", {}), seconds, scene=scene, sensors=sensors)
    events = [(round(t, 3), s, *v.as_dict().values()) for t, s, v in played.events if isinstance(v, Record)]
    return events, played.said("note")


@pytest.mark.slow
def test_a_button_counts_its_presses():
    buttons = (
        DeviceUse("go", "Go", "OperatorButton", {"label": "Next part"}),
        DeviceUse("b", "B", "OperatorButton", {}),
    )
    events, notes = given(buttons, "| 1 | Operator | presses | next part |\n| 1.5 | Operator | presses | B |\n"
                          "| 2 | Operator | presses | Next part |\n| 2.5 | Operator | presses | Stop |")  # fmt: skip
    assert events == [(1.0, "go", "Next part", 1), (1.5, "b", "B", 1), (2.0, "go", "Next part", 2)]
    assert notes == ["Operator presses Stop: no sensor of this workbook notices it."]


def test_a_touch_begins_and_ends():
    sensors = (
        DeviceUse("all", "All", "Touch", {}), DeviceUse("hand", "Hand", "Touch", {"zone": "Left hand"}),
        DeviceUse("foot", "Foot", "Bumper", {"side": "Right"}), DeviceUse("chest", "Chest", "ChestButton", {}),
    )  # fmt: skip
    events, notes = given(sensors, "| 0.5 | Child | touches | left hand |\n| 1.5 | Child | touches | Right foot |\n"
                          "| 2 | Child | touches | Left foot |\n| 2.2 | Child | touches | Chest |", 2.4)  # fmt: skip
    assert events == [
        (0.5, "all", True, "Left hand"), (0.5, "hand", True, "Left hand"),
        (1.0, "all", False, "Left hand"), (1.0, "hand", False, "Left hand"),
        (1.5, "all", True, "Right foot"), (1.5, "foot", True, "Right foot"),
        (2.0, "all", False, "Right foot"), (2.0, "all", True, "Left foot"), (2.0, "foot", False, "Right foot"),
        (2.2, "all", True, "Chest"), (2.2, "chest", True, "Chest"),
    ]  # fmt: skip
    assert notes == []


def test_a_zone_that_is_touched_again_is_touched_longer():
    events, _ = given(
        (DeviceUse("t", "T", "Touch", {}),), "| 0.5 | Child | touches | Head |\n| 0.8 | Mia | touches | Head |"
    )
    assert events == [(0.5, "t", True, "Head"), (1.3, "t", False, "Head")]


@pytest.mark.slow
def test_the_torso_turns():
    tilt = DeviceUse("tilt", "Tilt", "Orientation", {})
    tracker = DeviceUse("tracker", "Tracker", "Tracker", {"mode": "Whole body", "effector": "None"})
    red = DeviceUse("redball", "Red ball", "RedBall", {"rate": 10})
    played = play((tracker,), lambda s, v: [("tracker", True)], 4, sensors=(red, tilt),
                  scene="| 0 | Red ball | appears | at 0.9, 0, 0.4 |\n"
                  "| 0.5 | Red ball | circles | radius 0.9 period 16 s around 0, 0, 0.4 flat |")  # fmt: skip
    turns = [v.get("yaw") for _, s, v in played.events if s == "tilt"]
    assert abs(turns[0]) < 0.02 and turns[-1] > 0.4 and len(turns) > 3
    assert not any(v.get("fallen") for _, s, v in played.events if s == "tilt")


def test_the_default_scene_presses_touches_and_speaks():
    uses = (
        DeviceUse("b", "B", "OperatorButton", {"label": "Go"}), DeviceUse("t", "T", "Touch", {"zone": ""}),
        DeviceUse("f", "F", "Bumper", {"side": "Right"}), DeviceUse("c", "C", "ChestButton", {}),
        DeviceUse("w", "W", "WordRecognized", {"words": ("yes", "no")}),
    )  # fmt: skip
    actions = [(a.thing, a.verb, *a.values.values()) for a in default_scene(uses, ROBOT)]
    assert actions == [
        ("Operator", "press", "Go"), ("Person", "touch", "Head"), ("Person", "touch", "Right foot"),
        ("Person", "touch", "Chest"), ("Person", "say", "yes"), ("Person", "say", "no"),
    ]  # fmt: skip
    scene_of("| 1 | Person | touches | Right foot |")


@pytest.mark.parametrize(("label", "expected"), [("Go on", []), ("B", []), ("Go", [("SCENE006", "D2")])])
def test_a_press_of_a_button_that_is_not_there(label, expected):
    book = rows(
        "| A | subscribe | | Print |\n| B | subscribe | | Print |",
        "\n## Devices\n| Stream | Device | Label |\n|---|---|---|\n| A | OperatorButton | Go on |\n| B | OperatorButton | |\n",
        f"\n## Scene\n| Time (s) | Thing | Does | Value |\n|---|---|---|---|\n| 1 | Operator | presses | {label} |\n",
    )
    assert findings(book) == expected


def test_what_people_do_by_hand_is_noticed_like_the_scene():
    sensors = (
        DeviceUse("go", "Go", "OperatorButton", {"label": "Go"}), DeviceUse("t", "T", "Touch", {}),
        RED,
    )  # fmt: skip
    world = SimulatedWorld(ROBOT, sensors, (), scene_of("| 0 | Red ball | appears | at 1, 0, 0.4 |"), frame_rate=RATE)
    acts = {
        3: [SceneAction(0, "Anna", "press", {"label": "go"}), SceneAction(0, "Anna", "press", {"label": "Stop"})],
        4: [SceneAction(4_000_000 // 30, "Anna", "touch", {"zone": "Head"})],
        20: [SceneAction(20_000_000 // 30, "Anna", "touch", {"zone": "Chest", "seconds": 1.0})],
        22: [SceneAction(22_000_000 // 30, "Anna", "touch", {"zone": "Chest", "seconds": 1.0})],  # held, and let go
        23: [SceneAction(23_000_000 // 30, "Anna", "touch", {"zone": "Chest", "seconds": 0.0})],
    }
    try:
        world.start()
        events, notes = [], []
        for frame in range(1, 25):
            world.act(acts.get(frame, ()))
            arrivals = world.advance(frame * 1_000_000 // RATE, ())
            events += [(frame, s, *v.as_dict().values()) for s, v in arrivals.events if s != "redball"]
            notes += [h for h in arrivals.notices if h.kind == "note"]
        assert events == [
            (3, "go", "Go", 1), (4, "t", True, "Head"), (19, "t", False, "Head"), (20, "t", True, "Chest"), (24, "t", False, "Chest"),
        ]  # fmt: skip
        assert [(n.text, n.row) for n in notes] == [("Anna presses Stop: no sensor of this workbook notices it.", "")]
        before = world.show(True)
        world.act([SceneAction(0, "Red ball", "move", {"to": (1.0, 0.3, 0.4), "seconds": 0.0})])
        after = world.show(True)  # at once, though no time has passed
        assert after.state.things["Red ball"] == (1.0, 0.3, 0.4) and after.picture != before.picture
        assert before.picture.startswith(b"\xff\xd8") and world.show(False).picture == b""
    finally:
        end_simulator(world)
