"""Reads and checks a robot's catalogue that comes with a workbook, in `robots/<name>/` beside it, as in a bundle.

It may come from anyone, and the simulator's libraries read some of its files. So it is checked before anything uses it:
its tables are compared with those of the program's own robot, its URDF may only have our own's elements, and
its files can only name files with plain names in that folder.
"""

from __future__ import annotations

import itertools
import math
import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from defusedxml.common import DefusedXmlException
from defusedxml.ElementTree import ParseError, iterparse

from rrp_sheets.diagnostics.report import Report, UnreadableWorkbook
from rrp_sheets.model.names import key
from rrp_sheets.robots import Robot, Setting, load_robot, robot_names
from rrp_sheets.robots.catalogue import CATALOGUE, REST_POSTURE, robot_in
from rrp_sheets.robots.trajectory import pitch_limits
from rrp_sheets.texts import N_, MessageError

FOLDER = "robots"
_MOST_FILES = 40
_MOST_BYTES = 2_000_000  # of one file; ours have at most 40,000
_MOST_TEXT = 2_000  # letters of one text in a table
_LARGEST = 1e7  # of any number
_DEEPEST = 12  # tables within tables
_OPTIONAL = ("body", "languages", "touch", "posture_leans", "posture_ways", "groups", "postures")
_NAMED = ("groups", "postures", "posture_leans", "posture_ways", "languages")  # their keys are names of their own


def own_robot(folder: Path, name: str) -> Robot | None:
    """Return the robot of that name beside a workbook, if any; raises UnreadableFile if it fails the checks."""
    if not name.replace("_", "").isalnum() or not (folder / FOLDER / name / CATALOGUE).is_file():
        return None
    place = folder / FOLDER / name
    try:
        files = _files(place)
        return _judged(place, name, tuple((p.name, p.stat().st_mtime_ns, p.stat().st_size) for p in files))
    except (CatalogueError, OSError) as problem:
        why = problem.args[0] if isinstance(problem, CatalogueError) else problem.strerror or N_("it cannot be read")
        raise UnreadableWorkbook(Report().add("FILE019", None, name=f"{FOLDER}/{name}", why=why)) from None


def files_of(robot: Robot) -> list[Path]:
    """The files of a robot that a run needs: its tables, its shape, and the solids which that is made of."""
    folder, shape = robot.folder, robot.folder / str(robot.data["robot"]["urdf"])
    tables = [p for p in folder.glob("*.toml") if p.is_file()]
    return sorted([*tables, shape, *(folder / name for name in sorted(read_shape(shape).meshes))])


def _files(place: Path) -> list[Path]:
    found = sorted(place.iterdir())[: _MOST_FILES + 1]
    if len(found) > _MOST_FILES:
        raise CatalogueError("it has more than {most} files", most=_MOST_FILES)
    for path in found:
        if path.is_symlink() or not path.is_file():
            if path.is_dir() and not path.is_symlink():
                continue  # examples, say: nothing reads them
            raise CatalogueError("“{file}” is a link and no file", file=path.name)
        if path.stat().st_size > _MOST_BYTES:
            raise CatalogueError("“{file}” is larger than {most} MB", file=path.name, most=_MOST_BYTES // 1_000_000)
    return [p for p in found if p.is_file()]


@lru_cache(maxsize=4)
def _judged(place: Path, name: str, stamp: tuple[tuple[str, int, int], ...]) -> Robot:
    model = load_robot(name if name in robot_names() else "nao")
    tables = {path.name: _table(path) for path in sorted(place.glob("*.toml"))}
    for file, table in tables.items():
        _judge_values(table, file)
    data = tables[CATALOGUE]
    _judge_likeness(data, model.data, "")
    if [j.get("name") for j in data["joints"]] != [j.name for j in model.joints.values()]:
        raise CatalogueError("its joints are other ones than those that can be simulated here")
    shape = str(data["robot"]["urdf"])
    if not PLAIN.fullmatch(shape) or not (place / shape).is_file():
        raise CatalogueError("“{file}” is not a file of its folder", file=shape[:80])
    body = read_shape(place / shape)
    judge_solids(place, body.meshes)
    try:
        robot = robot_in(place, name, data)
        judge_limits(robot, body, model, _shape_of(model.name))
    except (KeyError, TypeError, ValueError, AttributeError, IndexError) as problem:
        told = f"{type(problem).__name__}: {problem}"[:160]
        raise CatalogueError("its tables do not fit together ({problem})", problem=told) from None
    return robot


@lru_cache(maxsize=4)
def _shape_of(name: str) -> Shape:
    model = load_robot(name)
    return read_shape(model.folder / str(model.data["robot"]["urdf"]))


def _table(path: Path) -> dict[str, Any]:
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError, ValueError) as problem:
        raise CatalogueError(
            "“{file}” is not a table ({problem})", file=path.name, problem=str(problem)[:100]
        ) from None


