"""A robot's catalogue, read from `robots/<name>/robot.toml` (design: 5-robot).

The catalogue drives drop-downs, checks, help and the ethics summary; drivers look their devices up in it.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

from rrp_sheets.devices.device import ANY, DeviceType, Found, Setting
from rrp_sheets.devices.gestures import Gesture, load_gestures, resources
from rrp_sheets.devices.spoken import words_of
from rrp_sheets.errors import SheetsError
from rrp_sheets.model.durations import parse_duration
from rrp_sheets.model.names import key
from rrp_sheets.model.values import Field, RecordType
from rrp_sheets.resources import bundled

CATALOGUE = "robot.toml"
REST_POSTURE = "Crouch"  # where a run ends


@dataclass(frozen=True)
class Joint:
    """A joint: limits and top velocity (per second) in its unit, and its chain (`Head`, `LArm`, …).

    The unit is rad, or empty for a hand, which goes from 0 (closed) to 1 (open).
    """

    name: str
    lower: float
    upper: float
    max_velocity: float
    chain: str
    unit: str = "rad"


@dataclass(frozen=True)
class Robot:
    """A robot: joints, groups, postures, gestures and devices.

    Attributes:
        data: the whole robot.toml, for the simulator and drivers.
        motions: its gestures by key; also those of the workbook, see `with_gestures`.
        talking: the small gestures that go with talking, in turn.
    """

    name: str
    title: str
    folder: Path
    joints: Mapping[str, Joint]
    groups: Mapping[str, tuple[str, ...]]
    devices: Mapping[str, DeviceType]
    names: Mapping[str, Found]
    data: Mapping[str, Any]
    motions: Mapping[str, Gesture] = field(default_factory=dict)
    talking: tuple[Gesture, ...] = ()

    def find(self, name: str) -> Found | None:
        """The device that a name means (`Red ball`, `Say`, `Head yaw`), in any spelling."""
        return self.names.get(key(name))

    def others_with(self, found: Found, setting: str) -> list[Found]:
        """The devices to use instead of one that lacks a setting: they use the same, or give the same.

        >>> nao = load_robot()
        >>> [other.name for other in nao.others_with(nao.names["say"], "text")]
        ['Say parameter']
        """
        mine = found.type
        return [
            other for other in self.names.values()
            if other.offered and other.type.kind == mine.kind and setting in other.type.settings
            and setting not in other.preset and other.type.name != mine.name
            and (set(mine.resources) & set(other.type.resources)
                 or (mine.payload is not None and other.type.payload == mine.payload))
        ]  # fmt: skip

    @property
    def postures(self) -> tuple[str, ...]:
        """The postures that it can take."""
        return tuple(self.data.get("postures", {}))

    @property
    def gestures(self) -> tuple[str, ...]:
        """The gestures that it can make."""
        return tuple(gesture.name for gesture in self.motions.values())

    def with_gestures(self, own: Sequence[Gesture]) -> Robot:
        """The robot with the gestures of a workbook; one that is named like one of its own takes that one's place."""
        if not own:
            return self
        motions = {**{key(g.name): g for g in own}, **self.motions} | {key(g.name): g for g in own}
        return _assemble(self.name, self.folder, self.data, motions, self.talking)

    @property
    def languages(self) -> Mapping[str, str]:
        """The languages that it speaks: their codes, each with its name."""
        languages: Mapping[str, str] = self.data.get("languages", {})
        return languages

    @property
    def touch_zones(self) -> tuple[str, ...]:
        """Where it feels a touch."""
        return tuple(self.data.get("touch", {}).get("zones", ()))

    def device_names(self, kind: str) -> list[str]:
        """The names that the drop-downs offer, for `sensor` or `actuator`."""
        return list(dict.fromkeys(f.name for f in self.names.values() if f.type.kind == kind and f.offered))


def robot_names() -> list[str]:
    """The robots that come with the program."""
    return sorted(p.parent.name for p in bundled("robots").glob("*/robot.toml"))


@lru_cache(maxsize=8)
def load_robot(name: str = "nao") -> Robot:
    """Read a robot's catalogue; raises SheetsError for an unknown robot."""
    folder = bundled("robots") / name
    if not name.replace("_", "").isalnum() or not (folder / CATALOGUE).is_file():
        raise SheetsError(f"There is no robot “{name}”.", f"The robots are: {', '.join(robot_names())}.")
    return robot_in(folder, name)


