"""The Gestures sheet: one's own gestures as keyframes, read, checked, made by the robot, and recorded from it."""

from __future__ import annotations

import re
import shutil
import zipfile

import pytest
from click.testing import CliRunner
from play import check, rows

from rrp_sheets import api
from rrp_sheets.checks import check_workbook
from rrp_sheets.resources import bundled
from rrp_sheets.robots import load_robot
from rrp_sheets.workbook import read

pytest.importorskip("pybullet")
pytest.importorskip("cv2")

from rrp_sheets.cli.files import pose_command
from rrp_sheets.model.exchange import Command, DeviceUse
from rrp_sheets.sim.process import Spec
from rrp_sheets.sim.world import SimWorld

EXAMPLE = load_robot().devices["gesture"].example
TWICE = "| Greet | 0.5 | 0.3 |\n| Greet | 1 | -0.1 |"


def sheet(lines=TWICE, header="HeadPitch", device="Greet"):
    rule = "|---" * (2 + len(header.split("|"))) + "|"
    own = f"\n## Devices\n| Stream | Device | Name |\n|---|---|---|\n| Hello | Gesture | {device} |\n"
    return rows(
        "| Touch | subscribe | | Hello |", own + f"\n## Gestures\n| Name | Time (s) | {header} |\n{rule}\n{lines}\n"
    )


def found(*lines, header="HeadPitch", device="Greet"):
    return check(sheet("\n".join(lines) or TWICE, header, device)).report.flatten(["code", "cell"])


@pytest.mark.parametrize("form", ["md", "csv", "xlsx"])
def test_every_format_gives_the_same_gesture(form, tmp_path):
    path = tmp_path / "example.md"
    path.write_text(EXAMPLE, encoding="utf-8")
    if form != "md":
        path = api.convert(path, tmp_path / ("it.xlsx" if form == "xlsx" else "it"))
    reading = read(path)
    checked = check_workbook(reading.workbook, reading.report)
    assert checked.report.flatten(["code", "cell"]) == []
    salute = checked.robot.motions["salute"]
    assert [f.at for f in salute.frames] == [0.8, 1.2, 2.2]
    assert salute.frames[0].angles["RShoulderPitch"] == pytest.approx(-0.349, abs=1e-3)  # -20°
    assert salute.frames[1].angles == {
        "RShoulderPitch": pytest.approx(-0.611, abs=1e-3), "RShoulderRoll": pytest.approx(-0.785, abs=1e-3),
        "RElbowRoll": pytest.approx(1.501, abs=1e-3), "HeadPitch": -0.1,
    }  # fmt: skip
    assert checked.robot.devices["gesture"].resources_for({"name": "Salute"}) == {"right arm", "head"}


@pytest.mark.slow
def test_it_is_made_and_held_by_the_simulated_robot():
    robot = check(EXAMPLE).robot
    use = DeviceUse("g", "Show", "Gesture", {"name": "Salute"})
    world = SimWorld(Spec(robot, actuators=(use,), dones={"g": "gdone"}))
    try:
        world.advance(100_000, [Command("g", True)])
        world.advance(1_900_000, ())
        joints = world.state().joints
        assert joints["RElbowRoll"] == pytest.approx(1.501, abs=0.02) and joints["HeadPitch"] == pytest.approx(
            -0.1, abs=0.02
        )
        assert joints["RShoulderRoll"] == pytest.approx(-0.785, abs=0.02)
        (done,) = world.advance(6_000_000, ()).events
        assert done[1]["completed"] is True
    finally:
        world.close()


def test_one_that_is_named_like_a_robots_own_takes_its_place():
    checked = check(sheet("| nod | 1 | 0.2 |", device="Nod"))
    assert not checked.report.errors
    assert checked.robot.motions["nod"].frames[0].angles == {"HeadPitch": 0.2}
    assert checked.robot.gestures.count("nod") + checked.robot.gestures.count("Nod") == 1


