"""A robot's catalogue that comes with a workbook, in `robots/<name>/` beside it: how a bundle brings its own along.

It may be a stranger's, and the simulator's libraries read some of its files. So it is judged before anything uses it: a
table is held against the one of the program, the robot's shape against what our own are made of, and no file can name
another one that is not of plain name in that folder.
"""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

from defusedxml.common import DefusedXmlException
from defusedxml.ElementTree import ParseError, iterparse

from rrp_sheets.devices.catalogue import CATALOGUE, Robot, load_robot, robot_in, robot_names
from rrp_sheets.diagnostics.catalogue import CODES
from rrp_sheets.errors import UnreadableFile

FOLDER = "robots"
_MOST_FILES = 40
_MOST_BYTES = 2_000_000  # of one file; ours have at most 40,000
_MOST_TEXT = 2_000  # letters of one text in a table
_LARGEST = 1e7  # of any number
_DEEPEST, _MOST_ELEMENTS, _MOST_LINES = 12, 20_000, 100_000
_OPTIONAL = ("languages", "touch", "posture_leans", "posture_ways", "groups", "postures")
_NAMED = ("groups", "postures", "posture_leans", "posture_ways", "languages")  # their keys are names of their own
_PLAIN = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,63}\.(?:urdf|obj|toml)")
_ATTRIBUTE = re.compile(r"[\w.+ -]{0,200}", re.ASCII)
_SHAPE = {
    "robot", "link", "inertial", "origin", "mass", "inertia", "visual", "collision", "geometry", "box", "cylinder",
    "sphere", "capsule", "mesh", "material", "color", "joint", "parent", "child", "axis", "limit", "dynamics",
}  # fmt: skip
_NUMBER = r"-?\d{1,12}(?:\.\d{1,12})?(?:e-?\d{1,2})?"
_CORNER = r"\d{1,6}(?:/\d{0,6}){0,2}"
_OBJ_LINE = re.compile(rf"(?:#.*|(?:v|vn)(?: {_NUMBER}){{3}}|vt(?: {_NUMBER}){{2,3}}|f(?: {_CORNER}){{3,4}}|)\r?")


class _Refused(Exception):
    """Why a catalogue is not used; the text goes on after the name of its folder."""


def own_robot(folder: Path, name: str) -> Robot | None:
    """The robot of that name whose catalogue stands beside a workbook; None when there is none.

    Args:
        folder: where the workbook's files are.
        name: as the Protocol says it.

    Raises:
        UnreadableFile: when there is one and it cannot be trusted.
    """
    if not name.replace("_", "").isalnum() or not (folder / FOLDER / name / CATALOGUE).is_file():
        return None
    place = folder / FOLDER / name
    try:
        files = _files(place)
        return _judged(place, name, tuple((p.name, p.stat().st_mtime_ns, p.stat().st_size) for p in files))
    except (_Refused, OSError) as problem:
        why = problem.strerror or "it cannot be read" if isinstance(problem, OSError) else str(problem)
        entry = CODES["FILE019"]
        message = entry.message.format(name=f"{FOLDER}/{name}", why=why)
        raise UnreadableFile("FILE019", message, entry.remedy) from None


def files_of(robot: Robot) -> list[Path]:
    """The files of a robot that a run needs: its tables, its shape, and the solids which that is made of."""
    folder, shape = robot.folder, robot.folder / str(robot.data["robot"]["urdf"])
    tables = [p for p in folder.glob("*.toml") if p.is_file()]
    return sorted([*tables, shape, *(folder / name for name in sorted(_meshes(shape)))])


def _files(place: Path) -> list[Path]:
    """What there is in the folder."""
    found = sorted(place.iterdir())[: _MOST_FILES + 1]
    if len(found) > _MOST_FILES:
        raise _Refused(f"it has more than {_MOST_FILES} files")
    for path in found:
        if path.is_symlink() or not path.is_file():
            if path.is_dir() and not path.is_symlink():
                continue  # examples, say: nothing reads them
            raise _Refused(f"“{path.name}” is a link and no file")
        if path.stat().st_size > _MOST_BYTES:
            raise _Refused(f"“{path.name}” is larger than {_MOST_BYTES // 1_000_000} MB")
    return [p for p in found if p.is_file()]


@lru_cache(maxsize=4)
def _judged(place: Path, name: str, stamp: tuple[tuple[str, int, int], ...]) -> Robot:
    """The robot, after everything in its folder was looked at."""
    model = load_robot(name if name in robot_names() else "nao")
    for path in sorted(place.glob("*.toml")):
        _judge_values(_table(path), path.name)
    data = _table(place / CATALOGUE)
    _judge_likeness(data, model.data, "")
    if [j.get("name") for j in data["joints"]] != [j.name for j in model.joints.values()]:
        raise _Refused("its joints are other ones than those that can be simulated here")
    shape = str(data["robot"]["urdf"])
    if not _PLAIN.fullmatch(shape) or not (place / shape).is_file():
        raise _Refused(f"“{shape[:80]}” is no file of its folder")
    for mesh in sorted(_meshes(place / shape)):
        _judge_solid(place / mesh)
    try:
        return robot_in(place, name)
    except (KeyError, TypeError, ValueError, AttributeError, IndexError) as problem:
        raise _Refused(f"its tables do not fit together ({type(problem).__name__}: {problem})"[:200]) from None


