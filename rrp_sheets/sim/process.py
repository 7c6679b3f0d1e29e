"""Control of the simulator's process, for the supervisor that starts it, its messages, and whether it can run here.

The supervisor has a connection of its own, over which it can bring the robot to rest whatever the engine does; the
engine has another one, for its requests (`drivers/simulated.py`). Messages are plain data only.
"""

from __future__ import annotations

import importlib.metadata
import importlib.util
import platform
import socket
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from rrp_sheets.errors import MissingPart
from rrp_sheets.model.exchange import Arrivals, Command, DeviceUse, Notice, SceneAction, WorldSnapshot, WorldState
from rrp_sheets.robots.catalogue import Robot
from rrp_sheets.texts import N_
from rrp_sheets.workers.codec import unpack
from rrp_sheets.workers.transport import Liveness, SharedCounters, cpu_clock
from rrp_sheets.workers.worker_process import Task, WorkerProcess

ALONE_WITHIN = 5.0  # s, of its processor time or without any, to bring the robot to rest when its supervisor has gone
# Pictures and sound need more memory than its starter may have.
SIMULATOR = Task("rrp_sheets.sim.server.serve", ALONE_WITHIN, ALONE_WITHIN, memory=True)
OPEN_WITHIN = 90.0  # s of its processor time to make the world; usually 2
COMPUTE_WITHIN = 20.0  # s of its processor time without progress; usually some ms, for the strip of moments 0.5
ANSWER_STILL_WITHIN = 10.0  # s without processor time while it has a request
REST_BEGINS_WITHIN = 1.0  # s from Stop, of its processor time or without any: then it is ended
LOOK_EVERY = 0.1  # s
REMEDY_DIED = N_("Run it again; if it happens again, please report it with the workbook.")
PYBULLETS = ("pybullet", "pybullet-arm64")  # the packages that bring the module pybullet; one of them is installed
NEEDED = {"pybullet": "pybullet", "cv2": "opencv-python-headless", "numpy": "numpy", "PIL": "pillow"}
BEATS, STATE = range(2)
"""Places of the simulator's heartbeat: a number that grows while it goes on; what it does."""
PLACES = 2
IDLE, BUSY, OPENING = range(3)
"""States of the simulator: waits for a request, carries one out or brings the robot to rest, makes the world."""


@dataclass(frozen=True, slots=True)
class Spec:
    """Everything the simulator must know at the start."""

    robot: Robot  # the catalogue, with the folder of the robot's model
    sensors: tuple[DeviceUse, ...] = ()
    actuators: tuple[DeviceUse, ...] = ()
    scene: tuple[SceneAction, ...] = ()  # in the order of their times
    seed: int = 0  # of the room's random noise
    frame_rate: int = 30  # frames a second; divides 240
    out: str = ""  # the folder for sound and film, or empty for none
    film: bool = False  # whether to record the film and the strip of moments
    record: bool = False  # whether to record poses and camera pictures, for looking back at the run
    camera: bool = True  # whether pictures of the robot's camera may be kept
    title: str = ""  # shown on the strip
    language: str = "en"  # of the captions of film and strip
    beside: str = ""  # the folder of the workbook, for its sounds; empty for none
    faces: str = ""  # the file that keeps remembered faces beyond the run, or empty
    dones: Mapping[str, str] = field(default_factory=dict)  # by actuator stream: the stream that gets reports of ends


@dataclass(frozen=True, slots=True)
class OpenFailure:
    """Reason why a world cannot be made; `missing` when a part of the program is not installed."""

    message: str
    remedy: str
    missing: bool


@dataclass(frozen=True, slots=True)
class Picture:
    """A picture as its pixels, row by row: the shape of the array, and its bytes."""

    shape: tuple[int, ...]
    pixels: bytes | bytearray


REQUESTS: Mapping[str, tuple[tuple[Any, ...], Any]] = {
    "open": ((Spec,), OpenFailure | None), "start": ((), Arrivals), "advance": ((int, tuple[Command, ...]), Arrivals),
    "act": ((tuple[SceneAction, ...],), None), "show": ((bool,), WorldSnapshot), "state": ((), WorldState),
    "look": ((), Picture), "watch": ((), Picture), "stop": ((), Arrivals | None),
}  # fmt: skip
"""The requests, each with the types of its arguments, and of its answer."""


def missing() -> list[str]:
    """Return the packages that the simulator needs and this Python does not have."""
    return [package for module, package in NEEDED.items() if importlib.util.find_spec(module) is None]


