"""Persons of a scene: their bodies, their heads, and the choice of each one's number and drawn face.

A body looks along the figure's x; its measures follow from the height of the face alone.
"""

from __future__ import annotations

import math
import os
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from rrp_sheets.model.exchange import SceneAction
from rrp_sheets.model.names import key
from rrp_sheets.perception.faces import FaceModels
from rrp_sheets.sim.appearance import AROUND, BACK, FRONT, HAIR, HEAD, NOSE, RGB, RINGS
from rrp_sheets.sim.portraits import Portrait, drawn, from_file
from rrp_sheets.sim.shapes import CompoundShape, ellipsoid, turned

STANDS_ABOVE = 0.85  # m: a face higher than that belongs to somebody who stands
NECK = 1.1 * HEAD  # m, from the middle of the face down to the top of the neck
TROUSERS: tuple[RGB, ...] = ((0.44, 0.46, 0.52), (0.50, 0.46, 0.42), (0.40, 0.44, 0.44), (0.52, 0.50, 0.54))
SHOE: RGB = (0.34, 0.33, 0.33)
"""Pale or grey, as clothes are: none is taken for a ball."""
Spot = tuple[float, float, float]
Colours = tuple[RGB, RGB, RGB]
"""Of shirt, trousers and skin."""
FACES = 8  # drawn faces, see `appearance`
CHILDREN, ADULTS = (0, 1, 2), (3, 4, 5, 6, 7)
_GROWN = ("adult", "therapist", "parent", "visitor")
"""Beginnings of the names of persons who are grown up; `Child` is none, and anybody else may be either."""


def is_seated(face: float, posture: str) -> bool:
    """Return whether a person sits; without a posture the height of the face decides.

    >>> is_seated(0.62, ""), is_seated(1.5, ""), is_seated(0.62, "standing")
    (True, False, False)
    """
    return posture == "seated" or (not posture and face < STANDS_ABOVE)


def body(bullet: Any, figure: CompoundShape, clothes: RGB, skin: RGB, face: float, posture: str = "") -> None:
    """Add a body to a figure, `seated`, `standing`, or as the height of the middle of the face (m) tells."""
    trousers = TROUSERS[int(100 * clothes[0]) % len(TROUSERS)]
    add = _sit if is_seated(face, posture) else _stand
    add(bullet, figure, (clothes, trousers, skin), face - NECK)


def _sit(bullet: Any, figure: CompoundShape, colours: Colours, neck: float) -> None:
    """Add a body that sits cross-legged, the hands on the knees."""
    trousers = colours[1]
    wide = 0.27 * neck + 0.02
    _torso(bullet, figure, colours, 0.02, neck, wide)
    thick = 0.105 * neck + 0.01
    for side in (1.0, -1.0):
        hip, knee = (-0.02, side * 0.55 * wide, thick), (0.44 * neck, side * 1.35 * wide, thick * 1.05)
        ankle = (0.36 * neck, -side * 0.30 * wide, thick * 0.72)
        limb(bullet, figure, hip, knee, thick * 1.15, thick * 0.92, trousers)
        limb(bullet, figure, knee, ankle, thick * 0.85, thick * 0.62, trousers)
        foot = (ankle[0], -side * 0.55 * wide, 0.04)
        figure.add(ellipsoid(bullet, (0.10 * neck, 0.06 * neck, 0.05 * neck), SHOE), foot)
        shoulder, elbow = (0.0, side * 0.88 * wide, neck * 0.84), (0.10 * neck, side * 1.18 * wide, neck * 0.46)
        _arm(bullet, figure, colours, shoulder, elbow, (0.40 * neck, side * 1.10 * wide, neck * 0.33), neck)


def _stand(bullet: Any, figure: CompoundShape, colours: Colours, neck: float) -> None:
    """Add a body that stands upright, the arms hanging."""
    trousers = colours[1]
    wide, hips = 0.115 * neck + 0.045, 0.55 * neck
    _torso(bullet, figure, colours, hips - 0.04 * neck, neck, wide)
    for side in (1.0, -1.0):
        thick = 0.052 * neck + 0.012
        hip, knee, ankle = ((0.0, side * 0.50 * wide, h) for h in (hips, 0.29 * neck, 0.05 * neck))
        limb(bullet, figure, hip, knee, thick * 1.15, thick * 0.88, trousers)
        limb(bullet, figure, knee, ankle, thick * 0.86, thick * 0.66, trousers)
        figure.add(ellipsoid(bullet, (0.075 * neck, 0.035 * neck, 0.030 * neck), SHOE),
                   (0.03 * neck, side * 0.52 * wide, 0.030 * neck))  # fmt: skip
        shoulder, elbow = (0.0, side * 0.92 * wide, neck * 0.91), (-0.01 * neck, side * 1.22 * wide, neck * 0.70)
        _arm(bullet, figure, colours, shoulder, elbow, (0.04 * neck, side * 1.24 * wide, neck * 0.51), 0.62 * neck)


