"""A run in a process of its own, watched: what the command line uses, and a server.

Formulas come from files that strangers exchange. So they are evaluated in a process with a memory limit, and a watchdog
here ends it when a row does not come to an end. The robot does not depend on that process: its own (the simulator's)
brings it to its safe stop when the engine is gone.
"""

from __future__ import annotations

import os
import threading
import time
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rrp_sheets.diagnostics import Diagnostic
from rrp_sheets.errors import RunBroken, SheetsError
from rrp_sheets.runs.mending import close_trace
from rrp_sheets.runs.office import KeptOffice, RunOffice, readable
from rrp_sheets.runs.telling import pack_settings, show, unpack_result, unpack_start
from rrp_sheets.runs.view import RunResult, RunSettings, RunStart, RunView
from rrp_sheets.runs.watchdog import FINISHED_AFTER, PREPARED_AFTER, SILENT_AFTER, STUCK_AFTER, Watchdog
from rrp_sheets.runs.wire import unpack_error, unpack_finding
from rrp_sheets.runtime.progress import RANK
from rrp_sheets.sim.process import require

LISTEN = 0.1  # s: how often the watchdog looks, and Ctrl-C is passed on
REST_WITHIN = 30.0  # s, for a robot whose engine is gone to come to its safe stop
FINISH_WITHIN = 90.0  # s, to write table and diagram of a run that broke off
REMEDY_STUCK = "Look at that row's connector and formula; if they are of ours, please report it with the workbook."
REMEDY_DIED = "Run it again; if it happens again, please report it with the workbook."


@dataclass(frozen=True)
class Ended:
    """How it ended.

    Attributes:
        findings: about the workbook, when it has errors; then it did not run.
        result: what the run left; None when it did not run, because of errors or since it was stopped before it began.
    """

    findings: tuple[Diagnostic, ...] = ()
    result: RunResult | None = None


