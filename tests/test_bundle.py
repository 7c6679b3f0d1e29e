"""Bundles: what is in one, that it runs and replays elsewhere, and that nothing in a stranger's is believed."""

from __future__ import annotations

import hashlib
import html
import io
import json
import os
import re
import shutil
import stat
import struct
import subprocess
import sys
import wave
import zipfile
from collections.abc import Callable
from datetime import date
from pathlib import Path
from typing import Any

import pytest
from browser import get, post, visit
from click.testing import CliRunner, Result
from flask.testing import FlaskClient

from rrp_sheets import api
from rrp_sheets.cli.main import group
from rrp_sheets.devices import load_robot
from rrp_sheets.devices.own_robot import files_of, own_robot
from rrp_sheets.errors import SheetsError, UnreadableFile
from rrp_sheets.runs.bundle.packing import pack
from rrp_sheets.runs.bundle.unpacking import unpack

SONG = """## Tracking
| Input streams | Connector | Formula | Output stream |
|---|---|---|---|
| Red ball | map | redBall.distance | Distance |
| Distance | filter | distance < 0.8 | Near |
| Near | throttle | 3 s | Now |
| Now | subscribe | | Tune |

## Devices
| Stream | Device | File |
|---|---|---|
| Tune | Play sound | a tune.wav |

## Scene
| Time (s) | Thing | Does | Value |
|---|---|---|---|
| 0.2 | Red ball | appears | at 0.6, 0, 0.42 |
"""
DAY = date(2026, 1, 2)
PROGRAM = [sys.executable, "-c", "from rrp_sheets.cli.main import main; main()"]


def sound(path: Path) -> None:
    with wave.open(str(path), "wb") as file:
        file.setnchannels(1)
        file.setsampwidth(2)
        file.setframerate(16_000)
        file.writeframes(b"".join(struct.pack("<h", n * 37 % 2000) for n in range(1600)))