def _torso(bullet: Any, figure: CompoundShape, colours: Colours, low: float, neck: float, wide: float) -> None:
    """Add a torso from the hips to the neck, flatter than wide."""
    tall = neck - low
    outline = [
        (0.0, 0.0), (wide * 0.80, 0.01), (wide * 0.90, tall * 0.06), (wide * 0.84, tall * 0.25),
        (wide * 0.80, tall * 0.42), (wide * 0.90, tall * 0.66), (wide * 0.94, tall * 0.80),
        (wide * 0.82, tall * 0.89), (wide * 0.46, tall * 0.955),
        (0.042, tall * 0.98), (0.0, tall * 0.98),
    ]  # fmt: skip
    figure.add(turned(bullet, outline, colours[0], (0.68, 1.0)), (0, 0, low))


def _arm(
    bullet: Any, figure: CompoundShape, colours: Colours, shoulder: Spot, elbow: Spot, hand: Spot, size: float
) -> None:
    thick = 0.058 * size + 0.008
    limb(bullet, figure, shoulder, elbow, thick, thick * 0.86, colours[0])
    limb(bullet, figure, elbow, hand, thick * 0.80, thick * 0.62, colours[2])
    figure.add(ellipsoid(bullet, (thick * 0.85, thick * 0.75, thick * 1.0), colours[2]), hand)


def limb(bullet: Any, figure: CompoundShape, start: Spot, end: Spot, thick: float, thin: float, colour: RGB) -> None:
    """Add a round part of an arm or a leg between two places, `thick` (radius, m) here and `thin` there."""
    long = math.dist(start, end)
    outline = [(0.0, -thick * 0.9), (thick * 0.70, -thick * 0.6), (thick, 0.0), (thin, long),
               (thin * 0.70, long + thin * 0.6), (0.0, long + thin * 0.9)]  # fmt: skip
    along = [(e - s) / long for s, e in zip(start, end, strict=True)]
    figure.add(turned(bullet, outline, colour, around=12), start, _upright_to(along))


def _upright_to(way: Sequence[float]) -> Spot | tuple[float, float, float, float]:
    """Return the rotation (a quaternion) that turns z into a direction."""
    x, y, z = way
    if z < -0.999999:  # upside down: any axis across
        return 1.0, 0.0, 0.0, 0.0
    half = math.sqrt((1 + z) / 2)
    return -y / (2 * half), x / (2 * half), 0.0, half


class Heads:
    """Makes heads in one world; each picture is loaded only once. Networks find the face in a picture file."""

    def __init__(self, bullet: Any, models: Callable[[], FaceModels]) -> None:
        self._b, self._models = bullet, models
        self._drawn: dict[int, Portrait] = {}
        self._files: dict[str, Portrait] = {}
        self._textures: dict[str, int] = {}

    def portrait(self, face: int, picture: str = "") -> Portrait:
        """The portrait in a picture file, else the drawn face of that number; raises SheetsError for a bad picture."""
        if not picture:
            if face not in self._drawn:
                self._drawn[face] = drawn(face)
            return self._drawn[face]
        if picture not in self._files:
            self._files[picture] = from_file(Path(picture), self._models())
        return self._files[picture]

    def add(self, figure: CompoundShape, portrait: Portrait, height: float) -> None:
        """Put a head on a figure; `height` of the middle of the face, m. It looks along the figure's x."""
        b = self._b
        points, places, normals, faces = _shape(portrait.outline)
        shape = b.createVisualShape(
            b.GEOM_MESH, vertices=points, indices=faces, uvs=places, normals=normals, rgbaColor=[1, 1, 1, 1],
            specularColor=[0, 0, 0],
        )  # fmt: skip
        body = figure.add(shape, (0, 0, height))
        b.changeVisualShape(body, -1, textureUniqueId=self._texture(portrait))
        wide = portrait.outline(0.1)
        shade = [0.82 * c for c in portrait.skin]
        neck = [(0.0, -1.5 * HEAD), (0.42 * HEAD, -1.5 * HEAD), (0.36 * HEAD, -0.55 * HEAD), (0.0, -0.5 * HEAD)]
        figure.add(turned(b, neck, (shade[0], shade[1], shade[2])), (-0.22 * HEAD, 0, height))
        for side in (1, -1):
            ear = ellipsoid(b, (0.13 * HEAD, 0.09 * HEAD, 0.20 * HEAD), portrait.skin)
            figure.add(ear, (-0.08 * HEAD, side * wide * 0.99 * HEAD, 0.02 * HEAD + height))
        for x, z, deep, across, high in HAIR[portrait.style]:
            hair = ellipsoid(b, (deep * HEAD, across * wide * HEAD, high * HEAD), portrait.hair)
            figure.add(hair, (x * HEAD, 0, z * HEAD + height))

    def _texture(self, portrait: Portrait) -> int:
        # The physics library reads pictures from files only, and knows them again by their path.
        if portrait.name not in self._textures:
            handle, path = tempfile.mkstemp(prefix="rrp-face-", suffix=".png")
            os.close(handle)
            try:
                cv2.imwrite(path, np.ascontiguousarray(portrait.picture[:, :, ::-1]))
                self._textures[portrait.name] = self._b.loadTexture(path)
            finally:
                Path(path).unlink(missing_ok=True)
        return self._textures[portrait.name]


