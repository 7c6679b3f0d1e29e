"""Task of the simulator's process, which `sim.process` starts.

It answers the engine's requests on one connection, and reads its supervisor's on the other, also between two steps of
the physics. It brings the robot to its safe stop (silence, a moment's hold, the rest posture; film and speech are
finished) when either requests it or its connection closes, and ends when the engine's does.
"""

from __future__ import annotations

import select
import socket
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from rrp_sheets.errors import MissingPart, SheetsError
from rrp_sheets.model.exchange import Arrivals, Notice
from rrp_sheets.private import only_for_this_user
from rrp_sheets.sim.process import BEATS, BUSY, IDLE, OPENING, PLACES, REQUESTS, STATE, OpenFailure, Picture, Spec
from rrp_sheets.workers.codec import pack, unpack
from rrp_sheets.workers.transport import MessageReader, SharedCounters, encode
from rrp_sheets.workers.worker_loop import limit_threads

if TYPE_CHECKING:
    from rrp_sheets.perception.pinhole import Pixels
    from rrp_sheets.sim.world import SimWorld


class _Server:
    def __init__(self, control: socket.socket, requests: socket.socket, heartbeat: SharedCounters) -> None:
        self._control, self._requests = control, requests
        self._reader = MessageReader(requests)
        self._ready = select.poll()
        self._ready.register(control, select.POLLIN)
        self._ready.register(requests, select.POLLIN)
        self._numbers = heartbeat.numbers
        self._halted = False  # the robot is to rest: somebody said so, or has gone
        self._resting = False  # and the supervisor knows
        self._listens = True  # to the supervisor, which has not gone
        self._world: SimWorld | None = None
        self._answers: dict[str, Callable[..., Any]] = {}
        self._outcome: Arrivals | None = None  # of the rest

    def serve(self) -> None:
        """Answer requests until the engine's connection closes."""
        try:
            while True:
                if self.pulse():
                    self._rest()
                self._numbers[STATE] = IDLE
                if self._control.fileno() in (fd for fd, _ in self._ready.poll()):
                    continue
                messages = self._reader.receive()
                if messages is None:
                    break
                for message in messages:
                    if self.pulse():  # many may have come at once
                        self._rest()
                    if not self._answer(*message):
                        return
        except (BrokenPipeError, ConnectionResetError):
            pass  # the engine has gone before its answer
        outcome = self._rest()
        if outcome is not None:
            self._say("rested", pack(outcome.notices, tuple[Notice, ...]))

    def _answer(self, number: int, request: str, *packed: Any) -> bool:
        """Carry a request out; return whether to go on."""
        self._numbers[STATE] = OPENING if request == "open" else BUSY
        self._numbers[BEATS] += 1
        takes, gives = REQUESTS[request]
        arguments = [unpack(hint, part) for hint, part in zip(takes, packed, strict=True)]
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
            answer = Arrivals()  # it rests already
        else:
            answer = self._answers[request](*arguments)
        self._requests.sendall(encode([number, pack(answer, gives)]))
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
            if not said:
                self._leave_supervisor()
            self._halted = True  # nothing else is ever said
        return self._halted

    def _rest(self) -> Arrivals | None:
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
                self._control.sendall(encode(message))
            except OSError:
                self._leave_supervisor()

    def _leave_supervisor(self) -> None:
        self._listens = False
        self._ready.unregister(self._control)

    def _open(self, spec: Spec) -> None:
        """Make the world, and the table of the requests that it answers."""
        import cv2

        from rrp_sheets.sim.world import SimWorld

        cv2.setNumThreads(1)
        world = self._world = SimWorld(spec, self.pulse)
        self._answers = {
            "start": world.start, "advance": world.advance, "state": world.state,
            "look": lambda: _picture(world.sight.look()), "watch": lambda: _picture(world.watch()),
            "act": world.act, "show": world.show,
        }  # fmt: skip


def _picture(image: Pixels) -> Picture:
    return Picture(image.shape, image.tobytes())


def serve(control: socket.socket, requests: int, heartbeat: int) -> None:
    """Serve the engine until its connection closes."""
    only_for_this_user()
    limit_threads()
    _Server(control, socket.socket(fileno=requests), SharedCounters(PLACES, heartbeat)).serve()
