"""Requests to the simulator's process, and its answers: plain data only."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from rrp_sheets.model.exchange import Command, DeviceUse, Notice, SceneAction, State, WorldSnapshot
from rrp_sheets.model.values import Value
from rrp_sheets.robots.catalogue import Robot

BEATS, STATE = range(2)
"""Places of the simulator's heartbeat: a number that grows while it goes on; what it does."""
PLACES = 2
IDLE, BUSY, OPENING = range(3)
"""States of the simulator: waits for a request, carries one out or brings the robot to rest, makes the world."""


@dataclass(frozen=True, slots=True)
class Spec:
    """Everything the simulator must know at the start.

    Attributes:
        robot: the catalogue, with the folder of the robot's model.
        scene: in the order of their times.
        seed: of the room's random noise.
        frame_rate: frames a second; divides 240.
        out: the folder for sound and film, or empty for none.
        film: whether to record the film and the strip of moments.
        record: whether to record poses and camera pictures, for looking back at the run.
        camera: whether pictures of the robot's camera may be kept.
        title: shown on the strip.
        beside: the folder of the workbook, for its sounds; empty for none.
        faces: the file that keeps remembered faces beyond the run, or empty.
        dones: the actuator streams whose commands report their end, each with the stream that gets the reports.
    """

    robot: Robot
    sensors: tuple[DeviceUse, ...] = ()
    actuators: tuple[DeviceUse, ...] = ()
    scene: tuple[SceneAction, ...] = ()
    seed: int = 0
    frame_rate: int = 30
    out: str = ""
    film: bool = False
    record: bool = False
    camera: bool = True
    title: str = ""
    beside: str = ""
    faces: str = ""
    dones: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class OpenFailure:
    """Reason why a world cannot be made; `missing` when a part of the program is not installed."""

    message: str
    remedy: str
    missing: bool


@dataclass(frozen=True, slots=True)
class Outcome:
    """Result of one advance: sensor values (records as mappings of their fields) and notices, in order."""

    events: tuple[tuple[str, Value], ...] = ()
    notices: tuple[Notice, ...] = ()


@dataclass(frozen=True, slots=True)
class Picture:
    """A picture as its pixels, row by row: the shape of the array, and its bytes."""

    shape: tuple[int, ...]
    pixels: bytes | bytearray


REQUESTS: Mapping[str, tuple[tuple[Any, ...], Any]] = {
    "open": ((Spec,), OpenFailure | None), "start": ((), Outcome), "advance": ((int, tuple[Command, ...]), Outcome),
    "act": ((tuple[SceneAction, ...],), None), "show": ((bool,), WorldSnapshot), "state": ((), State),
    "look": ((), Picture), "watch": ((), Picture), "stop": ((), Outcome | None),
}  # fmt: skip
"""The requests, each with the types of its arguments, and of its answer."""