def robot_in(folder: Path, name: str, data: Mapping[str, Any] | None = None) -> Robot:
    """The robot whose catalogue is in that folder; `data` is that catalogue when it was read already."""
    data = data or tomllib.loads((folder / CATALOGUE).read_text(encoding="utf-8"))
    motions, talking = load_gestures(folder / "gestures.toml", [j["name"] for j in data["joints"]])
    return _assemble(name, folder, data, motions, talking)


def _assemble(
    name: str, folder: Path, data: Mapping[str, Any], motions: Mapping[str, Gesture], talking: tuple[Gesture, ...]
) -> Robot:
    joints = {key(j["name"]): Joint(**j) for j in data["joints"]}
    groups = {key(n): tuple(members) for n, members in data["groups"].items()}
    movers = {n: (data["chains"][joint.chain],) for n, joint in joints.items()}
    movers |= {n: tuple(r for member in members for r in movers[key(member)]) for n, members in groups.items()}
    uses: dict[str, Mapping[str, tuple[str, ...]]] = {
        "chains": movers,
        "gestures": _gesture_uses({n: resources(g, movers) for n, g in motions.items()}),
    }
    devices: dict[str, DeviceType] = {}
    names: dict[str, Found] = {}
    for kind in ("sensor", "actuator"):
        for entry in data[kind]:
            device = replace(_device(kind, entry, uses), spoken=words_of(folder, entry["name"]))
            devices[key(device.name)] = device
            title = entry.get("title", device.name)
            names[key(device.name)] = names[key(title)] = Found(title, device)
            for preset in entry.get("names", ()):
                shown = preset["name"]
                names[key(shown)] = Found(shown, device, {key(k): v for k, v in preset.items() if k != "name"})
            names.update((key(also), Found(also, device, offered=False)) for also in entry.get("also", ()))
            if entry.get("names_of") == "joints":
                for joint in joints.values():
                    found = Found(_spaced(joint.name), replace(device, unit=joint.unit), {"joint": joint.name})
                    names[key(joint.name)] = found
    return Robot(
        name, data["robot"]["title"], folder, joints, groups, devices, names, data, dict(motions), talking
    )  # fmt: skip


def _gesture_uses(gestures: Mapping[str, Sequence[str]]) -> dict[str, tuple[str, ...]]:
    """What each gesture (by key) uses; one that is not known before the run may use all of that."""
    uses = {name: tuple(used) for name, used in gestures.items()}
    return {**uses, ANY: tuple(dict.fromkeys(r for used in uses.values() for r in used))}


def _setting(entry: Mapping[str, Any]) -> Setting:
    default = entry.get("default")
    if entry.get("kind") == "duration" and default is not None:
        default = parse_duration(default, bare="s")
    return Setting(**{**entry, "choices": tuple(entry.get("choices", ())), "default": default})


def _device(kind: str, entry: Mapping[str, Any], uses: Mapping[str, Mapping[str, tuple[str, ...]]]) -> DeviceType:
    """Read a device's entry; `uses` are tables of resources that it may name: of each joint, of each gesture."""
    settings = {key(s["name"]): _setting(s) for s in entry.get("settings", ())}
    payload = None
    if "fields" in entry:
        fields = tuple(Field(**{**f, "choices": tuple(f.get("choices", ()))}) for f in entry["fields"])
        name = entry.get("record", entry.get("title", entry["name"]))
        payload = RecordType(name, fields, entry.get("aliases", {}))
    by = {
        key(setting): uses[choices] if isinstance(choices, str) else {key(c): tuple(u) for c, u in choices.items()}
        for setting, choices in entry.get("resources_by", {}).items()
    }
    return DeviceType(
        name=entry["name"], kind=kind, help=entry["help"], settings=settings, payload=payload,
        unit=entry.get("unit", ""), takes=entry.get("takes", ""), resources=tuple(entry.get("resources", ())),
        resources_by=by, colour=entry.get("colour", ""), shows=tuple(entry.get("shows", ())),
        knowledge=entry.get("knowledge", False), engine=entry.get("engine", False),
        simulated=entry.get("simulated", True), says=entry.get("says", ""), stops=entry.get("stops", ""),
    )  # fmt: skip


def _spaced(name: str) -> str:
    """HeadYaw → Head yaw."""
    words = "".join(" " + c.lower() if c.isupper() and i > 1 else c for i, c in enumerate(name))
    return words if not (len(name) > 1 and name[1].isupper()) else name[0] + " " + words[1:].strip().lower()
