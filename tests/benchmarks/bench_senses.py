"""Accuracy of finding balls and faces and of recognising faces, and the speed of the simulation meanwhile.

Measured: pictures rendered from the head camera of a robot that stands still; balls of 6 cm at 320×240, faces at 640×480,
eight drawn and two photographed ones, by YuNet and SFace with the thresholds of `perception/faces.py`. The truth is where the
simulator has put the thing, which image processing does not know. Everybody is known from a portrait, as somebody whom
the Scene sheet names; recognised means: more alike than the threshold, and the right one.

Not measured: a real camera's noise, blur and colours, real light, expressions, hair or glasses that change, more people
than these ten, faces of one family, other ball sizes, a head that moves while the picture is taken. Two photographs are
of two people: they show that photographs work, not how often.
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Iterator, Sequence

import numpy as np
import pytest
from onecore import go, one_core
from portraits import FACE, Studio

from rrp_sheets.model.exchange import SceneAction
from rrp_sheets.perception.faces import SAME
from rrp_sheets.robots import load_robot
from rrp_sheets.sim.people import FACES
from rrp_sheets.sim.process import Spec
from rrp_sheets.sim.world import SimWorld

DISTANCES = (0.6, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5)
ASIDE = (-12.0, 12.0)  # degrees from the picture's middle
TURNS = (0.0, 15.0, 30.0, 45.0, 60.0)
LIGHTS = (1.0, 0.6, 0.4, 0.2, 0.1, 0.05)
FASTER, MEGABYTES = 2.0, 600.0  # limits
COLOURS = ("red", "green", "blue")


@pytest.fixture(scope="module")
def studio() -> Iterator[Studio]:
    made = Studio()
    yield made
    made.world.close()


def test_balls() -> None:
    world = SimWorld(Spec(load_robot()))
    camera = world.body.camera()
    chance = np.random.default_rng(7)
    us = 0
    every: list[float] = []
    print("\nballs of 6 cm anywhere in the picture (320×240): found, angle off (mean, worst), distance off (mean, sd)")
    for far in (0.3, 0.5, 1.0, 2.0, 3.0, 4.0, 5.0):
        angles, distances, count = [], [], 36
        for n in range(count):
            us += 1
            across, down = chance.uniform(-0.85, 0.85, 2)
            ray = np.array([1.0, across * math.tan(world.body.hfov / 2), -down * math.tan(world.body.vfov / 2)])
            ray *= far / np.linalg.norm(ray)
            values = {"at": tuple(camera.position + camera.rotation @ ray), "size": 0.06, "colour": COLOURS[n % 3]}
            world.stage.plan([SceneAction(us, "Ball", "appear", values)])
            world.stage.go_on(us)
            found = world.sight.detector().any_ball()
            if found is not None and found[0] == COLOURS[n % 3]:
                spot = found[1]
                off = math.hypot(spot.x - math.atan2(ray[1], ray[0]), spot.y - math.atan2(-ray[2], ray[0]))
                angles.append(math.degrees(off))
                distances.append(100 * (spot.distance / far - 1))
        print(
            f"  {far:3.1f} m: {len(angles)}/{count}, {statistics.mean(angles):.2f}° {max(angles):.2f}°, "
            f"{statistics.mean(map(abs, distances)):.1f} % {statistics.stdev(distances):.1f} %"
        )
        assert len(angles) >= 0.97 * count
        every += angles
        assert statistics.mean(angles) <= 0.25
        assert statistics.mean(map(abs, distances)) <= (2.0 if far <= 2 else 6.0)
    world.close()
    assert statistics.mean(every) <= 0.15


def tried(studio: Studio, who: Sequence[int], **how: float) -> tuple[int, int, int, float, float]:
    """Pictures, faces found, recognised, and the least alike with oneself, the most with another."""
    pictures = found = right = 0
    least, most = 1.0, -1.0
    for person in who:
        for aside in ASIDE:
            numbers = studio.numbers(studio.picture(person, aside=aside, **how))
            pictures += 1
            if numbers is None:
                continue
            found += 1
            own, other = studio.alike(numbers, person)
            right += own >= SAME and own > other
            least, most = min(least, own), max(most, other)
    return pictures, found, right, least, most


def told(studio: Studio, words: str, **how: float) -> list[tuple[int, int, int, float, float]]:
    """Print and give how drawn and photographed faces fared."""
    kinds = (("drawn", range(FACES)), ("photographed", range(FACES, len(studio.names))))
    results = [tried(studio, who, **how) for _, who in kinds]
    parts = [
        f"{kind} found {found}/{pictures}, recognised {right}, alike to oneself ≥ {least:.2f}, to others ≤ {most:.2f}"
        for (kind, _), (pictures, found, right, least, most) in zip(kinds, results, strict=True)
    ]
    print(f"  {words}: {'; '.join(parts)}")
    return results


def test_faces_by_distance(studio: Studio) -> None:
    print(f"\nfaces by distance (640×480; the same person from {SAME} on)")
    for far in DISTANCES:
        for pictures, found, right, _, most in told(studio, f"{far:.1f} m", far=far):
            assert most < SAME, "nobody is taken for somebody else"
            if far <= 2:
                assert found == pictures and right == pictures
            elif far <= 3:
                assert found >= 0.8 * pictures and right >= 0.8 * found


def test_faces_turned_aside(studio: Studio) -> None:
    print("\nfaces turned aside, from 1.2 m")
    for turn in TURNS:
        for pictures, found, right, _, most in told(studio, f"{turn:.0f}°", far=1.2, turned=turn):
            assert most < SAME
            if turn <= 30:
                assert found == pictures and right >= 0.9 * pictures


def test_faces_in_the_dark(studio: Studio) -> None:
    print("\nfaces by the light of the room, from 1.2 m")
    for light in LIGHTS:
        for pictures, found, right, _, most in told(studio, f"{light:.0%}", far=1.2, light=light):
            assert most < SAME
            if light >= 0.4:
                assert found == pictures and right == pictures


def test_no_face_is_seen_where_none_is(studio: Studio) -> None:
    seen = sum(bool(studio.models.find(studio.picture(None, 1, light=light))) for light in LIGHTS)
    backs = sum(
        bool(studio.models.find(studio.picture(person, far, turned=180))) for person in range(FACES) for far in (1, 2)
    )
    print(
        f"\nfaces found in an empty room: {seen} of {len(LIGHTS)} pictures; on the backs of heads: {backs} of {2 * FACES}"
    )
    assert not seen and not backs


def test_speed_and_memory() -> None:
    stands = (SceneAction(0, "Mia", "appear", {"at": (1.1, 0.2, 0.62)}),)
    walks = (*stands, SceneAction(2_000_000, "Mia", "move", {"to": (1.2, -0.5), "seconds": 8.0}),
             SceneAction(0, "Ken", "appear", {"at": (1.6, -0.3, 0.62)}))  # fmt: skip
    print()
    with one_core() as where:
        for words, scene, mode in (("one face", stands, "Head"), ("two faces, one walks", walks, "Whole body")):
            bare, filmed = (go(FACE, mode, scene, film) for film in (False, True))
            print(
                f"{mode} tracking, {words}, 640×480 at 2 Hz ({where}): {bare.ratio:.1f}× real time, {filmed.ratio:.1f}× "
                f"with film (limit {FASTER:g}×; by the clock {bare.wall:.1f}×, {filmed.wall:.1f}×), {bare.megabytes:.0f} MB, {filmed.megabytes:.0f} MB with film "
                f"(limit {MEGABYTES:.0f} MB), {bare.events} faces told in 20 s"
            )
            assert bare.ratio >= FASTER
            assert max(bare.megabytes, filmed.megabytes) < MEGABYTES
            assert bare.events >= 36
