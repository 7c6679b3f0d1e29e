"""The server's runs: one run with its users, its process and phases; and their manager, as there is one robot."""

from __future__ import annotations

import secrets
import threading
import time
from base64 import b64encode
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from rrp_sheets.errors import RunBroken, SheetsError
from rrp_sheets.recording.metadata import UNNAMED, clock, who
from rrp_sheets.recording.timeline import unit_of
from rrp_sheets.runs.run_data import RunSettings, Summary
from rrp_sheets.runs.run_process import RunOutcome, RunProcess
from rrp_sheets.texts import N_, sentences
from rrp_sheets.web.completions import in_browser
from rrp_sheets.web.models import error_text
from rrp_sheets.web.run_state import Line, RunState
from rrp_sheets.web.workbook_session import Event, OpenWorkbooks, WorkbookSession, message

TELL_EVERY = 0.1  # seconds: as often as pages are told at most
_WORK_SHARE = 4.0  # times as long as telling takes, the telling rests: a long sheet must leave the server time
FOREVER = 24 * 3600.0  # seconds: a run that goes on until somebody stops it
GOING = frozenset(("starting", "running", "paused", "stopping", "finishing"))
LONGEST_TEXTS = {"label": 60, "note": 500, "value": 2_000}
"""Letters of what a user sends to a run: a participant's code, condition or operator; a note; a value."""
JsonObject = dict[str, Any]


@dataclass(frozen=True)
class RunOptions:
    """Options with which a user starts a run.

    Attributes:
        seconds: the time limit; None: until the scene is over; FOREVER: until a user stops it.
        speed: 1 is real time, 0 as fast as it can.
    """

    by: str = UNNAMED
    mode: str = "simulated"
    participant: str = ""
    condition: str = ""
    operator: str = ""
    seconds: float | None = FOREVER
    speed: float = 1.0


