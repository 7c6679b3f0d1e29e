"""Runs in supervised processes of their own: control, watchdog, and the end of a run whose engine is gone.

Formulas come from untrusted files. So the engine evaluates them in a process with a memory limit, and is ended here
when a row does not come to an end. The robot does not depend on it: this module starts the simulator's process too, and
has a connection of its own to it, over which Stop is sent whatever rows and engine do.
"""

from __future__ import annotations

import json
import selectors
import threading
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from rrp_sheets.diagnostics import Diagnostic
from rrp_sheets.engine.ports import INSTANT, NO_ROW, PLACES, RANK, SETTLING, Heartbeat
from rrp_sheets.engine.run_events import NoticeEvent, OperatorCommand, RunEvent, RunObserver
from rrp_sheets.engine.trace import notice_entry
from rrp_sheets.errors import RunBroken, SheetsError
from rrp_sheets.model.exchange import Notice
from rrp_sheets.model.run_files import TRACE, RecordedValue
from rrp_sheets.recording.trace_reader import TraceReader
from rrp_sheets.runs.engine_process import ENGINE
from rrp_sheets.runs.run_data import FinishingEvent, RestedEvent, RunResult, RunSettings, RunStart, StartEvent, Summary
from rrp_sheets.sim.process import REMEDY_DIED, Simulator, require
from rrp_sheets.texts import N_, known_language, sentences
from rrp_sheets.workers.codec import pack, unpack
from rrp_sheets.workers.transport import Liveness, SharedCounters, cpu_clock, ready
from rrp_sheets.workers.worker_process import WorkerProcess

FINISH = "rrp_sheets.runs.check_worker.finish_run"
LOOK_EVERY = 0.05  # s: how often the processes are looked at, and Ctrl-C is passed on
ROWS_END_WITHIN = 0.15  # s from Stop, for the engine to say that its rows are over; then it is ended
STOP_WAITS = 0.05  # s, for another message to the engine, which somebody is just sending
SEND_WITHIN = 2.0  # s, for the engine to take a message; its connection holds hundreds of them
FINISH_WITHIN = 90.0  # s, to write table and diagram of a run that broke off
SIMULATOR_CLOSE_WITHIN = 5.0  # s, for the simulator to bring its robot to rest when nobody listens to the run any more
REMEDY_STUCK = N_("Check that row's connector and formula. If they come with the program, please report it with the "
                  "workbook.")  # fmt: skip
REMEDY_SLOW = N_("Use shorter texts and lists in these rows, or run them less often.")
ROW_WITHIN = 2.0
"""Seconds of processor time that one row may take. The budget of a formula ends within a tenth of a second, so that 2 s
are no slow row but one that never ends; and a robot should not be without its engine for longer."""
INSTANT_WITHIN = 5.0
"""Seconds of processor time that all rows together may take for one instant: a frame, or an event of the event loop."""
ROWS_STILL_WITHIN = 5.0
"""Seconds (wall clock) that an engine may use no processor time while rows are worked out."""
SILENT_AFTER = 30.0
"""Seconds without a word between the frames of a run: of processor time, or of the wall clock without any."""
PREPARED_AFTER = 90.0
"""As many before the run: reading, checking, starting the simulator. Usually 2."""
FINISHED_AFTER = 900.0
"""As many after it, when the robot rests: a table of a million rows takes minutes."""
_MOST_NAMED = 3  # rows


@dataclass(frozen=True)
class RunOutcome:
    """Outcome of a run in a process of its own.

    Attributes:
        findings: about the workbook, when it has errors; then it did not run.
        result: what the run left; None when it did not run, because of errors or since it was stopped before it began.
        language: of the workbook, when it has errors.
    """

    findings: tuple[Diagnostic, ...] = ()
    result: RunResult | None = None
    language: str = "en"


