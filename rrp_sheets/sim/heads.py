"""The looks of persons, and their heads: a shape with a face picture on its front, and hair."""

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

from rrp_sheets.model.names import key
from rrp_sheets.model.scene_actions import SceneAction
from rrp_sheets.sim.face_models import FaceModels
from rrp_sheets.sim.face_traits import AROUND, BACK, FRONT, HAIR, HEAD, NOSE, RINGS
from rrp_sheets.sim.figures import CompoundShape, ellipsoid, turned
from rrp_sheets.sim.portraits import Portrait, drawn, from_file


class Heads:
    """Makes heads in one world; each picture is loaded only once.

    Args:
        bullet: the physics.
        models: makes the networks when they are needed, to find the face in a picture file.
    """

    def __init__(self, bullet: Any, models: Callable[[], FaceModels]) -> None:
        self._b = bullet
        self._models = models
        self._drawn: dict[int, Portrait] = {}
        self._files: dict[str, Portrait] = {}
        self._textures: dict[str, int] = {}

    def portrait(self, face: int, picture: str = "") -> Portrait:
        """The portrait in a picture file, else the drawn face of that number.

        Raises:
            SheetsError: the picture cannot be used.
        """
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
    """Return points (m), the place of each in the picture (0 to 1), normals, and triangles.

    The picture lies on the front as if it were projected from before it; the back has its edge's colours.
    """
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


FACES = 8  # drawn faces, see `face_people`
CHILDREN, ADULTS = (0, 1, 2), (3, 4, 5, 6, 7)
_GROWN = ("adult", "therapist", "parent", "visitor")
"""Beginnings of the names of persons who are grown up; `Child` is none, and anybody else may be either."""


@dataclass(frozen=True)
class KnownPerson:
    """A person whom the robot knows before the run begins.

    Attributes:
        number: the id that the sensor then gives.
        name: as the robot knows it.
        face: of the drawn faces.
        picture: the file with the person's face, or empty for the drawn one.
    """

    number: int
    name: str
    face: int
    picture: str


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

    def faces(self) -> dict[str, int]:
        """Return the drawn face of each person, by the key of the thing."""
        return {name: self.face(number) for name, number in self._numbers.items()}

    def _choose(self, thing: str, number: int) -> int:
        name = key(thing)
        order: Sequence[int] = range(FACES)
        if name.startswith("child"):
            order = CHILDREN
        elif name.startswith(_GROWN):
            order = ADULTS
        start = (number - 1) % len(order)
        wanted: list[int] = [*order[start:], *order[:start], *range(FACES)]
        taken = set(self._faces.values())
        return next((face for face in wanted if face not in taken), wanted[0])


def is_entry(action: SceneAction) -> bool:
    """Return whether a person comes in by this action.

    >>> is_entry(SceneAction(0, "Mia", "appear", {"at": (1, 0, 0.6)})), is_entry(SceneAction(0, "Mia", "disappear"))
    (True, False)
    """
    return action.verb in ("appear", "seen") and action.what == "person"
