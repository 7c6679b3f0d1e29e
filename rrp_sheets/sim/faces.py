"""Faces: who is in view, and whom the robot remembers.

In this version it is the scene that tells who is in view; nothing is perceived (the catalogue marks it `knowledge`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from rrp_sheets.model.values import Value
from rrp_sheets.sim.body import Pose
from rrp_sheets.sim.camera import Lens
from rrp_sheets.sim.stage import Person, Stage

REACH = (0.3, 3.0)  # m: a detector finds faces of 320×240 pictures about this far
WELL_WITHIN = 2.0  # m: near enough to be remembered
WELL_AFTER_US = 1_000_000  # in view for so long before it is seen well
OBLIQUE = math.radians(60)  # a face turned away further is not found
WIDTH, HEIGHT = 0.15, 0.20  # m, of a face


@dataclass
class _View:
    person: Person
    since_us: int
    values: dict[str, Value]


class Faces:
    """What the robot knows of faces."""

    def __init__(self, stage: Stage, lens: Lens) -> None:
        self._stage = stage
        self._lens = lens
        self._views: dict[str, _View] = {}
        self._names: dict[int, str] = {}
        self._guests = 0

    def look(self, camera: Pose) -> list[dict[str, Value]]:
        """The faces in view from there, now, by their ids."""
        us = self._stage.us
        views: dict[str, _View] = {}
        for name, person in self._stage.persons.items():
            if person.known:
                self._names.setdefault(person.number, person.known)
            seen = self._see(person, camera, us)
            if seen is not None:
                before = self._views.get(name)
                views[name] = _View(person, before.since_us if before else us, seen)
        self._views = views
        for view in views.values():
            remembered = self._names.get(view.person.number)
            far = view.values.pop("metres")
            well = us - view.since_us >= WELL_AFTER_US and far <= WELL_WITHIN
            view.values.update(
                id=view.person.number, name=remembered or "", new=remembered is None,
                recognised=remembered is not None, recognized_new_face=remembered is None and well,
            )  # fmt: skip
        return [v.values for v in sorted(views.values(), key=lambda v: v.person.number)]

    def _see(self, person: Person, camera: Pose, us: int) -> dict[str, Value] | None:
        offset = np.array(person.face(us)) - camera.position
        ahead, left, up = (float(c) for c in offset @ camera.rotation)
        far = math.hypot(ahead, left, up)
        if ahead <= 0 or not REACH[0] <= far <= REACH[1]:
            return None
        x, y = math.atan2(left, ahead), math.atan2(-up, ahead)
        if abs(x) > self._lens.hfov / 2 or abs(y) > self._lens.vfov / 2:
            return None
        heading = person.heading(us)
        towards = -(offset[0] * math.cos(heading) + offset[1] * math.sin(heading)) / math.hypot(offset[0], offset[1])
        if towards < math.cos(OBLIQUE):
            return None
        score = 0.97 - 0.08 * max(0.0, far - 1.0) - 0.2 * (1 - towards)
        return {
            "x": x, "y": y, "width": 2 * math.atan(WIDTH / 2 / far), "height": 2 * math.atan(HEIGHT / 2 / far),
            "score": score, "metres": far,
        }  # fmt: skip

    @property
    def anyone(self) -> bool:
        """Whether a face is in view."""
        return bool(self._views)

    def remember(self, name: str, number: int | None = None) -> str:
        """Remember a face that is new: the one of that id, else the one longest in view.

        Returns the name it is now remembered by, or an empty text when no new face is there.
        """
        new = [v for v in self._views.values() if v.person.number not in self._names]
        if number is not None:
            new = [v for v in new if v.person.number == number]
        if not new:
            return ""
        view = min(new, key=lambda v: (v.since_us, v.person.number))
        if not name:
            self._guests += 1
            name = f"Guest {self._guests}"
        self._names[view.person.number] = name
        return name
