"""Plain data that passes between the engine and a robot's world, whichever it is, and the actions of a scene."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from rrp_sheets.model.japanese import field_aliases
from rrp_sheets.model.values import Field, Record, RecordType, Value

_FIELDS = (
    Field("value", "any", help="what was commanded"),
    Field("completed", "truth", example=True, help="FALSE when it was stopped, replaced, outranked or dropped"),
    Field("seconds", "number", "s", 2.0, "how long it took"),
)
DONE = RecordType("Done", _FIELDS, field_aliases(_FIELDS))
"""Record type of the stream `X done`, which has one value for every command of the actuator stream X."""


def commanded(value: Value) -> Value:
    """Return a command's value for its done event: done records within it are given without their own values.

    Rows that command each other in a circle through `X done` would otherwise send a value that grows for ever.

    >>> end = DONE.make(value="Hello", completed=True, seconds=1.5)
    >>> commanded("Hello"), commanded([end, 2])
    ('Hello', [Done(value=None, completed=True, seconds=1.5), 2])
    """
    if isinstance(value, Record):
        if value.type == DONE:
            return Record(value.type, {**value.values, "value": None})
        return Record(value.type, {k: commanded(v) for k, v in value.values.items()})
    if isinstance(value, (list, tuple)):
        return type(value)(commanded(v) for v in value)
    return value


@dataclass(frozen=True, slots=True)
class DeviceUse:
    """A device as a behaviour uses it."""

    stream: str  # the key of the sensor or actuator stream
    name: str  # the stream's name as shown
    device: str  # the device type's name in the catalogue (`RedBall`, `Tracker`)
    # by the setting's key, defaults and presets filled in, numbers as numbers
    settings: Mapping[str, Value] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Command:
    """A value for an actuator. Blank (None) stops what the actuator stream is doing."""

    stream: str  # the actuator stream's key
    value: Value  # what the row sent
    row: str = ""  # the sending row, as `Sheet!row` is shown (`Tracking!4`)
    # keys of the sensor streams that the row descends from, in the behaviour's order (a tracker follows the newest
    # detection among them)
    sensors: tuple[str, ...] = ()
    priority: float = 0.0  # of the row
    # with a blank, that the behaviour behind it was switched off: what it has moved goes back to rest
    release: bool = False
    # names the command in its done event, for a world that cannot give `value` back; 0 for one that can
    number: int = 0


@dataclass(frozen=True, slots=True)
class Notice:
    """One notice of a run besides its events: `kind` is `say`, `sound`, `person`, `clamp`, `note` or `error`.

    A `person` is somebody who speaks to the robot; a `sound` is what it plays.
    """

    kind: str
    text: str
    stream: str = ""
    row: str = ""
    sound: str = ""  # the file in the run's folder with what is said or played; empty where there is none


@dataclass(frozen=True, slots=True)
class OperatorAction:
    """One action of an operator during a run."""

    kind: str  # `mark`, `switch`, `send`, `press`, `scene`, `speed`, `edit`, `pause`, `resume` or `step`
    text: str  # in words
    by: str = ""
    detail: Mapping[str, Any] = field(default_factory=dict)  # all that is needed to do it again, by name


@dataclass(frozen=True, slots=True)
class WorldState:
    """The world as it is, for displays and tests."""

    joints: Mapping[str, float]  # positions by the joint's name, rad
    base: tuple[float, ...]  # x, y, z (m) of the torso and roll, pitch, yaw (rad)
    eyes: tuple[float, ...]  # red, green, blue of both eyes as they shine, 0 to 1
    saying: str  # the sentence being spoken, or empty
    # positions (m) by name: of a ball its middle, of a person the face, else the middle of the underside
    things: Mapping[str, tuple[float, ...]]
    # the row that has each resource of the robot (`head`, `voice`, …) now
    driving: Mapping[str, str] = field(default_factory=dict)
    # what the things look like, by name: their `kind`, `size` (m), `colour` and so on
    looks: Mapping[str, Mapping[str, Value]] = field(default_factory=dict)
    # light, noise: how bright and how loud the room is, 0 to 1
    light: float = 1.0
    noise: float = 0.0


@dataclass(frozen=True, slots=True)
class WorldSnapshot:
    """The world for a display: its state, and what the robot sees as a JPEG picture, empty when none was wanted."""

    state: WorldState
    picture: bytes = b""


@dataclass(frozen=True, slots=True)
class Arrivals:
    """Values of sensor streams, in a fixed order, and notices, from a world for the engine at one instant."""

    events: Sequence[tuple[str, Value]] = ()
    notices: Sequence[Notice] = ()


ROW_ABOVE = "+"
"""The cue of a row whose time counts from the row above it."""


@dataclass(frozen=True, slots=True)
class RandomRange:
    """A number that each run draws anew: `0.4..0.6`.

    >>> print(RandomRange(0.4, 0.6))
    0.4..0.6
    """

    low: float
    high: float

    def __str__(self) -> str:
        return f"{self.low:g}..{self.high:g}"


@dataclass(frozen=True, slots=True)
class SceneAction:
    """One thing that happens at one time."""

    time_us: int  # on the run's clock, microseconds; with a cue: after that
    thing: str  # the thing's name as shown ("Red ball", "Person")
    verb: str  # `appear`, `move`, `circle`, `disappear`, `seen`, … (the tables in `scene/scene_words.py` list them)
    # what the verb needs: positions in m (robot's starting frame, x forward, y left, z up), durations in s; numbers may
    # be ranges until the run draws them
    values: Mapping[str, Value] = field(default_factory=dict)
    row: int = 0  # the Scene row, for messages
    kind: str = ""  # of the thing: `ball`, `cup`, `person`, …; empty where the values tell
    # the id of the stream whose next event it waits for, `+` for the row above, empty for a time of the run
    cue: str = ""
    span_us: int = 0  # how much later than `time_us` it may be: a range that the run draws

    @property
    def what(self) -> str:
        """The kind of the thing, also where only the values tell: a ball has a size."""
        return self.kind or ("ball" if "size" in self.values else "person")
