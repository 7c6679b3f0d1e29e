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
from rrp_sheets.devices import load_robot
from rrp_sheets.devices.own_robot import files_of, own_robot
from rrp_sheets.errors import UnreadableFile
from rrp_sheets.runs.bundle.packing import pack
from rrp_sheets.runs.bundle.unpacking import unpack


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
    "out of the folder": (lambda c: relisted({**c, "../evil": EVIL}), "outside of its folder"),
    "from the root": (lambda c: relisted({**c, "/tmp/evil": EVIL}), "outside of its folder"),
    "another drive": (lambda c: relisted({**c, "C:\\evil": EVIL}), "outside of its folder"),
    "a name with a line break": (lambda c: relisted({**c, "a\nevil": EVIL}), "a name that is not taken"),
    "two names": (lambda c: relisted({**c, "SONG.md": EVIL}), "two of its files have one name"),
    "many files": (lambda c: {**c, **{f"runs/{n}": b"" for n in range(2_001)}}, "2,000 are possible"),
    "a bomb": (lambda c: {**c, "runs/big": bytes(20_000_000)}, "compressed as no file of a bundle is"),
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
        (bytes(locked), "password"), (whole[: len(whole) // 2], "damaged"), (b"hello", "damaged"), (b"", "damaged"),
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
    "a shape elsewhere": ("robot.toml", 'urdf = "nao.urdf"', 'urdf = "/etc/passwd"', "no file of its folder"),
    "no number": ("robot.toml", "height = ", "height = nan # ", "no robot has"),
    "a text for a number": ("robot.toml", "height = ", "height = 'tall' # ", "not what it is"),
    "a joint of its own": ("robot.toml", 'name = "HeadYaw"', 'name = "Tail"', "other ones than those that can be simulated"),
    "no table": ("robot.toml", "[robot]", "[robot", "no table"),
    "a table that is gone": ("robot.toml", "[camera.top]", "[lens.top]", "is missing"),
    "a gesture that is none": ("gestures.toml", "frames = ", "pictures = ", "do not fit together"),
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
