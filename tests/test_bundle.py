"""Bundles: what is in one, and that it runs and replays elsewhere."""

from __future__ import annotations

import errno
import hashlib
import html
import io
import json
import os
import shutil
import sys
from datetime import date
from pathlib import Path
from typing import Any

import forked
import pytest
from browser import get, post, visit
from bundles import SONG, files, relisted, remade, run, sound
from flask.testing import FlaskClient

from rrp_sheets import api
from rrp_sheets.errors import SheetsError
from rrp_sheets.robots import load_robot
from rrp_sheets.robots.own_robot import files_of
from rrp_sheets.services.bundle_packing import pack
from rrp_sheets.services.bundles import unpack

DAY = date(2026, 1, 2)


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


# ---- what is in it


@pytest.mark.slow
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
        (["song.md", "--against", "none.md"], "There is no file"), (["song.zip"], "is a bundle already"),
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


def test_a_zip_that_is_none_is_told_as_json_too(place: Path, tmp_path: Path) -> None:
    (tmp_path / "bad.zip").write_bytes(b"no zip")
    told = run("check", tmp_path / "bad.zip", "--json")
    [finding] = json.loads(told.output)["findings"]
    assert told.exit_code == 2 and finding["code"] == "FILE020" and "damaged" in finding["message"]
    told = run("diff", place / "song.md", tmp_path / "bad.zip", "--json")
    assert told.exit_code == 2 and json.loads(told.output)["error"]["code"] == "FILE020"


def test_commands_take_a_bundle(place: Path, tmp_path: Path, monkeypatch: Any) -> None:
    monkeypatch.chdir(tmp_path)
    bundle = place / "song.zip"
    assert run("check", bundle).exit_code == 0
    assert "play the sound a tune.wav" in run("explain", bundle).output
    assert run("diagram", bundle, "-o", "x.svg").exit_code == 0 and (tmp_path / "x.svg").is_file()
    assert "no difference" in run("diff", bundle, place / "song.md").output
    assert run("print", bundle).exit_code == 0 and (place / "song.pdf").read_bytes().startswith(b"%PDF")
    shutil.copy(place / "song.md", "mine.md")
    assert run("print", "mine.md", "--against", bundle).exit_code == 0 and (tmp_path / "mine.pdf").is_file()
    result = run("replay", bundle)
    assert result.exit_code == 0 and "one:" in result.output and "The same:" in result.output


def test_it_runs_in_a_folder_of_its_own_and_the_run_replays(place: Path, tmp_path: Path) -> None:
    (tmp_path / "far").mkdir()
    bundle = Path(shutil.copy(place / "song.zip", tmp_path / "far" / "歌.zip"))
    bundle.chmod(0o444)
    done = forked.run(
        [*forked.COMMAND, "run", str(bundle), "--fast", "--for", "1.5s", "--json"], cwd=tmp_path, capture_output=True,
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


def test_a_file_of_its_catalogue_that_nothing_reads_is_not_told(place: Path, tmp_path: Path) -> None:
    content = files(place / "song.zip")
    content["robots/nao/ja.toml"] = b"# texts as older bundles have them"
    assert unpack(remade(tmp_path / "old.zip", relisted(content)), tmp_path / "out").notes == ()


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
        assert "song.md is uploaded." in said
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
    evil = remade(tmp_path / "x.zip", relisted({**files(place / "song.zip"), "../evil": b"evil"}))
    assert "leads out of the folder" in upload(client, "x.zip", evil.read_bytes())
    assert "cannot be opened as a bundle" in upload(client, "x.zip", b"hello")
    swollen = {f"runs/{n}": bytes(9_999_999) for n in range(21)}
    bomb = remade(tmp_path / "b.zip", {**files(place / "song.zip"), **swollen})
    assert "larger than 200 MB" in upload(client, "b.zip", bomb.read_bytes())
    assert sorted(place.iterdir()) == before


@pytest.mark.skipif(sys.platform == "win32", reason="links need rights there")
def test_runs_that_lie_elsewhere_get_none_by_an_upload(place: Path, tmp_path: Path) -> None:
    (tmp_path / "shelf").mkdir()
    (tmp_path / "outside").mkdir()
    (tmp_path / "shelf" / "runs").symlink_to(tmp_path / "outside")
    said = upload(visit(tmp_path / "shelf"), "song.zip", (place / "song.zip").read_bytes())
    assert "leads to another folder" in said
    assert not list((tmp_path / "outside").iterdir()) and not (tmp_path / "shelf" / "song.md").exists()


def test_a_run_for_which_there_is_no_room_is_told(place: Path, tmp_path: Path, monkeypatch: Any) -> None:
    def full(run: Path, making: Path, **_: Any) -> None:
        making.mkdir()
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr("rrp_sheets.web.views.workbook_list.shutil.copytree", full)
    monkeypatch.setattr("rrp_sheets.services.bundles.add_catalogues", lambda *_: None)
    said = html.unescape(upload(visit(tmp_path), "song.zip", (place / "song.zip").read_bytes()))
    assert "“one” could not be stored" in said and "song.md is uploaded" in said
    assert not list((tmp_path / "runs").iterdir())


def upload(client: FlaskClient, name: str, data: bytes) -> str:
    return post(client, "/shelf/upload", file=(io.BytesIO(data), name)).text
