"""How fast the simulated robot goes beside real time, and how well its camera finds a ball.

Measured: the engine's door (`SimulatedWorld`) with the simulator's process, both pinned to one core, 240 Hz physics, the
head camera at 320×240; with film also the three pictures a second from outside. Not measured: starting and stopping
(the film is written then), the behaviour's rows and their trace (`bench_engine.py`), speech, an idle second core; the
ball's figures are of rendered pictures without noise, blur or a real camera's colours, and of a head that keeps still.
"""

from __future__ import annotations

import math
import os
import statistics
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest

from rrp_sheets.devices import load_robot
from rrp_sheets.drivers.simulated import SimulatedWorld
from rrp_sheets.model.exchange import Command, DeviceUse
from rrp_sheets.model.scene import SceneAction
from rrp_sheets.sim.messages import Spec
from rrp_sheets.sim.world import PICTURE, SimWorld

SECONDS, RATE = 20, 30
LIMIT = 4.0  # times real time
FOUND, ANGLE_LIMIT, DISTANCE_LIMIT = 0.99, 0.4, 2.0  # of the balls; degrees; % nearer than 2 m
BALL = DeviceUse("ball", "Red ball", "RedBall", {"rate": 10})
FACE = DeviceUse("face", "Face", "FaceDetection", {"rate": 2})
BALL_SCENE = (
    SceneAction(0, "Red ball", "appear", {"at": (0.8, 0.0, 0.4), "size": 0.06, "colour": "red"}),
    SceneAction(1_000_000, "Red ball", "circle", {"radius": 0.3, "period": 4.0}),
)
AROUND_SCENE = (
    BALL_SCENE[0],
    SceneAction(1_000_000, "Red ball", "circle", {"radius": 0.8, "period": 20.0, "around": (0, 0, 0.4), "flat": True}),
)
PERSON_SCENE = (SceneAction(0, "Person", "seen", {"id": 1, "name": "", "seconds": 60.0}),)
CASES = {
    "head tracking, ball circles before it": (BALL, "Head", BALL_SCENE),
    "whole-body tracking, ball circles before it": (BALL, "Whole body", BALL_SCENE),
    "whole-body tracking, ball goes all around": (BALL, "Whole body", AROUND_SCENE),
    "head tracking of a face, faces at 2 Hz": (FACE, "Head", PERSON_SCENE),
}


@contextmanager
def one_core() -> Iterator[str]:
    """Pin this process, and thereby the simulator's, to one core; says what was done."""
    if not hasattr(os, "sched_setaffinity"):  # a Mac
        yield "not pinned"
        return
    before = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {max(before)})
    try:
        yield "one core"
    finally:
        os.sched_setaffinity(0, before)


def ratio(sensor: DeviceUse, mode: str, scene: tuple[SceneAction, ...], film: bool) -> float:
    """Simulated seconds per second, the start and the stop not counted."""
    tracker = DeviceUse("tracker", "Tracker", "Tracker", {"mode": mode, "effector": "None"})
    with TemporaryDirectory() as folder:
        world = SimulatedWorld(load_robot(), (sensor,), (tracker,), scene, out=Path(folder), film=film)
        try:
            arrivals = world.start()
            before = time.perf_counter()
            for frame in range(1, SECONDS * RATE + 1):
                orders = [Command("tracker", True, "Bench!1", (sensor.stream,)) for _ in arrivals.events]
                arrivals = world.advance(frame * 1_000_000 // RATE, orders)
            passed = time.perf_counter() - before
        finally:
            world.stop()
    return SECONDS / passed


@pytest.mark.parametrize("case", CASES)
def test_faster_than_real_time(case: str) -> None:
    with one_core() as where:
        bare, filmed = (ratio(*CASES[case], film=film) for film in (False, True))
    size = "×".join(map(str, PICTURE))
    print(f"\n{case} ({size}, {where}): {bare:.1f}× real time, {filmed:.1f}× with film (limit {LIMIT:g}×)")
    assert bare >= LIMIT


def test_a_ball_is_found_where_it_is() -> None:
    """The truth is where the simulator has put the ball, which the camera's image processing does not know."""
    world = SimWorld(Spec(load_robot()))
    camera = world.body.camera()
    angles, near, far = [], [], []
    chance = np.random.default_rng(7)
    count = 300
    for us in range(1, count + 1):
        distance, across, down = chance.uniform(0.3, 4.0), *chance.uniform(-0.9, 0.9, 2)
        ray = np.array([1.0, across * math.tan(world.body.hfov / 2), -down * math.tan(world.body.vfov / 2)])
        ray *= distance / np.linalg.norm(ray)
        place = tuple(camera.position + camera.rotation @ ray)
        values = {"at": place, "size": 0.06, "colour": ("red", "green", "blue")[us % 3]}
        world.stage.plan([SceneAction(us, "Ball", "appear", values)])
        world.stage.go_on(us)
        found = world.sight.detector().any_ball()
        if found is not None:
            spot = found[1]
            off = math.hypot(spot.x - math.atan2(ray[1], ray[0]), spot.y - math.atan2(-ray[2], ray[0]))
            angles.append(math.degrees(off))
            (near if distance < 2 else far).append(100 * abs(spot.distance / distance - 1))
    world.close()
    worst_angle, typical = max(angles), statistics.mean(angles)
    print(
        f"\nball of 6 cm, 0.3 to 4 m, anywhere in the picture: found {len(angles)} of {count} (limit {FOUND:.0%}); "
        f"angle off {typical:.2f}° in the mean, {worst_angle:.2f}° at worst (limit {ANGLE_LIMIT}°); "
        f"distance off {statistics.mean(near):.1f} % in the mean below 2 m (limit {DISTANCE_LIMIT:g} %), "
        f"{max(near):.1f} % at worst, {statistics.mean(far):.1f} % in the mean beyond"
    )
    assert len(angles) >= FOUND * count
    assert worst_angle <= ANGLE_LIMIT
    assert statistics.mean(near) <= DISTANCE_LIMIT
