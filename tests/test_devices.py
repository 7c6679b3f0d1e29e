"""The catalogue and the Devices sheet: names, settings, resources, what is not simulated yet."""

from __future__ import annotations

from dataclasses import replace

import pytest
from play import check, findings, rows

from rrp_sheets.model.names import key
from rrp_sheets.robots import load_robot

ROBOT = load_robot()
EXPECTED_DEVICES = {
    "sensor": "RedBall GreenBall BlueBall Ball Blob FaceDetection WordRecognized JointPosition Touch Bumper ChestButton "
    "Sonar Orientation OperatorButton Timer",
    "actuator": "EyeLedColor EyeColor EyeBrightness SayInput SayParameter RememberFace Tracker SetJointPosition Posture "
    "Gesture Wait EndRun Walk PlaySound Behaviour Print",
}


def devices(*lines: str, columns: str = "", rows_: str = "| Head yaw | subscribe | | Print |") -> str:
    header = f"## Devices\n| Stream | Device |{columns}\n|---|---|{'---|' * columns.count('|')}\n"
    return rows(rows_, "\n" + header + "\n".join(lines) + "\n")


def settings(line: str, columns: str) -> dict[str, object]:
    """The settings of the device that an actuator row of this line drives, or an input row reads."""
    stream = line.split("|")[1].strip()
    found = ROBOT.find(line.split("|")[2].strip())
    assert found is not None
    row = (
        f"| Head yaw | subscribe | | {stream} |"
        if found.type.kind == "actuator"
        else f"| {stream} | subscribe | | Print |"
    )
    checked = check(devices(line, columns=columns, rows_=row))
    assert not checked.report.errors, [d.as_dict() for d in checked.report.errors]
    return dict(checked.graph.streams[key(stream)].settings)


@pytest.mark.parametrize("kind", EXPECTED_DEVICES)
def test_every_expected_device_is_in_the_catalogue(kind):
    assert {d.name for d in ROBOT.devices.values() if d.kind == kind} >= set(EXPECTED_DEVICES[kind].split())


@pytest.mark.parametrize("kind", EXPECTED_DEVICES)
def test_the_devices_of_the_catalogue_are_those_that_have_a_class(kind):
    """So a device that comes by mistake is found, and one that is added in its three places needs no edit here."""
    pytest.importorskip("pybullet")
    from rrp_sheets.sim.actuators import ACTUATORS
    from rrp_sheets.sim.sensors import SENSORS

    classes = {"sensor": SENSORS, "actuator": ACTUATORS}
    carried_out = {d.name for d in ROBOT.devices.values() if d.kind == kind and d.simulated and not d.engine}
    assert set(classes[kind]) == carried_out and not set(SENSORS) & set(ACTUATORS)


@pytest.mark.slow
@pytest.mark.parametrize("device", list(ROBOT.devices.values()), ids=lambda d: d.name)
def test_every_device_tells_what_it_is(device):
    assert device.help and device.says
    assert all(s.help for s in device.settings.values())
    assert device.kind == "sensor" or device.takes
    for field in device.payload.fields if device.payload else ():
        assert field.help and field.example is not None and field.kind in ("number", "text", "truth")


def test_what_the_engine_carries_out():
    assert {d.name for d in ROBOT.devices.values() if d.engine} == {"Timer", "Wait", "EndRun", "Behaviour"}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("line", "columns", "name", "value"),
    [
        ("| T | Timer | 10 s |", " Every |", "every", 10_000_000),
        ("| T | Timer | |", " Every |", "every", 1_000_000),
        ("| W | Wait | 8 s |", " Time |", "time", 8_000_000),
        ("| W | Wait | |", " Time |", "time", None),
        ("| B | OperatorButton | Next part |", " Label |", "label", "Next part"),
        ("| Go on | OperatorButton | |", " Label |", "label", "Go on"),
        ("| W | WordRecognized | yes, no ,yes |", " Words |", "words", ("yes", "no")),
        ("| T | Touch | left hand |", " Zone |", "zone", "Left hand"),
        ("| G | Gesture | shake head |", " Name |", "name", "Shake head"),
        ("| P | Posture | standinit |", " Name |", "name", "StandInit"),
        ("| B | Behaviour | t |", " Name |", "name", "T"),
        ("| B | Behaviour | T | toggle |", " Name | State |", "state", "Toggle"),
        ("| W | Walk | 30° |", " Turn |", "turn", pytest.approx(0.5236, abs=1e-4)),
        ("| W | Walk | -0.5 |", " Turn |", "turn", -0.5),
    ],
)
def test_settings(line, columns, name, value):
    assert settings(line, columns)[name] == value


