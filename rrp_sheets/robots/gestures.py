"""Gestures as data: keyframes of joints, from `robots/<name>/gestures.toml` or a Gestures sheet."""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rrp_sheets.model.names import key

SIDES = ("L", "R")
_DEGREES = re.compile(r"([+-]?(?:\d+(?:\.\d*)?|\.\d+))\s*°")
_NUMBER = re.compile(r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)")


@dataclass(frozen=True, slots=True)
class Keyframe:
    """Angles of joints at a time; a joint that is not among them is then on its way, or has not begun to move.

    Attributes:
        at: s from the beginning, or beats of a gesture that goes by beats.
        angles: by the joint's name, in its unit (rad; a hand from 0, closed, to 1).
        by: the same, added to where the joint was at the beginning: legs, which may stand or sit.
    """

    at: float
    angles: Mapping[str, float]
    by: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Gesture:
    """A gesture; when it is over, all its joints return to where they were.

    Attributes:
        tempo: beats a minute when its times are beats, else 0.
        help: what it looks like, in a few words.
    """

    name: str
    frames: tuple[Keyframe, ...]
    tempo: float = 0.0
    help: str = ""

    @property
    def joints(self) -> tuple[str, ...]:
        """The joints that it moves."""
        return tuple(dict.fromkeys(joint for frame in self.frames for joint in (*frame.angles, *frame.by)))

    def timed(self, tempo: float | None = None, times: int = 1) -> tuple[Keyframe, ...]:
        """Its keyframes with their times in s.

        Args:
            tempo: beats a minute, for a gesture that goes by beats; None is its own.
            times: how often it is made, one time after the other.

        >>> march = Gesture("March", (Keyframe(1, {"HeadYaw": 0.1}), Keyframe(2, {"HeadYaw": -0.1})), tempo=120)
        >>> [frame.at for frame in march.timed()], [frame.at for frame in march.timed(60, times=2)]
        ([0.5, 1.0], [1.0, 2.0, 3.0, 4.0])
        """
        second = 60.0 / (tempo or self.tempo) if self.tempo else 1.0
        length = self.frames[-1].at
        return tuple(
            Keyframe((length * again + frame.at) * second, frame.angles, frame.by)
            for again in range(times)
            for frame in self.frames
        )

    def of_side(self, side: str) -> Gesture:
        """Only what the arm (or leg) of a side does, `L` or `R`."""
        mine = [Keyframe(f.at, {j: a for j, a in f.angles.items() if j.startswith(side)}, f.by) for f in self.frames]
        return Gesture(self.name, tuple(mine), self.tempo, self.help)


def load_gestures(path: Path, joints: Iterable[str]) -> tuple[dict[str, Gesture], tuple[Gesture, ...]]:
    """A robot's gestures by key, and the small ones that go with talking; none when there is no such file.

    In the file `ShoulderPitch` means both arms, the right one mirrored; `+HipPitch` is added to where the joint was.
    """
    if not path.is_file():
        return {}, ()
    data = tomllib.loads(path.read_text(encoding="utf-8"))
    known, mirrored = frozenset(joints), frozenset(data.get("mirrored", ()))
    gestures = [_gesture(entry, known, mirrored) for entry in data.get("gesture", ())]
    talking = [
        _gesture({"name": f"Talking {n}", **entry}, known, mirrored)
        for n, entry in enumerate(data.get("talking", ()), 1)
    ]
    return {key(g.name): g for g in gestures}, tuple(talking)


def _gesture(entry: Mapping[str, Any], joints: frozenset[str], mirrored: frozenset[str]) -> Gesture:
    frames = []
    for line in entry["frames"]:
        angles: dict[str, float] = {}
        by: dict[str, float] = {}
        for name, angle in line.items():
            if name != "at":
                into = by if name.startswith("+") else angles
                into.update(_both(name.removeprefix("+"), float(angle), joints, mirrored))
        frames.append(Keyframe(float(line["at"]), angles, by))
    return Gesture(entry["name"], tuple(frames), float(entry.get("tempo", 0)), entry.get("help", ""))


def _both(name: str, angle: float, joints: frozenset[str], mirrored: frozenset[str]) -> dict[str, float]:
    """A joint's angle; without a side the name means the joints of both sides."""
    if name in joints:
        return {name: angle}
    left, right = (side + name for side in SIDES)
    if not {left, right} <= joints:
        raise ValueError(f"there is no joint {name}")
    return {left: angle, right: -angle if name in mirrored else angle}


def parse_angle(text: str) -> float | None:
    """An angle in rad from what was typed: `0.5` or `30°`; None when it is none.

    >>> parse_angle("0.5"), round(parse_angle("30°"), 4), parse_angle("-.2"), parse_angle("up"), parse_angle("1e9")
    (0.5, 0.5236, -0.2, None, None)
    """
    text = text.strip().replace("−", "-")
    if (degrees := _DEGREES.fullmatch(text)) is not None:
        return math.radians(float(degrees[1]))
    return float(text) if _NUMBER.fullmatch(text) and len(text) < 30 else None


def resources(gesture: Gesture, movers: Mapping[str, Sequence[str]]) -> tuple[str, ...]:
    """Return the resources that a gesture uses; `movers` has those of each joint, by key."""
    return tuple(dict.fromkeys(used for joint in gesture.joints for used in movers[key(joint)]))
