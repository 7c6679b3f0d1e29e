"""What all actuators share: what they work with, and how a value that is wrong for them is told."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from rrp_sheets.model.exchange import Command, DeviceUse, Notice
from rrp_sheets.model.names import key
from rrp_sheets.model.values import Value, show
from rrp_sheets.sim.actuators.lamps import Eyes
from rrp_sheets.sim.arbitration import Arbiter
from rrp_sheets.sim.body import Body
from rrp_sheets.sim.faces import Faces
from rrp_sheets.sim.keyframes import Motions
from rrp_sheets.sim.stage import Stage
from rrp_sheets.sim.stance import Stance
from rrp_sheets.sim.tracker import Trackers
from rrp_sheets.sim.voice import Voice

Tell = Callable[[Notice], None]


@dataclass(frozen=True)
class Parts:
    """What actuators work with."""

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


class SimActuator(Protocol):
    """Carries out the orders of one actuator stream."""

    def take(self, order: Command, us: int) -> None:
        """Carry out an order, which is not blank."""
        ...

    def blank(self, order: Command, us: int) -> None:
        """End what the stream does and has waiting."""
        ...


class Base:
    """An actuator stream with its settings and the resources that it uses."""

    def __init__(self, spec: DeviceUse, parts: Parts) -> None:
        self.spec = spec
        self.parts = parts
        self.settings: Mapping[str, Value] = spec.settings
        self.uses = parts.body.robot.devices[key(spec.device)].resources_for(spec.settings)

    def blank(self, order: Command, us: int) -> None:
        """End what the stream does and has waiting."""
        self.parts.arbiter.stop(order.stream, us)

    def wrong(self, order: Command, needs: str) -> None:
        """Tell that a value cannot be used here."""
        self.fail(order, f"{self.spec.name} cannot use {show(order.value)}: it needs {needs}.")

    def fail(self, order: Command, text: str, kind: str = "error") -> None:
        """Tell why an order is not carried out; it is over."""
        self.parts.tell(Notice(kind, text, order.stream, order.row))
        self.parts.arbiter.at_once(order, completed=False)

    @property
    def refused(self) -> str:
        """What is told when something of a larger priority is going on."""
        return f"{self.spec.name} does nothing now: what moves the robot has a higher priority."

    def clamp(self, order: Command, what: str, value: float, limits: tuple[float, float], unit: str = "") -> float:
        """The value within its limits, telling when that changes it."""
        limited = min(max(value, limits[0]), limits[1])
        if limited != value:
            text = f"{what}: {value:.4g} → {limited:.4g}{unit}, its limit."
            self.parts.tell(Notice("clamp", text, order.stream, order.row))
        return limited


def as_number(value: Value) -> float | None:
    """The value as a number, or None when it is none (TRUE and FALSE are none).

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