def test_a_gesture_of_the_workbooks_own():
    own = "\n## Gestures\n| Name | Time (s) | HeadYaw |\n|---|---|---|\n| Big wave | 0 | 0.5 |\n"
    book = devices("| G | Gesture | big wave |", columns=" Name |", rows_="| Head yaw | subscribe | | G |") + own
    assert check(book).graph.streams["g"].settings["name"] == "Big wave"


@pytest.mark.parametrize(
    ("line", "columns", "expected"),
    [
        ("| W | Wait | soon |", " Time |", ("DEV004", "C2")),
        ("| B | Behaviour | Tt |", " Name |", ("DEV010", "C2")),
        ("| B | Behaviour | |", " Name |", ("DEV003", "C2")),
        ("| B | Behaviour | T | Of |", " Name | State |", ("DEV004", "D2")),
        ("| G | Gesture | Wve |", " Name |", ("DEV004", "C2")),
        ("| T | Touch | Nose |", " Zone |", ("DEV004", "C2")),
        ("| W | WordRecognized | , |", " Words |", ("DEV004", "C2")),
        ("| W | Walk | 900° |", " Turn |", ("DEV004", "C2")),
    ],
)
def test_settings_that_are_wrong(line, columns, expected):
    assert findings(devices(line, columns=columns)) == [expected]


def test_the_nearest_gesture_is_proposed():
    (found,) = check(devices("| G | Gesture | Wve |", columns=" Name |")).report
    assert found.remedy.startswith("Write Wave (")


def test_what_is_not_simulated_yet_is_told_once_for_each_device(monkeypatch):
    later = {n: replace(d, simulated=d.name not in ("Gesture", "Sonar")) for n, d in ROBOT.devices.items()}
    names = {n: replace(f, type=later[key(f.type.name)]) for n, f in ROBOT.names.items()}
    monkeypatch.setattr("rrp_sheets.checks.check.load_robot", lambda name: replace(ROBOT, devices=later, names=names))
    book = devices("| A | Gesture | Wave |", "| B | Gesture | Nod |", "| C | Gesture | Bow |", columns=" Name |",
                   rows_="| Head yaw | subscribe | | A |\n| | subscribe | | B |\n| Sonar | subscribe | | Print |")  # fmt: skip
    found = [(d.code, str(d.address), d.severity.value) for d in check(book).report]
    assert found == [("DEV009", "T!A4", "info"), ("DEV009", "Devices!A2", "info")]  # C is not used
    assert "A, B" in list(check(book).report)[1].message


@pytest.mark.parametrize(
    ("device", "name", "uses"),
    [
        ("Gesture", "Nod", {"head"}),
        ("Gesture", "Bow", {"head", "left arm", "right arm", "legs"}),
        ("Gesture", "", {"head", "left arm", "right arm", "legs"}),
        ("Gesture", "My own", {"head", "left arm", "right arm", "legs"}),
        ("Posture", "Crouch", {"head", "left arm", "right arm", "legs"}),
        ("Wait", "", set()),
    ],
)
def test_what_an_actuator_uses(device, name, uses):
    assert ROBOT.devices[key(device)].resources_for({"name": name}) == uses


def test_touches_of_several_sensors_are_of_one_kind():
    kinds = [ROBOT.devices[d].payload for d in ("touch", "bumper", "chestbutton")]
    assert kinds[0] == kinds[1] == kinds[2]
    book = devices(rows_="| Touch, Bumper, Chest button | merge | | M |\n| M | filter | m.pressed and m.zone == 1 | |\n"
                   "| | subscribe | | Print |")  # fmt: skip
    assert not check(book).report.errors
