"""Files recorded beside a trace; and traces, poses and pictures from unknown sources."""

from __future__ import annotations

import base64
import json
import zipfile
from pathlib import Path

import numpy as np
import pytest
from motion import RED
from PIL import Image
from test_lookback import BOOK, ask

from rrp_sheets import api
from rrp_sheets.errors import SheetsError, UnreadableFile
from rrp_sheets.model.exchange import DeviceUse, SceneAction
from rrp_sheets.recording.lookback import PIECE_EVENTS, Index, answer
from rrp_sheets.robots import load_robot
from rrp_sheets.sim import recording
from rrp_sheets.sim.film import FilmFile, write_strip
from rrp_sheets.sim.process import Spec
from rrp_sheets.sim.recording import Pictures
from rrp_sheets.sim.world import SimWorld
from rrp_sheets.workbook.files import make_workbook


def test_what_came_at_one_instant_is_in_one_piece_and_every_piece_knows_what_was_before(tmp_path: Path) -> None:
    lines = [
        {"type": "header", "streams": [{"stream": "S", "kind": "sensor"}]},
        {"t": 0, "stream": "S", "row": "", "value": -1},
    ]
    lines += [
        {"t": 1 + k // 3, "stream": f'T!a"{k % 2}', "row": f"T!{k % 2}", "value": k} for k in range(2 * PIECE_EVENTS)
    ]
    (tmp_path / "trace.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))
    index = Index(tmp_path)
    assert index.count == 2 * PIECE_EVENTS + 1 and len(index.starts) > 100  # 20 s each
    for number in range(len(index.starts)):
        numbers, before = index.piece(number)
        assert before[0] == (0 if number else -1)
        if number:
            assert index.times[numbers[0]] > index.times[numbers[0] - 1]
    last = len(index.starts) - 1
    part = ask(tmp_path, "piece", last)
    assert part["series"]["0"]["t"] == [0.0] and part["words"][part["series"]["0"]["v"][0]] == "-1"
    assert [s[1] for s in ask(tmp_path, "overview")["series"]] == ["S", 'a"0', 'a"1']


def test_edits_and_switches_of_a_run_are_told_with_their_times(tmp_path: Path) -> None:
    edit = {"t": 2.5, "happening": "edit", "text": "a → b", "by": "Aya", "row": "Look!4"}
    lines = [
        {"type": "header", "streams": []},
        {**edit, "detail": {"place": "Look!4", "was": "distance < 1", "now": "distance < 2"}},
        {"t": 3, "happening": "switch", "text": "Look off", "by": "Aya", "detail": {"behaviour": "Look", "on": False}},
        {"t": 4, "happening": "mark", "text": "<script>", "by": "Aya"},
        {"t": 4, "stream": "Ball", "row": "", "value": 1},
        {"t": 5, "stream": "Ball", "row": "", "value": 2, "stimulated": True, "by": "Aya"},
    ]
    (tmp_path / "trace.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))
    overview = ask(tmp_path, "overview")
    assert overview["edits"] == [[2.5, "Look!4", "distance < 1", "distance < 2"]]
    assert overview["switches"] == [[3, "Look", False]] and overview["seconds"] == 5
    assert [m["kind"] for m in overview["moments"]] == ["edit", "switch", "mark", "send"]
    assert ask(tmp_path, "piece") == {"words": ["1", "2"], "series": {"0": {"t": [4, 5], "v": [0, 1]}}}


@pytest.mark.slow
@pytest.mark.parametrize(("text", "kept"), [("kept", True), ("", True), ("Not kept", False)])
def test_the_protocol_says_whether_pictures_are_kept(tmp_path: Path, text: str, kept: bool) -> None:
    sheets = {**BOOK, "Protocol": [*BOOK["Protocol"], ["Camera pictures", text]]}
    assert api.check(make_workbook(sheets, tmp_path / "look.xlsx")).run.keeps_pictures is kept


@pytest.mark.slow
@pytest.mark.parametrize(("sensors", "camera"), [((RED,), False), ((), True)], ids=["forbidden", "no row looks"])
def test_where_no_picture_may_be_kept_the_film_has_none(
    tmp_path: Path, sensors: tuple[DeviceUse, ...], camera: bool
) -> None:
    ball = SceneAction(0, "Red ball", "appear", {"at": (0.8, 0.0, 0.4), "size": 0.06, "colour": "red"})
    world = SimWorld(Spec(load_robot(), sensors, scene=(ball,), film=True, camera=camera))
    world.start()
    film = world._film
    assert film is not None and [shot.inside for shot in film.shots] == [None]
    FilmFile(tmp_path / "film.gif").add(film.shots[0])
    write_strip(tmp_path / "strip.png", film.shots)
    corner = np.asarray(Image.open(tmp_path / "film.gif").convert("RGB"), int)[200:300, 430:540]
    assert corner.std() < 15  # where else the camera's small picture is, with its frame
    world.close()


def test_a_workbook_without_camera_devices_keeps_no_pictures(tmp_path: Path) -> None:
    yaw = DeviceUse("yaw", "Yaw", "JointPosition", {"joint": "HeadYaw", "rate": 10})
    world = SimWorld(Spec(load_robot(), (yaw,), out=str(tmp_path), record=True))
    world.start()
    world.advance(700_000, ())
    assert world._recording is not None
    world._recording.close()
    world.close()
    assert [path.name for path in tmp_path.iterdir()] == ["poses.jsonl"]


def test_a_long_run_keeps_every_other_picture_and_the_zip_is_whole_at_any_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(recording, "MOST_PICTURES", 40)
    pictures = Pictures(tmp_path / "camera.zip", lambda *told: pytest.fail(str(told)))
    step, number = 0, 0
    while step < 400:
        pictures.add(step * 500_000, b"\xff\xd8\xff%d" % step)
        step += pictures.thinning
        number += 1
        if number % 20 == 0:
            with zipfile.ZipFile(tmp_path / "camera.zip") as archive:
                assert archive.testzip() is None and len(archive.namelist()) <= 40
    pictures.write()
    (tmp_path / "trace.jsonl").write_text('{"type":"header","streams":[]}\n')
    times = ask(tmp_path, "overview")["pictures"]
    assert 20 <= len(times) <= 40 and times[0] == 0 and times[-1] > 180 and pictures.thinning == 16
    assert base64.b64decode(answer(tmp_path, "picture", 1)) == b"\xff\xd8\xff%d" % round(2 * times[1])


def test_a_disk_that_is_full_leaves_no_half_zip_and_breaks_nothing(tmp_path: Path) -> None:
    told: list[str] = []
    pictures = Pictures(tmp_path / "gone" / "camera.zip", lambda what, error: told.append(f"{what}: {error}"))
    for number in range(50):
        pictures.add(number * 500_000, b"\xff\xd8\xff")
    pictures.write()
    assert list(tmp_path.iterdir()) == []
    assert len(told) == 1 and "No such file" in told[0]


@pytest.mark.parametrize(
    "line",
    [
        "nonsense", "[]", '{"t":"x"}', '{"t":1e999}', '{"t":1,"joints":[1],"things":{"a":[1,2]},"looks":{"b":7},"eyes":"red"}',
        '{"t":1,"full":true,"joints":{"HeadYaw":"far"},"base":[1,2,3],"light":null,"saying":7}', "[" * 5000,
    ],
)  # fmt: skip
def test_poses_of_strangers_are_not_believed(tmp_path: Path, line: str) -> None:
    (tmp_path / "trace.jsonl").write_text('{"type":"header","streams":[]}\n')
    good = '{"t":0,"full":true,"joints":{"HeadYaw":0.5}}\n'
    (tmp_path / "poses.jsonl").write_text(f"{good}{line}\n{good[:20]}")
    told = ask(tmp_path, "poses")
    assert told[0] == {"t": 0.0, "full": True, "joints": {"HeadYaw": 0.5}}
    assert all(set(pose) <= {"t", "full"} for pose in told[1:])
    with pytest.raises(SheetsError):
        answer(tmp_path, "poses", 1)


def test_a_zip_of_strangers_gives_only_small_jpegs_of_our_names(tmp_path: Path) -> None:
    (tmp_path / "trace.jsonl").write_text('{"type":"header","streams":[]}\n')
    with zipfile.ZipFile(tmp_path / "camera.zip", "w") as archive:
        archive.writestr("../00001.000.jpg", b"\xff\xd8\xffout")
        archive.writestr("00002.000.jpg", b"<svg onload=alert(1)>")
        archive.writestr("00003.000.jpg", b"\xff\xd8\xff" + bytes(2_000_000))
        archive.writestr(zipfile.ZipInfo("00004.000.jpg"), b"\xff\xd8\xff" + bytes(9000), zipfile.ZIP_DEFLATED)
        archive.writestr("00005.000.jpg", b"\xff\xd8\xffgood")
    assert ask(tmp_path, "overview")["pictures"] == [2.0, 5.0]
    assert answer(tmp_path, "picture", 0) == "" == answer(tmp_path, "picture", 7)
    assert base64.b64decode(answer(tmp_path, "picture", 1)) == b"\xff\xd8\xffgood"
    (tmp_path / "camera.zip").write_bytes((tmp_path / "camera.zip").read_bytes()[:-30])
    assert ask(tmp_path, "overview")["pictures"] == [] and answer(tmp_path, "picture") == ""


@pytest.mark.parametrize(
    "text", ["", "no json\n", '{"type":"header"}\n{"t":-1,"stream":"a","row":"","value":1}\n', "[1]\n"]
)
def test_a_trace_that_is_none_says_so(tmp_path: Path, text: str) -> None:
    (tmp_path / "trace.jsonl").write_text(text)
    if not text:
        assert ask(tmp_path, "overview")["count"] == 0
        return
    with pytest.raises(UnreadableFile, match="is not the recording of a run"):
        answer(tmp_path, "overview")


def test_a_film_is_whole_after_each_picture_and_when_pictures_are_dropped(tmp_path):
    from rrp_sheets.sim.camera import Shot

    colours = [(200, 200, 200), (200, 40, 40), (40, 40, 200), (40, 160, 40)]

    def shot(n):
        outside = np.full((320, 560, 3), 120, np.uint8)
        outside[100 : 120 + 10 * n, 200:260] = colours[n % 4]
        return Shot(n * 333_333, outside, None, "", (1, 0, 0), f"moment {n}", 0.0)

    def pictures():
        with Image.open(tmp_path / "f.gif") as film:
            for n in range(film.n_frames):
                film.seek(n)
                yield np.asarray(film.convert("RGB"), int)

    film = FilmFile(tmp_path / "f.gif")
    shots = [shot(n) for n in range(8)]
    for n, one in enumerate(shots):
        film.add(one)
        assert len(list(pictures())) == n + 1
    for kept in (shots, shots[::2]):
        if kept is not shots:
            film.keep(kept)
        for one, shown in zip(kept, pictures(), strict=True):
            assert np.abs(shown[:320] - one.outside).max() <= 24
    film.add(shot(9))
    assert len(list(pictures())) == 5 and [p.name for p in tmp_path.iterdir()] == ["f.gif"]