class RunProcess:
    """A run in a process of its own, which starts at once. Listen to it until it ends; stop it from any thread.

    Args:
        path: of the workbook, which that process reads and checks.
        settings: how to run.

    Raises:
        MissingPart: when the simulator is not installed here.
    """

    def __init__(self, path: Path, settings: RunSettings | None = None) -> None:
        require()
        self._office = RunOffice()
        self._sending = threading.Lock()
        self._asked = False  # to stop
        self._send("run", str(path.absolute()), pack_settings(settings or RunSettings()))
        self._started: RunStart | None = None
        self._world: int | None = None
        self._starting = False
        self._finishing = False
        self._began = time.monotonic()

    @property
    def pid(self) -> int:
        """The process's number."""
        return self._office.pid

    # ---- what people do: from any thread, without waiting; the view is told what came of it
    def stop(self, by: str = "") -> None:
        """Let the run stop in order, whatever it is doing: it ends after its frame, and the robot goes to its rest."""
        self._asked = True
        self._send("stop", by)

    def pause(self, by: str = "") -> None:
        """Let everything stand still: streams, timers, motion."""
        self._wish("pause", by)

    def resume(self, by: str = "") -> None:
        """Let it go on from where it stands."""
        self._wish("resume", by)

    def step(self, by: str = "") -> None:
        """Let it go on for one frame (of an event loop: some 33 ms), and stand still."""
        self._wish("step", by)

    def speed(self, factor: float, by: str = "") -> None:
        """Be faster or slower: 1 is real time, 0 as fast as it can."""
        self._wish("speed", by, factor=factor)

    def mark(self, note: str, by: str = "") -> None:
        """Record a note with the time of now."""
        self._wish("mark", by, note=note)

    def switch(self, behaviour: str, on: bool, by: str = "") -> None:
        """Switch a behaviour by its name."""
        self._wish("switch", by, behaviour=behaviour, on=on)

    def send(self, stream: str, text: str, by: str = "") -> None:
        """Let a value enter a sensor stream (or one of ended commands) in the next frame.

        Args:
            stream: its name.
            text: as the Send cell of a test has it: a formula, or `field=value; field=value`; blank is the example.
            by: who sends it.
        """
        self._wish("send", by, stream=stream, text=text)

    def press(self, label: str, by: str = "") -> None:
        """Press an operator's button."""
        self._wish("press", by, label=label)

    def scene(self, thing: str, verb: str, value: str, by: str = "") -> None:
        """Let something happen in the world at once, in the words of a Scene sheet's row."""
        self._wish("scene", by, thing=thing, verb=verb, value=value)

    def put(self, thing: str, at: tuple[float, float, float], by: str = "") -> None:
        """Move a thing of the scene (m) at once, as one drags it: of many places in a frame the last one counts."""
        self._wish("put", by, thing=thing, at=at)

    def apply(self, path: Path, by: str = "") -> None:
        """Let the run go on with the rows of the edited workbook, when their graph has the same shape."""
        self._wish("apply", by, path=str(path.absolute()))

    def look(self, wanted: bool) -> None:
        """Say whether somebody wants to see what the robot sees."""
        self._wish("look", wanted=wanted)

    def _wish(self, kind: str, by: str = "", **what: Any) -> None:
        self._send("wish", kind, by, what)

    def _send(self, *message: Any) -> None:
        with self._sending:
            self._office.send(*message)

    def listen(self, view: RunView) -> Ended:
        """Tell a view everything until the run has ended.

        Raises:
            UnreadableFile: when the workbook cannot be read.
            MissingPart: when the simulator is not installed here.
            SheetsError: when the folder cannot be used.
            RunBroken: when a device does not start, or the process ends before the run has begun.
        """
        try:
            return self._listen(view)
        finally:
            self._office.close()
            if self._world is not None:
                os.close(self._world)

    def _listen(self, view: RunView) -> Ended:
        office = self._office
        if type(view).state is not RunView.state:
            self._wish("show", wanted=True)
        watchdog = Watchdog(office.cell)
        while True:
            if not self._asked and view.stopped():
                self.stop()
            messages = office.receive(LISTEN)
            if messages is None:
                return self._broken(view, f"The run's process has ended unexpectedly{office.last_words()}", REMEDY_DIED)
            for message in messages:
                ended = self._take(message, view)
                if ended is not None:
                    return ended
            if self._asked and not self._starting:
                office.kill()  # nothing has begun, and the check of a workbook need not be waited for
                return Ended()
            patience = self._patience()
            if watchdog.bites(heard=bool(messages), silent_after=patience):
                office.kill()
                late = STUCK_AFTER if watchdog.stuck else patience
                return self._broken(view, f"The run has not gone on for {late:g} s", REMEDY_STUCK)

    def _patience(self) -> float:
        if self._started is None:
            return PREPARED_AFTER
        return FINISHED_AFTER if self._finishing else SILENT_AFTER

    def _take(self, message: list[Any], view: RunView) -> Ended | None:
        kind, *rest = message
        if kind == "result":
            return Ended(result=unpack_result(rest[0]))
        if kind == "failed":
            raise unpack_error(rest[0])
        if kind == "memory":
            raise RunBroken("The workbook needs more memory than a run may have.", "Divide it into smaller ones.")
        if kind == "checked":
            return Ended(findings=tuple(map(unpack_finding, rest[0])))
        if kind == "starting":
            self._starting = True
        elif kind == "started":
            self._started = unpack_start(rest[0])
            self._began = time.monotonic()
            self._hold_world()
            view.started(self._started)
        elif kind == "finishing":
            self._finishing = True
            view.finishing()
        else:
            show(message, view)
        return None

    def _hold_world(self) -> None:
        """Hold on to the simulator's process, so that its end can be awaited even when the engine has died."""
        if self._started is not None and self._started.world is not None and hasattr(os, "pidfd_open"):
            with suppress(OSError):
                self._world = os.pidfd_open(self._started.world)

    # ---- a run that broke off
    def _broken(self, view: RunView, what: str, remedy: str) -> Ended:
        """The engine is gone: wait for the robot's safe stop, close the trace, write what can be written."""
        start = self._started
        row = start.rows.get(self._office.cell[RANK], "") if start else ""
        if row:
            what += f" while the row {row} was being worked out"
        error = RunBroken(f"{what}.", remedy)
        if start is None or not (start.folder / "trace.jsonl").is_file():
            raise error
        wall = time.monotonic() - self._began
        if not self._finishing:
            view.finishing()
        self._await_rest()
        summary = close_trace(start, row, error)
        summary.wall = wall
        view.rested(summary, error)
        files, problems = _finish(start.folder)
        return Ended(result=RunResult(start.folder, files, summary, error, problems))

    def _await_rest(self) -> None:
        """Wait until the robot has come to its safe stop and its process has ended."""
        world = self._started.world if self._started else None
        if self._world is not None:
            readable(self._world, REST_WITHIN)
        elif world is not None:
            deadline = time.monotonic() + REST_WITHIN
            with suppress(ProcessLookupError):
                while time.monotonic() < deadline:
                    os.kill(world, 0)
                    time.sleep(0.05)


def _finish(folder: Path) -> tuple[dict[str, str], tuple[str, ...]]:
    """Let a fresh process write table and diagram; it checks the workbook again, and may be ended as well."""
    from rrp_sheets.runs.folder import files_in  # loads what reads a trace: only when something broke

    office = KeptOffice(RunOffice)
    try:
        files, problems = office.ask(["finish", str(folder)], FINISH_WITHIN)
        return files, tuple(problems)
    except SheetsError:
        return files_in(folder), ("The table and the diagram could not be made.",)
    finally:
        office.close()


def run_apart(path: Path, settings: RunSettings | None = None, view: RunView | None = None) -> Ended:
    """Run a workbook in a process of its own, to its end; see :meth:`RunProcess.listen`."""
    return RunProcess(path, settings).listen(view or RunView())
