"""Cameras: the robot's head camera, the camera that films the robot, and the pictures that they take.

The physics' renderer draws the bodies; floor and room are painted behind them, which is several times faster.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from rrp_sheets.perception.pinhole import Floats, Lens, Pixels, Pose, Vector

NEAR, FAR = 0.03, 12.0  # m
AHEAD, ASIDE = (-1.5, -0.6, 2.6), (0.1, -1.8, 2.5)
"""Directions of the light: for the robot's own pictures from behind it, so that faces before it are lit; for the
film from its right."""
AMBIENT, DIFFUSE, SPECULAR = 0.68, 0.38, 0.03
RUG = 0.85  # m, radius of the rug that the robot stands on
TILE = 0.5  # m, between the lines on the floor: they help to judge distances
ROOM_FADE = 5.0  # m, over which the floor becomes the wall's colour
ELSEWHERE = tuple(math.radians(a) for a in (62, 75, -95, 95, -35, 35, 130, -130))
"""From where the robot is filmed when it is hidden from the best places, rad."""
CLOSEST = 0.7  # m from the film's camera to anything
SMOOTHING = 1.5  # how much larger the film is drawn
LEAST_LIGHT = 0.35  # of a film in the dark
QUALITY = 80  # of 100, of a picture for a display: 320 × 240 are some 10 kB


def photograph(bullet: Any, pose: Pose, lens: Lens, light: Sequence[float]) -> tuple[Pixels, Pixels]:
    """Render the bodies as seen from `pose`: the picture (height, width, 3), and 1 where there is nothing."""
    ahead = pose.position + pose.rotation[:, 0]
    view = bullet.computeViewMatrix(pose.position.tolist(), ahead.tolist(), pose.rotation[:, 2].tolist())
    aspect = math.tan(lens.hfov / 2) / math.tan(lens.vfov / 2)
    projection = bullet.computeProjectionMatrixFOV(math.degrees(lens.vfov), aspect, NEAR, FAR)
    picture = bullet.getCameraImage(
        lens.width, lens.height, view, projection, shadow=0, lightDirection=light, lightColor=[1, 1, 1],
        lightAmbientCoeff=AMBIENT, lightDiffuseCoeff=DIFFUSE, lightSpecularCoeff=SPECULAR,
        renderer=bullet.ER_TINY_RENDERER, flags=0,
    )  # fmt: skip
    rgba = _colours(picture[2]).reshape(lens.height, lens.width, 4)
    empty = (_bodies(picture[4]).reshape(lens.height, lens.width) < 0).view(np.uint8)
    return np.asarray(cv2.cvtColor(rgba, cv2.COLOR_RGBA2RGB), dtype=np.uint8), empty


def _colours(read: Any) -> Pixels:
    """Return the colour values, which PyBullet gives as an array, or as a tuple when built without NumPy."""
    # `bytearray` is the fastest way from a tuple of ints below 256 to an array: an eighth of the time of `np.asarray`.
    return np.frombuffer(bytearray(read), np.uint8) if isinstance(read, tuple) else np.asarray(read, np.uint8)


def _bodies(read: Any) -> NDArray[np.int32]:
    """Return the number of the body in each pixel, -1 for none."""
    # The depths would tell the same, but a tuple of floats takes five times as long to read.
    if isinstance(read, tuple):
        return np.frombuffer(struct.pack(f"{len(read)}i", *read), np.int32)
    return np.asarray(read, np.int32)


def floor_points(pose: Pose, rays: Floats) -> tuple[Floats, Floats, Floats]:
    """Return where each ray meets the floor: x and y in m, and the distance (infinite above the horizon)."""
    world = rays @ pose.rotation.T.astype(np.float32)
    down = -world[:, :, 2]
    with np.errstate(divide="ignore", invalid="ignore"):
        along = np.where(down > 1e-4, np.float32(pose.position[2]) / down, np.float32(np.inf))
        reach = np.minimum(along, np.float32(1e3))
    x = np.float32(pose.position[0]) + reach * world[:, :, 0]
    y = np.float32(pose.position[1]) + reach * world[:, :, 1]
    return x, y, along


def room(pose: Pose, rays: Floats) -> Floats:
    """Floor and wall behind everything, (height, width, 3), 0 to 255. Pale, so that nothing is taken for a ball."""
    x, y, distance = floor_points(pose, rays)
    pixel = np.float32(rays[0, 0, 1] - rays[0, 1, 1])  # rad, about
    blur = np.minimum(distance, 50) * pixel * 2 + 0.004
    line = np.zeros_like(x)
    for c in (x, y):
        off = np.abs(c / TILE - np.round(c / TILE)) * TILE
        line = np.maximum(line, np.clip(1 - off / blur, 0, 1) * np.float32(0.006) / (blur + np.float32(0.004)))
    floor = np.array([206, 205, 202], np.float32) * (1 - 0.13 * line)[:, :, None]
    radius = np.hypot(x, y)
    inside = np.clip((RUG - radius) / blur + 0.5, 0, 1)
    border = np.clip(1 - np.abs(radius - RUG + 0.06) / (0.012 + blur), 0, 1)
    rug = np.array([176, 194, 204], np.float32) + border[:, :, None] * np.array([50, 38, 32], np.float32)
    floor += inside[:, :, None] * (rug - floor)
    wall = np.array([236, 238, 240], np.float32)
    fade = np.exp(-np.minimum(distance, 50) / np.float32(ROOM_FADE))
    seen = np.where(np.isfinite(distance), fade, 0)[:, :, None]
    painted: Floats = (wall + seen * (floor - wall)).astype(np.float32)
    return painted


class Eye:
    """The robot's head camera."""

    def __init__(self, bullet: Any, lens: Lens) -> None:
        self._b = bullet
        self.lens = lens
        self._rays = lens.rays(2)  # half as fine: the room has no detail

    def look(self, pose: Pose, light: float = 1.0) -> Pixels:
        """The picture from `pose`, (height, width, 3); `light` is how bright the room is, 0 to 1."""
        picture, empty = photograph(self._b, pose, self.lens, AHEAD)
        size = (self.lens.width, self.lens.height)
        behind = cv2.resize(room(pose, self._rays).astype(np.uint8), size, interpolation=cv2.INTER_LINEAR)
        return dimmed(np.asarray(cv2.copyTo(behind, empty, picture), dtype=np.uint8), light)


