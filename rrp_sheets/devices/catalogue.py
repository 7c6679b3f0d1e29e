"""A robot's catalogue, read from `robots/<name>/robot.toml` (design: 5-robot).

The catalogue drives drop-downs, checks, help and the ethics summary; drivers look their devices up in it.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any

from rrp_sheets.errors import SheetsError
from rrp_sheets.model.names import key
from rrp_sheets.model.values import Field, RecordType, Value
from rrp_sheets.resources import bundled


@dataclass(frozen=True)
class Joint:
    """A joint: limits in rad (hands: 0 closed to 1 open), top velocity in rad/s, and its chain (`Head`, `LArm`, …)."""

    name: str
    lower: float
    upper: float
    max_velocity: float
    chain: str


@dataclass(frozen=True)
class Setting:
    """A setting of a device: a column of the Devices sheet.

    Attributes:
        kind: `text`, `number`, `choice`, `joint`, `colour` or `duration`.
        unit: of a number.
        choices: of a choice.
        default: when the cell is blank; None when there is none.
        required: whether the cell must not be blank.
    """

    name: str
    kind: str = "text"
    unit: str = ""
    choices: tuple[str, ...] = ()
    default: Value = None
    required: bool = False
    lower: float | None = None
    upper: float | None = None
    help: str = ""


@dataclass(frozen=True)
class DeviceType:
    """A sensor or an actuator as the catalogue describes it.

    Attributes:
        kind: `sensor` or `actuator`.
        help: what it is for, one or two sentences; shown to users.
        payload: the record a sensor gives, or None when it gives a plain value.
        gives: the plain value's kind (`number`, `text`, `truth`), when there is no payload.
        unit: of the plain value.
        example: an example value (a record for a payload).
        takes: what an actuator takes, in words.
        resources: what an actuator uses (`voice`, `eyes`, `head`, …).
        knowledge: True when the simulated sensor is fed from the scene and perceives nothing.
        says: a sentence template for the plain-language description.
    """

    name: str
    kind: str
    help: str
    settings: Mapping[str, Setting] = field(default_factory=dict)
    payload: RecordType | None = None
    gives: str = "any"
    unit: str = ""
    example: Value = None
    takes: str = ""
    resources: tuple[str, ...] = ()
    knowledge: bool = False
    says: str = ""


@dataclass(frozen=True)
class Found:
    """A device found by a name: its type and the settings that the name implies (`Head yaw`: Joint = HeadYaw)."""

    name: str
    type: DeviceType
    preset: Mapping[str, Value] = field(default_factory=dict)


@dataclass(frozen=True)
class Robot:
    """A robot: joints, groups, postures and devices; `data` is the whole robot.toml for the simulator and drivers."""

    name: str
    title: str
    folder: Path
    joints: Mapping[str, Joint]
    groups: Mapping[str, tuple[str, ...]]
    devices: Mapping[str, DeviceType]
    names: Mapping[str, Found]
    data: Mapping[str, Any]

    def find(self, name: str) -> Found | None:
        """The device that a name means (`Red ball`, `Say`, `Head yaw`), in any spelling."""
        return self.names.get(key(name))

    def device_names(self, kind: str) -> list[str]:
        """The names that the drop-downs offer, for `sensor` or `actuator`."""
        return list(dict.fromkeys(f.name for f in self.names.values() if f.type.kind == kind))


def robot_names() -> list[str]:
    """The robots that come with the program."""
    return sorted(p.parent.name for p in bundled("robots").glob("*/robot.toml"))


@lru_cache(maxsize=8)
def load_robot(name: str = "nao") -> Robot:
    """Read a robot's catalogue; raises SheetsError for an unknown robot."""
    path = bundled("robots") / name / "robot.toml"
    if not name.replace("_", "").isalnum() or not path.is_file():
        raise SheetsError(f"There is no robot “{name}”.", f"The robots are: {', '.join(robot_names())}.")
    data = tomllib.loads(path.read_text(encoding="utf-8"))
    joints = {key(j["name"]): Joint(**j) for j in data["joints"]}
    groups = {key(n): tuple(members) for n, members in data["groups"].items()}
    devices: dict[str, DeviceType] = {}
    names: dict[str, Found] = {}
    for kind in ("sensor", "actuator"):
        for entry in data[kind]:
            device = _device(kind, entry)
            devices[key(device.name)] = device
            title = entry.get("title", device.name)
            names[key(device.name)] = names[key(title)] = Found(title, device)
            for preset in entry.get("names", ()):
                shown = preset["name"]
                names[key(shown)] = Found(shown, device, {key(k): v for k, v in preset.items() if k != "name"})
            if entry.get("names_of") == "joints":
                for joint in joints.values():
                    names[key(joint.name)] = Found(_spaced(joint.name), device, {"joint": joint.name})
    return Robot(name, data["robot"]["title"], path.parent, joints, groups, devices, names, data)


def _device(kind: str, entry: Mapping[str, Any]) -> DeviceType:
    settings = {}
    for s in entry.get("settings", ()):
        settings[key(s["name"])] = Setting(**{**s, "choices": tuple(s.get("choices", ()))})
    payload = None
    example = entry.get("example")
    if "fields" in entry:
        fields = tuple(Field(**f) for f in entry["fields"])
        payload = RecordType(entry.get("title", entry["name"]), fields, entry.get("aliases", {}))
        example = payload.example()
    return DeviceType(
        name=entry["name"], kind=kind, help=entry["help"], settings=settings, payload=payload,
        gives=entry.get("gives", "any"), unit=entry.get("unit", ""), example=example,
        takes=entry.get("takes", ""), resources=tuple(entry.get("resources", ())),
        knowledge=entry.get("knowledge", False), says=entry.get("says", ""),
    )  # fmt: skip


def _spaced(name: str) -> str:
    """HeadYaw → Head yaw."""
    words = "".join(" " + c.lower() if c.isupper() and i > 1 else c for i, c in enumerate(name))
    return words if not (len(name) > 1 and name[1].isupper()) else name[0] + " " + words[1:].strip().lower()
