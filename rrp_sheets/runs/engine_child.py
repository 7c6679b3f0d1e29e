"""Worker process that evaluates formulas: `python -m rrp_sheets.runs.engine_child LINK CELL [SIMULATOR]`.

It has a memory limit, and the program that started it watches its heartbeat. Requests and answers are lines of JSON; it
ends when the connection closes. A run uses a simulator that the same program has started: SIMULATOR is the connection.
"""

from __future__ import annotations

import os
import socket
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any

from rrp_sheets.engine.clock import PLACES
from rrp_sheets.engine.command_queue import CommandQueue, OperatorCommand
from rrp_sheets.errors import RunBroken, SheetsError
from rrp_sheets.model.values import show
from rrp_sheets.private import only_for_this_user
from rrp_sheets.processes import Lines, SharedCell
from rrp_sheets.runs.run_events import RunEventSender, pack_result, unpack_settings
from rrp_sheets.runs.view import Summary
from rrp_sheets.runs.wire import NonBlockingWriter, pack_error, pack_finding
from rrp_sheets.runs.worker_loop import begin, lift_limit

if TYPE_CHECKING:
    from rrp_sheets.checks import Checked
    from rrp_sheets.workbook import Reading

ALONE_WITHIN = 5.0  # s of its processor time: when the program has gone, the record of a run is closed
ALONE_STILL_WITHIN = 60.0  # s that it may wait then for the simulator, which brings the robot to rest
ENDING_TOLD_WITHIN = 2.0  # s, for the program to say why the simulator has ended
ORPHANED = "the end of the program that had started it"
"""Name under which the record says that a run was stopped by the end of its program."""


class _RunReporter(RunEventSender):
    def finishing(self) -> None:
        """Lift the memory limit: no more formulas are evaluated, and drawing may take what memory it needs."""
        lift_limit()
        super().finishing()

    def rested(self, summary: Summary, broken: RunBroken | None) -> None:
        """Lower the priority of this process: only files are left to write, and other runs come first."""
        super().rested(summary, broken)
        if hasattr(os, "nice"):
            os.nice(10)


class _Process:
    def __init__(self, link: socket.socket, cell: SharedCell, simulator: socket.socket | None) -> None:
        self._lines = Lines(link)
        self._cell = cell
        self._simulator = simulator
        self._ending: SimpleQueue[str] = SimpleQueue()  # why the simulator has ended
        self.box = NonBlockingWriter(link)
        self._reporter = _RunReporter(self.box)
        self._control = CommandQueue()
        self._running = threading.Event()
        self._requests: SimpleQueue[list[Any]] = SimpleQueue()

    def serve(self) -> None:
        """Carry out requests, one by one."""
        threading.Thread(target=self._listen, daemon=True).start()
        do: dict[str, Callable[..., None]] = {"check": self._check, "run": self._run, "finish": self._finish}
        while True:
            name, *arguments = self._requests.get()
            try:
                do[name](*arguments)
            except SheetsError as error:
                self.box.post(["failed", pack_error(error)])
            except MemoryError:
                self.box.post(["memory"])
            self.box.finish()
            if self.box.gone:
                os._exit(0)

    def _listen(self) -> None:
        """Read messages from the program on a thread of its own, at no cost for the engine."""
        for message in self._lines:
            if message[0] == "stop":
                self._control.stop(*message[1:])
            elif message[0] == "wish":
                self._control.ask(OperatorCommand(*message[1:]))
            elif message[0] == "simulator ended":
                self._ending.put(message[1])
            else:
                self._requests.put(message)
        if self._running.is_set():  # the program has died: the robot comes to its rest, the files are written
            self._control.stop(ORPHANED)
            threading.Event().wait(ALONE_STILL_WITHIN)
        os._exit(0)

    def _check(self, path: str) -> None:
        _, checked = _checked(Path(path))
        self.box.post(["checked", [pack_finding(d) for d in checked.report], _examples(checked)])

    def _run(self, path: str, settings: dict[str, Any]) -> None:
        from rrp_sheets.runs.running import run

        reading, checked = _checked(Path(path))
        if checked.report.errors:
            self.box.post(["checked", [pack_finding(d) for d in checked.report]])
            return
        self.box.post(["starting"])
        self.box.flush()
        self._running.set()
        result = run(
            reading, checked, unpack_settings(settings), self._reporter, cell=self._cell.numbers,
            control=self._control, simulator=self._simulator, ending=self._told_ending,
        )  # fmt: skip
        self._running.clear()
        self.box.post(["result", pack_result(result)])

    def _told_ending(self) -> str:
        """Return the reason for the simulator's end, which only the program can know; empty if it sends none."""
        with suppress(Empty):
            return self._ending.get(timeout=ENDING_TOLD_WITHIN)
        return ""

    def _finish(self, folder: str) -> None:
        """Write the table and the diagram of a run whose process has been ended."""
        from rrp_sheets.runs.folder import finish_folder

        _, checked = _checked(Path(folder) / "protocol.xlsx")
        lift_limit()
        files, problems = finish_folder(Path(folder), checked)
        self.box.post(["finished", files, problems])


def _checked(path: Path) -> tuple[Reading, Checked]:
    from rrp_sheets.checks import check_workbook
    from rrp_sheets.workbook import read

    reading = read(path)
    return reading, check_workbook(reading.workbook, reading.report)


def _examples(checked: Checked) -> dict[str, str]:
    """Return an example of each row's value as shown, by the row's ref; in brackets if a filter would stop it."""
    from rrp_sheets.checks.shown import row_examples

    found = {}
    for ref, fact in row_examples(checked).items():
        number = isinstance(fact.example, (int, float)) and not isinstance(fact.example, bool)
        text = f"{show(fact.example)} {fact.known.unit if number else ''}".rstrip()
        found[ref] = text if fact.sure else f"({text})"
    return found


def main() -> None:
    """Serve until the connection closes."""
    only_for_this_user()
    link = begin(ALONE_WITHIN, ALONE_STILL_WITHIN)
    cell, *simulator = map(int, sys.argv[2:])
    _Process(link, SharedCell(PLACES, cell), socket.socket(fileno=simulator[0]) if simulator else None).serve()


if __name__ == "__main__":
    main()