@pytest.mark.parametrize(
    ("lines", "header", "expected"),
    [
        ([], "HeadPitch", []),
        (["| Greet | soon | 0.3 |"], "HeadPitch", [("GEST001", "B2")]),
        (["| Greet | 1000 | 0.3 |", "| Greet | 1 | 0.3 |"], "HeadPitch", [("GEST001", "B2")]),
        (["| Greet | 1 | 0.3 |", "| Greet | 1 | 0 |"], "HeadPitch", [("GEST002", "B3")]),
        (["| Greet | 1 | 0.3 |", "| Bow | 0.5 | 0 |", "| Greet | 2 | 0 |"], "HeadPitch", []),
        (["| Greet | 1 | 0.3 | 1 |"], "HeadPitch | ShoulderPitch", [("GEST003", "D2")]),
        (["| Greet | 1 | 0.3 | 1 |"], "HeadPitch | Heart", [("GEST003", "D2")]),
        (["| Greet | 1 | 0.3 | |"], "HeadPitch | Heart", []),
        (["| Greet | 1 | up | 0.5 |"], "HeadPitch | HeadYaw", [("GEST004", "C2")]),
        (["| Greet | 1 | 0.3 | 90° |"], "HeadPitch | RHand", [("GEST004", "D2")]),
        (["| Greet | 1 | 0.3 | 1.5 |"], "HeadPitch | RHand", [("GEST005", "D2")]),
        (["| Greet | 1 | 0.5 |"], "HeadPitch", []),
        (["| Greet | 1 | 0.5 | 60° |"], "HeadPitch | HeadYaw", [("GEST005", "C2")]),  # turned aside it nods less
        (["| Greet | 1 | 1.5 |", "| Greet | 1.1 | -1.5 |"], "HeadYaw", [("GEST006", "B3")]),
        (["| Greet | 1 | |", "| Greet | 2 | 0.2 |", "| Greet | 3 | |"], "HeadPitch", []),  # waits, then holds
        (["| | 1 | 0.3 |", *TWICE.split("\n")], "HeadPitch", [("SHEET013", "A2")]),
    ],
)
def test_what_is_wrong_is_told_at_its_cell(lines, header, expected):
    assert sorted(found(*lines, header=header)) == expected


def test_the_head_turned_aside_is_told_as_a_reason_for_its_nod_only():
    def message(line: str, header: str) -> str:
        return next(d.message for d in check(sheet(line, header, "Greet")).report if d.code == "GEST005")

    assert "while HeadYaw is at" in message("| Greet | 1 | 0.5 | 60° |", "HeadPitch | HeadYaw")
    assert "HeadYaw" not in message("| Greet | 1 | 60° | 1.5 |", "HeadYaw | RHand")
    assert "while" not in message("| Greet | 1 | 2 |", "HeadPitch")


def test_remedies_name_the_joint_the_time_and_the_gesture():
    def remedy(*lines, header="HeadPitch", device="Greet"):
        return next(d.remedy for d in check(sheet("\n".join(lines) or TWICE, header, device)).report)

    assert "LShoulderPitch and RShoulderPitch" in remedy("| Greet | 1 | 1 | 0 |", header="Shoulder pitch | HeadPitch")
    assert "Did you mean HeadPitch?" in remedy("| Greet | 1 | 1 | 0 |", header="HeadPich | HeadYaw")
    assert remedy(device="Gret").startswith("Write Greet")
    late = remedy("| Greet | 1 | 1.5 |", "| Greet | 1.1 | -1.5 |", header="HeadYaw")
    time = re.search(r"Write ([\d.]+) or later", late)[1]
    assert found("| Greet | 1 | 1.5 |", f"| Greet | {time} | -1.5 |", header="HeadYaw") == []


def test_a_value_that_names_no_gesture_is_told_before_the_run():
    book = sheet().replace("| Touch | subscribe | | Hello |", '| Touch | subscribe | "Gret" | Gesture |')
    (finding,) = [d for d in check(book).report if d.code == "LINT012"]
    assert "Greet" in finding.message


@pytest.mark.parametrize("text", ["1e999", "nan", "=1+1", "°", "--1", "9" * 400, "1;2", "½", "<b>"])
def test_hostile_angles_are_findings(text):
    report = check(sheet(f"| Greet | 1 | {text} |")).report
    assert {d.code for d in report} <= {"GEST004", "GEST005", "DEV004", "SHEET007"} and report


# ---- recorded from the robot