def _judge_values(value: Any, where: str, depth: int = 0) -> None:
    """Raise CatalogueError unless a value consists of texts and numbers of sensible size, and nothing else."""
    if depth > _DEEPEST:
        raise CatalogueError("“{file}” is nested too deeply", file=where)
    match value:
        case bool():
            return
        case int() | float():
            if not math.isfinite(value) or abs(value) > _LARGEST:
                raise CatalogueError("“{file}” has a number that no robot has", file=where)
        case str():
            if len(value) > _MOST_TEXT or any(not c.isprintable() and c not in "\n\t" for c in value):
                raise CatalogueError("“{file}” has a text that cannot be shown", file=where)
        case list():
            for entry in value:
                _judge_values(entry, where, depth + 1)
        case dict():
            for k, entry in value.items():
                _judge_values(k, where, depth + 1)
                _judge_values(entry, where, depth + 1)
        case _:
            raise CatalogueError("“{file}” has a date, which no robot has", file=where)


def _judge_likeness(found: Any, model: Any, where: str) -> None:
    """Raise CatalogueError unless a table has the tables, and values of the kinds, that the program's own has."""
    if _kind(found) is not _kind(model):
        raise CatalogueError("“{file}” is not what it is in the program's own catalogue", file=where or CATALOGUE)
    if isinstance(model, Mapping):
        named = where in _NAMED
        for k, part in model.items():
            at = f"{where}.{k}" if where else k
            if k in found:
                _judge_likeness(found[k], part, at)
            elif not named and (where or k not in _OPTIONAL):
                raise CatalogueError("“{file}” is missing; it was perhaps made for another version of the program",
                                     file=at)  # fmt: skip
    elif isinstance(model, Sequence) and not isinstance(model, str):
        kinds = {_kind(part) for part in model}
        if len(kinds) == 1 and {_kind(part) for part in found} - kinds:
            raise CatalogueError("“{file}” is not what it is in the program's own catalogue", file=where)


def _kind(value: Any) -> type:
    return float if isinstance(value, (int, float)) and not isinstance(value, bool) else type(value)


_SAME = ("engine", "knowledge", "perception", "resources", "resources_by", "unit", "names_of", "record")
"""The fields of a device that must equal those of the built-in robot: its resources and how it gets its values."""
_FASTEST = 30.0  # rad/s, of a joint of a robot that the program does not know
_MOST_SHOWN = 10  # things that a scene has for one sensor
_NEAR = 1e-3  # rad: our own postures are rounded to four places
_LONGEST, _TEMPOS = 600.0, (20.0, 400.0)  # s or beats of a gesture; beats a minute
_PLACES = ("camera", "sonar", "legs", "arm", "touch")  # tables with places (m) and angles (rad)
_FARTHEST = 3.0  # m
_WIDE_VIEW = (0.1, 3.0)  # rad, of a camera
_CONE = (1.0, 170.0)  # degrees, of a sonar
_HEIGHT = (0.1, 3.0)  # m


