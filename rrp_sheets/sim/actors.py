"""The balls and the persons of a scene: where they are at a time, and the shapes of which they are."""

from __future__ import annotations

import math
from dataclasses import dataclass

from rrp_sheets.sim import figures
from rrp_sheets.sim.face_traits import HEAD
from rrp_sheets.sim.paths import Circle, Line, Point, Still
from rrp_sheets.sim.people import is_seated
from rrp_sheets.sim.solids import Cylinder, Solid, Sphere

AWAY = math.radians(150)  # how far a person who looks away turns
WIDE, SEATED_WIDE = 0.15, 0.19  # of a face's height: how wide a person is who stands, who sits (radius)
Path = Still | Line | Circle


@dataclass
class Ball:
    """A ball in the world."""

    name: str
    figure: figures.Figure
    radius: float
    path: Path
    colour: str = ""

    def solids(self, us: int) -> list[Solid]:
        """Its shape where it is at a time."""
        return [Sphere(self.name, self.path.at(us), self.radius)]


@dataclass
class Person:
    """A person in the world.

    Attributes:
        number: the id that the face sensor gives for them when the robot knows them from the beginning.
        known: the name the robot knows already, or empty.
        looks: False when looking away.
        until_us: when the person leaves by themselves, or None.
        posture: `seated`, `standing`, or empty: the height tells.
        drawn: which of the drawn faces.
        picture: the file of the face, or empty for the drawn one.
        voice: `child`, `female`, `male`, or empty.
    """

    name: str
    number: int
    known: str
    figure: figures.Figure
    path: Path
    height: float
    looks: bool = True
    until_us: int | None = None
    posture: str = ""
    drawn: int = 0
    picture: str = ""
    voice: str = ""

    def face(self, us: int) -> Point:
        """Where the face is at a time."""
        return self.path.at(us)

    def heading(self, us: int) -> float:
        """Which way the face looks, rad: towards the robot's place, or away."""
        x, y, _ = self.path.at(us)
        return math.atan2(-y, -x) + (0.0 if self.looks else AWAY)

    @property
    def seated(self) -> bool:
        """Whether they sit."""
        return is_seated(self.height, self.posture)

    def solids(self, us: int) -> list[Solid]:
        """The body, and the head on it."""
        x, y, z = self.path.at(us)
        body = z - HEAD
        radius = min((SEATED_WIDE if self.seated else WIDE) * self.height + 0.03, 0.25)
        return [
            Cylinder(self.name, (x, y, body / 2), radius, max(body, 0.01)),
            Sphere(self.name, (x, y, z), HEAD),
        ]
