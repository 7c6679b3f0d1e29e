"""Manager of the server's single run: there is one robot, so one run at a time for all workbooks."""

from __future__ import annotations

import threading
from collections.abc import Collection, Mapping
from typing import Any

from rrp_sheets.errors import SheetsError
from rrp_sheets.recording.formatting import clock
from rrp_sheets.texts import N_
from rrp_sheets.web.collab.broadcaster import message
from rrp_sheets.web.collab.workbook_session import OpenWorkbooks, WorkbookSession
from rrp_sheets.web.models import said
from rrp_sheets.web.run.run_session import RunOptions, RunSession

NONE: dict[str, Any] = {"phase": "none", "book": ""}


class RobotBusy(SheetsError):
    """Error for a start while another run is going; `book` is its workbook."""

    def __init__(self, message: str, remedy: str, book: str) -> None:
        super().__init__(message, remedy)
        self.book = book


class RunManager:
    """Owner of the current run, or of the last one until it is cleared.

    Args:
        open_workbooks: whose pages are notified.
    """

    def __init__(self, open_workbooks: OpenWorkbooks) -> None:
        self._open_workbooks = open_workbooks
        self._lock = threading.Lock()
        self._unwritten: list[RunSession] = []  # the files of their folders are not all there yet
        self.run: RunSession | None = None
        open_workbooks.opened, open_workbooks.leaving = self._attach, self._leaving

    def _attach(self, session: WorkbookSession) -> None:
        session.about_run = lambda: self._about(session)
        session.after_check = lambda: self._checked(session)
        session.after_edit = lambda: self._edited(session)

    def _leaving(self, session: WorkbookSession) -> None:
        run = self.run
        if run is not None and run.session is session and run.is_going:
            message = N_("{who} is running {book}.", who=run.options.by, book=run.book)
            raise SheetsError(message, N_("Stop the run first."))

    def start(self, session: WorkbookSession, book: str, options: RunOptions) -> RunSession:
        """Start a run of a workbook, and notify all pages.

        Raises:
            RobotBusy: when a run is going.
            MissingPart: when the simulator is not installed here.
            SheetsError: when the workbook has errors.
        """
        errors = session.analysis().errors
        if errors:
            raise SheetsError(N_("Run starts when there are no errors."), N_("Mend what is listed under Problems."))
        with self._lock:
            going = self.run
            if going is not None and going.is_going:
                raise RobotBusy(_taken(going), N_("Wait for its end, or stop it there."), going.book)
            with self._open_workbooks.staying(
                session
            ):  # a file is renamed before, and then it is not here, or after the run
                run = self.run = RunSession(session, book, options, self._tell)
            self._unwritten = [s for s in self._unwritten if not s.written] + [run]
        self._tell(run)
        run.begin(self._over)
        return run

    def now(self) -> dict[str, Any]:
        """Return the summary of the current run that every page of the server shows."""
        run = self.run
        return run.short() if run is not None and run.is_going else NONE

    def going(self) -> set[str]:
        """Return the folder names of the runs that are going."""
        run = self.run
        return {run.folder} if run is not None and run.is_going and run.folder else set()

    def joints(self, session: WorkbookSession) -> Mapping[str, float]:
        """Return the joints (rad) of the robot that runs a workbook now; empty when none does."""
        run = self.run
        return run.run_state.joints if run is not None and run.session is session and run.is_going else {}

    def writing(self) -> set[str]:
        """Return the folder names of the runs that are over and whose table and pictures are still being written."""
        return {s.folder for s in list(self._unwritten) if s.folder and not s.is_going and not s.written}

    def clear(self, session: WorkbookSession) -> None:
        """Forget the last run of a workbook, so that its values disappear from the grid."""
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
        own, others = message("run", run.state()), message("run", run.short())
        for session in self._open_workbooks.sessions():
            session.tell_all(own if session is run.session else others)

    def _about(self, session: WorkbookSession) -> str:
        run = self.run
        if run is None:
            return message("run", NONE)
        if run.session is session:
            return run.about()
        return message("run", run.short() if run.is_going else NONE)

    def _over(self, run: RunSession) -> None:
        self._tell(run)
        if run.again_by and run.ended is not None and not run.ended["broken"]:
            try:
                self.start(run.session, run.book, run.again())
            except SheetsError as error:
                run.session.tell("trouble", {"message": said(error)})

    def _checked(self, session: WorkbookSession) -> None:
        run = self.run
        if run is not None and run.session is session:
            run.follow_edits()

    def _edited(self, session: WorkbookSession) -> None:
        """Clear a run that is over at the first edit after it, which brings the examples back."""
        run = self.run
        if run is not None and run.session is session and not run.is_going:
            self.clear(session)


def _taken(run: RunSession) -> str:
    return N_(
        "{who} is running {book} since {since}. There is one robot, so one run at a time.",
        who=run.options.by,
        book=run.book,
        since=clock(run.run_state.us),
    )