def require() -> None:
    """Raise MissingPart when the simulator cannot run here."""
    lacking = missing()
    if lacking:
        one = N_("The simulator needs {packages}. Python {version} on this computer ({system}) does not have it.")
        many = N_("The simulator needs {packages}. Python {version} on this computer ({system}) does not have them.")
        why = N_(one if len(lacking) == 1 else many, packages=", ".join(lacking), version=platform.python_version(),
                 system=f"{platform.system()} {platform.machine()}")  # fmt: skip
        remedy = N_("Install rrp-sheets with Python 3.11, 3.12 or 3.13 on Linux x86-64, macOS or Windows (in WSL). "
                    "Checking, drawing and explaining work without it.")  # fmt: skip
        raise MissingPart(why, remedy)


def about() -> str:
    """Return in a line whether the simulator can run here: with which package, or what is missing."""
    lacking = missing()
    if lacking:
        return N_("no, {packages} missing", packages=", ".join(lacking))
    found = [f"{d.name} {d.version}" for d in importlib.metadata.distributions() if d.name in PYBULLETS]
    return N_("yes, {packages}", packages=", ".join(sorted(set(found))) or "pybullet")


class Simulator:
    """A simulator process as its supervisor sees it; raises MissingPart when a package that it needs is missing."""

    def __init__(self) -> None:
        require()
        self.requests, theirs = socket.socketpair()  # the engine's end: close it when the engine has it
        self._heartbeat = SharedCounters(PLACES)
        with theirs:
            self._child = WorkerProcess(SIMULATOR, theirs.fileno(), self._heartbeat.fd)
        self._cpu = cpu_clock(self._child.pid)
        self._liveness = Liveness(self._cpu)
        self._asked: float | None = None  # its processor time when it was told to rest
        self._still_before_rest = 0.0
        self.resting = False  # whether the robot has begun its rest: it is silent, and its joints are halted
        self.gone = False  # the process has ended, or is about to
        self.rested: tuple[Notice, ...] | None = None  # once it rests without its engine: the last notices

    @property
    def pid(self) -> int:
        """Process id of the simulator."""
        return self._child.pid

    def fileno(self) -> int:
        """Return the file descriptor of the connection, to wait for messages."""
        return self._child.fileno()

    @property
    def working(self) -> bool:
        """True while the simulator is busy, so that the engine waits for it and not the other way round."""
        return self._heartbeat.numbers[STATE] != IDLE

    def rest(self) -> None:
        """Bring the robot to rest now, whatever the engine does: from any thread, without waiting."""
        if self._asked is None:
            self._asked = self._cpu()
            self._child.say("rest")

    def hear(self) -> None:
        """Process the messages that have arrived from the simulator."""
        while not self.gone:
            messages = self._child.receive(0)
            if messages is None:
                self.gone = True
            elif not messages:
                return
            for kind, *words in messages or ():
                if kind == "resting":
                    self.resting = True
                elif kind == "rested":
                    self.rested = unpack(tuple[Notice, ...], words[0])

    def failure(self) -> str:
        """Return why the process must be ended, as a sentence; empty while it works. Call it ten times a second."""
        numbers = self._heartbeat.numbers
        state, opened = numbers[STATE], numbers[STATE] != OPENING
        waits_for_rest = self._asked is not None and not self.resting and opened
        passed = self._liveness.look(numbers[BEATS], has_work=state != IDLE or waits_for_rest)[1]
        used, still = self._liveness.computing, self._liveness.still
        if self.gone:
            return ""
        if waits_for_rest and self._asked is not None:
            since = self._cpu() - self._asked
            self._still_before_rest = self._still_before_rest + passed if still else 0.0
            if max(since, self._still_before_rest) > REST_BEGINS_WITHIN:
                return N_("The simulator did not react to Stop within {seconds:g} s and was stopped. The robot did "
                          "not reach its rest position.", seconds=REST_BEGINS_WITHIN)  # fmt: skip
        if still > ANSWER_STILL_WITHIN:
            return N_("The simulator has not answered for {seconds:g} s.", seconds=ANSWER_STILL_WITHIN)
        limit = COMPUTE_WITHIN if opened else OPEN_WITHIN
        if used > limit and state:
            return N_("The simulator has computed for {seconds:g} s without an answer.", seconds=limit)
        return ""

    def exit_words(self) -> str:
        """Return how the process ended, in brackets."""
        return self._child.exit_summary()

    def kill(self) -> None:
        """End the process at once."""
        self._child.kill()
        self.gone = True

    def close(self, within: float = 1.0) -> None:
        """Close the connections and let the process end within some seconds; else end it."""
        self.requests.close()
        self._child.close(within)
        self._heartbeat.close()
        self.gone = True
