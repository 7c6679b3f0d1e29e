"""Numbers and drawn faces of a scene's persons; the same for the world, its film and its 3D view.

This is knowledge of the scene: code that draws people uses it, perception does not.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from rrp_sheets.model.names import key
from rrp_sheets.model.scene_actions import SceneAction

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
