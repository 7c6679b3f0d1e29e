"""Workbooks of one folder: listed, read, and checked when their files have changed."""

from __future__ import annotations

import threading
from collections import OrderedDict
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from rrp_sheets import api
from rrp_sheets.documents.document import stamp_if_there
from rrp_sheets.errors import SheetsError, UnreadableFile
from rrp_sheets.runs.check_worker import CheckWorker
from rrp_sheets.texts import N_
from rrp_sheets.web.analysis import Analysis, analyse
from rrp_sheets.workbook import Reading
from rrp_sheets.workbook.files import WORKBOOK_SUFFIXES, Stamp

MOST_FILES = 200
NO_SHEETS = "FILE017"
_KEPT = 64


@dataclass(frozen=True)
class CheckedWorkbook:
    """Workbook that was read and checked; the file was last written when it `changed`."""

    name: str
    path: Path
    changed: datetime
    reading: Reading
    analysis: Analysis

    @property
    def title(self) -> str:
        """Title from the Protocol, or the file's name without its ending."""
        return self.analysis.workbook.protocol.text("Title") or Path(self.name).stem


class WorkbookRepository:
    """Workbooks directly in a folder, which `worker` checks. Safe to use from several threads."""

    def __init__(self, folder: Path, worker: CheckWorker) -> None:
        self.folder = folder
        self.worker = worker
        self._lock = threading.Lock()
        self._kept: OrderedDict[tuple[str, Stamp], CheckedWorkbook | SheetsError] = OrderedDict()
        self._prose: dict[str, tuple[Stamp, bool]] = {}

    def names(self) -> list[str]:
        """Return the sorted names of the files that may be workbooks; raises SheetsError for an unreadable folder."""
        try:
            files = self.folder.iterdir()
            found = [p.name for p in files if p.suffix.casefold() in WORKBOOK_SUFFIXES and p.name[0] not in ".~"]
        except OSError as error:
            why = error.strerror or N_("the system refuses it")
            raise SheetsError(
                N_("The folder {folder} cannot be read: {why}.", folder=str(self.folder), why=why),
                N_("Start again with another."),
            ) from error
        return sorted(found, key=lambda name: (name.casefold(), name))

    def has(self, name: str) -> bool:
        """Return whether the folder lists such a file; only these can be opened, so no name leads out of it."""
        return name in self.names()

    def workbooks(self) -> list[str]:
        """Return the names of workbooks that an address can hold; prose in Markdown, such as a README, is none."""
        return [name for name in self.names() if addressable(name) and not self.is_text(name)]

    def is_text(self, name: str) -> bool:
        """Return whether a file is readable Markdown prose, such as a README, and not a workbook."""
        path = self.folder / name
        stamp = None if path.suffix.casefold() == ".xlsx" else stamp_if_there(path)
        if stamp is None or not path.resolve().is_relative_to(self.folder.resolve()):
            return False
        known = self._prose.get(name)
        if known is None or known[0] != stamp:
            known = self._prose[name] = stamp, _is_text(path)
        return known[1]

    def path(self, name: str) -> Path:
        """Return the path of a file of the folder; raises SheetsError when its name leads out of the folder."""
        path = self.folder / name
        if not self.has(name) or not path.resolve().is_relative_to(self.folder.resolve()):
            raise SheetsError(
                N_("{name} is not a file of this folder.", name=printable(name)),
                N_("Put the workbook itself there; links that lead elsewhere are not followed."),
            )
        return path

    def open(self, name: str) -> CheckedWorkbook:
        """Read and check a workbook; raises SheetsError when it cannot be read, or its name leads out of the folder."""
        path = self.path(name)
        stamp = stamp_if_there(path)
        with self._lock:
            found = self._kept.get((name, stamp)) if stamp else None
        if found is None:
            found = _read(name, path, self.worker)
            if stamp:
                with self._lock:
                    self._kept[name, stamp] = found
                    while len(self._kept) > _KEPT:
                        self._kept.popitem(last=False)
        if isinstance(found, SheetsError):
            raise found
        return found


def _read(name: str, path: Path, worker: CheckWorker) -> CheckedWorkbook | SheetsError:
    try:
        reading = api.read(path)
        changed = datetime.fromtimestamp(path.stat().st_mtime)
        return CheckedWorkbook(name, path, changed, reading, analyse(path, reading, worker))
    except UnreadableFile as error:
        return error
    except OSError as error:
        message = N_("{name} has just disappeared: {why}.", name=printable(name), why=error.strerror)
        return SheetsError(message, N_("Go back and look again."))


def refuse_text(repository: WorkbookRepository, name: str) -> None:
    """Raise SheetsError for a file that is prose: it has nothing to edit, run, compare or print."""
    if repository.is_text(name):
        raise SheetsError(
            N_("“{name}” is not a workbook but a text for people.", name=printable(name)),
            N_("A workbook needs another name." if _is_readme(name) else "Choose a workbook from the page Workbooks."),
        )


def _is_readme(name: str) -> bool:
    return Path(name).stem.casefold() == "readme"


def _is_text(path: Path) -> bool:
    if _is_readme(path.name):  # also when it shows a table of rows as an example
        return True
    try:
        reading = api.read(path)
    except UnreadableFile as error:
        return error.code == NO_SHEETS
    except (SheetsError, OSError):
        return False
    book = reading.workbook
    sheets = (
        book.behaviours, book.protocol.fields, book.scene, book.tests, book.devices, book.helpers, book.gestures,
        book.risks,
    )  # fmt: skip
    near = any(d.code.startswith("SHEET") and d.code != "SHEET001" for d in reading.report)  # nearly a known sheet
    return reading.format == "markdown" and not near and not any(sheets)


def printable(name: str) -> str:
    r"""Return a file's name as it can be shown: undecodable bytes become question marks.

    >>> printable("caf\udce9.xlsx")
    'caf?.xlsx'
    """
    return name.encode("utf-8", "replace").decode()


def addressable(name: str) -> bool:
    """Return whether a name can be used in a URL, which names with undecodable bytes cannot."""
    return printable(name) == name