def judge_limits(robot: Robot, shape: Shape, model: Robot, model_shape: Shape) -> None:
    """Raise CatalogueError unless a robot stays within the limits of `model`, a robot of the program.

    A robot of another name has limits of its own: those of the joints in its shape, which no table may exceed. Where
    these are as in the shape of `model`, its limits are those of `model`, whose shape has some more room.
    """
    known = robot.name == model.name
    _judge_shape(shape, model_shape, str(robot.data["robot"]["urdf"]), known=known)
    limits, usual = ({joint.name: joint.limits for joint in s.joints} for s in (shape, model_shape))
    for joint in model.joints.values():
        own = robot.joints[key(joint.name)]
        if (own.chain, own.unit) != (joint.chain, joint.unit):
            raise CatalogueError("joint {joint} has another chain or unit than in the program", joint=own.name)
        unit = f" {joint.unit}" if joint.unit else ""
        mine = {"lower": joint.lower, "upper": joint.upper, "velocity": joint.max_velocity}
        if not known:
            changed = limits[joint.name].items() - usual[joint.name].items()
            mine |= dict(changed)
        low, high, fastest = mine["lower"], mine["upper"], min(mine["velocity"], _FASTEST)
        within = _within if known else _within_shape
        _judge_order(own.name, own.lower, own.upper, unit, CATALOGUE)
        within(own.name, "lower", own.lower, low, high, unit)
        within(own.name, "upper", own.upper, low, high, unit)
        within(own.name, "max_velocity", own.max_velocity, 1e-3, fastest, f"{unit}/s")
    _judge_head(robot, model, known=known)
    if robot.data["chains"] != model.data["chains"]:
        raise CatalogueError("its chains are other ones than those of {robot}", robot=model.title)
    for name, members in model.groups.items():
        if robot.groups.get(name) != members:
            raise CatalogueError("its group {name} has other joints than that of {robot}", name=name, robot=model.title)
    _judge_devices(robot, model)
    _judge_postures(robot)
    for gesture in (*robot.motions.values(), *robot.talking):
        name = gesture.name[:80]
        times = [0.0, *(frame.at for frame in gesture.frames)]
        if len(times) < 2 or any(b <= a for a, b in itertools.pairwise(times)) or times[-1] > _LONGEST:
            raise CatalogueError("the times of the gesture {name} do not rise, or go beyond {longest} s",
                                 name=name, longest=f"{_LONGEST:g}")  # fmt: skip
        if gesture.tempo and not _TEMPOS[0] <= gesture.tempo <= _TEMPOS[1]:
            raise CatalogueError("the gesture {name} has a tempo that no music has", name=name)
    _judge_places(robot.data)


def _within(joint: str, what: str, value: float, low: float, high: float, unit: str = "") -> None:
    if not low <= value <= high:
        raise CatalogueError(
            "joint {joint} has {name} {value}{unit}; this catalogue may only narrow it, from {low} to {high}",
            joint=joint, name=what, value=f"{value:g}", unit=unit, low=f"{low:g}", high=f"{high:g}",
        )  # fmt: skip


def _within_shape(joint: str, what: str, value: float, low: float, high: float, unit: str = "") -> None:
    if not low <= value <= high:
        raise CatalogueError(
            "joint {joint} has {name} {value}{unit}; the limits of the joint in its shape allow {low} to {high}{unit}",
            joint=joint, name=what, value=f"{value:g}", unit=unit, low=f"{low:g}", high=f"{high:g}",
        )  # fmt: skip


def _judge_order(joint: str, lower: float, upper: float, unit: str, file: str) -> None:
    if lower > upper:  # the simulator takes that for no limits at all
        raise CatalogueError("joint {joint} has upper {upper}{unit} below lower {lower}{unit} in “{file}”",
                             joint=joint, upper=f"{upper:g}", lower=f"{lower:g}", unit=unit, file=file)  # fmt: skip


def _judge_shape(shape: Shape, model: Shape, file: str, *, known: bool) -> None:
    own = {joint.name: joint for joint in shape.joints}
    for joint in model.joints:
        mine = own.pop(joint.name, None)
        if mine is None or mine.fixed != joint.fixed:
            raise CatalogueError("joint {joint} is missing in its shape, or is placed elsewhere", joint=joint.name)
        for name, limit in joint.limits.items():
            if name not in mine.limits:
                raise CatalogueError("joint {joint} has no limit “{name}” in its shape", joint=joint.name, name=name)
            if known:
                is_end = name in ("lower", "upper")
                low, high = (joint.limits["lower"], joint.limits["upper"]) if is_end else (0.0, limit)
                _within(joint.name, name, mine.limits[name], low, high)
        _judge_order(joint.name, mine.limits.get("lower", 0.0), mine.limits.get("upper", 0.0), " rad", file)
    if own:
        raise CatalogueError("joint {joint} of its shape cannot be simulated here", joint=next(iter(own)))
    if missing := set(model.links) - set(shape.links):
        raise CatalogueError("the link {name} is missing in its shape", name=min(missing))


