"""Base of all actuators: the parts of the world that they use, and reports on values that they cannot use."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from rrp_sheets.model.exchange import Command, DeviceUse, Notice
from rrp_sheets.model.names import key
from rrp_sheets.model.values import Value, show
from rrp_sheets.perception.faces import Faces
from rrp_sheets.sim.arbitration import Arbiter, Tell
from rrp_sheets.sim.body import Body, Eyes, Motions
from rrp_sheets.sim.sounds import Voice
from rrp_sheets.sim.stage import Stage
from rrp_sheets.sim.stance import Stance
from rrp_sheets.texts import N_

if TYPE_CHECKING:  # a tracker is an actuator too
    from rrp_sheets.sim.actuators.tracker import Trackers


@dataclass(frozen=True)
class Parts:
    """Parts of the simulated world that actuators use."""

    body: Body
    stance: Stance
    eyes: Eyes
    voice: Voice
    faces: Faces
    trackers: Trackers
    motions: Motions
    arbiter: Arbiter
    tell: Tell
    seeing: frozenset[str]  # the sensor streams that tell where something is
    stage: Stage
    beside: Path | None = None  # the folder of the workbook


class SimActuator(ABC):
    """Carries out the commands of one actuator stream, with its settings and the resources that it uses.

    A subclass names the device of the catalogue that it is for: `class Walk(SimActuator, device="Walk")`.
    """

    def __init_subclass__(cls, device: str = "") -> None:
        if device:
            ACTUATORS[device] = cls

    def __init__(self, spec: DeviceUse, parts: Parts) -> None:
        self.spec, self.parts = spec, parts
        self.settings: Mapping[str, Value] = spec.settings
        self.uses = parts.body.robot.devices[key(spec.device)].resources_for(spec.settings)
        self.refused = N_("{name} does nothing now: the current movement has a higher priority.", name=spec.name)

    @abstractmethod
    def take(self, command: Command, us: int) -> None:
        """Carry out a command, which is not blank."""

    def blank(self, command: Command, us: int) -> None:
        """End the running and waiting commands of the stream."""
        self.parts.arbiter.stop(command.stream, us)

    def wrong(self, command: Command, needs: str) -> None:
        """Report that a value cannot be used here."""
        name, value = self.spec.name, show(command.value)
        self.fail(command, N_("{name} cannot use {value}: it needs {needs}.", name=name, value=value, needs=needs))

    def fail(self, command: Command, text: str, kind: str = "error") -> None:
        """Report why a command is not carried out, and end it."""
        self.parts.tell(Notice(kind, text, command.stream, command.row))
        self.parts.arbiter.at_once(command, completed=False)

    def clamp(self, command: Command, what: str, value: float, limits: tuple[float, float], unit: str = "") -> float:
        """Return the value limited to its range, and report it when that changes the value."""
        limited = min(max(value, limits[0]), limits[1])
        if limited != value:
            text = N_("{what}: {value:.4g} → {limited:.4g}{unit}, its limit.", what=what, value=value, limited=limited,
                      unit=unit)  # fmt: skip
            self.parts.tell(Notice("clamp", text, command.stream, command.row))
        return limited


ACTUATORS: dict[str, type[SimActuator]] = {}
"""The class for each device."""


def as_number(value: Value) -> float | None:
    """Return the value as a number, or None when it is not one (TRUE and FALSE are not).

    >>> as_number(2), as_number(True), as_number("2")
    (2.0, None, None)
    """
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return None
    try:
        number = float(value)
    except OverflowError:  # a whole number with hundreds of digits
        return None
    return number if math.isfinite(number) else None
