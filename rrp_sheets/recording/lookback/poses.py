"""Poses of robot and things in a recorded run, and the camera's pictures, as `sim/recording.py` has written them.

These files are untrusted: what is no number or no name is left out.
"""

from __future__ import annotations

import json
import re
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rrp_sheets.model.run_files import CAMERA, POSES
from rrp_sheets.workbook.package import BROKEN_ZIP

PIECE_SECONDS = 30.0
_FULL = b'"full":true'
_MOST_LINES = 2_000_000
_LONGEST_LINE = 1 << 18  # bytes
_MOST_PARTS = 200  # joints, or things
_MOST_PICTURES = 5_000
_LARGEST_PICTURE = 1 << 20  # bytes
_LARGEST_ZIP = 1 << 30
_PICTURE = re.compile(r"(\d{5,8}\.\d{3})\.jpg")
_JPEG = b"\xff\xd8\xff"


@dataclass
class PoseIndex:
    """Times and places of the pieces of a file of poses. Each piece begins with a full pose."""

    path: Path
    times: list[float] = field(default_factory=list)
    places: list[int] = field(default_factory=list)

    def piece(self, number: int) -> list[dict[str, Any]]:
        """Return the poses of a piece, each with what has changed since the one before."""
        end = self.places[number + 1] if number + 1 < len(self.places) else None
        found = []
        with self.path.open("rb") as file:
            file.seek(self.places[number])
            while end is None or file.tell() < end:
                line = file.readline(_LONGEST_LINE)
                if not line.endswith(b"\n"):
                    break
                pose = _pose(line)
                if pose is not None:
                    found.append(pose)
        return found


def index_poses(place: Path) -> PoseIndex:
    """Look through the poses of a run; the index has no pieces when there are none."""
    found = PoseIndex(place / POSES)
    if not found.path.is_file() or found.path.is_symlink():
        return found
    at = 0
    with found.path.open("rb") as file:
        for _ in range(_MOST_LINES):
            line = file.readline(_LONGEST_LINE)
            if not line.endswith(b"\n"):
                break
            if _FULL in line and (pose := _pose(line)) is not None:
                t = pose["t"]
                if not found.times or t - found.times[-1] >= PIECE_SECONDS:
                    found.times.append(t)
                    found.places.append(at)
            at += len(line)
    return found


def _pose(line: bytes) -> dict[str, Any] | None:
    try:
        entry = json.loads(line)
    except (ValueError, RecursionError):
        return None
    if not isinstance(entry, dict) or not _is_number(entry.get("t")):
        return None
    found: dict[str, Any] = {"t": float(entry["t"])}
    if entry.get("full") is True:
        found["full"] = True
    joints = {n: v for n, v in _named(entry.get("joints")) if _is_number(v)}
    things = {n: v for n, v in _named(entry.get("things")) if v is None or _numbers(v, 3)}
    looks = {n: look for n, v in _named(entry.get("looks")) if (look := _look(v)) is not None}
    parts = {
        "joints": joints, "things": things, "looks": looks,
        "base": v if _numbers(v := entry.get("base"), 6) else None,
        "eyes": v if _numbers(v := entry.get("eyes"), 3) else None,
        "light": v if _is_number(v := entry.get("light")) else None,
        "noise": v if _is_number(v := entry.get("noise")) else None,
        "saying": v[:500] if isinstance(v := entry.get("saying"), str) else None,
    }  # fmt: skip
    found.update((name, part) for name, part in parts.items() if part is not None and part != {})
    return found


def _named(part: Any) -> list[tuple[str, Any]]:
    if not isinstance(part, dict):
        return []
    return [(name[:100], v) for name, v in list(part.items())[:_MOST_PARTS]]


def _look(look: Any) -> dict[str, Any] | None:
    """Return a thing's appearance (texts, numbers, truth values, sizes of three numbers); None without a size."""
    if not isinstance(look, Mapping):
        return None
    plain = {n: v for n, v in look.items() if isinstance(v, bool) or _is_number(v) or _numbers(v, 3)}
    words = {n: v[:100] for n, v in look.items() if isinstance(v, str)}
    sized = "size" in plain or look.get("kind") == "person"
    return {**plain, **words} if sized else None


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) < 1e6


def _numbers(value: Any, count: int) -> bool:
    return isinstance(value, list) and len(value) == count and all(map(_is_number, value))


def picture_times(place: Path) -> list[float]:
    """Return the times at which the camera's pictures were taken; the number of a picture is its place here."""
    return [float(m[1]) for name in _picture_names(place) if (m := _PICTURE.fullmatch(name))]


def picture(place: Path, number: int) -> bytes:
    """Return a picture as JPEG; empty when there is none that can be shown."""
    names = _picture_names(place)
    if not 0 <= number < len(names):
        return b""
    try:
        with zipfile.ZipFile(place / CAMERA) as archive:
            data = archive.read(names[number])
    except BROKEN_ZIP:
        return b""
    return data if data.startswith(_JPEG) else b""


def _picture_names(place: Path) -> list[str]:
    path = place / CAMERA
    try:
        if path.is_symlink() or not path.is_file() or path.stat().st_size > _LARGEST_ZIP:
            return []
        with zipfile.ZipFile(path) as archive:
            entries = archive.infolist()
    except BROKEN_ZIP:
        return []
    names = {
        e.filename for e in entries
        if e.compress_type == zipfile.ZIP_STORED and e.file_size <= _LARGEST_PICTURE and _PICTURE.fullmatch(e.filename)
    }  # fmt: skip
    return sorted(names)[:_MOST_PICTURES]
