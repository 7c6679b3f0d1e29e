"""Starts the simulator's process and talks to it, request by request."""

from __future__ import annotations

import importlib.metadata
import importlib.util
import platform
from collections.abc import Sequence
from multiprocessing.connection import Connection
from typing import TYPE_CHECKING, Any

from rrp_sheets.errors import MissingPart, RunBroken, SheetsError
from rrp_sheets.model.exchange import Command
from rrp_sheets.model.scene import SceneAction
from rrp_sheets.processes import Child
from rrp_sheets.sim.messages import Outcome, Refused, Shown, Spec, State

if TYPE_CHECKING:  # numpy may be missing; then there is no simulator
    from rrp_sheets.sim.camera import Image

START_WITHIN = 60.0  # s, on a slow and busy machine; usually 1 s
ANSWER_WITHIN = 10.0  # s, for one advance; usually some ms
STOP_WITHIN = 30.0  # s, with writing the film; usually 2 s
REMEDY_DIED = "Run it again; if it happens again, please report it with the workbook."
PYBULLETS = ("pybullet", "pybullet-arm64")  # the packages that bring the module pybullet; one of them is installed
NEEDED = {"pybullet": "pybullet", "cv2": "opencv-python-headless", "numpy": "numpy", "PIL": "pillow"}


def missing() -> list[str]:
    """The packages that the simulator needs and this Python does not have."""
    return [package for module, package in NEEDED.items() if importlib.util.find_spec(module) is None]


def require() -> None:
    """Raise MissingPart when the simulator cannot run here."""
    lacking = missing()
    if lacking:
        raise MissingPart(
            f"The simulator needs {', '.join(lacking)}. Python {platform.python_version()} on this computer "
            f"({platform.system()} {platform.machine()}) does not have {'it' if len(lacking) == 1 else 'them'}.",
            "Install rrp-sheets with Python 3.11, 3.12 or 3.13 on Linux x86-64, macOS or Windows (in WSL). "
            "Checking, drawing and explaining work without it.",
        )


def about() -> str:
    """Whether the simulator can run here, in a line: with which package, or what is missing."""
    lacking = missing()
    if lacking:
        return f"no, {', '.join(lacking)} missing"
    found = [f"{d.name} {d.version}" for d in importlib.metadata.distributions() if d.name in PYBULLETS]
    return f"yes, {', '.join(sorted(set(found))) or 'pybullet'}"


class SimProcess:
    """A simulated world in a process of its own. Every method waits for the answer, or raises RunBroken."""

    def __init__(self, spec: Spec) -> None:
        require()
        self._spec = spec
        self._link: Connection[Any, Any] | None = None
        self._child: Child | None = None
        self._number = 0
        self._broken = False

    @property
    def pid(self) -> int | None:
        """The process's number, while it runs."""
        return self._child.pid if self._child is not None else None

    def open(self) -> None:
        """Start the process and make the world."""
        self._child = Child("rrp_sheets.sim.child")
        self._link = Connection(self._child.link.detach())
        try:
            refused = self._ask(START_WITHIN, "open", self._spec)
            if isinstance(refused, Refused):
                raise (MissingPart if refused.missing else SheetsError)(refused.message, refused.remedy)
        except BaseException:  # Ctrl-C too: no process is left behind, and what happened is told further up
            self.kill()
            raise

    def start(self) -> Outcome:
        """The outcome of time 0."""
        return self._outcome(self._ask(START_WITHIN, "start"))

    def advance(self, now_us: int, orders: Sequence[Command]) -> Outcome:
        """Carry out orders and go on until `now_us`."""
        return self._outcome(self._ask(ANSWER_WITHIN, "advance", now_us, tuple(orders)))

    def state(self) -> State:
        """The world as it is."""
        state = self._ask(ANSWER_WITHIN, "state")
        assert isinstance(state, State)
        return state

    def act(self, actions: Sequence[SceneAction]) -> None:
        """Let something happen in the world now, by hand."""
        self._ask(ANSWER_WITHIN, "act", tuple(actions))

    def show(self, picture: bool) -> Shown:
        """The world for a display, with what the robot sees when that is wanted."""
        shown = self._ask(ANSWER_WITHIN, "show", picture)
        assert isinstance(shown, Shown)
        return shown

    def look(self) -> Image:
        """What the robot sees now, (240, 320, 3)."""
        picture: Image = self._ask(ANSWER_WITHIN, "look")
        return picture

    def watch(self) -> Image:
        """The robot from outside now, (320, 560, 3)."""
        picture: Image = self._ask(ANSWER_WITHIN, "watch")
        return picture

    def stop(self) -> Outcome:
        """Bring the robot to rest, write the film, and end the process; it is ended in any case.

        After a break that was told already there is nothing to bring to rest, and nothing more to tell.
        """
        if self._link is None:
            return Outcome()
        try:
            return Outcome() if self._broken else self._outcome(self._ask(STOP_WITHIN, "stop"))
        finally:
            self.kill()

    def kill(self) -> None:
        """End the process at once."""
        link, child = self._link, self._child
        self._link = self._child = None
        if link is not None:
            link.close()
        if child is not None:
            child.close(1.0)  # it ends by itself when the connection closes, unless it is busy

    def _ask(self, within: float, request: str, *arguments: object) -> Any:
        if self._link is None:
            raise RunBroken("The simulator is not running.", "Start the run again.")
        self._number += 1
        try:
            self._link.send((self._number, request, arguments))
            while True:
                if not self._link.poll(within):
                    self._broken = True
                    raise RunBroken(f"The simulator has not answered for {within:g} s.", REMEDY_DIED)
                number, answer = self._link.recv()
                if number == self._number:  # an older one belongs to a request that Ctrl-C broke off
                    return answer
        except (EOFError, OSError):
            self._broken = True
            words = self._child.last_words() if self._child is not None else ""
            raise RunBroken(f"The simulator has ended unexpectedly{words}.", REMEDY_DIED) from None

    @staticmethod
    def _outcome(answer: Any) -> Outcome:
        assert isinstance(answer, Outcome)
        return answer