def _judge_head(robot: Robot, model: Robot, *, known: bool) -> None:
    own, other = robot.data.get("head_pitch_by_yaw"), model.data.get("head_pitch_by_yaw")
    if own is None or other is None:
        return
    yaws = own["yaw"]
    even = 2 <= len(yaws) == len(own["lower"]) == len(own["upper"])
    if not even or any(a >= b for a, b in itertools.pairwise(yaws)):
        raise CatalogueError("its table {name} does not rise, or has columns of different lengths",
                             name="head_pitch_by_yaw")  # fmt: skip
    for yaw in sorted({*yaws, *other["yaw"]}) if known else ():
        (low, high), (own_low, own_high) = pitch_limits(other, yaw), pitch_limits(own, yaw)
        _within("HeadPitch", "lower", own_low, low - 1e-9, high)
        _within("HeadPitch", "upper", own_high, low, high + 1e-9)


def _judge_devices(robot: Robot, model: Robot) -> None:
    for kind in ("sensor", "actuator"):
        entries = {entry["name"]: entry for entry in model.data[kind]}
        for own in robot.data[kind]:
            name = str(own["name"])[:80]
            other = entries.get(own["name"])
            if other is None or any(own.get(k) != other.get(k) for k in _SAME):
                raise CatalogueError("the device {name} is not what it is in the program", name=name)
            if len(own.get("shows", ())) > _MOST_SHOWN:
                raise CatalogueError("the device {name} shows too many things", name=name)
    for found in robot.names.values():
        settings = model.devices[key(found.type.name)].settings
        for k, setting in found.type.settings.items():
            if k in settings and not _narrower(setting, settings[k], found.preset.get(k)):
                raise CatalogueError("the setting {name} of {device} is wider than in the program",
                                     name=setting.name[:80], device=found.type.name)  # fmt: skip


def _narrower(own: Setting, model: Setting, preset: Any) -> bool:
    low, high = -math.inf if model.lower is None else model.lower, math.inf if model.upper is None else model.upper
    limits = -math.inf if own.lower is None else own.lower, math.inf if own.upper is None else own.upper
    values = [v for v in (own.default, preset) if isinstance(v, (int, float)) and not isinstance(v, bool)]
    return own.kind == model.kind and all(low <= v <= high for v in (*limits, *values))


def _judge_postures(robot: Robot) -> None:
    postures: Mapping[str, Mapping[str, float]] = robot.data.get("postures", {})
    start = str(robot.data["robot"]["start_posture"])
    for name in (start, REST_POSTURE):
        if lacking := {j.name for j in robot.joints.values()} - set(postures.get(name, ())):
            raise CatalogueError("the posture {name} says nothing about {joint}", name=name[:80], joint=min(lacking))
    for name, angles in postures.items():
        for named, angle in angles.items():
            joint = robot.joints.get(key(named))
            if joint is None:
                raise CatalogueError("the posture {name} has a joint {joint} that there is not",
                                     name=name, joint=named[:80])  # fmt: skip
            if not joint.lower - _NEAR <= angle <= joint.upper + _NEAR:
                raise CatalogueError("the posture {name} brings {joint} to {value}, outside of its limits",
                        name=name, joint=joint.name, value=f"{angle:g}")  # fmt: skip
    ways: Mapping[str, str] = robot.data.get("posture_ways", {})
    for name in ways:
        path = [name]
        while path[-1] in ways and len(path) <= len(ways):
            path.append(ways[path[-1]])
        if path[-1] in ways or not set(path) <= set(postures):
            raise CatalogueError("the way to the posture {name} has no beginning", name=name[:80])
    if any(abs(lean) > math.pi / 2 + 0.1 for lean in robot.data.get("posture_leans", {}).values()):
        raise CatalogueError("a posture leans farther than lying down")


