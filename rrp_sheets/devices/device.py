"""A sensor or an actuator of a robot: its settings, what it gives or takes, what it uses, and its names."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from rrp_sheets.devices.spoken import DeviceWords
from rrp_sheets.model.names import key
from rrp_sheets.model.values import RecordType, Value

ANY = "*"
"""In `resources_by`: what is used when the setting says anything else."""


@dataclass(frozen=True)
class Setting:
    """A setting of a device: a column of the Devices sheet.

    Attributes:
        kind: `text`, `number`, `choice`, `joint`, `colour`, `zone` (where the robot feels a touch), `posture`,
            `gesture` (also the workbook's own), `behaviour` (of the workbook), `angle` (rad; `30°` too), `words` (a
            list of texts), `label` (a text; blank is the stream's name), `truth`, `language`
            (its code), `sound file` (a .wav beside the workbook), or `duration` (whole microseconds).
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
        unit: of the plain value.
        takes: what an actuator takes, in words.
        resources: what an actuator uses whatever its settings are (`voice`, `eyes`, …).
        resources_by: what it uses besides, by the key of a setting and the key of what that setting says.
        colour: of the balls that a sensor looks for, or `any`.
        shows: what a default scene has for a sensor: `person`, `near` (somebody comes near), balls of a colour
            (`{colour}` is its setting), `press` and a button's label, `touch` and a zone, `say` and words.
        knowledge: True when the simulated sensor is fed from the scene and perceives nothing.
        engine: True when the engine itself carries it out, whatever the robot (`Wait`).
        simulated: False when the simulated robot does not carry it out yet.
        says: a sentence template for the plain-language description.
        stops: the same for what a blank stops; empty for an actuator that a blank does not stop.
        spoken: what is printed about it in other languages, by their codes; see `words`.
    """

    name: str
    kind: str
    help: str
    settings: Mapping[str, Setting] = field(default_factory=dict)
    payload: RecordType | None = None
    unit: str = ""
    takes: str = ""
    resources: tuple[str, ...] = ()
    resources_by: Mapping[str, Mapping[str, tuple[str, ...]]] = field(default_factory=dict)
    colour: str = ""
    shows: tuple[str, ...] = ()
    knowledge: bool = False
    engine: bool = False
    simulated: bool = True
    says: str = ""
    stops: str = ""
    spoken: Mapping[str, DeviceWords] = field(default_factory=dict)

    def resources_for(self, settings: Mapping[str, Value]) -> frozenset[str]:
        """What an actuator with these settings (by key) uses: two that share a resource are in each other's way.

        >>> from rrp_sheets.devices import load_robot
        >>> sorted(load_robot().devices["tracker"].resources_for({"mode": "Whole body", "effector": "Left arm"}))
        ['head', 'left arm', 'legs']
        """
        used = set(self.resources)
        for name, by_choice in self.resources_by.items():
            used.update(by_choice.get(key(str(settings.get(name))), by_choice.get(ANY, ())))
        return frozenset(used)

    def words(self, language: str) -> DeviceWords:
        """What is printed about it in a language; in English what has not been translated.

        >>> from rrp_sheets.devices import load_robot
        >>> load_robot().devices["redball"].words("en").says
        'the robot sees a red ball'
        """
        found = self.spoken.get(language, DeviceWords())
        mine = {key(f.name): (f.name.replace("_", " "), f.help) for f in self.payload.fields} if self.payload else {}
        fields = {k: (found.fields.get(k, names)[0] or names[0], found.fields.get(k, names)[1] or names[1])
                  for k, names in mine.items()}  # fmt: skip
        return replace(
            found, help=found.help or self.help, says=found.says or self.says, stops=found.stops or self.stops,
            takes=found.takes or self.takes, fields=fields,
        )  # fmt: skip

    def with_defaults(self, settings: Mapping[str, Value]) -> dict[str, Value]:
        """The settings by key, with the catalogue's defaults where they say nothing."""
        return {**{k: s.default for k, s in self.settings.items()}, **settings}


@dataclass(frozen=True)
class Found:
    """A device found by a name.

    Attributes:
        type: what it is.
        preset: the settings that the name implies (`Head yaw`: Joint = HeadYaw).
        offered: False for a further spelling of a name that is offered already.
    """

    name: str
    type: DeviceType
    preset: Mapping[str, Value] = field(default_factory=dict)
    offered: bool = True
