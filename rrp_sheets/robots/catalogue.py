"""Robot catalogues, read from `robots/<name>/`: a robot with its joints, devices, settings, words and gestures.

The catalogue drives drop-downs, checks, help and the ethics summary; drivers look their devices up in it. A Gestures
sheet adds gestures.
"""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

from rrp_sheets.errors import SheetsError
from rrp_sheets.model import japanese
from rrp_sheets.model.durations import parse_duration
from rrp_sheets.model.names import key
from rrp_sheets.model.values import Field, RecordType, Value
from rrp_sheets.resources import bundled
from rrp_sheets.texts import N_, LazyMessage, listed, translate

CATALOGUE = "robot.toml"
REST_POSTURE = "Crouch"  # where a run ends
SIDES = ("L", "R")
_DEGREES = re.compile(r"([+-]?(?:\d+(?:\.\d*)?|\.\d+))\s*°")
_NUMBER = re.compile(r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)")


@dataclass(frozen=True, slots=True)
class Keyframe:
    """Angles of joints at a time; a joint that is not among them is then on its way, or has not begun to move."""

    at: float  # s from the beginning, or beats of a gesture that goes by beats
    angles: Mapping[str, float]  # by the joint's name, in its unit (rad; a hand from 0, closed, to 1)
    # the same, added to where the joint was at the beginning: legs, which may stand or sit
    by: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Gesture:
    """A gesture; when it is over, all its joints return to where they were."""

    name: str
    frames: tuple[Keyframe, ...]
    tempo: float = 0.0  # beats a minute when its times are beats, else 0
    help: str = ""  # what it looks like, in a few words

    @property
    def joints(self) -> tuple[str, ...]:
        """The joints that it moves."""
        return tuple(dict.fromkeys(joint for frame in self.frames for joint in (*frame.angles, *frame.by)))

    def timed(self, tempo: float | None = None, times: int = 1) -> tuple[Keyframe, ...]:
        """Its keyframes with their times in s, that many `times` one after the other; `tempo` is beats a minute.

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
    """A robot: joints, groups, postures, gestures and devices."""

    name: str
    title: str
    folder: Path
    joints: Mapping[str, Joint]
    groups: Mapping[str, tuple[str, ...]]
    devices: Mapping[str, DeviceType]
    names: Mapping[str, FoundDevice]
    data: Mapping[str, Any]  # the whole robot.toml, for the simulator and drivers
    # its gestures by key; also those of the workbook, see `with_gestures`
    motions: Mapping[str, Gesture] = field(default_factory=dict)
    talking: tuple[Gesture, ...] = ()  # the small gestures that go with talking, in turn

    def find(self, name: str) -> FoundDevice | None:
        """The device that a name means (`Red ball`, `Say`, `Head yaw`), in any spelling."""
        return self.names.get(key(name))

    def devices_for(self, word: str, kind: str = "") -> list[DeviceType]:
        """The devices (of a kind) that people call by a plain word, or else by one that begins with it (3 letters).

        >>> [device.title for device in load_robot().devices_for("hand", "sensor")]
        ['Touch']
        """
        k, mine = key(word), [(d, [*map(key, d.synonyms)]) for d in self.devices.values() if kind in ("", d.kind)]
        called = [device for device, words in mine if k in words]
        return called or [d for d, words in mine if len(k) > 2 and any(w.startswith(k) for w in words)]

    def others_with(self, found: FoundDevice, setting: str) -> list[FoundDevice]:
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

    def standard(self, device: str, value: Value) -> Value:
        """Return what is sent to an actuator with the robot's own word for a Japanese one; the name of a gesture stays.

        >>> nao = load_robot()
        >>> nao.standard("Gesture", "手を振る"), nao.standard("EyeLedColor", "赤"), nao.standard("SayInput", "手を振る")
        ('Wave', 'red', '手を振る')
        """
        if not isinstance(value, str) or key(value) in self.motions:
            return value
        return japanese.standard(japanese.SENT.get(device, {}), value)

    @property
    def languages(self) -> Mapping[str, str]:
        """The languages that it speaks: their codes, each with its name."""
        return dict(self.data.get("languages", {}))

    @property
    def touch_zones(self) -> tuple[str, ...]:
        """Zones where the robot feels a touch."""
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
        raise SheetsError(
            N_("There is no robot “{name}”.", name=name), N_("The robots are: {names}.", names=listed(robot_names()))
        )
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
    moved = {n: resources(g, movers) for n, g in motions.items()}
    moved[ANY] = tuple(dict.fromkeys(r for used in moved.values() for r in used))  # by one not known before the run
    uses: dict[str, Mapping[str, tuple[str, ...]]] = {"chains": movers, "gestures": moved}
    devices: dict[str, DeviceType] = {}
    names: dict[str, FoundDevice] = {}
    for kind in ("sensor", "actuator"):
        for entry in data[kind]:
            device = devices[key(entry["name"])] = _device(kind, entry, uses)
            names[key(device.name)] = names[key(device.title)] = FoundDevice(device.title, device)
            for preset in entry.get("names", ()):
                shown = preset["name"]
                names[key(shown)] = FoundDevice(shown, device, {key(k): v for k, v in preset.items() if k != "name"})
            names.update((key(also), FoundDevice(also, device, offered=False)) for also in entry.get("also", ()))
            if entry.get("names_of") == "joints":
                for k, joint in joints.items():
                    preset = {"joint": joint.name}
                    names[k] = FoundDevice(_spaced(joint.name), replace(device, unit=joint.unit), preset)
    return Robot(name, data["robot"]["title"], folder, joints, groups, devices, names, data, dict(motions), talking)


def _setting(entry: Mapping[str, Any]) -> Setting:
    found = Setting(**{**entry, "choices": tuple(entry.get("choices", ()))})
    is_time = found.kind == "duration" and found.default is not None
    return replace(found, default=parse_duration(found.default, bare="s")) if is_time else found


_PLAIN = ("title", "unit", "takes", "resources", "colour", "shows", "synonyms", "knowledge", "engine", "simulated",
          "says", "says_given", "given", "says_fixed", "says_value", "when", "stops", "example")  # fmt: skip
"""Fields of a device that its entry has as they are."""


def _field(entry: Mapping[str, Any]) -> Field:
    choices = tuple(entry.get("choices", ()))
    aliases = japanese.CHOICES.get(key(entry["name"]), {}) if choices else {}
    return Field(**{**entry, "choices": choices, "aliases": aliases})


def _device(kind: str, entry: Mapping[str, Any], uses: Mapping[str, Mapping[str, tuple[str, ...]]]) -> DeviceType:
    """Read a device's entry; `uses` are tables of resources that it may name: of each joint, of each gesture."""
    settings = {key(s["name"]): _setting(s) for s in entry.get("settings", ())}
    payload = None
    if "fields" in entry:
        fields = tuple(map(_field, entry["fields"]))
        name = entry.get("record", entry.get("title", entry["name"]))
        payload = RecordType(name, fields, {**entry.get("aliases", {}), **japanese.field_aliases(fields)})
    by = {
        key(setting): uses[choices] if isinstance(choices, str) else {key(c): tuple(u) for c, u in choices.items()}
        for setting, choices in entry.get("resources_by", {}).items()
    }
    name, help = entry["name"], entry["help"]
    given = {"title": name, **{k: v for k, v in entry.items() if k in _PLAIN}}
    given |= {k: tuple(entry.get(k, ())) for k in ("resources", "shows", "synonyms")}
    return DeviceType(name, kind, help, settings, payload, resources_by=by, **given)


