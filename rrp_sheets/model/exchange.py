"""What passes between the engine and a robot's world, whichever it is: plain data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from rrp_sheets.model.values import Field, Record, RecordType, Value

DONE = RecordType(
    "Done",
    (
        Field("value", "any", help="what was commanded"),
        Field("completed", "truth", example=True, help="FALSE when it was stopped, replaced, outranked or dropped"),
        Field("seconds", "number", "s", 2.0, "how long it took"),
    ),
)
"""What the stream `X done` gives, once for every command of the actuator stream X (design: 4-streams)."""


def commanded(value: Value) -> Value:
    """A command's value as its done event tells it: ends within it are told without what they were the end of.

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
    """A device as a behaviour uses it.

    Attributes:
        stream: the key of the sensor or actuator stream.
        name: the stream's name as shown.
        device: the device type's name in the catalogue (`RedBall`, `Tracker`).
        settings: by the setting's key, defaults and presets filled in, numbers as numbers.
    """

    stream: str
    name: str
    device: str
    settings: Mapping[str, Value] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Command:
    """A value for an actuator. Blank (None) stops what the actuator stream is doing.

    Attributes:
        stream: the actuator stream's key.
        value: what the row sent.
        row: the sending row, as `Sheet!row` is shown (`Tracking!4`).
        sensors: keys of the sensor streams that the row descends from, in the behaviour's order (a tracker
            follows the newest detection among them).
        priority: of the row.
    """

    stream: str
    value: Value
    row: str = ""
    sensors: tuple[str, ...] = ()
    priority: float = 0.0


@dataclass(frozen=True, slots=True)
class Happening:
    """Something to tell besides the events: `kind` is `say`, `clamp`, `note` or `error`."""

    kind: str
    text: str
    stream: str = ""
    row: str = ""
