"""Robot model for the browser: the robot's URDF and meshes as one JSON document (m, rad, colours 0 to 1)."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from functools import lru_cache
from pathlib import Path
from typing import Any

from rrp_sheets.errors import SheetsError
from rrp_sheets.model.names import key
from rrp_sheets.page_texts import json_in
from rrp_sheets.robots import Robot, load_robot
from rrp_sheets.scene.scene_words import BALL_SIZE
from rrp_sheets.sim.appearance import BACK, BALL_COLOURS, COLOURS, FRONT, HAIR, HEAD, NOSE, PEOPLE, RINGS, outline
from rrp_sheets.texts import N_

_GREY = (0.6, 0.6, 0.6)
_THUMBS = {"LThumbJoint": "LHand", "RThumbJoint": "RHand"}  # as the simulator does: the hand's motor moves both
_EYES = ("LeftEye", "RightEye")


def robot_model(robot: Robot) -> dict[str, Any]:
    """Return everything that a program needs to draw a robot; raises SheetsError when its files cannot be read.

    That is `links` with their visuals, `joints` with origin and axis, `meshes` as triangles with normals, `rest` (the
    joint angles of the start posture), `follow` (joints that have no angle of their own), `eyes` (the links that
    shine), `touch` (the middle of each zone that feels a touch, on its link, and its name for readers), `units` (of
    the fields that its sensors give, by key), `scene` (sizes and colours of the things beside it).
    """
    path = robot.folder / robot.data["robot"]["urdf"]
    try:
        root = ET.parse(path).getroot()
        colours = {m.get("name", ""): _colour(m) for m in root.iter("material") if m.find("color") is not None}
        links: list[dict[str, Any]] = [
            {"name": e.get("name", ""), "visuals": [_visual(v, colours) for v in e.findall("visual")]}
            for e in root.findall("link")
        ]
        used = {v["mesh"] for link in links for v in link["visuals"] if v["shape"] == "mesh"}
        meshes = {name: _mesh(robot.folder / f"{name}.obj") for name in sorted(used)}
    except (OSError, ET.ParseError, ValueError) as error:
        raise SheetsError(
            N_("The robot’s model {file} cannot be read: {why}", file=path.name, why=str(error)),
            N_("Install the program again."),
        ) from None
    joints = [_joint(e) for e in root.findall("joint")]
    names = {link["name"] for link in links}
    fields = [field for device in robot.devices.values() if device.payload for field in device.payload.fields]
    return {
        "name": robot.title, "height": robot.data["robot"]["height"],
        "links": links, "joints": joints, "meshes": meshes,
        "rest": dict(robot.data["postures"][robot.data["robot"]["start_posture"]]),
        "follow": {j["name"]: _THUMBS[j["name"]] for j in joints if j["name"] in _THUMBS},
        "eyes": [name for name in _EYES if name in names],
        "units": {key(field.name): field.unit for field in fields if field.unit},
        "touch": _touch(robot), "scene": {"ball": BALL_SIZE, "colours": {**COLOURS, **BALL_COLOURS}, "heads": _heads()},
    }  # fmt: skip


def _touch(robot: Robot) -> list[dict[str, Any]]:
    pads = robot.data.get("touch", {}).get("pads", [])
    zones = {zone: [pad for pad in pads if pad["zone"] == zone] for zone in robot.touch_zones}
    middles = {
        zone: [sum(c) / len(c) for c in zip(*(p["xyz"] for p in mine), strict=True)] for zone, mine in zones.items()
    }
    return [
        {"zone": zone, "label": N_(zone, msgctxt="value"), "link": mine[0]["link"], "xyz": middles[zone]}
        for zone, mine in zones.items() if mine
    ]  # fmt: skip


@lru_cache(maxsize=4)
def robot_json(name: str, language: str = "en") -> str:
    """Return the model of a robot of ours as JSON, in a language; made once. Raises as `robot_model`."""
    return json_in(robot_model(load_robot(name)), language)


def _heads() -> dict[str, Any]:
    """Return the shape of people's heads, and each drawn face's outline (half widths from below up) and colours."""
    heights = [-math.cos(math.pi * ring / RINGS) for ring in range(RINGS + 1)]
    return {
        "size": HEAD, "front": FRONT, "back": BACK, "nose": NOSE, "hair": HAIR,
        "faces": [
            {"outline": [round(outline(p, h), 4) for h in heights], "skin": p.skin, "hair": p.hair, "style": p.style}
            for p in PEOPLE
        ],
    }  # fmt: skip


@lru_cache(maxsize=16)
def face_picture(face: int) -> bytes:
    """Return a drawn face as a PNG file; empty without the simulator, or if there is no such face."""
    if not 0 <= face < len(PEOPLE):
        return b""
    try:
        from rrp_sheets.sim.portraits import drawn, png
    except ImportError:  # the simulator is not installed here
        return b""
    return png(drawn(face).picture)


def _visual(element: ET.Element, colours: dict[str, list[float]]) -> dict[str, Any]:
    geometry = element.find("geometry")
    shape = geometry[0] if geometry is not None and len(geometry) else None
    if shape is None:
        raise ValueError("a visual without a shape")
    material = element.find("material")
    colour = list(_GREY)
    if material is not None:
        colour = _colour(material) if material.find("color") is not None else colours[material.get("name", "")]
    visual: dict[str, Any] = {"shape": shape.tag, **_origin(element), "colour": colour}
    if shape.tag == "mesh":
        visual["mesh"] = Path(shape.get("filename", "")).stem
        visual["size"] = _numbers(shape.get("scale", "1 1 1"))
    elif shape.tag == "cylinder":
        visual["size"] = [float(shape.get("radius", "0")), float(shape.get("length", "0"))]
    elif shape.tag == "sphere":
        visual["size"] = [float(shape.get("radius", "0"))]
    elif shape.tag == "box":
        visual["size"] = _numbers(shape.get("size", ""))
    else:
        raise ValueError(f"an unknown shape, {shape.tag}")
    return visual


def _joint(element: ET.Element) -> dict[str, Any]:
    def of(tag: str, attribute: str, default: str = "") -> str:
        found = element.find(tag)
        return default if found is None else found.get(attribute, default)

    return {
        "name": element.get("name", ""), "fixed": element.get("type") == "fixed", "parent": of("parent", "link"),
        "child": of("child", "link"), **_origin(element), "axis": _numbers(of("axis", "xyz", "1 0 0")),
    }  # fmt: skip


def _origin(element: ET.Element) -> dict[str, list[float]]:
    origin = element.find("origin")
    given = {} if origin is None else origin.attrib
    return {name: _numbers(given.get(name, "0 0 0")) for name in ("xyz", "rpy")}


def _colour(material: ET.Element) -> list[float]:
    colour = material.find("color")
    return _numbers(colour.get("rgba", "") if colour is not None else "")[:3]


def _numbers(text: str) -> list[float]:
    return [float(word) for word in text.split()]


def _mesh(path: Path) -> dict[str, list[float] | list[int]]:
    """Read an .obj file whose points and normals have the same numbers, as our own generator writes it."""
    points: list[float] = []
    normals: list[float] = []
    faces: list[int] = []
    for line in path.read_text(encoding="utf-8").splitlines():
        kind, *words = line.split() or [""]
        if kind == "v":
            points += map(float, words)
        elif kind == "vn":
            normals += map(float, words)
        elif kind == "f":
            corners = [word.split("/") for word in words]
            if len(corners) != 3 or any(c[0] != c[-1] for c in corners):
                raise ValueError(f"{path.name} has a face that is no triangle with a normal for each point")
            faces += [int(c[0]) - 1 for c in corners]
    return {"points": points, "normals": normals, "faces": faces}
