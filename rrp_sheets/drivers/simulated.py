"""Driver of the simulated robot: the engine's world, backed by a simulator process."""

from __future__ import annotations

import socket
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rrp_sheets.engine.ports import World
from rrp_sheets.errors import MissingPart, RunBroken, SheetsError
from rrp_sheets.model.exchange import DONE, Arrivals, Command, DeviceUse, SceneAction, WorldSnapshot, commanded
from rrp_sheets.model.names import key
from rrp_sheets.model.values import RecordType, Value
from rrp_sheets.private import private_folder
from rrp_sheets.robots.catalogue import Robot
from rrp_sheets.sim.process import LOOK_EVERY, REMEDY_DIED, REQUESTS, OpenFailure, Picture, Simulator, Spec, require
from rrp_sheets.texts import N_, os_reason
from rrp_sheets.workers.codec import pack, unpack
from rrp_sheets.workers.transport import MessageReader, encode, ready

if TYPE_CHECKING:  # numpy may be missing; then there is no simulator
    from rrp_sheets.model.exchange import WorldState
    from rrp_sheets.perception.pinhole import Pixels


class SimulatedWorld(World):
    """A robot simulated in a process of its own. Every method waits for the answer, or raises RunBroken.

    Args:
        sensors: the sensors in use; their values arrive in this order.
        dones: done streams, which report the end of commands, each with its actuator stream.
        out: the folder of the run, for `say-001.wav`, …, `film.gif` and `strip.png`; None writes nothing.
        faces: the file that keeps remembered faces beyond the run; None keeps none.
        requests: the connection to a simulator that a supervisor has started; None starts one here.
        ending: waits until the supervisor has reported how that simulator ended, and returns it as a sentence.
        seed, frame_rate, film, record, camera, title, language, beside: as in `Spec`.

    Raises:
        MissingPart: when the simulator is not installed.
    """

    def __init__(
        self, robot: Robot, sensors: Sequence[DeviceUse], actuators: Sequence[DeviceUse],
        scene: Sequence[SceneAction] = (), *, dones: Mapping[str, str] | None = None, seed: int = 0,
        frame_rate: int = 30, out: Path | None = None, film: bool = False, record: bool = False, camera: bool = True,
        title: str = "", language: str = "en", beside: Path | None = None, faces: Path | None = None,
        requests: socket.socket | None = None, ending: Callable[[], str] | None = None,
    ) -> None:  # fmt: skip
        if out is not None:
            try:
                private_folder(out)
            except OSError as error:
                message = N_("The folder “{out}” cannot be made ({reason}).", out=str(out), reason=os_reason(error))
                raise SheetsError(message, N_("Name another folder with --out.")) from None
        self._records: dict[str, RecordType] = {}
        for use in sensors:
            found = robot.find(use.device)
            if found is not None and found.type.payload is not None:
                self._records[use.stream] = found.type.payload
        self._records.update(dict.fromkeys(dones or (), DONE))
        self._spec = Spec(
            robot=replace(robot, names={}),  # how its devices may be named the simulator need not know
            sensors=_specs(sensors, robot), actuators=_specs(actuators, robot),
            dones={of: done for done, of in (dones or {}).items()}, scene=tuple(scene), seed=seed,
            frame_rate=frame_rate, out=str(out.resolve()) if out is not None else "", film=film, record=record,
            camera=camera, title=title, language=language, beside=str(beside.resolve()) if beside is not None else "",
            faces=str(faces.resolve()) if faces is not None else "",
        )  # fmt: skip
        self._awaited = frozenset((dones or {}).values())
        self._values: dict[int, Value] = {}  # of commands that go on, by their numbers: records keep their types
        self._numbers = count(1)
        require()
        self._given = requests
        self._ending = ending or (lambda: "")
        self._link: socket.socket | None = None
        self._simulator: Simulator | None = None
        self._request = 0
        self._broken = False

    @property
    def pid(self) -> int | None:
        """Process id of a simulator that was started here, while it runs."""
        return self._simulator.pid if self._simulator is not None else None

    def start(self) -> Arrivals:
        """Start the simulator, make the world, and return the arrivals of time 0."""
        requests = self._given
        if requests is None:
            self._simulator = Simulator()
            requests = self._simulator.requests
        self._link = requests
        self._reader = MessageReader(requests)
        with ExitStack() as unless_open:
            unless_open.callback(self.kill)  # also after Ctrl-C: no process is left behind
            failure = self._ask("open", self._spec)
            if isinstance(failure, OpenFailure):
                raise (MissingPart if failure.missing else SheetsError)(failure.message, failure.remedy)
            unless_open.pop_all()
        return self._arrivals(self._ask("start"))

    def advance(self, now_us: int, commands: Sequence[Command]) -> Arrivals:
        """Carry out commands and go on until `now_us`."""
        return self._arrivals(self._ask("advance", now_us, tuple(self._numbered(command) for command in commands)))

    def stop(self) -> Arrivals:
        """Bring the robot to rest, write the film, and end the process; it is ended in any case.

        After a failure that was raised already, there is nothing to bring to rest and nothing more to report.
        """
        if self._link is None:
            return Arrivals()
        try:
            return Arrivals() if self._broken else self._arrivals(self._ask("stop"))
        finally:
            self.kill()

    def kill(self) -> None:
        """Close the connection, and end a process that was started here; a supervisor's simulator ends by itself."""
        link, simulator = self._link, self._simulator
        self._link = self._simulator = None
        if link is not None:
            link.close()
        if simulator is not None:
            simulator.close()  # it ends by itself when the connection closes, unless it is busy

    def state(self) -> WorldState:
        """Return the present state of the world: joints, torso, eyes, speech, things."""
        state: WorldState = self._ask("state")
        return state

    def act(self, actions: Sequence[SceneAction]) -> None:
        """Apply scene actions that are triggered by hand, now."""
        self._ask("act", tuple(actions))

    def show(self, picture: bool) -> WorldSnapshot:
        """Return the world for a display, with the robot's camera picture if wanted."""
        shown: WorldSnapshot = self._ask("show", picture)
        return shown

    def look(self) -> Pixels:
        """Return the present picture of the head camera: (240, 320, 3), 0 to 255."""
        return _image(self._ask("look"))

    def watch(self) -> Pixels:
        """Return a present picture of the robot from outside: (320, 560, 3), 0 to 255."""
        return _image(self._ask("watch"))

    # ---- requests
    def _ask(self, request: str, *arguments: object) -> Any:
        if self._link is None:
            raise RunBroken(N_("The simulator is not running."), N_("Start the run again."))
        self._request += 1
        try:
            takes, gives = REQUESTS[request]
            packed = (pack(part, hint) for hint, part in zip(takes, arguments, strict=True))
            self._link.sendall(encode([self._request, request, *packed]))
            while True:
                for number, answer in self._receive(self._link):
                    if number == self._request:  # an older one belongs to a request that Ctrl-C broke off
                        return unpack(gives, answer)
        except OSError:
            self._broken = True
            words = self._simulator.exit_words() if self._simulator is not None else self._ending()
            unexpected = N_("The simulator ended unexpectedly{how}.", how=words)
            raise RunBroken(words if words.endswith(".") else unexpected, REMEDY_DIED) from None

    def _receive(self, link: socket.socket) -> list[list[Any]]:
        """Wait for answers; a simulator that does not work any more is ended by its supervisor, or here."""
        simulator = self._simulator
        while simulator is not None and not ready(link.fileno(), LOOK_EVERY):
            simulator.hear()
            failure = simulator.failure()
            if failure:
                self._broken = True
                raise RunBroken(failure, REMEDY_DIED)
        messages = self._reader.receive()
        if messages is None:
            raise ConnectionResetError
        return messages

    # ---- values
    def _arrivals(self, found: Arrivals) -> Arrivals:
        """Return what the simulator gives with its records, which come as mappings of their fields."""
        return replace(found, events=tuple((stream, self._value(stream, value)) for stream, value in found.events))

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
        return self._records[stream].make(**value)


def _specs(uses: Sequence[DeviceUse], robot: Robot) -> tuple[DeviceUse, ...]:
    """Return the devices in use with all settings; those not given come from the catalogue."""
    return tuple(
        DeviceUse(u.stream, u.name, u.device, robot.devices[key(u.device)].with_defaults(u.settings)) for u in uses
    )


def _image(picture: Picture) -> Pixels:
    import numpy as np

    return np.frombuffer(picture.pixels, np.uint8).reshape(picture.shape)
