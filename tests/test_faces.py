"""The face sensor perceives: it finds, follows and recognises what the head camera shows."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import pytest

pytest.importorskip("pybullet")
pytest.importorskip("cv2")
from portraits import FACE, Studio

from rrp_sheets.model.exchange import Command, DeviceUse, SceneAction
from rrp_sheets.perception.face_memory import FACE_REMEMBERED
from rrp_sheets.perception.faces import SAME, Faces
from rrp_sheets.robots import load_robot
from rrp_sheets.sim.process import Spec
from rrp_sheets.sim.world import SimWorld

SECOND = 1_000_000
REMEMBER = DeviceUse("remember", "Remember face", "RememberFace", {"name": ""})
TRACK = DeviceUse("tracker", "Head tracker", "Tracker", {"mode": "Head", "effector": "None"})


def enters(seconds: float, who: str, /, *at: float, **values: Any) -> SceneAction:
    return SceneAction(round(seconds * SECOND), who, "appear", {"at": (*at, 0.62), **values}, kind="person")


def leaves(seconds: float, name: str) -> SceneAction:
    return SceneAction(round(seconds * SECOND), name, "disappear", kind="person")


class Run:
    """A world in this process that goes on by half seconds: each is one picture for faces."""

    def __init__(self, *scene: SceneAction, sensors: Sequence[DeviceUse] = (FACE,), film: bool = False) -> None:
        self.world = SimWorld(Spec(load_robot(), tuple(sensors), (REMEMBER, TRACK), scene, film=film))
        self.us = 0
        self.notes: list[str] = []
        self.faces = self._took(self.world.start())

    def go(self, seconds: float, *orders: Command) -> list[list[dict[str, Any]]]:
        """Go on; the faces of each picture."""
        pictures = []
        for _ in range(round(seconds * 2)):
            self.us += SECOND // 2
            self.faces = self._took(self.world.advance(self.us, orders))
            orders = ()
            pictures.append(self.faces)
        return pictures

    def remember(self, value: Any = True) -> str:
        """Let the robot remember a face, and what it says to that."""
        self.go(0.5, Command("remember", value, "A!2"))
        return self.notes[-1] if self.notes else ""

    def _took(self, outcome: Any) -> list[dict[str, Any]]:
        self.notes += [n.text for n in outcome.notices]
        return [v for s, v in outcome.events if s == "face"]


@pytest.fixture(scope="module")
def studio() -> Iterator[Studio]:
    made = Studio()
    yield made
    made.world.close()


@pytest.mark.slow
@pytest.mark.parametrize("afar", [(1, 5, 9), pytest.param((1, 3, 5, 7, 9), marks=pytest.mark.soak)])
def test_drawn_and_photographed_people_are_found_and_told_apart(studio: Studio, afar: tuple[int, ...]) -> None:
    assert len(studio.names) == 10
    for far, person in [(1.0, n) for n in range(10)] + [(2.0, n) for n in afar]:
        numbers = studio.numbers(studio.picture(person, far, aside=8.0))
        assert numbers is not None, f"{studio.names[person]} is not found at {far} m"
        own, other = studio.alike(numbers, person)
        assert own >= SAME > other + 0.03, f"{studio.names[person]} at {far} m"
    found = [bool(studio.models.find(studio.picture(person, 3.0))) for person in range(0, 10, 2)]
    assert sum(found) >= 4


@pytest.mark.slow
def test_light_and_how_far_a_face_is_turned_matter(studio: Studio) -> None:
    for person in (1, 3, 8):
        dim = studio.numbers(studio.picture(person, 1.2, light=0.4))
        assert dim is not None and studio.alike(dim, person)[0] >= SAME
        assert studio.numbers(studio.picture(person, 1.2, light=0.02)) is None
        assert studio.numbers(studio.picture(person, 1.2, turned=30)) is not None
        assert studio.numbers(studio.picture(person, 1.2, turned=150)) is None
    assert studio.models.find(studio.picture(None, 1.0)) == []


@pytest.mark.slow
def test_somebody_new_is_remembered_and_known_again_among_others() -> None:
    run = Run(enters(0, "Mia", 1.1, 0.15), enters(0.9, "Emma", 1.2, -0.3, name="Emma"), leaves(2.6, "Mia"),
              enters(3.4, "Ken", 1.3, 0.3), enters(4.4, "Mia", 1.6, 0.0))  # fmt: skip
    first = run.faces
    assert [(f["id"], f["name"], f["new"], f["recognised"]) for f in first] == [(1, "", True, False)]
    assert not first[0]["recognized_new_face"], "one picture is not enough"
    both = run.go(1.0)[-1]
    assert [f["recognized_new_face"] for f in both] == [True, False]
    assert [(f["name"], f["new"], f["recognised"]) for f in both] == [("", True, False), ("Emma", False, True)]
    emma = both[1]["id"]
    assert run.remember(3) == "The face is remembered as Guest 1."
    assert [(f["id"], f["name"], f["new"]) for f in run.faces] == [(1, "Guest 1", False), (emma, "Emma", False)]
    gone = run.go(2.0)[2]
    assert [f["name"] for f in gone] == ["Emma"]
    ken = run.faces[-1]
    assert (ken["new"], ken["name"]) == (True, "") and ken["id"] not in (1, emma)
    again = run.go(1.0)[-1]
    assert [(f["id"], f["name"]) for f in again] == [(1, "Guest 1"), (emma, "Emma"), (ken["id"], "")]
    assert run.world.faces.see() == run.world.faces.see(), "looking twice at one picture tells the same"
    run.world.close()


@pytest.mark.slow
def test_where_a_face_is_told_and_followed() -> None:
    run = Run(enters(0, "Mia", 1.0, 0.35))
    face = run.faces[0]
    camera = run.world.body.camera()
    ahead, left, up = camera.rotation.T @ ([1.0, 0.35, 0.62] - camera.position)
    assert face["x"] == pytest.approx(left / ahead, abs=0.05)
    assert face["y"] == pytest.approx(-up / ahead, abs=0.07), "the middle of what is found is a little lower"
    assert 0.10 < face["width"] < 0.20 and 0.14 < face["height"] < 0.26 and 0.8 < face["score"] <= 1
    for _ in range(4):
        run.go(0.5, Command("tracker", True, "A!3", ("face",)))
    assert abs(run.faces[0]["x"]) < 0.03 and abs(run.faces[0]["y"]) < 0.03
    assert run.world.body.position("HeadYaw") > 0.25
    run.world.close()


@pytest.mark.slow
def test_another_person_in_the_same_place_is_another() -> None:
    run = Run(enters(0, "Mia", 1.0, 0.0, name="Mia"), leaves(0.7, "Mia"), enters(0.7, "Ken", 1.05, 0.12))
    before = run.go(0.5)[-1][0]
    after = run.go(1.0)[-1][0]
    assert before["recognised"] and not after["recognised"] and after["new"]
    assert before["id"] != after["id"]
    run.world.close()


def test_a_face_that_is_seen_badly_is_neither_new_nor_known_until_it_comes_near() -> None:
    run = Run(enters(0, "Mia", 3.4, 0.0))
    far = run.go(1.0)[-1]
    assert [(f["new"], f["recognised"], f["recognized_new_face"]) for f in far] == [(False, False, False)]
    assert run.remember() == "The face is not seen well enough to be remembered."
    number = far[0]["id"]
    run.world.act((SceneAction(run.us, "Mia", "move", {"to": (1.2, 0.0), "seconds": 1.0}, kind="person"),))
    near = run.go(2.0)[-1]
    assert [(f["id"], f["new"], f["recognized_new_face"]) for f in near] == [(number, True, True)]
    run.world.close()


@pytest.mark.slow
def test_what_hides_a_face_hides_it() -> None:
    ball = SceneAction(SECOND, "Blue ball", "appear", {"at": (0.8, 0.0, 0.62), "size": 0.4, "colour": "blue"})
    run = Run(enters(0, "Mia", 1.3, 0.0), ball)
    assert run.go(0.5)[-1] and not run.go(1.0)[-1]
    run.world.close()


def test_why_a_face_is_not_remembered_is_told() -> None:
    run = Run(enters(1.4, "Mia", 1.0, 0.0))
    assert run.remember() == "No face to remember is in view."
    run.go(1.5)
    assert run.remember("Anna") == FACE_REMEMBERED.format(name="Anna")
    assert run.remember("Anna") == "The face is remembered already, as Anna."
    run.world.close()


@pytest.mark.slow
def test_without_a_face_sensor_no_network_is_loaded(monkeypatch: pytest.MonkeyPatch) -> None:
    def never() -> None:
        raise AssertionError("a network was loaded")

    monkeypatch.setattr("rrp_sheets.sim.world.FaceModels", never)
    ball = DeviceUse("redball", "Red ball", "RedBall", {"rate": 10})
    world = SimWorld(Spec(load_robot(), (ball,), (TRACK,), (enters(0, "Emma", 1.0, 0.0, name="Emma"),)))
    world.start()
    world.advance(SECOND, ())
    world.close()


@pytest.mark.slow
def test_the_same_run_tells_the_same() -> None:
    scene = (enters(0, "Mia", 1.1, 0.2), enters(0, "Child", 1.4, -0.3, name="Ben"),
             SceneAction(SECOND // 3, "Mia", "move", {"to": (1.2, 0.5), "seconds": 1.0}, kind="person"))  # fmt: skip
    told = []
    for _ in range(2):
        run = Run(*scene)
        told.append(repr([run.faces, *run.go(1.0)]))
        run.world.close()
    assert told[0] == told[1] and "Ben" in told[0]


def test_the_sensor_has_no_way_to_the_scene() -> None:
    assert not {"stage", "bullet", "scene"} & set(Faces.__dataclass_fields__)
    face = load_robot().devices["facedetection"]
    assert not face.knowledge and "simulator" not in face.help