def _judge_places(data: Mapping[str, Any]) -> None:
    """Raise CatalogueError unless sizes of the robot's parts are plausible, and their places have three coordinates."""
    camera = data["camera"]["top"]
    right = _HEIGHT[0] <= data["robot"]["height"] <= _HEIGHT[1]
    right &= all(_WIDE_VIEW[0] <= camera[view] <= _WIDE_VIEW[1] for view in ("hfov", "vfov"))
    right &= all(_CONE[0] <= beam["cone"] <= _CONE[1] for beam in data["sonar"].values())
    right &= all(0.01 <= data["legs"][bone] <= 1.0 for bone in ("thigh", "tibia"))
    right &= all(0.001 <= pad["radius"] <= 0.5 for pad in data.get("touch", {}).get("pads", ()))
    if not right or not all(_near(data.get(name)) for name in _PLACES):
        raise CatalogueError("its height, or a place or size of one of its parts, is one that no robot has")


def _near(value: Any) -> bool:
    if isinstance(value, Mapping):
        return all(_near(v) for k, v in value.items() if k != "cone")
    if isinstance(value, list):
        place = bool(value) and all(isinstance(part, (int, float)) for part in value)
        return all(map(_near, value)) and (not place or len(value) == 3)
    return not isinstance(value, (int, float)) or abs(value) <= _FARTHEST


_DEEPEST_ELEMENT, _MOST_ELEMENTS, _MOST_LINES = 12, 4_000, 20_000  # ours: 6, 748 and 513
_MOST_SOLIDS = 500_000  # lines of all solids together, each counted as often as the shape uses it
PLAIN = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,63}\.(?:urdf|obj|toml)")
_TEXT = re.compile(r"[\w.+ -]{0,200}", re.ASCII)
_FIGURE = re.compile(r"[+-]?(?:\d{1,12}(?:\.\d{0,15})?|\.\d{1,15})(?:[eE][+-]?\d{1,2})?", re.ASCII)
_PARENTS = {
    "robot": {""}, "link": {"robot"}, "joint": {"robot"}, "inertial": {"link"}, "visual": {"link"},
    "collision": {"link"}, "origin": {"inertial", "visual", "collision", "joint"}, "mass": {"inertial"},
    "inertia": {"inertial"}, "geometry": {"visual", "collision"}, "box": {"geometry"}, "cylinder": {"geometry"},
    "sphere": {"geometry"}, "capsule": {"geometry"}, "mesh": {"geometry"}, "material": {"robot", "visual"},
    "color": {"material"}, "parent": {"joint"}, "child": {"joint"}, "axis": {"joint"}, "limit": {"joint"},
    "dynamics": {"joint"},
}  # fmt: skip
"""Every part that is taken, with those that it may stand in."""
_OFTEN = {"link", "joint", "visual", "collision", "material"}  # the others stand in a part only once
_LENGTH, _AROUND = (0.0001, 3.0), (-2 * math.pi, 2 * math.pi)
_NUMBERS = {
    ("origin", "xyz"): (3, (-3.0, 3.0), "m"), ("origin", "rpy"): (3, _AROUND, "rad"),
    ("mass", "value"): (1, (0.0001, 50.0), "kg"),
    **{("inertia", f"i{a}{a}"): (1, (1e-7, 10.0), "kg m²") for a in "xyz"},
    **{("inertia", f"i{a}"): (1, (-10.0, 10.0), "kg m²") for a in ("xy", "xz", "yz")},
    ("box", "size"): (3, _LENGTH, "m"), ("cylinder", "radius"): (1, _LENGTH, "m"),
    ("cylinder", "length"): (1, _LENGTH, "m"), ("sphere", "radius"): (1, _LENGTH, "m"),
    ("capsule", "radius"): (1, _LENGTH, "m"), ("capsule", "length"): (1, _LENGTH, "m"),
    ("mesh", "scale"): (3, _LENGTH, "m"), ("color", "rgba"): (4, (0.0, 1.0), ""), ("axis", "xyz"): (3, (-1.0, 1.0), ""),
    ("limit", "lower"): (1, _AROUND, "rad"), ("limit", "upper"): (1, _AROUND, "rad"),
    ("limit", "effort"): (1, (0.0, 100.0), "N m"), ("limit", "velocity"): (1, (0.0, 50.0), "rad/s"),
    ("dynamics", "damping"): (1, (0.0, 100.0), ""), ("dynamics", "friction"): (1, (0.0, 100.0), ""),
}  # fmt: skip
"""The numbers of a part: how many, between which, in what unit. Every other attribute is a name."""
_LARGEST_CORNER = 10.0  # m, of a solid before it is scaled
_NUMBER = r"-?\d{1,12}(?:\.\d{1,12})?(?:e-?\d{1,2})?"
_CORNER = r"\d{1,6}(?:/\d{0,6}){0,2}"
_OBJ_LINE = re.compile(rf"(?:#.*|(?:v|vn)(?: {_NUMBER}){{3}}|vt(?: {_NUMBER}){{2,3}}|f(?: {_CORNER}){{3,4}}|)\r?")


