"""Check that a robot catalogue from outside stays within the limits of the built-in robot of the same name.

It may narrow what a joint or a device can do, never widen it: whoever runs the workbook relies on the limits of the
robot that it names. Postures, gestures and texts may be its own, as far as they stay within these limits.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from typing import Any

from rrp_sheets.devices.catalogue import REST_POSTURE, Joint, Robot
from rrp_sheets.devices.device import Setting
from rrp_sheets.devices.gestures import Gesture
from rrp_sheets.devices.own_shape import CatalogueError, Shape
from rrp_sheets.diagnostics.phrase import Phrase
from rrp_sheets.model.names import key

_SAME = ("engine", "knowledge", "perception", "resources", "resources_by", "unit", "names_of", "record")
"""The fields of a device that must equal those of the built-in robot: its resources and how it gets its values."""
_WIDEST, _FASTEST = 2 * math.pi, 30.0  # rad and rad/s, of a joint of a robot that the program does not know
_MOST_SHOWN = 10  # things that a scene has for one sensor
_NEAR = 1e-3  # rad: our own postures are rounded to four places
_LONGEST, _TEMPOS = 600.0, (20.0, 400.0)  # s or beats of a gesture; beats a minute
_PLACES = ("camera", "sonar", "legs", "arm", "touch")  # tables with places (m) and angles (rad)
_FARTHEST = 3.0  # m
_WIDE_VIEW = (0.1, 3.0)  # rad, of a camera
_CONE = (1.0, 170.0)  # degrees, of a sonar
_HEIGHT = (0.1, 3.0)  # m


def judge_limits(robot: Robot, shape: Shape, model: Robot, model_shape: Shape) -> None:
    """Raise CatalogueError unless a robot stays within the limits of another one.

    Args:
        robot: the stranger's.
        shape: its shape.
        model: the program's own robot that it is held against; of another name, only its parts count, not its limits.
        model_shape: that one's shape.
    """
    known = robot.name == model.name
    for joint in model.joints.values():
        own = robot.joints[key(joint.name)]
        if (own.chain, own.unit) != (joint.chain, joint.unit):
            raise CatalogueError(Phrase("joint {joint} has another chain or unit than in the program", joint=own.name))
        _judge_joint(own, joint, known=known)
    _judge_shape(shape, model_shape, known=known)
    _judge_head(robot, model, known=known)
    if robot.data["chains"] != model.data["chains"]:
        raise CatalogueError(Phrase("its chains are other ones than those of {robot}", robot=model.title))
    for name, members in model.groups.items():
        if robot.groups.get(name) != members:
            raise CatalogueError(
                Phrase("its group {name} has other joints than that of {robot}", name=name, robot=model.title)
            )
    _judge_devices(robot, model)
    _judge_postures(robot)
    for gesture in (*robot.motions.values(), *robot.talking):
        _judge_gesture(gesture)
    _judge_places(robot.data)


def _judge_joint(own: Joint, model: Joint, *, known: bool) -> None:
    low, high = (model.lower, model.upper) if known else (-_WIDEST, _WIDEST)
    fastest = model.max_velocity if known else _FASTEST
    unit = f" {model.unit}" if model.unit else ""
    _within(own.name, "lower", own.lower, low, high, unit)
    _within(own.name, "upper", own.upper, own.lower, high, unit)
    _within(own.name, "max_velocity", own.max_velocity, 1e-3, fastest, f"{unit}/s")


def _within(joint: str, what: str, value: float, low: float, high: float, unit: str = "") -> None:
    if not low <= value <= high:
        raise CatalogueError(
            Phrase(
                "joint {joint} has {name} {value}{unit}; this catalogue may only narrow it, from {low} to {high}",
                joint=joint, name=what, value=f"{value:g}", unit=unit, low=f"{low:g}", high=f"{high:g}",
            )
        )  # fmt: skip


def _judge_shape(shape: Shape, model: Shape, *, known: bool) -> None:
    own = {joint.name: joint for joint in shape.joints}
    for joint in model.joints:
        mine = own.pop(joint.name, None)
        if mine is None or mine.fixed != joint.fixed:
            raise CatalogueError(
                Phrase("joint {joint} is missing in its shape, or is placed elsewhere", joint=joint.name)
            )
        for name, limit in joint.limits.items() if known else ():
            if name not in mine.limits:
                raise CatalogueError(
                    Phrase("joint {joint} has no limit “{name}” in its shape", joint=joint.name, name=name)
                )
            low, high = (joint.limits["lower"], joint.limits["upper"]) if name in ("lower", "upper") else (0.0, limit)
            _within(joint.name, name, mine.limits[name], low, high)
        if mine.limits.get("lower", 0.0) > mine.limits.get(
            "upper", 0.0
        ):  # the simulator takes that for no limits at all
            _within(joint.name, "upper", mine.limits.get("upper", 0.0), mine.limits.get("lower", 0.0), _WIDEST)
    if own:
        raise CatalogueError(Phrase("joint {joint} of its shape cannot be simulated here", joint=next(iter(own))))
    if missing := set(model.links) - set(shape.links):
        raise CatalogueError(Phrase("the link {name} is missing in its shape", name=min(missing)))


def _judge_head(robot: Robot, model: Robot, *, known: bool) -> None:
    own, other = robot.data.get("head_pitch_by_yaw"), model.data.get("head_pitch_by_yaw")
    if own is None or other is None:
        return
    yaws = own["yaw"]
    if not (2 <= len(yaws) == len(own["lower"]) == len(own["upper"])) or any(
        a >= b for a, b in itertools.pairwise(yaws)
    ):
        raise CatalogueError(
            Phrase("its table {name} does not rise, or has columns of different lengths", name="head_pitch_by_yaw")
        )
    for yaw in sorted({*yaws, *other["yaw"]}) if known else ():
        low, high = (_between(other, side, yaw) for side in ("lower", "upper"))
        _within("HeadPitch", "lower", _between(own, "lower", yaw), low - 1e-9, high)
        _within("HeadPitch", "upper", _between(own, "upper", yaw), low, high + 1e-9)


def _between(table: Mapping[str, Sequence[float]], side: str, yaw: float) -> float:
    """The limit at a yaw, on the line between the two that stand beside it in the table."""
    yaws, limits = table["yaw"], table[side]
    for (first, low), (second, high) in itertools.pairwise(zip(yaws, limits, strict=True)):
        if yaw <= second:
            part = max((yaw - first) / (second - first), 0.0)
            return float(low + part * (high - low))
    return float(limits[-1])


def _judge_devices(robot: Robot, model: Robot) -> None:
    entries = {(kind, entry["name"]): entry for kind in ("sensor", "actuator") for entry in model.data[kind]}
    for kind in ("sensor", "actuator"):
        for own in robot.data[kind]:
            other = entries.get((kind, own["name"]))
            if other is None or any(own.get(k) != other.get(k) for k in _SAME):
                raise CatalogueError(
                    Phrase("the device {name} is not what it is in the program", name=str(own["name"])[:80])
                )
            if len(own.get("shows", ())) > _MOST_SHOWN:
                raise CatalogueError(Phrase("the device {name} shows too many things", name=str(own["name"])[:80]))
    for found in robot.names.values():
        settings = model.devices[key(found.type.name)].settings
        for k, setting in found.type.settings.items():
            if k in settings and not _narrower(setting, settings[k], found.preset.get(k)):
                raise CatalogueError(Phrase("the setting {name} of {device} is wider than in the program",
                                     name=setting.name[:80], device=found.type.name))  # fmt: skip


def _narrower(own: Setting, model: Setting, preset: Any) -> bool:
    """Whether a setting, its default and what a name says for it are within the limits of another one."""
    low, high = -math.inf if model.lower is None else model.lower, math.inf if model.upper is None else model.upper
    limits = -math.inf if own.lower is None else own.lower, math.inf if own.upper is None else own.upper
    values = [v for v in (own.default, preset) if isinstance(v, (int, float)) and not isinstance(v, bool)]
    return own.kind == model.kind and all(low <= v <= high for v in (*limits, *values))


def _judge_postures(robot: Robot) -> None:
    postures: Mapping[str, Mapping[str, float]] = robot.data.get("postures", {})
    start = str(robot.data["robot"]["start_posture"])
    for name in (start, REST_POSTURE):
        if lacking := {j.name for j in robot.joints.values()} - set(postures.get(name, ())):
            raise CatalogueError(
                Phrase("the posture {name} says nothing about {joint}", name=name[:80], joint=min(lacking))
            )
    for name, angles in postures.items():
        for named, angle in angles.items():
            joint = robot.joints.get(key(named))
            if joint is None:
                raise CatalogueError(
                    Phrase("the posture {name} has a joint {joint} that there is not", name=name, joint=named[:80])
                )
            if not joint.lower - _NEAR <= angle <= joint.upper + _NEAR:
                raise CatalogueError(
                    Phrase(
                        "the posture {name} brings {joint} to {value}, outside of its limits",
                        name=name, joint=joint.name, value=f"{angle:g}",
                    )
                )  # fmt: skip
    ways: Mapping[str, str] = robot.data.get("posture_ways", {})
    for name in ways:
        path = [name]
        while path[-1] in ways and len(path) <= len(ways):
            path.append(ways[path[-1]])
        if path[-1] in ways or not set(path) <= set(postures):
            raise CatalogueError(Phrase("the way to the posture {name} has no beginning", name=name[:80]))
    if any(abs(lean) > math.pi / 2 + 0.1 for lean in robot.data.get("posture_leans", {}).values()):
        raise CatalogueError(Phrase("a posture leans farther than lying down"))


def _judge_gesture(gesture: Gesture) -> None:
    times = [0.0, *(frame.at for frame in gesture.frames)]
    if len(times) < 2 or any(b <= a for a, b in itertools.pairwise(times)) or times[-1] > _LONGEST:
        raise CatalogueError(Phrase("the times of the gesture {name} do not rise, or go beyond {longest} s",
                             name=gesture.name[:80], longest=f"{_LONGEST:g}"))  # fmt: skip
    if gesture.tempo and not _TEMPOS[0] <= gesture.tempo <= _TEMPOS[1]:
        raise CatalogueError(Phrase("the gesture {name} has a tempo that no music has", name=gesture.name[:80]))


def _judge_places(data: Mapping[str, Any]) -> None:
    """The figures of where something is on the robot: near it, and as many as there are directions."""
    camera = data["camera"]["top"]
    right = _HEIGHT[0] <= data["robot"]["height"] <= _HEIGHT[1]
    right &= all(_WIDE_VIEW[0] <= camera[view] <= _WIDE_VIEW[1] for view in ("hfov", "vfov"))
    right &= all(_CONE[0] <= beam["cone"] <= _CONE[1] for beam in data["sonar"].values())
    right &= all(0.01 <= data["legs"][bone] <= 1.0 for bone in ("thigh", "tibia"))
    right &= all(0.001 <= pad["radius"] <= 0.5 for pad in data.get("touch", {}).get("pads", ()))
    if not right or not all(_near(data.get(name)) for name in _PLACES):
        raise CatalogueError(Phrase("its height, or a place or size of one of its parts, is one that no robot has"))


def _near(value: Any) -> bool:
    if isinstance(value, Mapping):
        return all(_near(v) for k, v in value.items() if k != "cone")
    if isinstance(value, list):
        place = bool(value) and all(isinstance(part, (int, float)) for part in value)
        return all(map(_near, value)) and (not place or len(value) == 3)
    return not isinstance(value, (int, float)) or abs(value) <= _FARTHEST