def _spaced(name: str) -> str:
    """HeadYaw → Head yaw."""
    words = "".join(" " + c.lower() if c.isupper() and i > 1 else c for i, c in enumerate(name))
    return words if not (len(name) > 1 and name[1].isupper()) else name[0] + " " + words[1:].strip().lower()


ANY = "*"
"""In `resources_by`: what is used when the setting says anything else."""


@dataclass(frozen=True)
class Setting:
    """A setting of a device: a column of the Devices sheet."""

    name: str
    # `text`, `number`, `choice`, `joint`, `colour`, `zone` (where the robot feels a touch), `posture`, `gesture` (also
    # the workbook's own), `behaviour` (of the workbook), `angle` (rad; `30°` too), `words` (a list of texts), `label`
    # (a text; blank is the stream's name), `truth`, `language` (its code), `sound file` (a .wav beside the workbook),
    # or `duration` (whole microseconds)
    kind: str = "text"
    unit: str = ""
    choices: tuple[str, ...] = ()
    default: Value = None  # when the cell is blank; None when there is none
    required: bool = False
    lower: float | None = None
    upper: float | None = None
    help: str = ""


@dataclass(frozen=True)
class DeviceType:
    """A sensor or an actuator as the catalogue describes it."""

    name: str
    kind: str  # `sensor` or `actuator`
    help: str  # what it is for, one or two sentences; shown to users
    settings: Mapping[str, Setting] = field(default_factory=dict)
    payload: RecordType | None = None  # the record a sensor gives, or None when it gives a plain value
    unit: str = ""  # of the plain value
    takes: str = ""  # what an actuator takes, in words
    resources: tuple[str, ...] = ()  # what an actuator uses whatever its settings are (`voice`, `eyes`, …)
    # what it uses besides, by the key of a setting and the key of what that setting says
    resources_by: Mapping[str, Mapping[str, tuple[str, ...]]] = field(default_factory=dict)
    colour: str = ""  # of the balls that a sensor looks for, or `any`
    # what a default scene has for a sensor: `person`, `near` (somebody comes near), balls of a colour (`{colour}` is
    # its setting), `press` and a button's label, `touch` and a zone, `say` and words
    shows: tuple[str, ...] = ()
    synonyms: tuple[str, ...] = ()  # plain words by which people look for it, in all languages of the pages
    knowledge: bool = False  # True when the simulated sensor is fed from the scene and perceives nothing
    engine: bool = False  # True when the engine itself carries it out, whatever the robot (`Wait`)
    simulated: bool = True  # False when the simulated robot does not carry it out yet
    says: str = ""  # a sentence template for the plain-language description
    says_given: str = ""  # the same after what has given the value: `make this gesture`
    given: str = ""  # that value in words: `the name of a gesture`
    says_fixed: str = ""  # the same for a row whose formula is a text or a number, `{value}`
    says_value: str = ""  # the same for a row with another formula, whose `{value}` in words it is
    when: str = ""  # for a sensor, instead of “When” and what it says: `every second`
    stops: str = ""  # the same for what a blank stops; empty for an actuator that a blank does not stop
    title: str = ""  # its name for people
    # a small workbook with a test, in Markdown, for the device's help; its heading says what it shows
    example: str = ""

    @property
    def is_button(self) -> bool:
        """True for a button that the operator presses."""
        return self.name == "OperatorButton"

    def resources_for(self, settings: Mapping[str, Value]) -> frozenset[str]:
        """Return the resources that an actuator with these settings (by key) uses; two that share one conflict.

        >>> from rrp_sheets.robots import load_robot
        >>> sorted(load_robot().devices["tracker"].resources_for({"mode": "Whole body", "effector": "Left arm"}))
        ['head', 'left arm', 'legs']
        """
        used = set(self.resources)
        for name, by_choice in self.resources_by.items():
            used.update(by_choice.get(key(str(settings.get(name))), by_choice.get(ANY, ())))
        return frozenset(used)

    def words(self, language: str) -> DeviceWords:
        """Return the texts about the device in a language; untranslated ones are in English.

        >>> from rrp_sheets.robots import load_robot
        >>> load_robot().devices["redball"].words("en").says
        'the robot sees a red ball'
        """

        def say(part: str, text: str) -> str:
            return translate(LazyMessage(text, msgctxt=f"{self.name}.{part}"), language)

        title = say("title", self.title)
        fields = self.payload.fields if self.payload else ()
        return DeviceWords(
            language, "" if title == self.title else title, say("help", self.help), say("says", self.says),
            say("says_given", self.says_given), say("given", self.given),
            say("says_fixed", self.says_fixed), say("says_value", self.says_value), say("when", self.when),
            say("takes", self.takes), say("stops", self.stops),
            {key(f.name): (say(f.name, f.name.replace("_", " ")), say(f.name, f.help)) for f in fields},
        )  # fmt: skip

    def with_defaults(self, settings: Mapping[str, Value]) -> dict[str, Value]:
        """The settings by key, with the catalogue's defaults where they say nothing."""
        return {**{k: s.default for k, s in self.settings.items()}, **settings}


