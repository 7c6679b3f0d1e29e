"""Kept versions of a workbook: the list, keeping one, and restoring one."""

from __future__ import annotations

import re
from datetime import datetime
from pathlib import Path

from flask import request

from rrp_sheets.documents import Refused
from rrp_sheets.documents.journal import Version
from rrp_sheets.errors import SheetsError
from rrp_sheets.web.records.record_pages import VersionLine, VersionsPage
from rrp_sheets.web.records.telling import when
from rrp_sheets.web.security import visitor
from rrp_sheets.web.sessions import clean_name
from rrp_sheets.web.workbook_session import WorkbookSession

_LONGEST = 100
_UNSAFE = re.compile(r'[\x00-\x1f/\\:*?"<>|]+')


def moment(version: Version) -> str:
    """Format the time at which a version was kept."""
    try:
        return when(datetime.fromisoformat(version.at).astimezone())
    except ValueError:
        return version.at


def versions_page(room: WorkbookSession, name: str, notice: str = "", *, failed: bool = False) -> VersionsPage:
    """Build the list, with the result of the last action or the reason why it failed."""
    kept = room.document.versions()
    now = "" if room.document.read_only else room.document.reading.digest
    lines = tuple(VersionLine(v.id, v.name, moment(v), v.author, v.digest == now) for v in kept)
    return VersionsPage(name, lines, room.document.why, notice, failed)


def keep(room: WorkbookSession, name: str) -> VersionsPage:
    """Keep the workbook as it is now under the name that was sent."""
    title = " ".join(request.form.get("title", "").split())[:_LONGEST]
    try:
        if not title or not title.isprintable():
            raise Refused("A version needs a name.", "Write what you want to find it by, such as “before the pilot”.")
        room.poll()
        room.document.keep_version(_author(), title)
    except SheetsError as error:
        return versions_page(room, name, f"{error.message} {error.remedy}".strip(), failed=True)
    return versions_page(room, name, f"Kept as “{title}”.")


def restore(room: WorkbookSession, name: str) -> VersionsPage:
    """Restore a version; refused while a cell is being edited, whose text would be lost."""
    number = request.form.get("version", "")
    found = next((v for v in room.document.versions() if str(v.id) == number), None)
    try:
        if found is None:
            raise Refused("There is no such version any more.", "Look at the list again.")
        people = busy(room)
        if people:
            who = " and ".join(people[:3])
            raise Refused(f"{who} {'is' if len(people) == 1 else 'are'} editing a cell just now.",
                          "Bring it back when they have finished.")  # fmt: skip
        author = _author()
        room.document.restore(author, found.id)
    except SheetsError as error:
        return versions_page(room, name, f"{error.message} {error.remedy}".strip(), failed=True)
    room.tell("reload", {"why": f"{author} has brought back the version “{found.name}”."})
    room.check_soon()
    notice = f"“{found.name}” is back. What the workbook was before is kept as a version too."
    return versions_page(room, name, notice)


def busy(room: WorkbookSession) -> list[str]:
    """Return the names of those who are editing a cell now."""
    return sorted(set(room.locks.taken().values()))


def file_name(book: str, version: Version) -> str:
    """Return the file name under which a version is downloaded.

    >>> file_name("a.xlsx", Version(1, "before: the/pilot", "", "", ""))
    'a (before the pilot).xlsx'
    """
    path = Path(book)
    return f"{path.stem} ({' '.join(_UNSAFE.sub(' ', version.name).split())}){path.suffix}"


def _author() -> str:
    """Return the name of the user: the one of the login, else the one that the page sends."""
    return visitor().name or clean_name(request.form.get("author", "")) or "Somebody"