class RunSession:
    """Run of a workbook, going or over; `tell` notifies all pages of a phase. Raises MissingPart without simulator."""

    def __init__(
        self, session: WorkbookSession, book: str, options: RunOptions, tell: Callable[[RunSession], None]
    ) -> None:
        self.session, self.book, self.options = session, book, options
        self.id = secrets.token_hex(4)
        self.phase = "starting"
        self.stopped_by = ""
        self.again_by = ""  # who wants it to start again when it has ended
        self.ended: JsonObject | None = None
        self.folder = ""
        self.written = False  # everything that it leaves is in its folder
        self._version = session.document.version
        self._tell = tell
        self._when_over = tell
        self._wall = time.time()
        self._over = threading.Event()
        self._pause = TELL_EVERY
        self._wanted = False  # camera pictures are made
        self._shown = b""  # the newest that pages were sent
        self._picture_lock = threading.Lock()
        self._lock = threading.Lock()
        examples = session.analysis().examples
        grids = session.document.grids.values()
        self.rows = {f"{g.name}!{n}": row for g in grids if g.kind == "behaviour" for row, n in g.numbers().items()}
        self.run_state = RunState(self.rows, {ref: unit_of(text) for ref, text in examples.items()}, self._changed)
        self.run_state.speed = options.speed
        self.process = RunProcess(session.document.path, RunSettings(
            seconds=options.seconds, mode=options.mode, participant=options.participant,
            condition=options.condition, operator=options.operator, everything=True,
        ))  # fmt: skip

    def begin(self, over: Callable[[RunSession], None]) -> None:
        """Start the threads that follow the run and notify the pages; `over` is called when it has ended."""
        self._when_over = over
        what = N_("Started" if self.options.mode == "simulated" else "Pilot rehearsal started")
        self.run_state.log.add(0, "start", what, by=self.options.by)
        for target in (self._listen, self._keep_telling):
            threading.Thread(target=target, daemon=True).start()

    # ---- the run's thread

    def _listen(self) -> None:
        remedy = N_("See the terminal where the server runs for more.")
        words = _ending("broken", N_("The run was lost by a fault of this program."), remedy)
        try:
            words = outcome_notice(self.process.listen(self.run_state), self.stopped_by)
        except SheetsError as error:
            words = failure_notice(error)
            if self.run_state.start is not None and not self.run_state.start.folder.is_dir():
                self.folder = ""  # there is no recording to look at
        finally:
            self.written = True
            self._end(words)

    def _end(self, words: JsonObject) -> None:
        """Set the outcome when the robot is at rest; announce it again if it changes while the files are written."""
        with self._lock:
            was, self.ended, self.phase = self.ended, words, "ended"
        if was is None:
            self.run_state.ended(words["words"])
            self._over.set()
            self._when_over(self)
        elif was != words:
            self._tell(self)

    def _changed(self, what: str) -> None:
        if what == "rested" and self.run_state.rest is not None:
            self._end(rest_notice(*self.run_state.rest, self.stopped_by))
            return
        with self._lock:
            if what == "started" and self.run_state.start is not None:
                self.folder = self.run_state.start.folder.name
                self.phase = "stopping" if self.phase == "stopping" else "running"
                self._wanted = False  # what was asked before it ran may be lost
            elif what == "paused" and self.phase in ("running", "paused"):
                self.phase = "paused" if self.run_state.is_paused else "running"
            elif what == "finishing":
                self.phase = "finishing"
        if what == "started":
            if self.options.speed != 1:
                self.process.command("speed", factor=self.options.speed)
            self.follow_edits()  # somebody may have been quicker than the start
        self._tell(self)

    # ---- telling

    def _keep_telling(self) -> None:
        """Send new values and log lines to the workbook's pages, at most ten times a second, until the run is over."""
        over = False
        while not over:
            over = self._over.wait(self._pause if self.session.listeners else 0.5)
            began = time.monotonic()
            self._want_pictures()
            if events := self._values(*self.run_state.news()):
                self.session.tell_live(events)
            if self._wanted and (jpeg := self.run_state.jpeg) is not self._shown:
                self._shown = jpeg
                self.session.tell_picture(self._picture())
            self._pause = max(TELL_EVERY, (time.monotonic() - began) * _WORK_SHARE)

    def _want_pictures(self) -> None:
        with self._picture_lock:  # two who decide at once must not be heard the wrong way round
            wanted = self.session.is_looked
            if wanted != self._wanted:
                self._wanted = wanted
                self.process.command("look", wanted=wanted)

    def look(self, client: str, *, wanted: bool) -> None:
        """Send a page camera pictures from now on, or no more; the run takes them while a page wants them."""
        self.session.look(client, wanted, self._picture())
        if self.run_state.start is not None:
            self._want_pictures()

    def _picture(self) -> str:
        jpeg, age = self.run_state.jpeg, self.run_state.picture_age
        return message("eye", {"run": self.id, "jpeg": b64encode(jpeg).decode(), "age": age}) if jpeg else ""

    def about(self) -> list[Event]:
        """Return the run's state and values so far as events for a page that joins."""
        return [("run", self.state()), *self._values(*self.run_state.all())]

    def _values(self, live: JsonObject | None, lines: list[Line]) -> list[Event]:
        events: list[Event] = [("live", {"run": self.id, **live})] if live else []  # names it: another may have begun
        return [*events, ("log", {"run": self.id, "lines": lines})] if lines else events

    def state(self) -> JsonObject:
        """Return the state of the run apart from its values."""
        run_state, start, options = self.run_state, self.run_state.start, self.options
        with self._lock:
            data: JsonObject = {
                "phase": self.phase, "id": self.id, "book": self.book, "by": options.by, "mode": options.mode,
                "participant": options.participant, "condition": options.condition, "operator": options.operator,
                "speed": run_state.speed, "t": run_state.us / 1e6, "since": self._wall, "until": None,
                "folder": self.folder,
                "ended": self.ended, "restart": run_state.refusal, "stopped_by": self.stopped_by, "rows": self.rows,
                "behaviours": [], "sensors": [], "buttons": [], "things": [], "camera": None, "resources": {},
            }  # fmt: skip
        if start is None:
            return data
        counts = run_state.button_counts()
        data.update({
            "until": start.until_us / 1e6 if options.seconds != FOREVER else None,
            "behaviours": [{"name": n, "on": on} for n, on in run_state.behaviours.items()],
            "sensors": [{"name": n, "device": d, "example": e} for n, d, e in start.sensors],
            "buttons": [{"stream": s, "label": label, "count": counts.get(s, 0)} for s, label in start.buttons],
            "things": [{"name": n, "title": title, "kind": k, "at": at} for n, title, k, at in start.things],
            "camera": {"hfov": start.hfov, "vfov": start.vfov},
            "resources": {start.actuators.get(s, s): list(r) for s, r in start.resources.items()},
        })  # fmt: skip
        return data

    def short(self) -> JsonObject:
        """Return the summary of the run for the pages of other workbooks."""
        data = self.state()
        return {n: data[n] for n in ("phase", "id", "book", "by", "mode", "participant", "t", "since")}

    # ---- what people do

    @property
    def is_going(self) -> bool:
        """True until the run has ended."""
        return self.phase in GOING

    def stop(self, by: str) -> None:
        """Stop the run; it is reported as stopped by the first user who asks."""
        with self._lock:
            if self.phase not in ("starting", "running", "paused"):
                return
            self.phase, self.stopped_by = "stopping", by
        self.process.stop(by)
        self._tell(self)

    def restart(self, by: str) -> None:
        """Stop the run, and start it again with the same settings."""
        self.again_by = by
        self.stop(by)

    def again(self) -> RunOptions:
        """Return the settings of the run that follows a restart."""
        return replace(self.options, by=self.again_by, speed=self.run_state.speed)

    def follow_edits(self) -> None:
        """Apply the edited workbook to the run after a check, or report why it is not used."""
        document = self.session.document
        if self.phase not in ("running", "paused") or document.version == self._version:
            return
        if self.session.analysis().errors:  # perhaps of an older version: what was mended meanwhile is checked next
            self.run_state.unused(N_("What was edited since then is not used while there are errors."))
            return
        self._version = document.version
        self.process.command("apply", self.session.author, path=str(document.path.absolute()))


