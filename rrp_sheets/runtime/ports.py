"""What the engine needs of a world, and what passes between the two. A world is a simulator, a test, or a robot."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from rrp_sheets.model.exchange import Command, Happening
from rrp_sheets.model.values import Value


@dataclass(frozen=True, slots=True)
class Arrivals:
    """What a world has for the engine at one instant: values of sensor streams, in a fixed order, and happenings."""

    events: Sequence[tuple[str, Value]] = ()
    happenings: Sequence[Happening] = ()


class World(Protocol):
    """Where sensor values come from and commands go to, in lockstep with the engine's clock."""

    def start(self) -> Arrivals:
        """Make everything ready; the arrivals of time 0. Raises RunBroken when a device fails to start."""
        ...

    def advance(self, now_us: int, commands: Sequence[Command]) -> Arrivals:
        """Carry out `commands`, let the world go on until `now_us`, and return what arrived meanwhile."""
        ...

    def stop(self) -> None:
        """Bring the robot to its safe rest and let everything go; in bounded time, whatever hangs."""
        ...
