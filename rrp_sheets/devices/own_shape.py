"""Reads and checks the URDF, and the solids that it names, of a robot catalogue from outside.

The simulator's libraries read these files. So only parts and numbers that a robot has are taken, and no file may name
another one that does not lie beside it.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from defusedxml.common import DefusedXmlException
from defusedxml.ElementTree import ParseError, iterparse

from rrp_sheets.diagnostics.phrase import Phrase

_DEEPEST, _MOST_ELEMENTS, _MOST_LINES = 12, 4_000, 20_000  # ours: 6, 748 and 513
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


class CatalogueError(Exception):
    """Raised when a catalogue is not used; its Phrase follows the name of the catalogue's folder."""


@dataclass(frozen=True)
class ShapeJoint:
    """A joint of a URDF.

    Attributes:
        fixed: what no robot of the same name may change: type, parent, child, origin (m, rad) and axis.
        limits: `lower` and `upper` (rad), `effort` (N m), `velocity` (rad/s), as far as they are given.
    """

    name: str
    fixed: tuple[object, ...]
    limits: Mapping[str, float]


@dataclass(frozen=True)
class Shape:
    """A URDF that may be used.

    Attributes:
        links: their names.
        joints: in the file's order.
        meshes: the files of solids, each with how often it is used.
    """

    links: tuple[str, ...]
    joints: tuple[ShapeJoint, ...]
    meshes: Mapping[str, int]


def read_shape(path: Path) -> Shape:
    """Read a URDF.

    Raises:
        CatalogueError: it has parts, numbers or files that are not taken, or no joints.
    """
    root = _tree(path)
    meshes: dict[str, int] = {}
    for mesh in root.iter("mesh"):
        meshes[mesh.get("filename", "")] = meshes.get(mesh.get("filename", ""), 0) + 1
    links = tuple(link.get("name", "") for link in root.findall("link"))
    joints = tuple(_joint(joint) for joint in root.findall("joint"))
    if not links or not joints:
        raise CatalogueError(Phrase("“{file}” has no links and joints: there is no robot in it", file=path.name))
    for names in (links, [joint.name for joint in joints]):
        if len(set(names)) != len(names):
            raise CatalogueError(Phrase("“{file}” has two parts of one name", file=path.name))
    coloured = {m.get("name") for m in root.findall("material") if len(m)}
    used = [m for visual in root.iter("visual") for m in visual.findall("material") if not len(m)]
    shapes = [part.find("geometry") for part in (*root.iter("visual"), *root.iter("collision"))]
    if any(s is None or len(s) != 1 for s in shapes) or any(m.get("name") not in coloured for m in used):
        raise CatalogueError(Phrase("“{file}” has a part without a shape, or without its colour", file=path.name))
    return Shape(links, joints, meshes)


def judge_solids(folder: Path, meshes: Mapping[str, int]) -> None:
    """Raise CatalogueError unless every solid is corners and faces, and all of them together are not too large."""
    lines = sum(_judge_solid(folder / name) * often for name, often in sorted(meshes.items()))
    if lines > _MOST_SOLIDS:
        raise CatalogueError(
            Phrase("its solids have {n} lines together; at most {most} are taken", n=lines, most=_MOST_SOLIDS)
        )


def _tree(path: Path) -> Any:
    """Return the root of a URDF after checking every part and every number in it."""
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
            if len(above) >= _DEEPEST or count > _MOST_ELEMENTS:
                raise CatalogueError(Phrase("“{file}” is too large", file=path.name))
            _judge_part(element, above[-1] if above else None, path.name)
            above.append(element)
    except (ParseError, DefusedXmlException, UnicodeDecodeError, LookupError, ValueError) as problem:
        kind = type(problem).__name__
        raise CatalogueError(
            Phrase("“{file}” cannot be read ({kind_of_error})", file=path.name, kind_of_error=kind)
        ) from None
    return root


def _judge_part(element: Any, above: Any, file: str) -> None:
    tag = str(element.tag)
    if (above.tag if above is not None else "") not in _PARENTS.get(tag, ()):
        raise CatalogueError(Phrase("“{file}” has a part “{tag}” that is not taken there", file=file, tag=tag[:40]))
    if tag not in _OFTEN and above is not None and sum(part.tag == tag for part in above) > 1:
        raise CatalogueError(Phrase("“{file}” has a part “{tag}” twice in one place", file=file, tag=tag))
    for name, value in element.attrib.items():
        if tag == "mesh" and name == "filename":
            if not PLAIN.fullmatch(value) or not value.endswith(".obj"):
                raise CatalogueError(Phrase("“{file}” names the file “{name}”, which is not in its folder",
                                     file=file, name=value[:80]))  # fmt: skip
        elif (tag, name) in _NUMBERS:
            _judge_numbers(value, tag, name, above, file)
        elif name == "filename" or not _TEXT.fullmatch(value):
            raise CatalogueError(
                Phrase("“{file}” has a value that is not taken: {value}", file=file, value=repr(value[:40]))
            )
    for (part, name), _ in _NUMBERS.items():
        needed = part == tag and part not in ("origin", "dynamics", "limit") and name not in ("scale", *_MIXED)
        if needed and name not in element.attrib:
            raise CatalogueError(Phrase("“{file}” has a part “{tag}” without {name}", file=file, tag=tag, name=name))


_MIXED = ("ixy", "ixz", "iyz")


def _judge_numbers(value: str, tag: str, name: str, above: Any, file: str) -> None:
    count, (low, high), unit = _NUMBERS[tag, name]
    words = value.split()
    if len(words) == count and all(_FIGURE.fullmatch(w) and low <= float(w) <= high for w in words):
        return
    if above is not None and above.tag == "joint":
        raise CatalogueError(Phrase("joint {joint} has {name} {value}; from {low} to {high} {unit} is possible",
                             joint=above.get("name", "")[:80], name=f"{tag} {name}", value=value[:40], low=f"{low:g}",
                             high=f"{high:g}", unit=unit))  # fmt: skip
    raise CatalogueError(Phrase("“{file}” has {name} {value}; from {low} to {high} {unit} is possible", file=file,
                         name=f"{tag} {name}", value=value[:40], low=f"{low:g}", high=f"{high:g}",
                         unit=unit))  # fmt: skip


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
        raise CatalogueError(Phrase("“{file}” is missing, or no text", file=path.name)) from None
    if len(lines) > _MOST_LINES:
        raise CatalogueError(Phrase("“{file}” is too large", file=path.name))
    corners = sum(line.startswith("v ") for line in lines)
    normals = sum(line.startswith("vn ") for line in lines)
    for line in lines:
        if not _OBJ_LINE.fullmatch(line):
            raise CatalogueError(
                Phrase("“{file}” has a line that is not taken: {value}", file=path.name, value=repr(line[:40]))
            )
        words = line.split()
        if line.startswith("v") and any(abs(float(word)) > _LARGEST_CORNER for word in words[1:]):
            raise CatalogueError(
                Phrase("“{file}” has a line that is not taken: {value}", file=path.name, value=repr(line[:40]))
            )
        for word in words[1:] if line.startswith("f") else ():
            corner, *rest = word.split("/")
            if not 1 <= int(corner) <= corners or any(r and not 1 <= int(r) <= max(normals, corners) for r in rest):
                raise CatalogueError(Phrase("“{file}” has a face with a corner that there is not", file=path.name))
    return len(lines)
