"""Movements of a run: for each command of an actuator that moves the robot, when its joints began and ended to move."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rrp_sheets.model.names import key
from rrp_sheets.model.run_files import POSES, RecordedValue
from rrp_sheets.recording.trace_reader import TraceReader, entry_of
from rrp_sheets.robots.catalogue import DeviceType, Robot

MOVED = 0.02  # rad, or share of a hand's opening
REPEATED = 0.5  # s: a command that comes sooner after the one before, from the same row, goes on with it
_STILL = 0.3  # s without movement after which it has ended
_MOST = 50_000  # of a run, as the help says
_MOVING = 0.005  # rad, or share of a hand's opening: a joint that changes by more between two poses is moving
_LONGEST_LINE = 1 << 18  # bytes


@dataclass
class Movement:
    """A command, its repetitions, and when the joints that it drove moved; None where that is not recorded."""

    command: RecordedValue
    commands: int = 1
    until: float = math.inf  # when the stream's next command came
    begin: float | None = None
    end: float | None = None
    latest: float = 0.0  # when the command was repeated
    angles: dict[str, float] = field(default_factory=dict)  # from which movement is measured
    joints: frozenset[str] = frozenset()
    under_way: frozenset[str] = frozenset()  # joints that were moving when the command came

    def see(self, t: float, angles: Mapping[str, float], drives: Mapping[str, frozenset[str]]) -> bool:
        """Take in a pose; return whether later ones may still belong to the command."""
        if t > self.until or (self.command.row not in drives and any(self.joints & mine for mine in drives.values())):
            self.close(min(t, self.until))
            return False
        self.joints |= drives.get(self.command.row, frozenset())
        if any(abs(angles.get(j, self.angles.get(j, 0.0)) - self.angles.get(j, 0.0)) > MOVED for j in self.joints):
            if self.end is None and not self.joints & self.under_way:
                self.begin = t
            self.end, self.angles = t, dict(angles)
        return True

    def close(self, t: float) -> None:
        """Leave the end open when the joints were still moving as something else took over, or the run ended."""
        if self.end is not None and t - self.end < _STILL:
            self.end = None


def movements(reader: TraceReader, robot: Robot | None) -> list[Movement]:
    """Return the movements of a run in the order of their commands; none when its robot is not known."""
    commands = _commands(reader, robot) if robot else []
    waiting, running = iter(commands), list[Movement]()
    coming, t, angles = next(waiting, None), 0.0, dict[str, float]()
    drives: dict[str, frozenset[str]] = {}
    moved: dict[str, float] = {}  # by joint: when it last moved
    for pose in _poses(reader.path.with_name(POSES)) if commands else ():
        t = pose["t"]
        while coming is not None and coming.command.t < t:
            since, coming.angles = coming.command.t - _STILL, dict(angles)
            coming.under_way = frozenset(joint for joint, at in moved.items() if at > since)
            running.append(coming)
            coming = next(waiting, None)
        now = {n: a for n, a in _named(pose, "joints").items() if _is_number(a)}
        moved.update({n: t for n, a in now.items() if abs(a - angles.get(n, a)) > _MOVING})
        angles.update(now)
        if "drives" in pose or pose.get("full") is True:
            named = _named(pose, "drives").items()
            drives = {r: frozenset(n for n in j if isinstance(n, str)) for r, j in named if isinstance(j, list)}
        running = [one for one in running if one.see(t, angles, drives)]
    for one in running:
        one.close(t)
    return commands


def _commands(reader: TraceReader, robot: Robot) -> list[Movement]:
    """Return the commands that move joints, those that only repeat one joined to it."""
    parts = frozenset(robot.data["chains"].values())
    devices = {s.name: robot.devices.get(key(s.device)) for s in reader.header.streams if s.kind == "actuator"}
    moving = {name for name, device in devices.items() if device and parts & _resources(device)}
    found: list[Movement] = []
    last: dict[str, Movement] = {}
    for event in reader:
        if not isinstance(event, RecordedValue) or event.stream not in moving:
            continue
        before = last.get(event.stream)
        if before is not None and before.until == math.inf:
            repeats = event.row == before.command.row and event.t - before.latest < REPEATED
            if repeats and event.value is not None:
                before.commands, before.latest = before.commands + 1, event.t
                continue
            before.until = event.t
        if event.value is not None and len(found) < _MOST:
            last[event.stream] = Movement(event, latest=event.t)
            found.append(last[event.stream])
    return found


def _resources(device: DeviceType) -> set[str]:
    choices = (uses for by in device.resources_by.values() for uses in by.values())
    return {*device.resources, *(one for uses in choices for one in uses)}


def _poses(path: Path) -> Iterator[dict[str, Any]]:
    if path.is_file() and not path.is_symlink():
        with path.open("rb") as file:
            for line in iter(lambda: file.readline(_LONGEST_LINE), b""):
                pose = entry_of(line)
                if _is_number(pose.get("t")):
                    yield pose


def _is_number(value: Any) -> bool:
    return type(value) in (int, float) and abs(value) < 1e9


def _named(pose: Mapping[str, Any], part: str) -> Mapping[str, Any]:
    found = pose.get(part)
    return found if isinstance(found, dict) else {}