def _table(path: Path) -> dict[str, Any]:
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError, ValueError) as problem:
        raise _Refused(f"“{path.name}” is no table ({str(problem)[:100]})") from None


def _judge_values(value: Any, where: str, depth: int = 0) -> None:
    """Texts and numbers of sensible size, and nothing else."""
    if depth > _DEEPEST:
        raise _Refused(f"“{where}” is nested too deeply")
    match value:
        case bool():
            return
        case int() | float():
            if not math.isfinite(value) or abs(value) > _LARGEST:
                raise _Refused(f"“{where}” has a number that no robot has")
        case str():
            if len(value) > _MOST_TEXT or any(not c.isprintable() and c not in "\n\t" for c in value):
                raise _Refused(f"“{where}” has a text that cannot be shown")
        case list():
            for entry in value:
                _judge_values(entry, where, depth + 1)
        case dict():
            for k, entry in value.items():
                _judge_values(k, where, depth + 1)
                _judge_values(entry, where, depth + 1)
        case _:
            raise _Refused(f"“{where}” has a date, which no robot has")


def _judge_likeness(found: Any, model: Any, where: str) -> None:
    """Whether a table has the tables, and values of the kinds, that the one of the program has."""
    if _kind(found) is not _kind(model):
        raise _Refused(f"“{where or CATALOGUE}” is not what it is in the program's own catalogue")
    if isinstance(model, Mapping):
        named = where in _NAMED
        for k, part in model.items():
            at = f"{where}.{k}" if where else k
            if k in found:
                _judge_likeness(found[k], part, at)
            elif not named and not (not where and k in _OPTIONAL):
                raise _Refused(f"“{at}” is missing; it was perhaps made for another version of the program")
    elif isinstance(model, Sequence) and not isinstance(model, str):
        kinds = {_kind(part) for part in model}
        if len(kinds) == 1 and {_kind(part) for part in found} - kinds:
            raise _Refused(f"“{where}” is not what it is in the program's own catalogue")


def _kind(value: Any) -> type:
    return float if isinstance(value, (int, float)) and not isinstance(value, bool) else type(value)


def _meshes(shape: Path) -> set[str]:
    """The files of solids that a robot's shape names; refuses a shape that is made of anything but plain parts."""
    meshes: set[str] = set()
    depth = count = 0
    try:
        for event, element in iterparse(shape, ("start", "end"), forbid_dtd=True):
            depth += 1 if event == "start" else -1
            count += event == "start"
            if depth > _DEEPEST or count > _MOST_ELEMENTS:
                raise _Refused(f"“{shape.name}” is too large")
            if event != "start":
                continue
            if element.tag not in _SHAPE:
                raise _Refused(f"“{shape.name}” has a part “{str(element.tag)[:40]}”, which is not taken")
            for name, value in element.attrib.items():
                if name == "filename" and element.tag == "mesh":
                    if not _PLAIN.fullmatch(value) or not value.endswith(".obj"):
                        raise _Refused(f"“{shape.name}” names the file “{value[:80]}”, which is not in its folder")
                    meshes.add(value)
                elif name == "filename" or not _ATTRIBUTE.fullmatch(value):
                    raise _Refused(f"“{shape.name}” has a value that is not taken: {value[:40]!r}")
    except (ParseError, DefusedXmlException, UnicodeDecodeError, LookupError, ValueError) as problem:
        raise _Refused(f"“{shape.name}” cannot be read ({type(problem).__name__})") from None
    return meshes


def _judge_solid(path: Path) -> None:
    """Corners and faces with numbers, and no word about other files."""
    try:
        lines = path.read_text(encoding="ascii").split("\n")
    except (OSError, UnicodeDecodeError):
        raise _Refused(f"“{path.name}” is missing, or no text") from None
    if len(lines) > _MOST_LINES:
        raise _Refused(f"“{path.name}” is too large")
    corners = sum(line.startswith("v ") for line in lines)
    normals = sum(line.startswith("vn ") for line in lines)
    for line in lines:
        if not _OBJ_LINE.fullmatch(line):
            raise _Refused(f"“{path.name}” has a line that is not taken: {line[:40]!r}")
        for word in line.split()[1:] if line.startswith("f") else ():
            corner, *rest = word.split("/")
            if not 1 <= int(corner) <= corners or any(r and not 1 <= int(r) <= max(normals, corners) for r in rest):
                raise _Refused(f"“{path.name}” has a face with a corner that there is not")