def pose(path, *words):
    done = CliRunner().invoke(pose_command, [str(path), *words])
    if done.exception and not isinstance(done.exception, SystemExit):
        raise done.exception
    return done.output


@pytest.mark.slow
def test_poses_become_the_keyframes_of_a_new_sheet(tmp_path):
    path = tmp_path / "mine.xlsx"
    shutil.copyfile(bundled("workbooks", "simple-tracking.xlsx"), path)
    said = [
        pose(path, "--name", "High five", "RShoulderPitch=-20°", "RElbowRoll=60°", "RHand=1"),
        pose(path, "--name", "High five", "RElbowRoll=10°", "--at", "1.5"),
        pose(path, "--name", "High five", "RShoulderPitch=-99", "--at", "1.2"),
    ]
    workbook = read(path).workbook
    found = [(g.name.text, g.time.text, {k: c.text for k, c in g.joints.items()}) for g in workbook.gestures]
    assert found == [
        ("High five", "1", {"rshoulderpitch": "-0.35", "relbowroll": "1.05", "rhand": "1"}),
        ("High five", "1.2", {"rshoulderpitch": "-2.08", "relbowroll": "1.05", "rhand": "1"}),
        ("High five", "1.5", {"rshoulderpitch": "-0.35", "relbowroll": "0.17", "rhand": "1"}),
    ]
    assert said[0].startswith("Gestures!A2: “High five” at 1 s: RShoulderPitch -0.35 (-20°)")
    assert "Note: RShoulderPitch: -99 → -2.086 rad, its limit." in said[2]


def test_all_else_in_the_file_stays_as_it_was(tmp_path):
    path = tmp_path / "mine.xlsx"
    shutil.copyfile(bundled("workbooks", "simple-tracking.xlsx"), path)
    before = zipfile.ZipFile(path)
    parts = {name: before.read(name) for name in before.namelist()}
    pose(path, "--name", "High five", "RElbowRoll=10°", "--at", "1.5", "--picture", str(tmp_path / "pose.png"))
    assert (tmp_path / "pose.png").stat().st_size > 5_000
    after = zipfile.ZipFile(path)
    sheets = [name for name in parts if name.startswith("xl/worksheets/sheet")]
    assert sheets and all(after.read(name) == parts[name] for name in sheets)


def test_a_pose_goes_into_the_sheet_that_is_there_and_its_columns(tmp_path):
    path = tmp_path / "mine.md"
    path.write_text(sheet(), encoding="utf-8")
    said = pose(path, "--name", "greet", "--posture", "Crouch", "HeadYaw=0.2", "--at", "1")
    assert "New columns: HeadYaw" in said
    reading = read(path)
    second = reading.workbook.gestures[1]
    assert second.name.text == "greet" and second.joints["headyaw"].text == "0.2"
    assert second.joints["lkneepitch"].text == "2.11" and len(reading.workbook.gestures) == 2


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--name", "x", "ShoulderPitch=1"], "LShoulderPitch or RShoulderPitch"),
        (["--name", "x", "HeadPich=1"], "HeadPitch"),
        (["--name", "x", "HeadPitch"], "HeadPitch=0.5"),
        (["--name", "x", "RHand=30°"], "RHand=0.5"),
        (["--name", "x"], "RShoulderPitch=-60°"),
        (["--name", " ", "HeadYaw=1"], "High five"),
        (["--name", "x", "--posture", "Sti"], "Sit"),
    ],
)
def test_what_is_wrong_is_told_with_what_to_write(words, message, tmp_path):
    from rrp_sheets.errors import SheetsError

    path = tmp_path / "mine.md"
    path.write_text(sheet(), encoding="utf-8")
    with pytest.raises(SheetsError) as error:
        pose(path, *words)
    assert message in error.value.remedy and path.read_text(encoding="utf-8") == sheet()


def test_the_help_of_the_command(golden):
    golden("pose-help.txt", CliRunner().invoke(pose_command, ["--help"], prog_name="rrp-sheets pose").output)


def test_a_time_that_is_none(tmp_path):
    assert "for example 1.5" in pose(tmp_path / "x.md", "--name", "x", "HeadYaw=1", "--at", "soon")
