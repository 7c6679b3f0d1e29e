"""The sonar: how far away the nearest thing before the chest is, found by rays."""

from __future__ import annotations

import math

import pytest

pytest.importorskip("pybullet")

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from rrp_sheets.model.exchange import DeviceUse, SceneAction
from rrp_sheets.robots import load_robot
from rrp_sheets.sim.process import Spec
from rrp_sheets.sim.sensors import FARTHEST, NEAREST, Beam, cone
from rrp_sheets.sim.shapes import Cylinder, Solid, SolidBox, Sphere
from rrp_sheets.sim.world import SimWorld

SIDES = {"left": "Left", "right": "Right", "both": ""}


@pytest.fixture(scope="module")
def world():
    sensors = tuple(DeviceUse(name, name, "Sonar", {"side": side, "rate": 10.0}) for name, side in SIDES.items())
    made = SimWorld(Spec(load_robot(), sensors=sensors))
    made.start()
    yield made
    made.close()


def measured(world: SimWorld, *actions: SceneAction) -> dict[str, float]:
    """Measurements of each side with some things in the room, which are taken away again."""
    us = world.stage.us
    world.act(actions)
    told = dict(world.advance(us + 150_000, ()).events)
    world.act([SceneAction(us, action.thing, "disappear") for action in actions])
    return {name: told[name]["distance"] for name in SIDES}


def ball(y: float, x: float = 0.8, size: float = 0.2) -> SceneAction:
    return SceneAction(0, "Ball", "appear", {"at": (x, y, 0.38), "size": size, "colour": "red"}, kind="ball")


def test_nothing_is_as_far_as_it_reaches(world: SimWorld) -> None:
    assert measured(world) == dict.fromkeys(SIDES, FARTHEST)


def test_each_side_measures_what_is_on_its_side(world: SimWorld) -> None:
    left, right = measured(world, ball(0.55)), measured(world, ball(-0.55))
    assert left["left"] < 1 and left["right"] == FARTHEST and left["both"] == left["left"]
    assert right["right"] < 1 and right["left"] == FARTHEST and right["both"] == right["right"]
    behind = measured(world, ball(0.0, -0.8))
    assert set(behind.values()) == {FARTHEST}


def test_what_is_too_near_or_too_far_is_at_the_limit(world: SimWorld) -> None:
    assert measured(world, ball(0.0, 0.15))["both"] == NEAREST
    assert measured(world, ball(0.0, 3.0))["both"] == FARTHEST


def test_the_distance_is_right_for_every_kind_of_thing(world: SimWorld) -> None:
    things = [
        SceneAction(0, "Wall", "appear", {"at": (1.2, 0.0, 0.0), "size": (2.0, 0.8)}, kind="wall"),
        SceneAction(0, "Box", "appear", {"at": (0.9, 0.2, 0.25), "size": (0.2, 0.2, 0.2)}, kind="box"),
        SceneAction(0, "Cup", "appear", {"at": (0.5, 0.1, 0.33), "size": 0.12, "colour": "red"}, kind="cup"),
        SceneAction(0, "Table", "appear", {"at": (0.7, 0.0, 0.0), "size": (0.7, 0.4, 0.38)}, kind="table"),
        SceneAction(0, "Mia", "appear", {"at": (1.0, 0.1, 0.62)}, kind="person"),
        ball(0.1),
    ]
    for action in things:
        world.act([action])
        eye = Beam(world.body, load_robot().data["sonar"]["left"]).pose().position
        true = min(s.distance(eye) for s in world.stage.solids())
        world.act([SceneAction(world.stage.us, action.thing, "disappear")])
        assert measured(world, action)["both"] == pytest.approx(true, abs=0.06), action.thing


def test_rays_fill_the_cone() -> None:
    rays = cone(math.radians(60))
    assert np.allclose(np.linalg.norm(rays, axis=1), 1) and np.degrees(np.arccos(rays[:, 0])).max() == pytest.approx(30)
    gaps = np.degrees(np.arccos(np.clip(rays @ rays.T - 2 * np.eye(len(rays)), -1, 1))).min(axis=1)
    assert gaps.max() < 2.7


spots = st.tuples(*(st.floats(-2, 2) for _ in range(3)))


@given(spots, st.floats(0.05, 0.5), st.floats(0.05, 1), st.floats(-3, 3))
def test_a_ray_never_goes_farther_than_the_shape_nor_stops_before_it(
    at: tuple[float, float, float], radius: float, size: float, turned: float
) -> None:
    rays, origin = cone(math.radians(60)), (0.0, 0.0, 0.0)
    solids: list[Solid] = [
        Sphere("a", at, radius), Cylinder("b", at, radius, size), SolidBox("c", at, (radius, size, 2 * radius), turned),
    ]  # fmt: skip
    for solid in solids:
        hits = solid.hits(origin, rays)
        far = hits[np.isfinite(hits)]
        assert (far >= solid.distance(origin) - 1e-6).all()
        for distance, ray in zip(hits, rays, strict=True):
            if np.isfinite(distance):
                assert solid.distance(tuple(ray * (distance + 1e-6))) < 1e-4