def _ending(how: str, words: str, remedy: str = "") -> JsonObject:
    return {"how": how, "words": words, "broken": how == "broken", "remedy": remedy}


def failure_notice(error: SheetsError) -> JsonObject:
    """Return the end notice of a run that could not begin, or left no record."""
    return _ending("broken", error.message, in_browser(error.remedy))


def outcome_notice(ended: RunOutcome, by: str) -> JsonObject:
    """Return the end notice of a run that has ended; `by` is who stopped it, or empty."""
    if ended.findings:
        n = sum(d.severity.value == "error" for d in ended.findings)
        one = N_("It did not start: the workbook has {n} error.")
        many = N_("It did not start: the workbook has {n} errors.")
        return _ending("errors", N_(one if n == 1 else many, n=n), N_("Fix them, and press Run again."))
    if ended.result is None:
        words = N_("Stopped by {name} before it started." if by else "Stopped before it started.", name=who(by))
        return _ending("stopped", words)
    data = rest_notice(ended.result.summary, ended.result.broken, by)
    return data if data["broken"] else {**data, "remedy": sentences(*ended.result.problems)}


def rest_notice(summary: Summary, broken: RunBroken | None, by: str) -> JsonObject:
    """Return the end notice of a run whose robot is at rest while its files are still being written.

    >>> rest_notice(Summary(simulated=9.13, ended="stopped"), None, "Aya")["words"]
    'Stopped by Aya at 0:09.1.'
    """
    at = clock(summary.simulated)
    endings = {
        "time": N_("Ended as planned at {time}.", time=at),
        "stopped": N_("Stopped by {name} at {time}." if by else "Stopped at {time}.", name=who(by), time=at),
        "end run": N_("Row {row} ended the run at {time}.", row=summary.ended_by, time=at),
    }
    if broken:
        return _ending(
            "broken", N_("The run stopped unexpectedly at {time}: {why}", time=at, why=broken.message), broken.remedy
        )
    return _ending(summary.ended, endings.get(summary.ended) or N_("Ended at {time}.", time=at))


NONE: JsonObject = {"phase": "none", "book": ""}


class RobotBusy(SheetsError):
    """Error for a start while another run is going; `book` is its workbook."""

    def __init__(self, message: str, remedy: str, book: str) -> None:
        super().__init__(message, remedy)
        self.book = book


