"""The workbook that an address names."""

from __future__ import annotations

from collections.abc import Callable

from flask import abort

from rrp_sheets.web.open_workbooks import OpenWorkbooks
from rrp_sheets.web.workbook_repository import WorkbookRepository, refuse_text
from rrp_sheets.web.workbook_session import WorkbookSession

RoomOf = Callable[[str], WorkbookSession]


def workbook_or_404(repository: WorkbookRepository, open_workbooks: OpenWorkbooks) -> RoomOf:
    """What gives the room of a workbook by the name in an address; a name that the folder has not is answered 404.

    A Markdown file that is no workbook is refused with SheetsError.
    """

    def room_of(name: str) -> WorkbookSession:
        if not repository.has(name):
            abort(404)
        if not open_workbooks.has(name):  # one that is open may have lost its last sheet, which undo brings back
            refuse_text(repository, name)
        return open_workbooks.room(repository.path(name))

    return room_of