class RunProcess:
    """A run in a process of its own, which starts at once, and reads and checks the workbook.

    `listen` reports it, any thread may stop it. Raises MissingPart when the simulator is not installed here.
    """

    def __init__(self, path: Path, settings: RunSettings | None = None) -> None:
        require()
        self._simulator = Simulator()
        self._shared = SharedCounters(PLACES)
        self._shared.numbers[RANK] = NO_ROW
        self._worker = WorkerProcess(ENGINE, self._shared.fd, self._simulator.requests.fileno())
        self._simulator.requests.close()  # else it would not be told when the engine has gone
        self._watchdog = Watchdog(self._shared.numbers, cpu_clock(self._worker.pid))
        self._sending = threading.Lock()
        self._asked: float | None = None  # when it was to stop
        self._stopped_by = ""
        self._resting: float | None = None  # when the robot had begun its rest, or could not any more
        self._ending = ""  # why the simulator has ended
        self._engine_unresponsive = False  # the engine takes no messages
        self._finisher: WorkerProcess | None = None
        settings = settings or RunSettings()
        out, home = (folder and folder.absolute() for folder in (settings.out, settings.home))
        self._send("run", str(path.absolute()), pack(replace(settings, out=out, home=home)))
        self._started: RunStart | None = None
        self._starting = False
        self._finishing = self._told_finishing = False
        self._reached_us = 0  # of the run's clock, as far as the engine has told
        self._began = time.monotonic()

    @property
    def pid(self) -> int:
        """Process ID of the engine."""
        return self._worker.pid

    @property
    def simulator_pid(self) -> int:
        """Process ID of the simulator."""
        return self._simulator.pid

    # ---- what people do: from any thread, waiting at most SEND_WITHIN; the view is told what came of it
    def stop(self, by: str = "") -> None:
        """Have the simulator bring the robot to its rest, then the engine end; one whose rows do not end is killed."""
        if self._asked is None:
            self._asked, self._stopped_by = time.monotonic(), by
            self._simulator.rest()  # first: the robot rests even when the engine hangs
            if self._sending.acquire(timeout=STOP_WAITS):  # an engine that does not take it is ended
                try:
                    self._worker.say("stop", by)
                finally:
                    self._sending.release()

    def command(self, kind: str, by: str = "", **what: Any) -> None:
        """Send a command to the engine, as plain data: one of the kinds of `CommandHandler`, or of its parts."""
        self._send("command", pack(OperatorCommand(kind, by, what)))

    def _send(self, *message: Any) -> None:
        with self._sending:
            self._engine_unresponsive = self._engine_unresponsive or not self._worker.send(*message, within=SEND_WITHIN)

    def listen(self, view: RunObserver) -> RunOutcome:
        """Report everything to a view until the run has ended.

        Raises:
            UnreadableFile: when the workbook cannot be read.
            MissingPart: when the simulator is not installed here.
            SheetsError: when the folder cannot be used.
            RunBroken: when a device does not start, or the process ends before the run has begun.
        """
        try:
            with selectors.DefaultSelector() as selector:
                for end in (self._worker, self._simulator):
                    selector.register(end, selectors.EVENT_READ)
                return self._listen(view, selector)
        finally:
            self._worker.close()
            self._shared.close()
            self._simulator.close(SIMULATOR_CLOSE_WITHIN)
            if self._finisher is not None:
                self._finisher.close()

    def _listen(self, view: RunObserver, selector: selectors.BaseSelector) -> RunOutcome:
        worker = self._worker
        if hasattr(view, "state"):
            self.command("show", wanted=True)
        while True:
            if self._asked is None and view.stopped():
                self.stop()
            selector.select(LOOK_EVERY)
            self._look_at_simulator()
            if self._simulator.gone and len(selector.get_map()) > 1:
                selector.unregister(self._simulator)
            messages = worker.receive(0)
            if messages is None:
                words = N_("The run's process ended unexpectedly{summary}", summary=worker.exit_summary())
                return self._finish_without_engine(view, RunBroken(_sentence(words, self._row()), REMEDY_DIED))
            for message in messages:
                ended = self._take(message, view)
                if ended is not None:
                    return ended
            self._tell_finishing(view)
            if self._asked is not None and not self._starting:
                worker.kill()  # nothing has begun, and the check of a workbook need not be waited for
                return RunOutcome()
            if self._is_late():
                return self._finish_without_engine(view, None)
            failure = self._failure(heard=bool(messages))
            if failure is not None:
                return self._finish_without_engine(view, failure)

    def _look_at_simulator(self) -> None:
        """Read the simulator's messages; kill it when it no longer works, and send the reason to the engine."""
        simulator = self._simulator
        if simulator.gone:
            return
        simulator.hear()
        failure = simulator.failure()
        if failure:
            simulator.kill()
        if simulator.gone:
            words = N_("The simulator ended unexpectedly{summary}.", summary=simulator.exit_words())
            self._ending = failure or words
            self._send("simulator ended", pack(self._ending))
        if self._resting is None and (simulator.resting or simulator.gone):
            self._resting = time.monotonic()

    def _is_late(self) -> bool:
        """Return whether the rows are not over in time after Stop; an engine that waits for the simulator may wait."""
        if self._asked is None or self._started is None or self._finishing:
            return False
        if self._resting is None and self._simulator.working:
            return False
        return time.monotonic() - max(self._asked, self._resting or 0.0) > ROWS_END_WITHIN

    def _failure(self, *, heard: bool) -> RunBroken | None:
        """Return the reason to end the engine; None while it goes on."""
        patience = PREPARED_AFTER if self._started is None else FINISHED_AFTER if self._finishing else SILENT_AFTER
        rows = self._started.rows if self._started else {}
        failure = self._watchdog.failure(
            heard=heard, silent_after=patience, waits=self._simulator.working and not self._simulator.gone, rows=rows
        )
        if self._engine_unresponsive and failure is None:
            failure = _at(N_("The run has read no message for {seconds:g} s", seconds=SEND_WITHIN), self._row()), False
        if failure is None:
            return None
        words, slow = failure
        return RunBroken(_sentence(words), REMEDY_SLOW if slow else REMEDY_STUCK)

    def _row(self) -> str:
        """Return the name of the row that is being evaluated; empty when there is none."""
        return self._started.rows.get(self._shared.numbers[RANK], "") if self._started else ""

    def _tell_finishing(self, view: RunObserver) -> None:
        """Tell the view once that the robot is brought to rest: as the simulator reports it, not as the engine asks."""
        if self._simulator.resting and self._started is not None and not self._told_finishing:
            self._told_finishing = True
            view.handle(FinishingEvent())

    def _take(self, message: list[Any], view: RunObserver) -> RunOutcome | None:
        kind, *rest = message
        if kind == "result":
            return RunOutcome(result=unpack(RunResult, rest[0]))
        if kind == "failed":
            raise unpack(SheetsError, rest[0])
        if kind == "memory":
            words = N_("The workbook needs more memory than a run may have.")
            raise RunBroken(words, N_("Split it into smaller ones."))
        if kind == "checked":
            return RunOutcome(unpack(tuple[Diagnostic, ...], rest[0]), language=known_language(rest[1]))
        if kind == "starting":
            self._starting = True
            return None
        event = unpack(RunEvent.kinds[kind], message)
        if isinstance(event, FinishingEvent):  # the view is told when the simulator says so
            self._finishing = True
            return None
        if isinstance(event, StartEvent):
            self._started, self._began = event.start, time.monotonic()
        self._reached_us = max(self._reached_us, getattr(event, "us", 0))
        view.handle(event)
        return None

    # ---- a run whose engine has gone, or is ended
    def _finish_without_engine(self, view: RunObserver, error: RunBroken | None) -> RunOutcome:
        """Bring the robot to rest without the engine, close the trace, write the files that can be written.

        Args:
            view: receives the notices and the end.
            error: why the run breaks off; None when it was stopped and its rows did not end in time.
        """
        start, row = self._started, self._row()
        self._worker.kill()
        self._simulator.rest()
        if start is None or not (start.folder / TRACE).is_file():
            if error is None:
                return RunOutcome()
            raise error
        wall = time.monotonic() - self._began
        self._finisher = WorkerProcess()  # it starts while the robot comes to rest
        notices, hindrance = self._await_rest(view)
        if error is None and hindrance is None:
            words = N_("The rows did not end within {seconds:g} s of Stop, so the engine was stopped")
            text = sentences(_sentence(N_(words, seconds=ROWS_END_WITHIN), row), N_("The recording is saved."))
            notices = (*notices, Notice("note", text))
        error = error or hindrance
        by = self._stopped_by if self._asked is not None else ""
        summary = close_trace(start, row, error, notices, by, self._reached_us)
        for notice in notices:
            view.handle(NoticeEvent(round(summary.simulated * 1e6), notice))
        summary.wall = wall
        view.handle(RestedEvent(summary, error))
        files, problems = self._finish(start.folder)
        return RunOutcome(result=RunResult(start.folder, files, summary, error, problems))

    def _await_rest(self, view: RunObserver) -> tuple[tuple[Notice, ...], RunBroken | None]:
        """Wait until the robot is at rest; return the simulator's notices, and the error if it could not rest."""
        simulator = self._simulator
        while not simulator.gone and simulator.rested is None:
            ready(simulator.fileno(), LOOK_EVERY)
            self._look_at_simulator()
            self._tell_finishing(view)
        if simulator.rested is None:
            return (), RunBroken(self._ending, REMEDY_DIED)
        return simulator.rested, None

    def _finish(self, folder: Path) -> tuple[dict[str, str], tuple[str, ...]]:
        """Write table and diagram in a fresh process, which checks the workbook again and may be ended as well."""
        from rrp_sheets.recording.folder import files_in  # loads what reads a trace: only when something broke

        assert self._finisher is not None
        with suppress(SheetsError):
            files, problems = self._finisher.ask([FINISH, str(folder)], FINISH_WITHIN)
            return files, tuple(problems)
        return files_in(folder), (N_("The table and the diagram could not be made."),)