def _shape(
    outline: Callable[[float], float],
) -> tuple[list[list[float]], list[list[float]], list[list[float]], list[int]]:
    """Return points (m), the place of each in the picture (0 to 1), normals, and triangles."""
    # The picture lies on the front as if it were projected from before it; the back has its edge's colours.
    points, places = [], []
    for ring in range(RINGS + 1):
        z = -math.cos(math.pi * ring / RINGS)
        wide = max(outline(z), 1e-3)
        round_ = math.sqrt(max(0.0, 1 - z * z))
        for step in range(AROUND + 1):
            turn = 2 * math.pi * step / AROUND - math.pi
            ahead, aside = math.cos(turn), math.sin(turn)
            y = wide * aside
            x = ahead * (FRONT * max(round_, 1e-3) ** 0.75 if ahead > 0 else BACK * round_)
            if ahead > 0:
                out, middle, half, high = NOSE
                x += out * math.exp(-((y / half) ** 2) - ((z - middle) / high) ** 2)
            points.append([x * HEAD, y * HEAD, z * HEAD])
            seen = y if ahead > 0 else math.copysign(wide, aside)
            places.append([0.5 + 0.499 * seen, 0.5 + 0.499 * z])
    row = AROUND + 1
    corners = [
        (k, k + 1, k + 1 + row) if half == 0 else (k, k + 1 + row, k + row)
        for i in range(RINGS) for k in range(i * row, i * row + AROUND) for half in (0, 1)
    ]  # fmt: skip
    return points, places, _normals(points, corners, row).tolist(), [k for face in corners for k in face]


def _normals(points: Sequence[Sequence[float]], corners: Sequence[tuple[int, int, int]], row: int) -> Any:
    at, index = np.array(points), np.array(corners)
    across = np.cross(at[index[:, 1]] - at[index[:, 0]], at[index[:, 2]] - at[index[:, 0]])
    normals = np.zeros_like(at)
    for k in range(3):
        np.add.at(normals, index[:, k], across)
    both = normals[0::row] + normals[row - 1 :: row]  # the seam at the back
    normals[0::row] = normals[row - 1 :: row] = both
    return normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)


@dataclass(frozen=True)
class KnownPerson:
    """A person whom the robot knows before the run begins."""

    number: int  # the id that the sensor then gives
    name: str
    face: int  # of the drawn faces
    picture: str  # the file with the person's face, or empty for the drawn one


class Looks:
    """The persons of a scene, numbered as they come; faces differ as long as there are enough."""

    def __init__(self, actions: Sequence[SceneAction]) -> None:
        self._numbers: dict[str, int] = {}
        self._faces: dict[int, int] = {}
        self.known: list[KnownPerson] = []
        for action in sorted(actions, key=lambda a: a.time_us):
            if is_entry(action):
                number = self.number(action)
                name = str(action.values.get("name") or "")
                if name and number not in {k.number for k in self.known}:
                    picture = str(action.values.get("picture") or "")
                    self.known.append(KnownPerson(number, name, self._faces[number], picture))

    def number(self, action: SceneAction) -> int:
        """Return the number of a person who comes in: the row's `id`, else the earlier number, else the next one."""
        name, given = key(action.thing), action.values.get("id")
        if given is None:
            given = self._numbers.get(name) or next(n for n in range(1, len(self._numbers) + 2) if n not in self._faces)
        number: int = int(given)
        if action.verb == "seen":
            name = f"{name} {number}"
        self._numbers[name] = number
        if number not in self._faces:
            self._faces[number] = self._choose(action.thing, number)
        return number

    def face(self, number: int) -> int:
        """Return the drawn face of the person with that number."""
        return self._faces.get(number, number - 1) % FACES

    def _choose(self, thing: str, number: int) -> int:
        name = key(thing)
        order: Sequence[int] = range(FACES)
        if name.startswith("child"):
            order = CHILDREN
        elif name.startswith(_GROWN):
            order = ADULTS
        start = (number - 1) % len(order)
        wanted: list[int] = [*order[start:], *order[:start], *range(FACES)]
        return next((face for face in wanted if face not in self._faces.values()), wanted[0])


def is_entry(action: SceneAction) -> bool:
    """Return whether a person comes in by this action.

    >>> is_entry(SceneAction(0, "Mia", "appear", {"at": (1, 0, 0.6)})), is_entry(SceneAction(0, "Mia", "disappear"))
    (True, False)
    """
    return action.verb in ("appear", "seen") and action.what == "person"