def run(*arguments: object) -> Result:
    return CliRunner().invoke(group, [str(a) for a in arguments])


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a workbook, its sound and a run, packed as `song.zip`."""
    folder = tmp_path_factory.mktemp("歌 folder")
    (folder / "song.md").write_text(SONG, encoding="utf-8")
    sound(folder / "a tune.wav")
    settings = api.RunSettings(seconds=1.5, fast=True, film=False, out=folder / "runs" / "one", participant="P-07")
    assert api.run_apart(folder / "song.md", settings).result is not None
    api.pack(folder / "song.md", folder / "song.zip", runs=["one"], today=DAY)
    return folder


def files(path: Path) -> dict[str, bytes]:
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def remade(target: Path, content: dict[str, bytes]) -> Path:
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in content.items():
            archive.writestr(name, data)
    return target


def relisted(content: dict[str, bytes]) -> dict[str, bytes]:
    """With a list that fits what is there, as a stranger would make it."""
    told = json.loads(content["versions.json"])
    told["files"] = {
        n: {"sha256": hashlib.sha256(d).hexdigest(), "bytes": len(d)}
        for n, d in content.items()
        if n != "versions.json"
    }
    return {**content, "versions.json": json.dumps(told).encode()}


def refusal(path: Path, folder: Path) -> str:
    with pytest.raises(UnreadableFile) as caught:
        unpack(path, folder / "out")
    assert not [p for p in folder.rglob("*") if "evil" in p.name]
    assert caught.value.code in ("FILE020", "FILE001") and caught.value.remedy
    return caught.value.message


# ---- what is in it


def test_everything_that_is_needed_is_in_it(place: Path) -> None:
    content = files(place / "song.zip")
    assert content["song.md"] == (place / "song.md").read_bytes()
    assert content["a tune.wav"] == (place / "a tune.wav").read_bytes()
    assert content["protocol.pdf"].startswith(b"%PDF")
    assert {f"robots/nao/{p.name}" for p in files_of(load_robot())} < content.keys()
    assert {"runs/one/trace.jsonl", "runs/one/protocol.xlsx", "runs/one/robot.toml"} < content.keys()
    assert next(iter(content)) == "README.txt" and b"rrp-sheets replay" in content["README.txt"]
    told = json.loads(content["versions.json"])
    for name, data in content.items():
        if name != "versions.json":
            assert told["files"][name] == {"sha256": hashlib.sha256(data).hexdigest(), "bytes": len(data)}
    assert told["dependencies"]["asteval"] and told["python"] and told["program"]
    assert told["runs"][0]["participant"] == "P-07"


def test_the_same_files_give_the_same_bytes(place: Path, tmp_path: Path) -> None:
    for name in ("song.md", "a tune.wav"):
        shutil.copy(place / name, tmp_path)
    shutil.copytree(place / "runs" / "one", tmp_path / "runs" / "one")
    os.utime(tmp_path / "song.md", (1, 1))
    packed = api.pack(tmp_path / "song.md", tmp_path / "again.zip", runs=["one"], today=DAY)
    assert packed.path.read_bytes() == (place / "song.zip").read_bytes()


def test_a_folder_of_csv_files_goes_with_its_sound(place: Path, tmp_path: Path) -> None:
    api.convert(place / "song.md", tmp_path / "book")
    sound(tmp_path / "book" / "a tune.wav")
    packed = pack(tmp_path / "book", tmp_path / "b.zip")  # without the printed protocol
    assert {"book/Tracking.csv", "book/a tune.wav", "book/robots/nao/robot.toml"} < packed.files.keys()
    out = unpack(packed.path, tmp_path / "out")
    assert not out.notes and api.check(out.workbook).robot.folder == out.workbook / "robots" / "nao"


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["song.md", "--run", "none"], "There is no run “none”. The runs of this folder: one."),
        (["song.md", "--run", ".."], "There is no run"), (["none.md"], "There is no file"),
        (["song.md", "-o", "x.xlsx"], "ends with .zip"), (["song.md", "-o", "no/folder/x.zip"], "cannot be written"),
        (["song.md", "--against", "none.md"], "There is no file"),
    ],
)  # fmt: skip
def test_what_cannot_be_packed(place: Path, arguments: list[str], said: str, monkeypatch: Any) -> None:
    monkeypatch.chdir(place)
    before = sorted(place.iterdir())
    result = run("pack", *arguments)
    text = result.output + (str(result.exception) if isinstance(result.exception, SheetsError) else "")
    assert result.exit_code and said in text
    assert sorted(place.iterdir()) == before


def test_a_name_that_no_other_system_can_have(tmp_path: Path) -> None:
    book = tmp_path / 'what "is"?.md'
    book.write_text(SONG, encoding="utf-8")
    with pytest.raises(SheetsError, match="every system"):
        api.pack(book, tmp_path / "x.zip")


def test_a_sound_that_is_missing_and_errors_are_told(tmp_path: Path) -> None:
    (tmp_path / "song.md").write_text(SONG.replace("| filter |", "| filtre |"), encoding="utf-8")
    packed = api.pack(tmp_path / "song.md", tmp_path / "x.zip")
    notes = " ".join(packed.notes)
    assert "The sound “a tune.wav” is not in the folder" in notes and "draft" in notes and "error" in notes
    assert "protocol.pdf" in packed.files


# ---- it is used


def test_commands_take_a_bundle(place: Path, tmp_path: Path, monkeypatch: Any) -> None:
    monkeypatch.chdir(tmp_path)
    bundle = place / "song.zip"
    assert run("check", bundle).exit_code == 0
    assert "play the sound a tune.wav" in run("explain", bundle).output
    assert run("diagram", bundle, "-o", "x.svg").exit_code == 0 and (tmp_path / "x.svg").is_file()
    assert "no difference" in run("diff", bundle, place / "song.md").output
    result = run("replay", bundle)
    assert result.exit_code == 0 and "one:" in result.output and "The same:" in result.output


def test_it_runs_in_a_folder_of_its_own_and_the_run_replays(place: Path, tmp_path: Path) -> None:
    (tmp_path / "far").mkdir()
    bundle = Path(shutil.copy(place / "song.zip", tmp_path / "far" / "歌.zip"))
    bundle.chmod(0o444)
    done = subprocess.run(
        [*PROGRAM, "run", str(bundle), "--fast", "--for", "1.5s", "--json"], cwd=tmp_path, capture_output=True,
        text=True, check=False, env={**os.environ, "HOME": str(tmp_path), "TMPDIR": str(tmp_path)},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    folder = Path(json.loads(done.stdout.splitlines()[-1])["folder"])
    assert folder.parent == tmp_path / "far" / "runs"
    assert not list(tmp_path.glob("rrp-bundle-*"))
    assert (folder / "robots" / "nao" / "robot.toml").is_file()  # its own catalogue, with which it is replayed
    found = api.replay(folder)
    assert found.same and found.compared > 20
    here = (place / "runs" / "one" / "trace.jsonl").read_text(encoding="utf-8")
    assert events(here) == events((folder / "trace.jsonl").read_text(encoding="utf-8"))


def events(trace: str) -> list[str]:
    return [line for line in trace.splitlines() if '"type"' not in line]


def changed_catalogue(place: Path, target: Path, old: str, new: str) -> Path:
    content = files(place / "song.zip")
    toml = content["robots/nao/robot.toml"].decode()
    assert old in toml
    content["robots/nao/robot.toml"] = toml.replace(old, new, 1).encode()
    return remade(target, relisted(content))


def test_its_own_catalogue_is_used_and_told(place: Path, tmp_path: Path) -> None:
    bundle = changed_catalogue(place, tmp_path / "x.zip", "Plays a sound:", "Plays some sound:")
    out = unpack(bundle, tmp_path / "out")
    assert any("another one than here (robot.toml)" in note for note in out.notes)
    robot = api.check(out.workbook).robot
    assert robot.folder == tmp_path / "out" / "robots" / "nao" and "some sound" in robot.devices["playsound"].help


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


# ---- in the browser


def test_a_bundle_is_downloaded_and_uploaded(place: Path, tmp_path: Path) -> None:
    answer = get(visit(place), "/book/song.md/bundle.zip?run=one")
    assert answer.status_code == 200 and answer.mimetype == "application/zip"
    assert "song-bundle.zip" in answer.headers["Content-Disposition"]
    got = tmp_path / "got.zip"
    got.write_bytes(answer.data)
    assert files(got).keys() == files(place / "song.zip").keys()
    (tmp_path / "shelf").mkdir()
    client = visit(tmp_path / "shelf")
    for _ in range(2):  # the same again harms nothing
        said = upload(client, "song.zip", answer.data)
        assert "song.md is on the shelf." in said
    assert (tmp_path / "shelf" / "a tune.wav").read_bytes() == (place / "a tune.wav").read_bytes()
    assert api.replay(tmp_path / "shelf" / "runs" / "one").same
    (tmp_path / "shelf" / "a tune.wav").write_bytes(b"mine")
    (tmp_path / "shelf" / "song.md").unlink()
    assert "already another file “a tune.wav”" in html.unescape(upload(client, "song.zip", answer.data))
    assert not (tmp_path / "shelf" / "song.md").exists()


def test_what_cannot_be_downloaded_or_uploaded(place: Path, tmp_path: Path) -> None:
    client = visit(place)
    assert get(client, "/book/none.md/bundle.zip").status_code == 404
    assert get(client, "/book/song.md/bundle.zip?run=../runs/one").status_code == 404
    before = sorted(place.iterdir())
    evil = remade(tmp_path / "x.zip", relisted({**files(place / "song.zip"), "../evil": EVIL}))
    assert "outside of its folder" in upload(client, "x.zip", evil.read_bytes())
    assert "cannot be taken as a bundle" in upload(client, "x.zip", b"hello")
    assert sorted(place.iterdir()) == before


def upload(client: FlaskClient, name: str, data: bytes) -> str:
    return post(client, "/shelf/upload", file=(io.BytesIO(data), name)).text