def _at(words: str, row: str) -> str:
    """Return what happened, with the row that was being worked out if there is one."""
    return N_("{what} while row {row} was being calculated", what=words, row=row) if row else words


def _sentence(words: str, row: str = "") -> str:
    return N_("{before}.", before=_at(words, row))


def close_trace(
    start: RunStart,
    row: str,
    error: RunBroken | None,
    notices: Sequence[Notice] = (),
    by: str = "",
    reached_us: int = 0,
) -> Summary:
    """Complete a trace: cut off an unfinished line, add a summary if there is none, and return the summary.

    Args:
        start: of the run.
        row: that was being worked out.
        error: why the run broke off; None when it was stopped.
        notices: to be added before the summary.
        by: who stopped it, if somebody did and it is known.
        reached_us: how far the run had come, which may be later than its last event.
    """
    events: Counter[str] = Counter(dict.fromkeys(start.streams.values(), 0))
    errors: Counter[str] = Counter()
    last = reached_us / 1e6
    reader = TraceReader(start.folder)
    whole = reader.begins
    for place, line, value in reader.skim():
        whole = place + len(line)
        if value is not None:
            last = max(last, value[0])
            events[value[1].decode()] += 1
        elif (event := reader.event(line)) is not None:
            last = max(last, event.t)
            if isinstance(event, RecordedValue):
                events[event.stream] += 1
            elif event.kind == "error":
                errors[event.row or event.stream] += 1
    if reader.summary is not None:
        return Summary.from_dict(reader.summary.fields)
    commands = {name: events[name] for name in start.actuators.values()}
    counts = (dict(events), dict(errors), commands, last, 0.0)
    if error is None:
        summary = Summary(*counts, "stopped", "", by)
    else:
        summary = Summary(*counts, "broken", row, by, error.message, error.remedy)
    lines = [notice_entry(round(last * 1e6), notice, start.streams) for notice in notices]
    lines.append({"type": "summary", **summary.as_dict(wall=False)})
    text = "".join(json.dumps(entry, ensure_ascii=False) + "\n" for entry in lines)
    with reader.path.open("r+b") as file:
        file.truncate(whole)
        file.seek(whole)
        file.write(text.encode("utf-8", "backslashreplace"))
    return summary