def dimmed(picture: Pixels, light: float) -> Pixels:
    """The picture with that part of its light, 0 to 1."""
    return picture if light >= 1 else np.asarray(cv2.convertScaleAbs(picture, alpha=max(light, 0.0)), dtype=np.uint8)


def jpeg(picture: Pixels) -> bytes:
    """Return a picture as a JPEG file, for a display."""
    _, data = cv2.imencode(".jpg", cv2.cvtColor(picture, cv2.COLOR_RGB2BGR), [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
    return bytes(data)


@dataclass(frozen=True)
class Shot:
    """One moment of a film."""

    us: int
    outside: Pixels  # the robot from outside
    inside: Pixels | None  # what the robot saw; None when no picture of its camera may be kept
    saying: str
    eyes: tuple[float, float, float]  # the colour of its eyes, 0 to 1
    sees: str  # what it detected, in words
    weight: float  # how much happened: the strip prefers moments where something did
    from_left: bool = False  # filmed from the robot's left, which then is to the right in the picture


class FilmCamera:
    """A camera that stands still and films the robot, smoothed by drawing it larger than it is shown."""

    def __init__(
        self, bullet: Any, points: Sequence[Sequence[float]], azimuths: Sequence[float], size: tuple[int, int],
        hiding: Sequence[tuple[float, float, float]] = (),
    ) -> None:  # fmt: skip
        self._b, self._size = bullet, size
        width, height = size
        vfov = math.radians(30.0)
        hfov = 2 * math.atan(math.tan(vfov / 2) * width / height)
        self.lens = Lens(hfov, vfov, round(width * SMOOTHING), round(height * SMOOTHING))
        corners = np.array(points, dtype=np.float64)

        def best(ways: Sequence[float]) -> tuple[int, float, Pose]:
            """Return the view in which the least hides the robot; of several the nearest, where it is largest."""
            views = [viewpoint(corners, azimuth, self.lens) for azimuth in ways]
            return min(((_hidden(hiding, pose), far, pose) for far, pose in views), key=lambda view: view[:2])

        view = best(azimuths)
        if view[0]:
            view = min(view, best(ELSEWHERE), key=lambda one: one[:2])
        self.pose = view[2]
        self._room = room(self.pose, self.lens.rays()).astype(np.uint8)
        self._x, self._y, _ = floor_points(self.pose, self.lens.rays(6))

    def shoot(self, shadows: Sequence[tuple[float, float, float, float]], light: float = 1.0) -> Pixels:
        """The picture, (height, width, 3); shadows on the floor are (x, y, radius, darkness).

        `light` is how bright the room is, 0 to 1; the film stays visible in the dark.
        """
        picture, empty = photograph(self._b, self.pose, self.lens, ASIDE)
        lit = np.full_like(self._x, 255)
        for x, y, radius, darkness in shadows:
            lit *= 1 - darkness * np.exp(-((self._x - x) ** 2 + (self._y - y) ** 2) / (2 * radius * radius))
        shade = cv2.resize(lit.astype(np.uint8), (self.lens.width, self.lens.height), interpolation=cv2.INTER_LINEAR)
        behind = cv2.multiply(self._room, cv2.cvtColor(shade, cv2.COLOR_GRAY2RGB), scale=1 / 255)
        small = cv2.resize(cv2.copyTo(behind, empty, picture), self._size, interpolation=cv2.INTER_AREA)
        return dimmed(np.asarray(small, dtype=np.uint8), LEAST_LIGHT + (1 - LEAST_LIGHT) * light)


def _hidden(hiding: Sequence[tuple[float, float, float]], pose: Pose) -> int:
    """Count what (x, y, radius) stands in the line of sight to the origin and to the place 0.5 m ahead of it."""
    count = 0
    for ahead in (0.0, 0.5):
        way = pose.position[:2] - (ahead, 0.0)
        for x, y, radius in hiding:
            along = min(max(float(way @ (x - ahead, y)) / float(way @ way), 0.0), 1.0)
            count += along > 0.0 and math.hypot(x - ahead - along * way[0], y - along * way[1]) < radius
    return count


def viewpoint(points: Vector, azimuth: float, lens: Lens) -> tuple[float, Pose]:
    """Return the distance (infinite when they do not fit) and the pose from which points are as large as can be.

    The camera looks from `azimuth` (rad, 0 is ahead of the robot).
    """
    up, along = math.sin(math.radians(12.0)), math.cos(math.radians(12.0))
    back = np.array([math.cos(azimuth) * along, math.sin(azimuth) * along, up])
    ahead = -back
    left = np.cross([0.0, 0.0, 1.0], ahead)
    left /= np.linalg.norm(left)
    rotation = np.stack([ahead, left, np.cross(ahead, left)], axis=1)
    centre = (points.min(axis=0) + points.max(axis=0)) / 2
    limits = np.array([math.tan(lens.hfov / 2), math.tan(lens.vfov / 2)]) * 0.95  # a margin around
    distance, fits = 1.0, False
    for _ in range(120):  # move the middle and the distance, in small steps, until the points just fit
        seen = (points - (centre + back * distance)) @ rotation
        across = seen[:, 1:] / np.maximum(seen[:, :1], 0.1)
        low, high = across.min(axis=0), across.max(axis=0)
        far_enough = bool(seen[:, 0].min() > CLOSEST)
        fits = far_enough and bool((np.maximum(high, -low) <= limits * 1.03).all())
        shift = 0.5 * distance * (low + high) / 2
        centre = centre + rotation[:, 1] * shift[0] + rotation[:, 2] * shift[1]
        grow = float(np.clip(((high - low) / (2 * limits)).max(), 0.9, 1.1))
        distance *= grow if far_enough else 1.05
    return distance if fits else math.inf, Pose(centre + back * distance, rotation)
