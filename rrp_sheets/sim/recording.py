"""Recording of a run for looking back at it: poses of robot and things, and camera pictures.

Nothing of the run depends on these files. What cannot be written is left out, which is reported.
"""

from __future__ import annotations

import json
import zipfile
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

from rrp_sheets.model.run_files import CAMERA, POSES
from rrp_sheets.private import private_text
from rrp_sheets.sim.camera import jpeg
from rrp_sheets.texts import N_

if TYPE_CHECKING:
    from rrp_sheets.sim.world import SimWorld

POSE_EVERY = 24  # physics steps between two poses: 10 a second
FULL_EVERY = 100  # poses between two that have everything, where a reader can begin
PICTURE_EVERY = 120  # physics steps between two pictures: 2 a second
MOST_PICTURES = 1200  # kept; of a longer run every other one is dropped, again and again
STALE_US = 200_000  # a picture may be so old: one that a sensor has taken anyway
WRITTEN_EVERY = 20  # poses, or pictures, that are written at once
MOVED, STIRRED = 0.002, 0.002  # m, rad: what moves less has not moved
DIGITS = 3
Unwritten = Callable[[str, Exception], None]
"""Receives what cannot be written, and the error."""


class Recording:
    """Records a world while it goes on, its camera pictures only if wanted."""

    def __init__(self, world: SimWorld, out: Path, pictures: bool) -> None:
        self._world = world
        self._poses = Poses(out / POSES, list(world.body.start), world.unwritten)
        self._pictures = Pictures(out / CAMERA, world.unwritten) if pictures else None
        self._next_pose = self._next_picture = 0

    def go_on(self, step: int) -> None:
        """Record what is due at a step of the physics."""
        if step >= self._next_pose:
            self._next_pose = step + POSE_EVERY
            self._poses.add(self._world)
        if self._pictures is not None and step >= self._next_picture:
            self._next_picture = step + PICTURE_EVERY * self._pictures.thinning
            world = self._world
            self._pictures.add(world.stage.us, jpeg(world.sight.recent(STALE_US)))

    def close(self) -> None:
        """Write the rest at the end of the run."""
        self._poses.close()
        if self._pictures is not None:
            self._pictures.write()


class Poses:
    """The poses' file: JSON Lines, each with what has changed since the one before.

    In a line, `t` is in seconds; `joints` (rad) by name; `base` x, y, z (m) and roll, pitch, yaw (rad) of the torso;
    `eyes` 0 to 1; `saying`; `things` (m) by name, null for what has gone; `looks` by name; `light`, `noise` 0 to 1;
    `drives` the joints that each row moves.
    """

    def __init__(self, path: Path, joints: list[str], unwritten: Unwritten) -> None:
        self._path, self._unwritten = path, unwritten
        self._file: TextIO | None = None
        self._told: dict[str, Any] = {}
        self._waiting = [_line({"poses": 1, "joints": joints})]
        self._count = 0
        self._broken = False

    def add(self, world: SimWorld) -> None:
        """Add the world's present pose, as far as it has changed."""
        if self._broken:
            return
        full = self._count % FULL_EVERY == 0
        if full:
            self._told = {}
        self._count += 1
        entry: dict[str, Any] = {"t": round(world.stage.us / 1e6, DIGITS), **({"full": True} if full else {})}
        body, stage = world.body, world.stage
        self._changed(entry, "joints", body.positions())
        self._drives(entry, world)
        self._whole(entry, "base", (*(float(c) for c in body.torso().position), *body.tilt()))
        self._changed(entry, "things", stage.places())
        self._looks(entry, stage.looks())
        self._whole(entry, "eyes", world.eyes.shining)
        self._whole(entry, "light", (stage.light,))
        self._whole(entry, "noise", (stage.noise,))
        if self._told.get("saying", "") != world.voice.saying or full:
            entry["saying"] = self._told["saying"] = world.voice.saying
        if len(entry) > 1:
            self._waiting.append(_line(entry))
        if self._count % WRITTEN_EVERY == 0:
            self._write()

    def _changed(self, entry: dict[str, Any], part: str, now: Mapping[str, Any]) -> None:
        """Enter the named values of a part that have moved; null for a name that has gone."""
        told = self._told.setdefault(part, {})
        moved = {name: _rounded(v) for name, v in now.items() if name not in told or _apart(told[name], v)}
        gone = dict.fromkeys(name for name in told if name not in now)
        told.update(moved)
        for name in gone:
            del told[name]
        if moved or gone:
            entry[part] = {**moved, **gone}

    def _drives(self, entry: dict[str, Any], world: SimWorld) -> None:
        used = [(job.command.row, world.body.joints_used(job.uses, job.joints)) for job in world.arbiter.used()]
        now = {row: sorted(joints) for row, joints in used if joints}
        if self._told.get("drives", {}) != now:
            entry["drives"] = self._told["drives"] = now

    def _looks(self, entry: dict[str, Any], now: Mapping[str, Any]) -> None:
        told = self._told.setdefault("looks", {})
        if new := {name: dict(look) for name, look in now.items() if told.get(name) != look}:
            told.update(new)
            entry["looks"] = new

    def _whole(self, entry: dict[str, Any], part: str, now: tuple[float, ...]) -> None:
        """Enter a part as a whole when any of it has changed."""
        told = self._told.get(part)
        if told is None or _apart(told, now):
            self._told[part] = _rounded(now)
            entry[part] = self._told[part][0] if len(now) == 1 else self._told[part]

    def _write(self) -> None:
        try:
            if self._file is None:
                self._file = private_text(self._path)
            self._file.write("".join(self._waiting))
            self._file.flush()
        except OSError as error:  # a full disk: the run goes on, and is looked back at as far as this was written
            self._broken = True
            self._unwritten(N_("How the robot moves"), error)
        self._waiting.clear()

    def close(self) -> None:
        """Write the rest."""
        if not self._broken:
            self._write()
        if self._file is not None:
            with suppress(OSError):  # all of it was written, or that it was not has been told
                self._file.close()