class RunManager:
    """Owner of the current run, or of the last one until it is cleared; notifies the pages of all open workbooks."""

    def __init__(self, open_workbooks: OpenWorkbooks) -> None:
        self._open_workbooks = open_workbooks
        self._lock = threading.Lock()
        self._unwritten: list[RunSession] = []  # the files of their folders are not all there yet
        self.run: RunSession | None = None
        open_workbooks.opened, open_workbooks.leaving = self._attach, self._leaving

    def _attach(self, session: WorkbookSession) -> None:
        session.about_run = partial(self._about, session)
        session.after_check = partial(self._checked, session)
        session.after_edit = partial(self._edited, session)

    def going_run(self, session: WorkbookSession | None = None) -> RunSession | None:
        """Return the run that is going; with a session, only if it is of that workbook."""
        run = self.run
        return run if run is not None and run.is_going and session in (None, run.session) else None

    def _leaving(self, session: WorkbookSession) -> None:
        if run := self.going_run(session):
            message = N_("{who} is running {book}.", who=run.options.by, book=run.book)
            raise SheetsError(message, N_("Stop the run first."))

    def start(self, session: WorkbookSession, book: str, options: RunOptions) -> RunSession:
        """Start a run of a workbook, and notify all pages.

        Raises RobotBusy when a run is going, SheetsError when the workbook has errors, or without the simulator.
        """
        errors = session.analysis().errors
        if errors:
            remedy = N_("Fix what is listed under Problems.")
            raise SheetsError(N_("The workbook has errors, so it cannot run."), remedy)
        with self._lock:
            if going := self.going_run():
                text = N_("{who} is running {book} since {since}. There is one robot, so one run at a time.",
                          who=going.options.by, book=going.book, since=clock(going.run_state.us / 1e6))  # fmt: skip
                raise RobotBusy(text, N_("Wait for its end, or stop it there."), going.book)
            # within, the file cannot be renamed: it was before, and `staying` refuses, or it is after the run
            with self._open_workbooks.staying(session):
                run = self.run = RunSession(session, book, options, self._tell)
            self._unwritten = [s for s in self._unwritten if not s.written] + [run]
        self._tell(run)
        run.begin(self._over)
        return run

    def now(self) -> dict[str, Any]:
        """Return the summary of the current run that every page of the server shows."""
        run = self.going_run()
        return run.short() if run else NONE

    def going(self) -> set[str]:
        """Return the folder names of the runs that are going."""
        run = self.going_run()
        return {run.folder} if run and run.folder else set()

    def joints(self, session: WorkbookSession) -> Mapping[str, float]:
        """Return the joints (rad) of the robot that runs a workbook now; empty when none does."""
        run = self.going_run(session)
        return run.run_state.joints if run else {}

    def writing(self) -> set[str]:
        """Return the folder names of the runs that are over and whose table and pictures are still being written."""
        return {s.folder for s in list(self._unwritten) if s.folder and not s.is_going and not s.written}

    def clear(self, session: WorkbookSession) -> None:
        """Forget the run of a workbook if it is over, so that its values disappear from the grid."""
        with self._lock:
            run = self.run
            if run is None or run.session is not session or run.is_going:
                return
            self.run = None
        for each in self._open_workbooks.sessions():
            each.tell("run", NONE)

    def forget(self, folders: Collection[str]) -> None:
        """Clear the last run, if it is among the deleted ones, so that no page shows its data any more."""
        run = self.run
        if run is not None and run.folder in folders:
            self.clear(run.session)

    # ---- telling

    def _tell(self, run: RunSession) -> None:
        if run is not self.run:  # its files were still being written when another run began
            return
        own, others = run.state(), run.short()
        for session in self._open_workbooks.sessions():
            session.tell("run", own if session is run.session else others)

    def _about(self, session: WorkbookSession) -> list[Event]:
        run = self.run
        return run.about() if run is not None and run.session is session else [("run", self.now())]

    def _over(self, run: RunSession) -> None:
        self._tell(run)
        if run.again_by and run.ended is not None and not run.ended["broken"]:
            try:
                self.start(run.session, run.book, run.again())
            except SheetsError as error:
                run.session.tell("trouble", {"message": error_text(error)})

    def _checked(self, session: WorkbookSession) -> None:
        if run := self.going_run(session):
            run.follow_edits()

    def _edited(self, session: WorkbookSession) -> None:
        run = self.run
        if run is not None and run.session is session and not run.is_going:  # over: its rows show examples again
            self.clear(session)