class CatalogueError(MessageError):
    """Raised when a catalogue is not used; its message follows the name of the catalogue's folder."""


@dataclass(frozen=True)
class ShapeJoint:
    """A joint of a URDF."""

    name: str
    # what no robot of the same name may change: type, parent, child, origin (m, rad) and axis
    fixed: tuple[object, ...]
    # `lower` and `upper` (rad), `effort` (N m), `velocity` (rad/s), as far as they are given
    limits: Mapping[str, float]


@dataclass(frozen=True)
class Shape:
    """A URDF that may be used."""

    links: tuple[str, ...]
    joints: tuple[ShapeJoint, ...]  # in the file's order
    meshes: Mapping[str, int]  # the files of solids, each with how often it is used


def read_shape(path: Path) -> Shape:
    """Read a URDF; raises CatalogueError if it has parts, numbers or files that are not taken, or no joints."""
    root = _tree(path)
    meshes: dict[str, int] = {}
    for mesh in root.iter("mesh"):
        meshes[mesh.get("filename", "")] = meshes.get(mesh.get("filename", ""), 0) + 1
    links = tuple(link.get("name", "") for link in root.findall("link"))
    joints = tuple(_joint(joint) for joint in root.findall("joint"))
    if not links or not joints:
        raise CatalogueError("“{file}” has no links and joints: there is no robot in it", file=path.name)
    for names in (links, [joint.name for joint in joints]):
        if len(set(names)) != len(names):
            raise CatalogueError("“{file}” has two parts of one name", file=path.name)
    coloured = {m.get("name") for m in root.findall("material") if len(m)}
    used = [m for visual in root.iter("visual") for m in visual.findall("material") if not len(m)]
    shapes = [part.find("geometry") for part in (*root.iter("visual"), *root.iter("collision"))]
    if any(s is None or len(s) != 1 for s in shapes) or any(m.get("name") not in coloured for m in used):
        raise CatalogueError("“{file}” has a part without a shape, or without its colour", file=path.name)
    return Shape(links, joints, meshes)


def judge_solids(folder: Path, meshes: Mapping[str, int]) -> None:
    """Raise CatalogueError unless every solid is corners and faces, and all of them together are not too large."""
    lines = sum(_judge_solid(folder / name) * often for name, often in sorted(meshes.items()))
    if lines > _MOST_SOLIDS:
        raise CatalogueError("its solids have {n} lines together; at most {most} are taken", n=lines, most=_MOST_SOLIDS)


def _tree(path: Path) -> Any:
    above: list[Any] = []
    root = None
    count = 0
    try:
        for event, element in iterparse(path, ("start", "end"), forbid_dtd=True):
            if event == "end":
                above.pop()
                continue
            if not above:
                root = element
            count += 1
            if len(above) >= _DEEPEST_ELEMENT or count > _MOST_ELEMENTS:
                raise CatalogueError("“{file}” is too large", file=path.name)
            _judge_part(element, above[-1] if above else None, path.name)
            above.append(element)
    except (ParseError, DefusedXmlException, UnicodeDecodeError, LookupError, ValueError) as problem:
        kind = type(problem).__name__
        raise CatalogueError("“{file}” cannot be read ({kind_of_error})", file=path.name, kind_of_error=kind) from None
    return root


