"""Task of the engine: the worker process that checks a workbook, and runs it.

It has a memory limit, and the program that started it watches its heartbeat. It ends when the connection closes. The
run uses a simulator that the same program has started.
"""

from __future__ import annotations

import os
import socket
import threading
from contextlib import suppress
from pathlib import Path
from queue import Empty, SimpleQueue

from rrp_sheets.diagnostics import Diagnostic
from rrp_sheets.engine.ports import PLACES
from rrp_sheets.engine.run_events import CommandQueue, NoticeEvent, OperatorCommand, RunEvent, RunObserver
from rrp_sheets.errors import SheetsError
from rrp_sheets.model.exchange import Notice
from rrp_sheets.model.run_files import ORPHANED
from rrp_sheets.private import only_for_this_user
from rrp_sheets.runs.check_worker import read_and_check
from rrp_sheets.runs.run_data import FinishingEvent, RestedEvent, RunSettings
from rrp_sheets.texts import N_
from rrp_sheets.workers.codec import pack, unpack
from rrp_sheets.workers.transport import MessageReader, NonBlockingWriter, SharedCounters
from rrp_sheets.workers.worker_loop import lift_limit
from rrp_sheets.workers.worker_process import Task

ALONE_WITHIN = 5.0  # s of its processor time: when the program has gone, the record of a run is closed
ALONE_STILL_WITHIN = 60.0  # s that it may wait then for the simulator, which brings the robot to rest
ENGINE = Task(f"{__name__}.serve", ALONE_WITHIN, ALONE_STILL_WITHIN)
MOST_WAITING = 4_000_000  # bytes of events that a watcher may be behind; what is more is not shown, but in the trace
LIGHT = 200_000  # bytes: less than that is little
ENDING_TOLD_WITHIN = 2.0  # s, for the program to say why the simulator has ended


class RunEventSender(RunObserver):
    """Observer in the run's process that sends every event to the program that watches it."""

    def __init__(self, writer: NonBlockingWriter) -> None:
        self._writer = writer
        self._missed, self._missed_us = 0, 0  # events that were left out, and when the last of them came

    def handle(self, event: RunEvent) -> None:
        """Send an event, unless the watcher is so far behind that it is of no use."""
        if event.while_light and self._writer.waiting >= LIGHT:
            return
        if event.may_miss and self._writer.waiting > MOST_WAITING:
            self._missed, self._missed_us = self._missed + 1, event.us  # type: ignore[attr-defined]
        else:
            self._writer.post(pack(event))
        if event.at_once:
            self.flush()

    def flush(self) -> None:
        """Send what can be sent without waiting."""
        if self._writer.waiting < MOST_WAITING // 2:
            self._post_missed()
        self._writer.flush()

    def finish(self) -> None:
        """Send everything, waiting for the watcher."""
        self._post_missed()
        self._writer.finish()

    def _post_missed(self) -> None:
        """Tell how many events were left out, when there is room again."""
        if self._missed:
            text = N_("{n:,} values came faster than they can be shown. The recording has all of them.", n=self._missed)
            self._writer.post(pack(NoticeEvent(self._missed_us, Notice("note", text))))
            self._missed = 0


class _Reporter(RunEventSender):
    def handle(self, event: RunEvent) -> None:
        if isinstance(event, FinishingEvent):
            lift_limit()  # no more formulas are evaluated, and drawing may take what memory it needs
        super().handle(event)
        if isinstance(event, RestedEvent) and hasattr(os, "nice"):
            os.nice(10)  # only files are left to write, and other runs come first


class _Engine:
    def __init__(self, link: socket.socket, heartbeat: SharedCounters, simulator: socket.socket) -> None:
        self._messages = MessageReader(link)
        self._heartbeat = heartbeat
        self._simulator = simulator
        self._ending: SimpleQueue[str] = SimpleQueue()  # why the simulator has ended
        self._box = NonBlockingWriter(link)
        self._reporter = _Reporter(self._box)
        self._control = CommandQueue()
        self._running = threading.Event()
        self._requests: SimpleQueue[tuple[str, RunSettings]] = SimpleQueue()

    def serve(self) -> None:
        threading.Thread(target=self._listen, daemon=True).start()
        while True:
            try:
                self._run(*self._requests.get())
            except SheetsError as error:
                self._box.post(["failed", pack(error)])
            except MemoryError:
                self._box.post(["memory"])
            self._reporter.finish()
            if self._box.gone:
                os._exit(0)

    def _listen(self) -> None:
        for kind, *words in self._messages:
            if kind == "stop":
                self._control.stop(*words)
            elif kind == "command":
                self._control.ask(unpack(OperatorCommand, words[0]))
            elif kind == "simulator ended":
                self._ending.put(unpack(str, words[0]))
            else:
                self._requests.put((words[0], unpack(RunSettings, words[1])))
        if self._running.is_set():  # the program has died: the robot comes to its rest, the files are written
            self._control.stop(ORPHANED)
            threading.Event().wait(ALONE_STILL_WITHIN)
        os._exit(0)

    def _run(self, path: str, settings: RunSettings) -> None:
        from rrp_sheets.runs.running import run

        reading, checked = read_and_check(Path(path))
        if checked.report.errors:
            self._box.post(["checked", pack(tuple(checked.report), tuple[Diagnostic, ...]), checked.run.language])
            return
        self._box.post(["starting"])
        self._box.flush()
        self._running.set()
        result = run(
            reading, checked, settings, self._reporter, heartbeat=self._heartbeat.numbers, control=self._control,
            simulator=self._simulator, ending=self._told_ending,
        )  # fmt: skip
        self._running.clear()
        self._box.post(["result", pack(result)])

    def _told_ending(self) -> str:
        """Return the reason for the simulator's end, which only the program can know; empty if it sends none."""
        with suppress(Empty):
            return self._ending.get(timeout=ENDING_TOLD_WITHIN)
        return ""


def serve(link: socket.socket, heartbeat: int, simulator: int) -> None:
    """Check and run one workbook; `heartbeat` and `simulator` are the files of the heartbeat and of the simulator."""
    only_for_this_user()
    _Engine(link, SharedCounters(PLACES, heartbeat), socket.socket(fileno=simulator)).serve()
