"""Detection in the head camera's pictures: balls and spots found in rendered pixels."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import pytest

pytest.importorskip("pybullet")
pytest.importorskip("cv2")
import numpy as np
from play import check, rows

from rrp_sheets.model.exchange import SceneAction
from rrp_sheets.perception.pinhole import Lens
from rrp_sheets.robots import load_robot
from rrp_sheets.sim.camera import AHEAD, photograph
from rrp_sheets.sim.process import Spec
from rrp_sheets.sim.world import SimWorld

SECOND = 1_000_000


def ball(colour: str, at: tuple[float, float, float], time_us: int = 0) -> SceneAction:
    return SceneAction(time_us, f"{colour} ball", "appear", {"at": at, "size": 0.06, "colour": colour})


@pytest.fixture
def world() -> Iterator[SimWorld]:
    made = SimWorld(Spec(load_robot()))
    yield made
    made.close()


PLACES = [(0.4, 0.0, 0.40), (0.6, 0.2, 0.45), (1.0, -0.3, 0.30), (1.5, 0.4, 0.55), (2.5, 0.0, 0.40), (3.0, -0.8, 0.10)]


@pytest.mark.slow
@pytest.mark.parametrize("colour", ["red", "green", "blue"])
def test_a_ball_is_found_where_it_is(world: SimWorld, colour: str) -> None:
    camera = world.body.camera()
    for number, place in enumerate(PLACES, start=1):
        world.stage.plan([ball(colour, place, number)])
        world.stage.go_on(number)
        ahead, left, up = (np.array(place) - camera.position) @ camera.rotation
        found = world.sight.detector().ball(colour)
        assert found is not None, place
        assert found.x == pytest.approx(math.atan2(left, ahead), abs=math.radians(0.4)), place
        assert found.y == pytest.approx(math.atan2(-up, ahead), abs=math.radians(0.4)), place
        distance = math.hypot(ahead, left, up)
        assert found.distance == pytest.approx(distance, rel=0.02 if distance < 2 else 0.08), place
        assert found.width == pytest.approx(2 * math.asin(0.03 / distance), rel=0.08), place


@pytest.mark.slow
@pytest.mark.parametrize("thing", ["Red ball", "Red cup", "Red box"])
@pytest.mark.parametrize("value", ["", *(f"at {x}, {y}, 0.4" for x, y in ((0.6, 0.0), (1.0, -0.3), (2.5, 0.0)))])
def test_things_are_seen_by_their_colour_where_balls_are(world: SimWorld, thing: str, value: str) -> None:
    """Also where they stand when the scene does not say where."""
    book = "| Red ball | subscribe | | Print |"
    scene = f"\n## Scene\n| Time (s) | Thing | Does | Value |\n|---|---|---|---|\n| 0 | {thing} | appears | {value} |\n"
    world.stage.plan(check(rows(book) + scene).scene or ())
    world.stage.go_on(1)
    assert world.sight.detector().spot((1.0, 0.0, 0.0), 20) is not None


def test_other_colours_and_persons_are_no_balls(world: SimWorld) -> None:
    scene = [ball(c, (0.8, 0.3 - 0.15 * k, 0.4)) for k, c in enumerate(("yellow", "purple", "pink", "white", "black"))]
    for k in range(4):  # all clothes
        scene.append(SceneAction(0, f"Person {k}", "appear", {"at": (1.5, -0.6 + 0.4 * k, 0.62)}))
    world.stage.plan(scene)
    world.stage.go_on(1)
    detector = world.sight.detector()
    assert [detector.ball(c) for c in ("red", "green", "blue")] == [None, None, None]


def test_of_two_balls_the_larger_is_told_and_any_ball_says_its_colour(world: SimWorld) -> None:
    world.stage.plan([ball("red", (1.2, 0.2, 0.4)), ball("blue", (0.6, -0.1, 0.4))])
    world.stage.go_on(1)
    any_ball = world.sight.detector().any_ball()
    assert any_ball is not None
    assert any_ball[0] == "blue"
    assert any_ball[1].distance < 0.7


@pytest.mark.parametrize(("colour", "found"), [((1.0, 1.0, 0.0), True), ((1.0, 0.5, 0.0), False), ((0, 0, 1), False)])
def test_a_spot_is_found_by_its_hue(world: SimWorld, colour: tuple[float, float, float], found: bool) -> None:
    world.stage.plan([ball("yellow", (0.8, 0.1, 0.4))])
    world.stage.go_on(1)
    spot = world.sight.detector().spot(colour, 20)
    assert (spot is not None) == found
    if spot is not None:
        assert spot.x > 0.05
        assert 0.0005 < spot.area < 0.05


class Tuples:
    """A physics client whose pictures are tuples, as they are of a PyBullet that was built without NumPy."""

    def __init__(self, bullet: Any) -> None:
        self._b = bullet

    def __getattr__(self, name: str) -> Any:
        return getattr(self._b, name)

    def getCameraImage(self, *arguments: Any, **named: Any) -> tuple[Any, ...]:  # noqa: N802  # its name
        width, height, *planes = self._b.getCameraImage(*arguments, **named)
        return width, height, *(tuple(np.asarray(plane).ravel().tolist()) for plane in planes)


def test_a_picture_is_the_same_from_a_library_built_without_numpy(world: SimWorld) -> None:
    world.stage.plan([ball("red", (0.6, 0.1, 0.45))])
    world.stage.go_on(1)
    world.stage.place()
    lens = Lens(world.body.hfov, world.body.vfov, 320, 240)
    pose = world.body.camera()
    usual, empty = photograph(world._b, pose, lens, AHEAD)
    other, nothing = photograph(Tuples(world._b), pose, lens, AHEAD)
    assert (usual == other).all() and (empty == nothing).all()
    red = (usual[:, :, 0] > 100) & (usual[:, :, 1] < 60)
    assert red.sum() > 100 and not empty[red].any() and empty.any()  # the ball is something, and around it is nothing