def _judge_part(element: Any, above: Any, file: str) -> None:
    tag = str(element.tag)
    if (above.tag if above is not None else "") not in _PARENTS.get(tag, ()):
        raise CatalogueError("“{file}” has a part “{tag}” that is not taken there", file=file, tag=tag[:40])
    if tag not in _OFTEN and above is not None and sum(part.tag == tag for part in above) > 1:
        raise CatalogueError("“{file}” has a part “{tag}” twice in one place", file=file, tag=tag)
    for name, value in element.attrib.items():
        if tag == "mesh" and name == "filename":
            if not PLAIN.fullmatch(value) or not value.endswith(".obj"):
                raise CatalogueError("“{file}” names the file “{name}”, which is not in its folder",
                                     file=file, name=value[:80])  # fmt: skip
        elif (tag, name) in _NUMBERS:
            _judge_numbers(value, tag, name, above, file)
        elif name == "filename" or not _TEXT.fullmatch(value):
            raise CatalogueError("“{file}” has a value that is not taken: {value}", file=file, value=repr(value[:40]))
    for part, name in _NUMBERS:
        optional = part in ("origin", "dynamics", "limit") or name in ("scale", "ixy", "ixz", "iyz")
        if part == tag and not optional and name not in element.attrib:
            raise CatalogueError("“{file}” has a part “{tag}” without {name}", file=file, tag=tag, name=name)


def _judge_numbers(value: str, tag: str, name: str, above: Any, file: str) -> None:
    count, (low, high), unit = _NUMBERS[tag, name]
    words = value.split()
    if len(words) == count and all(_FIGURE.fullmatch(w) and low <= float(w) <= high for w in words):
        return
    said = {"name": f"{tag} {name}", "value": value[:40], "low": f"{low:g}", "high": f"{high:g}", "unit": unit}
    if above is not None and above.tag == "joint":
        joint = above.get("name", "")[:80]
        raise CatalogueError(
            "joint {joint} has {name} {value}; from {low} to {high} {unit} is possible", joint=joint, **said
        )
    raise CatalogueError("“{file}” has {name} {value}; from {low} to {high} {unit} is possible", file=file, **said)


def _joint(element: Any) -> ShapeJoint:
    def attribute(part: str, name: str, default: str = "") -> str:
        found = element.find(part)
        return default if found is None else str(found.get(name, default))

    place = tuple(float(n) for name in ("xyz", "rpy") for n in attribute("origin", name, "0 0 0").split())
    axis = tuple(float(n) for n in attribute("axis", "xyz", "1 0 0").split())
    limit = element.find("limit")
    limits = {} if limit is None else {str(k): float(v) for k, v in limit.attrib.items() if ("limit", k) in _NUMBERS}
    links = attribute("parent", "link"), attribute("child", "link")
    return ShapeJoint(element.get("name", ""), (element.get("type", ""), *links, place, axis), limits)


def _judge_solid(path: Path) -> int:
    """Return the number of lines of a solid; raises CatalogueError for any line that is no geometry or comment."""
    try:
        lines = path.read_text(encoding="ascii").split("\n")
    except (OSError, UnicodeDecodeError):
        raise CatalogueError("“{file}” is missing, or no text", file=path.name) from None
    if len(lines) > _MOST_LINES:
        raise CatalogueError("“{file}” is too large", file=path.name)
    corners = sum(line.startswith("v ") for line in lines)
    normals = sum(line.startswith("vn ") for line in lines)
    for line in lines:
        words, known = line.split()[1:], _OBJ_LINE.fullmatch(line)
        if not known or (line.startswith("v") and any(abs(float(word)) > _LARGEST_CORNER for word in words)):
            raise CatalogueError("“{file}” has a line that is not taken: {value}",
                                 file=path.name, value=repr(line[:40]))  # fmt: skip
        for word in words if line.startswith("f") else ():
            corner, *rest = word.split("/")
            if not 1 <= int(corner) <= corners or any(r and not 1 <= int(r) <= max(normals, corners) for r in rest):
                raise CatalogueError("“{file}” has a face with a corner that there is not", file=path.name)
    return len(lines)
