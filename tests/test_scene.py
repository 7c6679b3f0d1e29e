"""The Scene sheet's grammar."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from rrp_sheets.diagnostics.report import Report
from rrp_sheets.engine.scene import default_scene
from rrp_sheets.model.exchange import DeviceUse
from rrp_sheets.model.workbook import Address, Cell, SceneRow
from rrp_sheets.robots import load_robot
from rrp_sheets.scene.scene_sheet import parse_scene, scene_end_us
from rrp_sheets.scene.scene_words import COLOURS
from rrp_sheets.sim.appearance import parse_colour

ROBOT = load_robot()


def rows_of(table: str) -> list[SceneRow]:
    """The rows of a Markdown table as they would stand in a Scene sheet, below a header in row 1."""
    rows = []
    for number, line in enumerate((line for line in table.strip().splitlines() if line.strip()), start=2):
        texts = [c.strip() for c in line.strip().strip("|").split("|")]
        texts += [""] * (4 - len(texts))
        rows.append(SceneRow(*(Cell(t, Address("Scene", number, c)) for c, t in enumerate(texts[:4], start=1))))
    return rows


UNDERSTOOD = [
    ("| 0 | Red ball | appears | at 1, 0.2, 0.4 |", "appear", {"at": (1, 0.2, 0.4), "size": 0.06, "colour": "red"}),
    ("| 0.5 | red_ball | appear | 1 0.2 0.4 size 10 cm |", "appear",
     {"at": (1, 0.2, 0.4), "size": 0.1, "colour": "red"}),
    ("| 1 s | Blue ball | moves | to 0.5, -0.1, .4 in 2 s |", "move", {"to": (0.5, -0.1, 0.4), "seconds": 2.0}),
    ("| 500 ms | Ball | circles | radius 30 cm period 4 |", "circle", {"radius": 0.3, "period": 4.0}),
    ("| 1 | Ball | circles | radius 0.3, period 4 s, around 1, 0, 0.4, flat |", "circle",
     {"radius": 0.3, "period": 4.0, "around": (1, 0, 0.4), "flat": True}),
    ("| 1 | Green ball | disappears | |", "disappear", {}),
    ("| 1 | Person | enters | at 1.2, 0.1 |", "appear", {"at": (1.2, 0.1, 0.62)}),
    ("| 1 | Emma | appears | at 1, 0, 0.9 name Emma id 3 |", "appear", {"at": (1, 0, 0.9), "name": "Emma", "id": 3}),
    ("| 1 | Person 2 | moves | to 1, 0.5 in 3 s |", "move", {"to": (1, 0.5), "seconds": 3.0}),
    ("| 1 | Child | looks away | |", "away", {}),
    ("| 1 | Carson | looks at the robot | |", "look", {}),
    ("| 1 | Person | leaves | |", "disappear", {}),
    ("| 1 | Person | is seen | 2, Emma, 6 |", "seen", {"id": 2, "name": "Emma", "seconds": 6.0}),
    ("| 1 | Person | is seen | 1, , 4 |", "seen", {"id": 1, "name": "", "seconds": 4.0}),
    ("| 1 | Operator | presses | Next part |", "press", {"label": "Next part"}),
    ("| 5 | Child | touches | Left hand |", "touch", {"zone": "Left hand"}),
    ("| 6 | Child | says | okay |", "say", {"words": "okay"}),
]  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize(("row", "verb", "values"), UNDERSTOOD)
def test_what_a_row_means(row: str, verb: str, values: dict[str, object]) -> None:
    report = Report()
    (action,) = parse_scene(rows_of(row), report, ROBOT)
    assert (action.verb, dict(action.values), action.row) == (verb, values, 2)
    assert not report.errors


WRONG = [
    ("| soon | Red ball | appears | at 1, 0, 0.4 |", "SCENE001", "A2", "2.5"),
    ("| | Red ball | appears | at 1, 0, 0.4 |", "SCENE001", "A2", "2.5"),
    ("| 1 | Red bal | appears | at 1, 0, 0.4 |", "SCENE002", "B2", "Red ball"),
    ("| 1 | Redd ball | appears | |", "SCENE002", "B2", "Red ball"),
    ("| 1 | Persn | enters | |", "SCENE002", "B2", "Person"),
    ("| 1 | Lamp | shines | |", "SCENE002", "B2", ""),
    ("| 1 | | appears | at 1, 0, 0.4 |", "SCENE012", "B2", "Red ball"),
    ("| 1 | | | |", "SCENE012", "B2", "Operator"),
    ("| 1 | Red ball | apears | |", "SCENE003", "C2", "appears"),
    ("| 1 | Red ball | looks away | |", "SCENE003", "C2", ""),
    ("| 1 | Person | | |", "SCENE003", "C2", "enters"),
    ("| 1 | Red ball | appears | on the floor |", "SCENE004", "D2", "at 1, 0.2, 0.4"),
    ("| 1 | Red ball | appears | at 1, 0 |", "SCENE004", "D2", "at 1, 0.2, 0.4"),
    ("| 1 | Red ball | appears | at 100, 0, 0 |", "SCENE004", "D2", "at 1, 0.2, 0.4"),
    ("| 1 | Red ball | appears | at 1, 0, 0 size 6 km |", "SCENE004", "D2", "at 1, 0.2, 0.4"),
    ("| 1 | Red ball | moves | to 1, 0, 0.4 in time |", "SCENE004", "D2", "in 2 s"),
    ("| 1 | Red ball | circles | period 0 |", "SCENE004", "D2", "radius 0.3 period 4 s"),
    ("| 1 | Person | is seen | Emma |", "SCENE004", "D2", "1, Emma, 6"),
    ("| 1 | Operator | presses | |", "SCENE004", "D2", "Start"),
    ("| 1 | Red ball | disappears | quickly |", "SCENE004", "D2", "blank"),
    ("| 1 | Child | touches | Left hnd |", "SCENE004", "D2", "Left hand"),
    ("| 1 | Child | touches | the tail |", "SCENE004", "D2", "Right foot"),
]


@pytest.mark.parametrize(("row", "code", "cell", "remedy"), WRONG)
def test_what_is_not_understood_says_what_to_do(row: str, code: str, cell: str, remedy: str) -> None:
    report = Report()
    assert parse_scene(rows_of(row), report, ROBOT) == ()
    assert report.flatten(["code", "cell"]) == [(code, cell)]
    assert remedy in next(iter(report)).remedy


def test_a_row_with_two_mistakes_tells_both() -> None:
    report = Report()
    parse_scene(rows_of("| never | Red ball | flies | |"), report, ROBOT)
    assert report.flatten(["code", "cell"]) == [("SCENE001", "A2"), ("SCENE003", "C2")]


def test_actions_come_in_the_order_of_time_and_must_find_their_thing() -> None:
    report = Report()
    table = """
    | 3 | Red ball | moves | to 1, 0, 0.4 in 4 s |
    | 1 | Red ball | appears | at 1, 0, 0.4 |
    | 0 | Blue ball | moves | to 1, 0, 0.4 |
    """
    actions = parse_scene(rows_of(table), report, ROBOT)
    assert [a.verb for a in actions] == ["move", "appear", "move"]
    assert report.flatten(["code", "cell"]) == [("SCENE005", "B4")]
    assert scene_end_us(actions) == 7_000_000


def test_persons_are_they_and_balls_are_it() -> None:
    report = Report()
    parse_scene(rows_of("| 0 | Mia | looks away | |\n| 1 | Blue ball | disappears | |"), report, ROBOT)
    mia, ball = report
    assert mia.message.endswith("when they are not there.") and mia.remedy == "Add a row above in which they enter."
    assert ball.message.endswith("when it is not there.") and ball.remedy == "Add a row above in which it appears."


def test_every_ball_colour_has_a_look() -> None:
    assert all(parse_colour(colour) is not None for colour in COLOURS)


def shown(*sensors: DeviceUse) -> dict[str, object]:
    """The things of the default scene, with their colours."""
    actions = default_scene(sensors, ROBOT)
    return {a.thing: a.values.get("colour") for a in actions if a.verb == "appear"}


def use(device: str, **settings: str) -> DeviceUse:
    return DeviceUse("s", device, device, settings)


def test_a_default_scene_shows_every_sensor_something() -> None:
    things = shown(use("RedBall"), use("Blue ball"), use("Face"), use("HeadYaw"))
    assert things == {"Red ball": "red", "Blue ball": "blue", "Person": None, "Person 2": None}
    assert default_scene([use("HeadYaw")], ROBOT) == ()
    assert shown(use("Ball")) == {"Red ball": "red", "Blue ball": "blue"}
    assert shown(use("Blob")) == {"Red ball": "red"}
    assert shown(use("Blob", colour="Yellow")) == {"Yellow ball": "yellow"}
    assert shown(use("Blob", colour="#ff8000")) == {"Ball": "#ff8000"}


def test_a_spelling_is_accepted_but_offered_once() -> None:
    assert [n for n in ROBOT.device_names("actuator") if n.startswith("Eye")] == [
        "Eye LED color", "Eye color", "Eye brightness",
    ]  # fmt: skip
    for american, british in (("Eye LED color", "Eye LED colour"), ("Eye color", "Eye colour")):
        first, second = ROBOT.find(american), ROBOT.find(british)
        assert first is not None
        assert second is not None
        assert first.type is second.type


USES = [
    ("Head tracker", {}, {"head"}),
    ("Head and body tracker", {}, {"head", "legs"}),
    ("Arm tracker", {}, {"left arm", "right arm"}),
    ("Tracker", {"mode": "Head", "effector": "Left arm"}, {"head", "left arm"}),
    ("Set joint position", {"joint": "Right wrist yaw"}, set()),
    ("Set joint position", {"joint": "RWristYaw"}, {"right arm"}),
    ("Set joint position", {"joint": "Body"}, {"head", "left arm", "right arm", "legs"}),
    ("Say", {}, {"voice"}),
]


@pytest.mark.parametrize(("device", "settings", "uses"), USES)
def test_what_an_actuator_uses_depends_on_its_settings(device: str, settings: dict[str, str], uses: set[str]) -> None:
    found = ROBOT.find(device)
    assert found is not None
    assert found.type.resources_for(found.type.with_defaults({**found.preset, **settings})) == uses


def test_a_hand_is_not_in_rad() -> None:
    units = {name: found.type.unit for name in ("Head yaw", "L hand") if (found := ROBOT.find(name))}
    assert units == {"Head yaw": "rad", "L hand": ""}


def test_example_scenes_of_workbooks_in_markdown_are_understood() -> None:
    root = Path(__file__).parent.parent / "workbooks"
    for path in sorted(root.glob("*.md")):
        part = re.search(r"^## Scene\n+\|.*\n\|[-| ]+\n((?:\|.*\n?)+)", path.read_text(encoding="utf-8"), re.MULTILINE)
        if part:
            report = Report()
            parse_scene(rows_of(part[1]), report, ROBOT)
            assert not report.errors, path
