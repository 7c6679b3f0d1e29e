"""Manager of the server's single run: there is one robot, so one run at a time for all workbooks."""

from __future__ import annotations

import threading
from collections.abc import Collection, Mapping
from typing import Any

from rrp_sheets.errors import SheetsError
from rrp_sheets.runs.formatting import clock
from rrp_sheets.web.collab.broadcaster import message
from rrp_sheets.web.collab.workbook_session import OpenWorkbooks, WorkbookSession
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
        self.session: RunSession | None = None
        open_workbooks.opened, open_workbooks.leaving = self._attach, self._leaving

    def _attach(self, room: WorkbookSession) -> None:
        room.about_run = lambda: self._about(room)
        room.after_check = lambda: self._checked(room)
        room.after_edit = lambda: self._edited(room)

    def _leaving(self, room: WorkbookSession) -> None:
        session = self.session
        if session is not None and session.room is room and session.is_going:
            raise SheetsError(f"{session.wish.by} is running {session.book}.", "Stop the run first.")

    def start(self, room: WorkbookSession, book: str, wish: RunOptions) -> RunSession:
        """Start a run of a workbook, and notify all pages.

        Raises:
            RobotBusy: when a run is going.
            MissingPart: when the simulator is not installed here.
            SheetsError: when the workbook has errors.
        """
        errors = room.analysis().errors
        if errors:
            raise SheetsError("Run starts when there are no errors.", "Mend what is listed under Problems.")
        with self._lock:
            going = self.session
            if going is not None and going.is_going:
                raise RobotBusy(_taken(going), "Wait for its end, or stop it there.", going.book)
            with self._open_workbooks.staying(
                room
            ):  # a file is renamed before, and then it is not here, or after the run
                session = self.session = RunSession(room, book, wish, self._tell)
            self._unwritten = [s for s in self._unwritten if not s.written] + [session]
        self._tell(session)
        session.begin(self._over)
        return session

    def now(self) -> dict[str, Any]:
        """Return the summary of the current run that every page of the server shows."""
        session = self.session
        return session.short() if session is not None and session.is_going else NONE

    def going(self) -> set[str]:
        """Return the folder names of the runs that are going."""
        session = self.session
        return {session.folder} if session is not None and session.is_going and session.folder else set()

    def joints(self, room: WorkbookSession) -> Mapping[str, float]:
        """Return the joints (rad) of the robot that runs a workbook now; empty when none does."""
        session = self.session
        return session.run_state.joints if session is not None and session.room is room and session.is_going else {}

    def writing(self) -> set[str]:
        """Return the folder names of the runs that are over and whose table and pictures are still being written."""
        return {s.folder for s in list(self._unwritten) if s.folder and not s.is_going and not s.written}

    def clear(self, room: WorkbookSession) -> None:
        """Forget the last run of a workbook, so that its values disappear from the grid."""
        with self._lock:
            session = self.session
            if session is None or session.room is not room or session.is_going:
                return
            self.session = None
        for each in self._open_workbooks.rooms():
            each.tell("run", NONE)

    def forget(self, folders: Collection[str]) -> None:
        """Clear the last run, if it is among the deleted ones, so that no page shows its data any more."""
        session = self.session
        if session is not None and session.folder in folders:
            self.clear(session.room)

    # ---- telling

    def _tell(self, session: RunSession) -> None:
        if session is not self.session:  # its files were still being written when another run began
            return
        own, others = message("run", session.state()), message("run", session.short())
        for room in self._open_workbooks.rooms():
            room.tell_all(own if room is session.room else others)

    def _about(self, room: WorkbookSession) -> str:
        session = self.session
        if session is None:
            return message("run", NONE)
        if session.room is room:
            return session.about()
        return message("run", session.short() if session.is_going else NONE)

    def _over(self, session: RunSession) -> None:
        self._tell(session)
        if session.again_by and session.ended is not None and not session.ended["broken"]:
            try:
                self.start(session.room, session.book, session.again())
            except SheetsError as error:
                session.room.tell("trouble", {"message": f"{error.message} {error.remedy}".strip()})

    def _checked(self, room: WorkbookSession) -> None:
        session = self.session
        if session is not None and session.room is room:
            session.follow_edits()

    def _edited(self, room: WorkbookSession) -> None:
        """Clear a run that is over at the first edit after it, which brings the examples back."""
        session = self.session
        if session is not None and session.room is room and not session.is_going:
            self.clear(room)


def _taken(session: RunSession) -> str:
    who, since = session.wish.by, clock(session.run_state.us)
    return f"{who} is running {session.book} since {since}. There is one robot, so one run at a time."
