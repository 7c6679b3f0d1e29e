"""Memory for people's faces, in numbers under their names, and the file that keeps it beyond a run, until wiped."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from rrp_sheets.errors import SheetsError
from rrp_sheets.model.names import key
from rrp_sheets.model.run_files import faces_file
from rrp_sheets.private import close_to_others, folder_above, opener
from rrp_sheets.texts import N_, os_reason, plural

if TYPE_CHECKING:
    from rrp_sheets.perception.faces import Features

NUMBERS = 128  # of a face
MOST_PERSONS = 500  # kept in a file
MOST_VIEWS = 4  # of one person
MOST_BYTES = 5_000_000
DIGITS = 6  # after the point, of the numbers in a file
GUEST = "Guest"
FACE_REMEMBERED = N_("The face is remembered as {name}.")
"""Template of a notice. A trace has it in English, and who deletes a participant's faces looks for it."""


@dataclass(eq=False)
class RememberedPerson:
    """A person whom the robot remembers."""

    id: int  # what the face sensor gives for this person
    name: str
    views: list[Features] = field(default_factory=list)  # their face in numbers, from some distances
    given: bool = False  # known from the scene, so that no file keeps them


@dataclass
class FaceMemory:
    """The persons whom the robot remembers, in the order in which it came to know them."""

    persons: list[RememberedPerson] = field(default_factory=list)

    def likest(self, face: Features) -> tuple[RememberedPerson | None, float]:
        """Return the person who looks most like a face, and how similar they are (1 is the same picture)."""
        found: tuple[RememberedPerson | None, float] = (None, -1.0)
        for person in self.persons:
            alike = max((float(face @ view) for view in person.views), default=-1.0)
            if alike > found[1]:
                found = person, alike
        return found

    def add(self, number: int, name: str, views: Sequence[Features]) -> RememberedPerson:
        """Add a person whom the robot is to remember; without a name as the next guest."""
        person = RememberedPerson(number, name or self._guest(), list(views)[:MOST_VIEWS])
        self.persons.append(person)
        return person

    def know(self, number: int, name: str, views: Sequence[Features]) -> None:
        """Add a person known from the scene; a person of that name who is there already gets more views."""
        same = next((p for p in self.persons if key(p.name) == key(name)), None)
        if same is not None:
            same.views = [*views, *same.views][: 2 * MOST_VIEWS]
            return
        free = next(n for n in (number, *range(1, len(self.persons) + 2)) if self.free(n))
        self.persons.append(RememberedPerson(free, name, list(views), given=True))

    def free(self, number: int) -> bool:
        """Return whether no person has that id."""
        return all(p.id != number for p in self.persons)

    def _guest(self) -> str:
        names = {p.name for p in self.persons}
        return next(name for n in range(1, len(names) + 2) if (name := f"{GUEST} {n}") not in names)


def read_memory(path: Path) -> FaceMemory:
    """Read the faces that earlier runs have kept, none when there is no file; raises SheetsError when it is broken.

    Others may not read the file from then on, even if an earlier version of the program has left it open to them.
    """
    close_to_others(path)
    try:
        if path.stat().st_size > MOST_BYTES:
            raise ValueError
        told = json.loads(path.read_text(encoding="utf-8"))
        return FaceMemory([_person(p) for p in told["persons"][:MOST_PERSONS]])
    except FileNotFoundError:
        return FaceMemory()
    except (OSError, ValueError, TypeError, KeyError, RecursionError):
        why = N_("The remembered faces in “{path}” cannot be read.", path=str(path))
        remedy = N_("Delete them with `rrp-sheets faces --forget-all` in the workbook’s folder. The robot then "
                    "starts without any.")  # fmt: skip
        raise SheetsError(why, remedy) from None


def write_memory(path: Path, memory: FaceMemory) -> None:
    """Write the memory to its file, or remove the file when there is nobody to keep; raises SheetsError."""
    persons = [
        {"id": p.id, "name": p.name, "views": [[round(float(v), DIGITS) for v in view] for view in p.views]}
        for p in [p for p in memory.persons if not p.given][-MOST_PERSONS:]
    ]
    try:
        if not persons:
            path.unlink(missing_ok=True)
            return
        folder_above(path)
        half = path.with_suffix(".new")
        half.unlink(missing_ok=True)
        with open(half, "x", encoding="utf-8", opener=opener) as file:  # faces are personal data
            json.dump({"persons": persons}, file, ensure_ascii=False)
        half.replace(path)
    except OSError as error:
        why = N_("The remembered faces cannot be written to “{path}” ({reason}).", path=str(path),
                 reason=os_reason(error))  # fmt: skip
        raise SheetsError(why, N_("Free some space.")) from None


def kept(folder: Path) -> list[str]:
    """Return the names that are remembered for a folder's workbooks; raises SheetsError when their file is broken."""
    return [person.name for person in read_memory(faces_file(folder)).persons]


def forget(folder: Path, name: str) -> str:
    """Delete one remembered person; return the name as stored. Raises SheetsError, also when nobody has that name."""
    memory = read_memory(faces_file(folder))
    gone = [p for p in memory.persons if key(p.name) == key(name)]
    if not gone:
        names = ", ".join(p.name for p in memory.persons)
        remedy = N_("Remembered are: {names}.", names=names) if names else N_("No faces are remembered here.")
        raise SheetsError(N_("Nobody called “{name}” is remembered.", name=name), remedy)
    write_memory(faces_file(folder), FaceMemory([p for p in memory.persons if p not in gone]))
    return gone[0].name


def forget_all(folder: Path) -> str:
    """Delete all remembered faces, also when the file is broken; return a sentence that says how many."""
    try:
        count = len(kept(folder))
        words = plural("{n} remembered face was deleted.", "{n} remembered faces were deleted.", count)
    except SheetsError:
        words = N_("All remembered faces were deleted.")
    write_memory(faces_file(folder), FaceMemory())
    return words


def _person(told: Any) -> RememberedPerson:
    number, name, views = told["id"], told["name"], told["views"]
    if not isinstance(number, int) or isinstance(number, bool) or not isinstance(name, str) or not 0 < len(name) <= 200:
        raise ValueError
    return RememberedPerson(number, name, [_view(view) for view in views[:MOST_VIEWS]])


def _view(numbers: Any) -> Features:
    if len(numbers) != NUMBERS or not all(isinstance(v, float | int) and math.isfinite(v) for v in numbers):
        raise ValueError
    view = np.array(numbers, dtype=np.float32)
    length = float(np.linalg.norm(view))
    if not length:
        raise ValueError
    return np.asarray(view / length, dtype=np.float32)