class Watchdog:
    """Watchdog over an engine: decides from its heartbeat and processor time whether it hangs.

    A paced wait is no stall: only an engine that is settling, at the same instant as before, is slow or stuck. `cpu` is
    its processor time, `now` the wall clock, s.
    """

    def __init__(
        self, heartbeat: Heartbeat, cpu: Callable[[], float], now: Callable[[], float] = time.monotonic
    ) -> None:
        self._heartbeat = heartbeat
        self._row = Liveness(cpu, now)
        self._process = Liveness(cpu, now)
        self._words = 0  # how often something was heard
        self._instant = -1
        self._rank = NO_ROW
        self._costs: dict[int, float] = {}  # s of processor time at the present instant, by rank

    def failure(
        self, *, heard: bool, silent_after: float = SILENT_AFTER, waits: bool = False, rows: Mapping[int, str]
    ) -> tuple[str, bool] | None:
        """Return why to end the process, as a sentence without its full stop, and whether rows are just slow; or None.

        Args:
            heard: whether a message has come since the last look.
            silent_after: seconds without a message that it may take for what it is doing now.
            waits: whether it waits for the simulator, which is at work.
            rows: the rows' names by rank.
        """
        instant, settling, rank = self._heartbeat[INSTANT], bool(self._heartbeat[SETTLING]), self._heartbeat[RANK]
        self._words += heard
        self._process.look((self._words, instant if settling else 0), has_work=not waits)
        at = (instant, rank) if settling else (instant, self._words, "between")
        computed, _ = self._row.look(at, has_work=settling)
        if not settling or instant != self._instant:
            self._costs.clear()
        else:  # what passed since the last look is shared between the row of then and that of now
            for place in (self._rank, rank):
                self._costs[place] = self._costs.get(place, 0.0) + computed / 2
        self._instant, self._rank = instant, rank
        if not settling:
            if max(self._process.computing, self._process.still) > silent_after:
                return N_("The run has not continued for {seconds:g} s", seconds=silent_after), False
            return None
        row = rows.get(rank, "")
        if self._row.computing > ROW_WITHIN:
            return _at(N_("The run has not continued for {seconds:g} s", seconds=ROW_WITHIN), row), False
        if self._row.still > ROWS_STILL_WITHIN:
            return _at(N_("The run has been stuck for {seconds:g} s", seconds=ROWS_STILL_WITHIN), row), False
        if sum(self._costs.values()) > INSTANT_WITHIN:
            costly = sorted((r for r in self._costs if r in rows), key=lambda r: -self._costs[r])[:_MOST_NAMED]
            named = ", ".join(f"{rows[r]} ({self._costs[r]:.1f} s)" for r in costly)
            words = N_("The rows of one moment took more than {seconds:g} s. The slowest are {rows}")
            return N_(words, seconds=INSTANT_WITHIN, rows=named), True
        return None
