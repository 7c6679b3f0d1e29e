"""Interfaces between engines and worlds (a simulator, a test, or a robot), and the heartbeat that a watchdog reads."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Protocol

from rrp_sheets.model.exchange import Arrivals, Command, DeviceUse, Notice, SceneAction, WorldSnapshot

if TYPE_CHECKING:
    from rrp_sheets.engine.realtime import EventQueue, SnapshotThrottle


class World(Protocol):
    """Source of sensor values and target of commands, in lockstep with the engine's clock."""

    def start(self) -> Arrivals:
        """Make everything ready; the arrivals of time 0. Raises RunBroken when a device fails to start."""
        ...

    def advance(self, now_us: int, commands: Sequence[Command]) -> Arrivals:
        """Carry out `commands`, let the world go on until `now_us`, and return what arrived meanwhile."""
        ...

    def act(self, actions: Sequence[SceneAction]) -> None:
        """Let something happen in the world now, by hand."""
        ...

    def show(self, picture: bool) -> WorldSnapshot:
        """The world as it is, for a display; with what the robot sees when that is wanted. It changes nothing."""
        ...

    def stop(self) -> Arrivals | None:
        """Bring the robot to its safe rest in bounded time, whatever hangs.

        Returns the ends of commands that were being carried out, and notices; None when there are none to come.
        """
        ...


class Sensor(Protocol):
    """A sensor of a world that goes by itself; what its own threads deliver is only put into the event queue."""

    def start(self, queue: EventQueue) -> None:
        """Begin to deliver. Raises RunBroken when it cannot."""
        ...

    def stop(self) -> None:
        """Deliver nothing more."""
        ...


class Actuator(Protocol):
    """An actuator of a world that goes by itself. It is called on a thread of its own, and may take its time."""

    def start(self) -> None:
        """Make ready. Raises RunBroken when it cannot."""
        ...

    def take(self, command: Command) -> None:
        """Carry out a command. Raises RunBroken when the run cannot go on."""
        ...

    def rest(self) -> None:
        """Come to a safe rest."""
        ...


class LiveWorld(Protocol):
    """A world that goes by itself, on the wall clock: devices one by one."""

    def open(self, queue: EventQueue) -> None:
        """Make the world ready. Raises RunBroken when it cannot be."""
        ...

    def sensor(self, use: DeviceUse) -> Sensor:
        """The device of a sensor stream."""
        ...

    def actuator(self, use: DeviceUse) -> Actuator:
        """The device of an actuator stream."""
        ...

    def act(self, actions: Sequence[SceneAction]) -> None:
        """Let something happen in the world now, by hand, where that can be done."""
        ...

    def show(self, showing: SnapshotThrottle) -> None:
        """Put the world into the event queue for a display, as often as that wants it."""
        ...

    def wake(self) -> None:
        """The clock of the event queue, which stood still, goes on."""
        ...

    def close(self) -> Sequence[Notice] | None:
        """Let everything go, the robot in its safe rest; returns what happened meanwhile."""
        ...


INSTANT, SETTLING, RANK = range(3)
"""Places: how many instants (frames) have begun; 1 while one settles, else 0; the rank of the row being worked out."""
PLACES = 3
NO_ROW = -1
Heartbeat = list[int] | memoryview
"""Whole numbers by place."""
