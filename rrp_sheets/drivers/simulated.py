"""Driver of the simulated robot: the engine's world, backed by a simulator process."""

from __future__ import annotations

import socket
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING

from rrp_sheets.engine.ports import Arrivals, World
from rrp_sheets.errors import SheetsError
from rrp_sheets.model.exchange import DONE, Command, DeviceUse, SceneAction, State, WorldSnapshot, commanded
from rrp_sheets.model.names import key
from rrp_sheets.model.values import RecordType, Value
from rrp_sheets.private import private_folder
from rrp_sheets.robots.catalogue import Robot
from rrp_sheets.sim.process import Outcome, SimProcess, Spec
from rrp_sheets.texts import N_

if TYPE_CHECKING:  # numpy may be missing; then there is no simulator
    from rrp_sheets.sim.camera import Pixels


class SimulatedWorld(World):
    """A robot simulated in a process of its own.

    Args:
        robot: its catalogue.
        sensors: the sensors in use; their values arrive in this order.
        actuators: the actuators in use.
        scene: what happens in the world.
        dones: done streams, which report the end of commands, each with its actuator stream.
        seed: of the room's random noise.
        frame_rate: frames a second of the engine; divides 240.
        out: the folder of the run, for `say-001.wav`, …, `film.gif` and `strip.png`; None writes nothing.
        film: whether to record the film and the strip of moments.
        record: whether to record poses and camera pictures, for looking back at the run.
        camera: whether pictures of the robot's camera may be kept.
        title: shown on the strip.
        beside: the folder of the workbook, for its sounds.
        faces: the file that keeps remembered faces beyond the run; None keeps none.
        requests: the connection to a simulator that a supervisor has started; None starts one here.
        ending: waits until the supervisor has reported how that simulator ended, and returns it.

    Raises:
        MissingPart: when the simulator is not installed.
    """

    def __init__(
        self,
        robot: Robot,
        sensors: Sequence[DeviceUse],
        actuators: Sequence[DeviceUse],
        scene: Sequence[SceneAction] = (),
        *,
        dones: Mapping[str, str] | None = None,
        seed: int = 0,
        frame_rate: int = 30,
        out: Path | None = None,
        film: bool = False,
        record: bool = False,
        camera: bool = True,
        title: str = "",
        beside: Path | None = None,
        faces: Path | None = None,
        requests: socket.socket | None = None,
        ending: Callable[[], str] | None = None,
    ) -> None:
        if out is not None:
            try:
                private_folder(out)
            except OSError as error:
                raise SheetsError(
                    N_("The folder “{out}” cannot be made ({reason}).", out=str(out), reason=error.strerror),
                    N_("Name another folder with --out."),
                ) from None
        self._records: dict[str, RecordType] = {}
        for use in sensors:
            found = robot.find(use.device)
            if found is not None and found.type.payload is not None:
                self._records[use.stream] = found.type.payload
        self._records.update(dict.fromkeys(dones or (), DONE))
        spec = Spec(
            robot=_bare(robot), sensors=_specs(sensors, robot), actuators=_specs(actuators, robot),
            dones={of: done for done, of in (dones or {}).items()}, scene=tuple(scene), seed=seed,
            frame_rate=frame_rate, out=str(out.resolve()) if out is not None else "", film=film, record=record,
            camera=camera, title=title,
            beside=str(beside.resolve()) if beside is not None else "",
            faces=str(faces.resolve()) if faces is not None else "",
        )  # fmt: skip
        self._awaited = frozenset((dones or {}).values())
        self._values: dict[int, Value] = {}  # of commands that go on, by their numbers: records keep their types
        self._numbers = count(1)
        self._process = SimProcess(spec, requests, ending)

    @property
    def pid(self) -> int | None:
        """Process id of a simulator that was started here, while it runs."""
        return self._process.pid

    def start(self) -> Arrivals:
        """Start the simulator and return the arrivals of time 0. Raises RunBroken when it does not start."""
        self._process.open()
        return self._arrivals(self._process.start())

    def advance(self, now_us: int, commands: Sequence[Command]) -> Arrivals:
        """Carry out commands and go on until `now_us`. Raises RunBroken when the simulator has died."""
        return self._arrivals(self._process.advance(now_us, [self._numbered(command) for command in commands]))

    def stop(self) -> Arrivals:
        """Bring the robot to rest, write the film and end the process."""
        return self._arrivals(self._process.stop())

    def kill(self) -> None:
        """End the process at once, as the robot stands."""
        self._process.kill()

    def state(self) -> State:
        """Return the present state of the world: joints, torso, eyes, speech, things."""
        return self._process.state()

    def act(self, actions: Sequence[SceneAction]) -> None:
        """Apply scene actions that are triggered by hand, now."""
        self._process.act(actions)

    def show(self, picture: bool) -> WorldSnapshot:
        """Return the world for a display, with the robot's camera picture if wanted."""
        return self._process.show(picture)

    def look(self) -> Pixels:
        """Return the present picture of the head camera: (240, 320, 3), 0 to 255."""
        return self._process.look()

    def watch(self) -> Pixels:
        """Return a present picture of the robot from outside: (320, 560, 3), 0 to 255."""
        return self._process.watch()

    def _arrivals(self, outcome: Outcome) -> Arrivals:
        events = tuple((stream, self._value(stream, value)) for stream, value in outcome.events)
        return Arrivals(events, outcome.notices)

    def _numbered(self, command: Command) -> Command:
        if command.stream not in self._awaited:
            return command
        number = next(self._numbers)
        self._values[number] = commanded(command.value)
        return replace(command, number=number)

    def _value(self, stream: str, value: Value) -> Value:
        if not isinstance(value, Mapping):
            return value
        if self._records[stream] is DONE:
            value = {**value, "value": self._values.pop(value["value"])}
        return self._records[stream].make(**{key(name): v for name, v in value.items()})


def _bare(robot: Robot) -> Robot:
    """Return what the simulator needs of a robot: not how its devices may be named."""
    return replace(robot, names={})


def _specs(uses: Sequence[DeviceUse], robot: Robot) -> tuple[DeviceUse, ...]:
    """Return the devices in use with all settings; those not given come from the catalogue."""
    return tuple(
        DeviceUse(u.stream, u.name, u.device, robot.devices[key(u.device)].with_defaults(u.settings)) for u in uses
    )
