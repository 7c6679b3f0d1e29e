"""Accuracy of the sonar, over many places of each kind of thing, and its cost in a full room.

The truth is the distance of the nearest point of the thing in the beam's cone, worked out from its shape with many
times as many rays; the sensor's own rays do not know it. Not measured: what real echoes do at slanting walls and soft clothes.
"""

from __future__ import annotations

import math
import statistics
import time

import numpy as np
import pytest

from rrp_sheets.model.exchange import SceneAction
from rrp_sheets.robots import load_robot
from rrp_sheets.sim.process import Spec
from rrp_sheets.sim.sensors import APART, FARTHEST, NEAREST, Beam
from rrp_sheets.sim.world import SimWorld

COUNT = 150  # places of each kind
FOUND = {"ball": 0.97, "cup": 0.97, "box": 0.99, "wall": 0.99, "person": 0.99}  # within 1 m
ERROR = 0.02  # m, the mean of what was found


def fine(beam: Beam, opening: float, finer: int = 4) -> np.ndarray:
    """Rays of a beam (its opening in rad) that lie closer than the sensor's own."""
    rings = round(opening / 2 / APART) * finer
    rays = [(1.0, 0.0, 0.0)]
    for ring in range(1, rings + 1):
        off = opening / 2 * ring / rings
        for k in range(6 * ring):
            turn = 2 * math.pi * (k + 0.5 * (ring % 2)) / (6 * ring)
            rays.append((math.cos(off), math.sin(off) * math.cos(turn), math.sin(off) * math.sin(turn)))
    return np.array(rays) @ beam.pose().rotation.T


def thing(kind: str, x: float, y: float, z: float) -> SceneAction:
    values = {
        "ball": {"at": (x, y, z), "size": 0.06, "colour": "red"},
        "cup": {"at": (x, y, z - 0.05), "size": 0.09, "colour": "red"},
        "box": {"at": (x, y, max(z - 0.1, 0.0)), "size": (0.2, 0.2, 0.2), "turned": 0.3},
        "wall": {"at": (x, y, 0.0), "size": (1.0, 0.8), "turned": 0.2},
        "person": {"at": (x, y, 0.62)},
    }[kind]
    return SceneAction(0, "It", "appear", values, kind=kind)


@pytest.mark.parametrize("kind", FOUND)
def test_the_sonar_measures_what_is_there(kind: str) -> None:
    world = SimWorld(Spec(load_robot()))
    left = load_robot().data["sonar"]["left"]
    beam = Beam(world.body, left)
    pose, rays, chance = beam.pose(), fine(beam, math.radians(left["cone"])), np.random.default_rng(11)
    near, far, missed, there = [], [], 0, 0
    for _ in range(COUNT):
        distance, across, up = chance.uniform(0.3, 2.2), *np.radians(chance.uniform(-24, 24, 2))
        ray = np.array([1.0, math.tan(across), math.tan(up) if kind in ("ball", "cup") else 0.0])
        place = pose.position + pose.rotation @ (ray * distance / np.linalg.norm(ray))
        world.act([thing(kind, *(float(c) for c in place))])
        true = min(float(s.hits(pose.position, rays).min()) for s in world.stage.solids())
        told = beam.measure(world.stage)
        if true >= FARTHEST:
            continue
        found = told < FARTHEST
        (near if true < 1 else far).append(abs(told - max(true, NEAREST)) if found else math.inf)
        there += true < 1
        missed += true < 1 and not found
    world.close()

    def words(errors: list[float]) -> str:
        seen = [e for e in errors if math.isfinite(e)]
        rate = f"{len(seen)}/{len(errors)} found"
        return (
            f"{rate}, error mean {1000 * statistics.mean(seen):.1f} mm, largest {1000 * max(seen):.0f} mm"
            if seen
            else rate
        )

    print(f"\nsonar, {kind}: nearer than 1 m {words(near)}; to 2.2 m {words(far)}")
    assert 1 - missed / there >= FOUND[kind]
    assert statistics.mean(e for e in near if math.isfinite(e)) <= ERROR


def test_what_the_sonar_costs_in_a_full_room() -> None:
    world = SimWorld(Spec(load_robot()))
    beam = Beam(world.body, load_robot().data["sonar"]["right"])
    costs = []
    for count in (1, 10, 50):
        balls = ({"at": (0.5 + 0.03 * n, 0.0, 0.4), "size": 0.06, "colour": "red"} for n in range(count))
        world.act([SceneAction(0, f"Ball {n}", "appear", values, kind="ball") for n, values in enumerate(balls)])
        began = time.process_time()
        for _ in range(50):
            beam.measure(world.stage)
        costs.append(f"{count} things {1000 * (time.process_time() - began) / 50:.2f} ms")
    world.close()
    print(f"\nsonar, one measurement of one side: {', '.join(costs)}")
