"""People for the tests of faces: the eight drawn ones, and two photographs in the public domain that come with packages."""

from __future__ import annotations

import math
from importlib.util import find_spec
from pathlib import Path

from rrp_sheets.model.exchange import DeviceUse
from rrp_sheets.perception.face_memory import FaceMemory
from rrp_sheets.perception.faces import Features
from rrp_sheets.perception.pinhole import Pixels
from rrp_sheets.robots import load_robot
from rrp_sheets.sim.people import FACES, Heads, body
from rrp_sheets.sim.portraits import studied
from rrp_sheets.sim.process import Spec
from rrp_sheets.sim.shapes import CLOTHES, CompoundShape
from rrp_sheets.sim.world import SimWorld

FACE = DeviceUse("face", "Face", "FaceDetection", {"rate": 2})
HEIGHT = 0.62  # m, of a face
NOWHERE = (0.0, 0.0, -9.0)


def photographs() -> list[Path]:
    """Eileen Collins (NASA) and Grace Hopper (US Navy): works of the United States' government."""
    found = [("skimage", "data/astronaut.png"), ("matplotlib", "mpl-data/sample_data/grace_hopper.jpg")]
    return [Path(str(find_spec(package).origin)).parent / path for package, path in found]  # type: ignore[union-attr]


class Studio:
    """A world in which one person after the other stands before the robot; the robot knows all of them.

    Attributes:
        names: of the persons, the drawn ones first.
    """

    def __init__(self, photos: bool = True) -> None:
        self.world = SimWorld(Spec(load_robot(), (FACE,)))
        self.models = self.world.faces.models
        heads = Heads(self.world._b, lambda: self.models)
        portraits = [heads.portrait(face) for face in range(FACES)]
        portraits += [heads.portrait(0, str(path)) for path in (photographs() if photos else [])]
        self.names = [p.name for p in portraits]
        self.memory = FaceMemory()
        self._figures = []
        for number, portrait in enumerate(portraits, start=1):
            self.memory.know(number, portrait.name, studied(portrait, self.models))
            figure = CompoundShape(self.world._b)
            body(self.world._b, figure, CLOTHES[0], portrait.skin, HEIGHT)
            heads.add(figure, portrait, HEIGHT)
            self._figures.append(figure)

    def picture(
        self, person: int | None, far: float, aside: float = 0.0, turned: float = 0.0, light: float = 1.0
    ) -> Pixels:
        """Picture of a person: `far` (m) from the camera, `aside` and `turned` away (degrees)."""
        for figure in self._figures:
            figure.place(NOWHERE)
        if person is not None:
            eye, way = self.world.body.camera().position, math.radians(aside)
            x, y = far * math.cos(way), far * math.sin(way)
            place = (float(eye[0]) + x, float(eye[1]) + y, 0.0)
            self._figures[person].place(place, math.atan2(-y, -x) + math.radians(turned))
        return self.world.sight._fine.look(self.world.body.camera(), light)

    def numbers(self, picture: Pixels) -> Features | None:
        """The only face of a picture in numbers; None without exactly one."""
        faces = self.models.find(picture)
        return self.models.features(picture, faces[0]) if len(faces) == 1 else None

    def alike(self, numbers: Features, person: int) -> tuple[float, float]:
        """Likeness of a face to that person, and to the most similar of the others."""
        mine = [p for p in self.memory.persons if p.name == self.names[person]]
        others = [p for p in self.memory.persons if p.name != self.names[person]]
        return FaceMemory(mine).likest(numbers)[1], FaceMemory(others).likest(numbers)[1]
