"""The simulator's process: `python -m rrp_sheets.sim.child CONTROL REQUESTS HEARTBEAT`, started by `sim.process` only.

It answers the engine's requests on one connection, one by one, and reads its supervisor's on the other, also between
two steps of the physics. It brings the robot to its safe stop (silence, a moment's hold, the rest posture; film and
speech are finished) when the engine or the supervisor requests it, and by itself when the connection to either closes.
It ends when the engine's connection does.
"""

from __future__ import annotations

import os
import signal
import socket
import sys
from collections.abc import Callable
from dataclasses import astuple
from multiprocessing.connection import Connection, wait
from typing import TYPE_CHECKING, Any

from rrp_sheets.errors import MissingPart, SheetsError
from rrp_sheets.private import only_for_this_user
from rrp_sheets.processes import SharedCell, end_with_starter, line
from rrp_sheets.sim.messages import BEATS, BUSY, IDLE, OPENING, PLACES, STATE, OpenFailure, Outcome, Spec

if TYPE_CHECKING:
    from rrp_sheets.sim.world import SimWorld

ALONE_WITHIN = 5.0  # s, of its processor time or without any, to bring the robot to rest when its supervisor has gone


class _Server:
    def __init__(self, control: socket.socket, requests: Connection[Any, Any], heartbeat: SharedCell) -> None:
        self._control = control
        self._requests = requests
        self._numbers = heartbeat.numbers
        self._halted = False  # the robot is to rest: somebody said so, or has gone
        self._resting = False  # and the supervisor knows
        self._listens = True  # to the supervisor, which has not gone
        self._world: SimWorld | None = None
        self._answers: dict[str, Callable[..., Any]] = {}
        self._outcome: Outcome | None = None  # of the rest

    def serve(self) -> None:
        """Answer requests until the engine's connection closes."""
        try:
            while True:
                if self.pulse():
                    self._rest()
                self._numbers[STATE] = IDLE
                ready = wait([self._requests, *([self._control] if self._listens else ())])
                if self._control not in ready and not self._answer(*self._requests.recv()):
                    return
        except (EOFError, BrokenPipeError, ConnectionResetError):
            outcome = self._rest()
            if outcome is not None:
                self._say("rested", [astuple(notice) for notice in outcome.notices])

    def _answer(self, number: int, request: str, arguments: tuple[Any, ...]) -> bool:
        """Carry a request out; return whether to go on."""
        self._numbers[STATE] = OPENING if request == "open" else BUSY
        self._numbers[BEATS] += 1
        going = True
        answer: Any = None
        if request == "open":
            try:
                self._open(*arguments)
            except SheetsError as error:  # something that the user can mend
                answer, going = OpenFailure(error.message, error.remedy, isinstance(error, MissingPart)), False
        elif request == "stop":
            answer = self._rest()
        elif request == "advance" and self._outcome is not None:
            answer = Outcome()  # it rests already
        else:
            answer = self._answers[request](*arguments)
        self._requests.send((number, answer))
        return going

    def pulse(self) -> bool:
        """Count up the heartbeat before a step of the physics; return whether the robot is to be brought to rest."""
        self._numbers[BEATS] += 1
        if self._listens:
            try:
                said = self._control.recv(1 << 12, socket.MSG_DONTWAIT)
            except BlockingIOError:
                return self._halted
            except OSError:
                said = b""
            self._listens = bool(said)
            self._halted = True  # nothing else is ever said
        return self._halted

    def _rest(self) -> Outcome | None:
        """Bring the robot to rest, once; return the outcome, or None when there is no robot yet."""
        begins = self._world is not None and self._outcome is None
        if self._world is not None and begins:
            self._numbers[STATE] = BUSY
            self._world.halt()
        if not self._resting:  # what has not been made does not move either
            self._resting = True
            self._say("resting")
        if self._world is not None and begins:
            self._outcome = self._world.stop()
        return self._outcome

    def _say(self, *message: Any) -> None:
        if self._listens:
            try:
                self._control.sendall(line(list(message)))
            except OSError:
                self._listens = False

    def _open(self, spec: Spec) -> None:
        """Make the world, and the table of the requests that it answers."""
        import cv2

        from rrp_sheets.sim.world import SimWorld

        cv2.setNumThreads(1)
        world = self._world = SimWorld(spec, self.pulse)
        self._answers = {
            "start": world.start, "advance": world.advance, "state": world.state,
            "look": world.sight.look, "watch": world.watch, "act": world.act, "show": world.show,
        }  # fmt: skip


def main() -> None:
    """Serve the engine until its connection closes."""
    only_for_this_user()
    control, requests, heartbeat = map(int, sys.argv[1:4])
    link = socket.socket(fileno=control)
    end_with_starter(link, ALONE_WITHIN)
    # Ctrl-C ends the run in the program, which then stops the robot properly through us.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # One thread: what is computed must not depend on the machine's load or its number of cores.
    for library in ("OMP", "OPENBLAS", "MKL"):
        os.environ[f"{library}_NUM_THREADS"] = "1"
    _take_all_memory()
    _Server(link, Connection(requests), SharedCell(PLACES, heartbeat)).serve()


def _take_all_memory() -> None:
    """Raise this process's memory limit to the highest allowed: pictures and sound need more than its starter."""
    try:
        import resource
    except ImportError:  # Windows knows no such limit
        return
    hard = resource.getrlimit(resource.RLIMIT_AS)[1]
    resource.setrlimit(resource.RLIMIT_AS, (hard, hard))


if __name__ == "__main__":
    main()