class Pictures:
    """Camera pictures as JPEG in a zip that is complete after every write; named by their seconds."""

    def __init__(self, path: Path, unwritten: Unwritten) -> None:
        self._path, self._unwritten = path, unwritten
        self._waiting: list[tuple[str, bytes]] = []
        self._count = 0
        self._begun = self._broken = False
        self.thinning = 1  # of so many pictures one is kept

    def add(self, us: int, picture: bytes) -> None:
        """Take a picture."""
        if self._broken:
            return
        self._waiting.append((f"{us / 1e6:09.3f}.jpg", picture))
        self._count += 1
        if len(self._waiting) >= WRITTEN_EVERY:
            self.write()
        if self._count >= MOST_PICTURES and not self._broken:
            self._thin()

    def write(self) -> None:
        """Write the pictures that wait."""
        if self._broken or not self._waiting:
            return
        try:
            with zipfile.ZipFile(self._path, "a" if self._begun else "w") as archive:  # stored: JPEGs get no smaller
                self._begun = True
                for name, picture in self._waiting:
                    archive.writestr(name, picture)
        except (OSError, zipfile.BadZipFile) as error:
            self._give_up(error)
        self._waiting.clear()

    def _thin(self) -> None:
        """Drop every other picture."""
        self.write()
        thinner = self._path.with_suffix(".part")
        try:
            with zipfile.ZipFile(self._path) as old, zipfile.ZipFile(thinner, "w") as new:
                names = old.namelist()[::2]
                for name in names:
                    new.writestr(name, old.read(name))
            thinner.replace(self._path)
            self._count, self.thinning = len(names), self.thinning * 2
        except (OSError, zipfile.BadZipFile) as error:
            thinner.unlink(missing_ok=True)
            self._give_up(error)

    def _give_up(self, error: Exception) -> None:
        """Remove the incomplete zip and write no more, for example when the disk is full."""
        self._broken = True
        self._waiting.clear()
        self._path.unlink(missing_ok=True)
        self._unwritten(N_("What the camera sees"), error)


def _apart(told: Any, now: Any) -> bool:
    """Return whether a number, or the numbers of a place, have moved since they were last written."""
    if isinstance(now, (int, float)):
        return bool(abs(told - now) >= STIRRED)
    return any(abs(a - b) >= MOVED for a, b in zip(told, now, strict=True))


def _rounded(value: Any) -> Any:
    if isinstance(value, (int, float)):
        return round(float(value), DIGITS)
    return [round(float(v), DIGITS) for v in value]


def _line(entry: Mapping[str, Any]) -> str:
    return json.dumps(entry, ensure_ascii=False, separators=(",", ":")) + "\n"
