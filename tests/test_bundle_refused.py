"""Bundles of strangers: nothing in one is believed, and nothing is written where it should not."""

from __future__ import annotations

import json
import re
import shutil
import stat
import struct
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from bundles import SONG, files, relisted, remade, run, sound

from rrp_sheets import api
from rrp_sheets.engine.scene import default_scene
from rrp_sheets.errors import UnreadableFile
from rrp_sheets.model.exchange import DeviceUse
from rrp_sheets.robots import load_robot
from rrp_sheets.robots.own_robot import files_of, own_robot
from rrp_sheets.services.bundle_packing import pack
from rrp_sheets.services.bundles import unpack


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a bundle, `song.zip`."""
    folder = tmp_path_factory.mktemp("bundles")
    (folder / "song.md").write_text(SONG, encoding="utf-8")
    sound(folder / "a tune.wav")
    pack(folder / "song.md", folder / "song.zip")
    return folder


def refusal(path: Path, folder: Path) -> str:
    with pytest.raises(UnreadableFile) as caught:
        unpack(path, folder / "out")
    assert not [p for p in folder.rglob("*") if "evil" in p.name]
    assert caught.value.code in ("FILE020", "FILE001") and caught.value.remedy
    return caught.value.message


# ---- what is not believed


def test_changed_missing_and_further_files_are_named(place: Path, tmp_path: Path) -> None:
    content = files(place / "song.zip")
    content["song.md"] += b"\n"
    content["evil.exe"] = b"x"
    del content["a tune.wav"]
    out = unpack(remade(tmp_path / "x.zip", content), tmp_path / "out")
    assert set(out.notes) >= {
        "“song.md” has been changed since the bundle was made.", "“a tune.wav” is missing in the bundle.",
        "“evil.exe” is not in the bundle's list; it was left out.",
    }  # fmt: skip
    assert not (tmp_path / "out" / "evil.exe").exists()
    assert "has been changed" in run("check", tmp_path / "x.zip").output


Change = Callable[[dict[str, bytes]], dict[str, bytes]]
EVIL = b"evil"


def listed(**changes: Any) -> Change:
    def change(content: dict[str, bytes]) -> dict[str, bytes]:
        return {**content, "versions.json": json.dumps({**json.loads(content["versions.json"]), **changes}).encode()}

    return change


REFUSED: dict[str, tuple[Change, str]] = {
    "out of the folder": (lambda c: relisted({**c, "../evil": EVIL}), "“../evil” has a name that cannot be used, or that leads out of the folder"),
    "from the root": (lambda c: relisted({**c, "/tmp/evil": EVIL}), "leads out of the folder"),
    "another drive": (lambda c: relisted({**c, "C:\\evil": EVIL}), "leads out of the folder"),
    "a name with a line break": (lambda c: relisted({**c, "a\nevil": EVIL}), "“a�evil” has a name that cannot be used"),
    "two names": (lambda c: relisted({**c, "SONG.md": EVIL}), "“song.md” and “SONG.md” would be one file"),
    "many files": (lambda c: {**c, **{f"runs/{n}": b"" for n in range(2_001)}}, "2,000 are possible"),
    "a bomb": (lambda c: {**c, "runs/big": bytes(20_000_000)}, "compressed as no file of a bundle is"),
    "zeros in many files": (lambda c: {**c, **{f"runs/{n}": bytes(9_000_000) for n in range(7)}}, "compressed as no files of a bundle are"),
    **{f"the name {name}": (lambda c, name=name: relisted({**c, name: EVIL}), f"“{name}” has a name that cannot be used")
       for name in ("NUL", "nul.txt", "runs/CON/evil", "COM1.csv", "COM¹", "aux .txt", "evil.", "evil ", "evil:stream", "a./evil", "CONOUT$")},
    "no list": (lambda c: {n: d for n, d in c.items() if n != "versions.json"}, "there is no versions.json"),
    "another list": (lambda c: {**c, "versions.json": b"[1]"}, "another program's"),
    "no text": (lambda c: {**c, "versions.json": b"\xff\xfe{"}, "is damaged"),
    "deep list": (lambda c: {**c, "versions.json": b"[" * 100_000}, "is damaged"),
    "newer": (listed(schema=99), "newer version"), "no files": (listed(files=[]), "names no files"),
    "workbook elsewhere": (listed(workbook="../evil.md"), "the workbook that its list names is not in it"),
    "workbook of another kind": (listed(workbook=7), "the workbook that its list names is not in it"),
    "Excel": (lambda c: {"[Content_Types].xml": b"<a/>", "xl/workbook.xml": b"<a/>"}, "end with .xlsx"),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_a_strangers_zip_is_refused(place: Path, tmp_path: Path, name: str) -> None:
    change, said = REFUSED[name]
    assert said in refusal(remade(tmp_path / "x.zip", change(files(place / "song.zip"))), tmp_path)


def test_links_encryption_and_damage(place: Path, tmp_path: Path) -> None:
    whole = (place / "song.zip").read_bytes()
    link = tmp_path / "link.zip"
    with zipfile.ZipFile(link, "w") as archive:
        archive.writestr("versions.json", "{}")
        info = zipfile.ZipInfo("evil")
        info.external_attr = (stat.S_IFLNK | 0o777) << 16
        archive.writestr(info, "/etc/passwd")
    assert "is a link" in refusal(link, tmp_path)
    locked = bytearray(whole)
    for mark, at in ((b"PK\x01\x02", 8), (b"PK\x03\x04", 6)):
        for match in re.finditer(re.escape(mark), whole):
            locked[match.start() + at] |= 1
    for data, said in (
        (bytes(locked), "“README.txt” is protected by a password"), (whole[: len(whole) // 2], "damaged"), (b"hello", "damaged"), (b"", "damaged"),
    ):  # fmt: skip
        (tmp_path / "x.zip").write_bytes(data)
        assert said in refusal(tmp_path / "x.zip", tmp_path), said
    assert "There is no file" in refusal(tmp_path / "none.zip", tmp_path)


def test_a_size_that_is_a_lie(place: Path, tmp_path: Path) -> None:
    data = bytearray((place / "song.zip").read_bytes())
    with zipfile.ZipFile(place / "song.zip") as archive:
        entry = archive.getinfo("robots/nao/robot.toml")
    for match in re.finditer(re.escape(struct.pack("<I", entry.file_size)), bytes(data)):
        data[match.start() : match.start() + 4] = struct.pack("<I", 10)
    (tmp_path / "x.zip").write_bytes(data)
    try:
        out = unpack(tmp_path / "x.zip", tmp_path / "out")
    except UnreadableFile:
        return
    assert any("robot.toml” has been changed" in note for note in out.notes)


Spoiled = tuple[str, str, str, str]
CATALOGUES: dict[str, Spoiled] = {
    "a mesh elsewhere": ("nao.urdf", 'filename="ell.obj"', 'filename="../../../etc/ell.obj"', "not in its folder"),
    "a mesh that is not there": ("nao.urdf", 'filename="ell.obj"', 'filename="more.obj"', "missing"),
    "an entity": ("nao.urdf", "<robot ", '<!DOCTYPE r [<!ENTITY a SYSTEM "/etc/passwd">]><robot ', "cannot be read"),
    "a texture": ("nao.urdf", "<link ", '<material name="t"><texture filename="x.png"/></material><link ', "texture"),
    "a plugin": ("nao.urdf", "<link ", "<gazebo/><link ", "gazebo"),
    "no markup": ("nao.urdf", "</robot>", "", "cannot be read"),
    "another file's material": ("ell.obj", "v 0", "mtllib /etc/passwd\nv 0", "not taken"),
    "a corner that is not there": ("ell.obj", "\nf ", "\nf 99999 1 2\nf ", "a corner that there is not"),
    "a shape elsewhere": ("robot.toml", 'urdf = "nao.urdf"', 'urdf = "/etc/passwd"', "not a file of its folder"),
    "no number": ("robot.toml", "height = ", "height = nan # ", "no robot has"),
    "a text for a number": ("robot.toml", "height = ", "height = 'tall' # ", "not what it is"),
    "a joint of its own": ("robot.toml", 'name = "HeadYaw"', 'name = "Tail"', "other ones than those that can be simulated"),
    "a text too long to show": ("robot.toml", 'help = "', 'help = "' + 2_001 * "x", "a text that cannot be shown"),
    "a text that cannot be shown": ("robot.toml", 'help = "', 'help = "\\u0007', "a text that cannot be shown"),
    "no table": ("robot.toml", "[robot]", "[robot", "not a table"),
    "a table that is gone": ("robot.toml", "[camera.top]", "[lens.top]", "is missing"),
    "a gesture that is none": ("gestures.toml", "frames = ", "pictures = ", "do not fit together"),
    # wider than the robot of that name
    "a wide joint": ("robot.toml", "upper = 2.08567", "upper = 100", "joint HeadYaw has upper 100 rad"),
    "a fast joint": ("robot.toml", "max_velocity = 8.26797", "max_velocity = 100", "joint HeadYaw has max_velocity 100 rad/s"),
    "a joint that never moves on": ("robot.toml", "max_velocity = 8.26797", "max_velocity = 0", "joint HeadYaw has max_velocity 0"),
    "a joint the wrong way round": ("robot.toml", "upper = 2.08567", "upper = -2.1", "joint HeadYaw has upper -2.1"),
    "a joint of another chain": ("robot.toml", 'name = "HeadYaw"\nchain = "Head"', 'name = "HeadYaw"\nchain = "LArm"', "joint HeadYaw has another chain"),
    "a head without its table": ("robot.toml", "upper = [0.330041, 0.200015", "upper = [0.330041, 0.5", "joint HeadPitch has upper"),
    "a table that goes back": ("robot.toml", "yaw = [-2.086017, -1.526988", "yaw = [-1.526988, -2.086017", "does not rise"),
    "a table that is too short": ("robot.toml", "yaw = [-2.086017, ", "yaw = [", "different lengths"),
    "a quick setting": ("robot.toml", 'lower = 0.01, upper = 1, ', 'lower = 0.01, upper = 20, ', "the setting Speed of SetJointPosition is wider"),
    "a setting without an end": ("robot.toml", 'lower = -3, upper = 3, help = "how far forward"', 'lower = -3, help = "x"', "the setting Forward of Walk is wider"),
    "a wide default": ("robot.toml", 'default = 0.3, lower = 0.01', 'default = 5, lower = 0.01', "the setting Speed of SetJointPosition is wider"),
    "parts that nobody claims": ("robot.toml", 'resources = ["legs"]', 'resources = ["eyes"]', "the device Walk is not what it is"),
    "a sensor that claims to see": ("robot.toml", "knowledge = true", "knowledge = false", "the device OperatorButton is not what it is"),
    "a device of its own": ("robot.toml", 'name = "Walk"', 'name = "Fly"', "the device Fly is not what it is"),
    "a chain that claims another part": ("robot.toml", 'LArm = "left arm"', 'LArm = "right arm"', "its chains"),
    "a group with another joint": ("robot.toml", 'Head = ["HeadYaw", "HeadPitch"]', 'Head = ["HeadYaw", "LHand"]', "its group head"),
    "no rest": ("robot.toml", "[postures.Crouch]", "[postures.Croutch]", "the posture Crouch says nothing about"),
    "a start beyond the limits": ("robot.toml", "[postures.StandInit]\nHeadYaw = 0.0", "[postures.StandInit]\nHeadYaw = 3.0", "the posture StandInit brings HeadYaw to 3"),
    "a posture's unknown joint": ("robot.toml", "[postures.Sit]\nHeadYaw", "[postures.Sit]\nTail = 1.0\nHeadYaw", "a joint Tail that there is not"),
    "postures in a circle": ("robot.toml", 'Crouch = "StandInit"', 'Crouch = "Sit"', "has no beginning"),
    "a lean beyond lying": ("robot.toml", "LyingBack = -1.5", "LyingBack = -9", "leans farther"),
    "a gesture that goes back in time": ("gestures.toml", "at = 1.3", "at = 0.2", "the times of the gesture Wave do not rise"),
    "a gesture without end": ("gestures.toml", "at = 2.5", "at = 1e6", "the times of the gesture Wave"),
    "no height": ("robot.toml", "height = 0.574", "height = 0", "no robot has"),
    "a place far away": ("robot.toml", "xyz = [0.05871", "xyz = [5871", "no robot has"),
    "a place without a side": ("robot.toml", "xyz = [0.05871, 0.0, ", "xyz = [0.05871, ", "no robot has"),
    "a leg without length": ("robot.toml", "thigh = 0.1", "thigh = 0", "no robot has"),
    # numbers of the shape
    "a heavy head": ("nao.urdf", '<mass value="0.65937"/>', '<mass value="1e30"/>', "mass value 1e30"),
    "a head without mass": ("nao.urdf", '<mass value="0.65937"/>', '<mass value="0"/>', "mass value 0"),
    "an infinite inertia": ("nao.urdf", 'ixx="0.001454"', 'ixx="inf"', "inertia ixx inf"),
    "a mass that is no number": ("nao.urdf", '<mass value="0.65937"/>', '<mass value="nan"/>', "mass value nan"),
    "a mass in Python's spelling": ("nao.urdf", '<mass value="0.65937"/>', '<mass value="0_1"/>', "mass value 0_1"),
    "no mass": ("nao.urdf", '<mass value="0.65937"/>', "<mass/>", "without value"),
    "a part far away": ("nao.urdf", '<origin xyz="0.00109 0.00146', '<origin xyz="1e9 0.00146', "origin xyz 1e9"),
    "a huge solid": ("nao.urdf", 'scale="0.114 0.118 0.112"', 'scale="1e9 1 1"', "mesh scale 1e9"),
    "two masses": ("nao.urdf", '<mass value="0.65937"/>', '<mass value="0.6"/><mass value="0.7"/>', "twice"),
    "a joint within a link": ("nao.urdf", '<link name="Head">', '<link name="Head"><joint name="x" type="fixed"/>', "not taken there"),
    "a joint elsewhere": ("nao.urdf", '<child link="Head"/>', '<child link="torso"/>', "placed elsewhere"),
    "two links of one name": ("nao.urdf", '<link name="Neck">', '<link name="Head">', "two parts of one name"),
    "no shape": ("nao.urdf", "<geometry><sphere radius=\"0.05733\"/></geometry>", "<geometry/>", "without a shape"),
    "a colour that is not there": ("nao.urdf", '<material name="dark"/></visual>', '<material name="gold"/></visual>', "without its colour"),
    "a far corner": ("ell.obj", "\nv ", "\nv 1e9 1 1\nv ", "not taken"),
}  # fmt: skip


def catalogue(place: Path) -> Path:
    folder = place / "robots" / "nao"
    folder.mkdir(parents=True)
    for path in files_of(load_robot()):
        shutil.copy(path, folder)
    return folder


@pytest.mark.parametrize("name", CATALOGUES)
def test_a_strangers_catalogue_is_refused(tmp_path: Path, name: str) -> None:
    file, old, new, said = CATALOGUES[name]
    folder = catalogue(tmp_path)
    text = (folder / file).read_text(encoding="utf-8")
    assert old in text
    (folder / file).write_text(text.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(UnreadableFile) as caught:
        own_robot(tmp_path, "nao")
    assert said in caught.value.message and caught.value.code == "FILE019"


def test_a_strangers_joint_of_the_shape_keeps_its_limits(tmp_path: Path) -> None:
    folder = catalogue(tmp_path)
    text = (folder / "nao.urdf").read_text(encoding="utf-8")
    joint = re.search(r'<joint name="HeadYaw".*?</joint>', text, re.DOTALL)
    assert joint is not None
    for name, value in (("upper", "6"), ("lower", "-6"), ("velocity", "40"), ("effort", "90")):
        wide = re.sub(rf'{name}="[^"]*"', f'{name}="{value}"', joint[0])
        (folder / "nao.urdf").write_text(text.replace(joint[0], wide), encoding="utf-8")
        with pytest.raises(UnreadableFile, match=f"joint HeadYaw has {name} {value}"):
            own_robot(tmp_path, "nao")
        (folder / "nao.urdf").write_text(
            text.replace(joint[0], re.sub(rf' {name}="[^"]*"', "", joint[0])), encoding="utf-8"
        )
        with pytest.raises(UnreadableFile, match=f"joint HeadYaw has no limit “{name}”"):
            own_robot(tmp_path, "nao")


def test_a_catalogue_may_narrow_limits_and_change_texts_and_motions(tmp_path: Path) -> None:
    folder = catalogue(tmp_path)
    for file, changes in {
        "robot.toml": (("max_velocity = 8.26797", "max_velocity = 2"), ("upper = 2.08567", "upper = 1.5"),
                       ("upper = 1, ", "upper = 0.5, "), ('help = "', 'help = "Mine: '), ("HeadPitch = -0.17", "HeadPitch = -0.1")),
        "gestures.toml": (("at = 2.5", "at = 3.5"),),
        "nao.urdf": (('<mass value="0.65937"/>', '<mass value="0.7"/>'), ('upper="2.18567"', 'upper="1.6"')),
    }.items():  # fmt: skip
        text = (folder / file).read_text(encoding="utf-8")
        for old, new in changes:
            assert old in text
            text = text.replace(old, new, 1)
        (folder / file).write_text(text, encoding="utf-8")
    robot = own_robot(tmp_path, "nao")
    assert robot is not None and (robot.joints["headyaw"].upper, robot.joints["headyaw"].max_velocity) == (1.5, 2)


def test_a_robot_of_another_name_keeps_to_the_limits_of_its_own_shape(tmp_path: Path) -> None:
    folder = catalogue(tmp_path)
    folder = folder.rename(folder.parent / "mine")
    table, shape = (
        (folder / "robot.toml").read_text(encoding="utf-8"),
        (folder / "nao.urdf").read_text(encoding="utf-8"),
    )

    def refused(old: str, new: str) -> str:
        assert old in table
        (folder / "robot.toml").write_text(table.replace(old, new, 1), encoding="utf-8")
        with pytest.raises(UnreadableFile) as told:
            own_robot(tmp_path, "mine")
        return told.value.message

    said = "the limits of the joint in its shape allow "
    assert f"joint HeadYaw has upper 3 rad; {said}-2.08567 to 2.08567 rad" in refused("upper = 2.08567", "upper = 3")
    assert f"joint HeadYaw has lower -3 rad; {said}-2.08567 to 2.08567 rad" in refused("lower = -2.08567", "lower = -3")
    assert f"has lower -2.1 rad; {said}-2.08567" in refused("lower = -2.08567", "lower = -2.1")
    assert "joint HeadYaw has upper -3 rad below lower -2.08567 rad in “robot.toml”" in refused(
        "upper = 2.08567", "upper = -3"
    )
    assert f"has max_velocity 9 rad/s; {said}0.001 to 8.26797 rad/s" in refused(
        "max_velocity = 8.26797", "max_velocity = 9"
    )
    (folder / "nao.urdf").write_text(shape.replace('upper="2.18567"', 'upper="3.2"'), encoding="utf-8")
    (folder / "robot.toml").write_text(table.replace("upper = 2.08567", "upper = 3", 1), encoding="utf-8")
    mine = own_robot(tmp_path, "mine")
    assert mine is not None and mine.joints["headyaw"].upper == 3
    (folder / "nao.urdf").write_text(shape.replace('upper="2.18567"', 'upper="100"'), encoding="utf-8")
    assert "joint HeadYaw has limit upper 100" in refused("upper = 2.08567", "upper = 100")


def test_a_robot_of_another_name_has_limits_for_every_joint_that_moves(tmp_path: Path) -> None:
    folder = catalogue(tmp_path)
    folder = folder.rename(folder.parent / "mine")
    shape = (folder / "nao.urdf").read_text(encoding="utf-8")
    limit = '<limit lower="-2.18567" upper="2.18567" effort="1.547" velocity="8.26797"/>'
    for new, said in (
        ("", "joint HeadYaw has no limit “lower” in its shape"),
        ('<limit effort="1.547"/>', "joint HeadYaw has no limit “lower” in its shape"),
        (limit.replace(' velocity="8.26797"', ""), "joint HeadYaw has no limit “velocity” in its shape"),
        (
            limit.replace('upper="2', 'upper="-3'),
            "joint HeadYaw has upper -3.18567 rad below lower -2.18567 rad in “nao.urdf”",
        ),
    ):
        assert limit in shape
        (folder / "nao.urdf").write_text(shape.replace(limit, new, 1), encoding="utf-8")
        with pytest.raises(UnreadableFile) as told:
            own_robot(tmp_path, "mine")
        assert said in told.value.message


@pytest.mark.parametrize(
    "text", ["<robot/>", '<robot name="nao"></robot>', '<robot name="nao"><link name="torso"/></robot>']
)
def test_an_empty_robot_is_an_error_of_check(tmp_path: Path, text: str) -> None:
    folder = catalogue(tmp_path)
    (folder / "nao.urdf").write_text(text, encoding="utf-8")
    (tmp_path / "song.md").write_text(SONG, encoding="utf-8")
    for language, said in (("en", "there is no robot in it"), ("ja", "ロボットが入っていません")):
        result = run("check", tmp_path / "song.md", "--json", "--language", language)
        (finding,) = json.loads(result.output)["findings"]
        assert result.exit_code == 2 and finding["code"] == "FILE019" and said in finding["message"]


def test_a_strangers_text_is_no_format_of_pythons(tmp_path: Path) -> None:
    folder = catalogue(tmp_path)
    table = (folder / "robot.toml").read_text(encoding="utf-8")
    shows = (
        "{colour.__class__.__mro__} ball",
        "{colour:>99999999} ball",
        "{none} ball",
        "{0} ball",
        "{",
        " ",
        "touch {zone.x}",
        "touch {none}",
        "say",
    )
    for shown in shows:
        changed = table.replace('shows = ["{colour} ball"]', f'shows = ["{shown}"]')
        assert changed != table
        (folder / "robot.toml").write_text(changed, encoding="utf-8")
        robot = own_robot(tmp_path, "nao")
        assert robot is not None
        actions = default_scene([DeviceUse("s", "Blob", "Blob", {"colour": "red"})], robot)
        assert all(len(a.thing) < 60 and "class '" not in a.thing for a in actions), shown


def test_a_catalogue_beside_a_workbook_is_used_or_refused(tmp_path: Path) -> None:
    folder = catalogue(tmp_path)
    (tmp_path / "song.md").write_text(SONG, encoding="utf-8")
    assert api.check(tmp_path / "song.md").robot.folder == folder
    (folder / "nao.urdf").write_text("<robot/><robot/>", encoding="utf-8")
    result = run("check", tmp_path / "song.md", "--json")
    assert result.exit_code == 2 and json.loads(result.output)["findings"][0]["code"] == "FILE019"


def test_a_link_in_a_catalogue_is_refused(tmp_path: Path) -> None:
    folder = catalogue(tmp_path)
    (folder / "ell.obj").unlink()
    (folder / "ell.obj").symlink_to("/etc/passwd")
    with pytest.raises(UnreadableFile, match="is a link"):
        own_robot(tmp_path, "nao")