@dataclass(frozen=True)
class FoundDevice:
    """A device found by a name."""

    name: str
    type: DeviceType
    # the settings that the name implies (`Head yaw`: Joint = HeadYaw)
    preset: Mapping[str, Value] = field(default_factory=dict)
    offered: bool = True  # False for a further spelling of a name that is offered already


_OURS = ("choice", "colour", "zone", "truth")  # kinds of settings whose words are the catalogue's own
_NAMED = ("posture", "gesture")


@dataclass(frozen=True)
class DeviceWords:
    """Texts that are printed about a device, in one language."""

    language: str
    title: str  # the device's name for people; empty when it has none but that of the catalogue
    help: str
    says: str
    says_given: str
    given: str
    says_fixed: str
    says_value: str
    when: str
    takes: str
    stops: str
    fields: Mapping[str, tuple[str, str]]  # name and help of its record's fields, by their keys

    def name(self, text: str) -> str:
        """Return the name of a posture or a gesture in this language; any other text as it is."""
        return translate(LazyMessage(text, msgctxt="posture"), self.language)

    def said(self, text: str, kind: str) -> str:
        """Return a setting's text by its kind (`choice`, `text`, …): only the catalogue's words are translated."""
        return self.name(text) if kind in _NAMED else self.value(text) if kind in _OURS else text

    def setting(self, name: str) -> str:
        """Return the name of a setting in this language."""
        return translate(LazyMessage(name, msgctxt="setting"), self.language)

    def value(self, text: str) -> str:
        """Return a word of the catalogue in this language; any other text as it is."""
        return translate(LazyMessage(text, msgctxt="value"), self.language)
