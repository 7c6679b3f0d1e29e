"""The simulator's process: `python -m rrp_sheets.sim.child FD`, started by :mod:`rrp_sheets.sim.process` only.

It answers requests on the connection that it inherits, one by one, and ends when that connection does. When the engine
has gone without a word, it first brings the robot to its safe stop by itself (the dead man's switch): silence, a
moment's hold, the rest posture; the film and the speech are finished.
"""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import Any

from rrp_sheets.errors import MissingPart, SheetsError
from rrp_sheets.private import only_for_this_user
from rrp_sheets.sim.messages import Refused


def main() -> None:
    """Serve until the connection closes: the program that started us has ended, or wants us to."""
    only_for_this_user()
    # Ctrl-C ends the run in the program, which then stops the robot properly through us.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # One thread: what is computed must not depend on the machine's load or its number of cores.
    for library in ("OMP", "OPENBLAS", "MKL"):
        os.environ[f"{library}_NUM_THREADS"] = "1"
    _take_all_memory()
    link: Connection[Any, Any] = Connection(int(sys.argv[1]))
    answers: dict[str, Callable[..., Any]] = {}
    rests = True
    try:
        while True:
            number, request, arguments = link.recv()
            if request == "open":
                try:
                    answers = _open(*arguments)
                except SheetsError as error:  # something that the user can mend
                    link.send((number, Refused(error.message, error.remedy, isinstance(error, MissingPart))))
                    return
                rests = False
                link.send((number, None))
            else:
                rests = rests or request == "stop"
                link.send((number, answers[request](*arguments)))
    except (EOFError, BrokenPipeError, ConnectionResetError):
        if not rests:
            answers["stop"]()


def _take_all_memory() -> None:
    """The process that evaluates formulas has a memory limit, and we inherit it: pictures and sound need more."""
    try:
        import resource
    except ImportError:  # Windows knows no such limit
        return
    hard = resource.getrlimit(resource.RLIMIT_AS)[1]
    resource.setrlimit(resource.RLIMIT_AS, (hard, hard))


def _open(spec: Any) -> dict[str, Callable[..., Any]]:
    """Make the world; the requests it answers."""
    import cv2

    from rrp_sheets.sim.world import SimWorld

    cv2.setNumThreads(1)
    world = SimWorld(spec)
    return {
        "start": world.start, "advance": world.advance, "stop": world.stop, "state": world.state,
        "look": world.sight.look, "watch": world.watch, "act": world.act, "show": world.show,
    }  # fmt: skip


if __name__ == "__main__":
    main()
