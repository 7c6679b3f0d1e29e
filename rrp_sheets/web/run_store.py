"""Access to the runs of a folder by name, none of which leads out of it; what their pages say of each."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Collection
from dataclasses import dataclass
from datetime import date, datetime, timedelta
from pathlib import Path
from typing import BinaryIO

from rrp_sheets.errors import SheetsError
from rrp_sheets.model.run_files import CAMERA, DIAGRAM, FILM, POSES, RUNS, STRIP, TABLE, TRACE, WORKBOOK
from rrp_sheets.recording.exporting import XLSX
from rrp_sheets.recording.metadata import RunMetadata, ended, length, metadata_of, run_names
from rrp_sheets.texts import N_, LazyMessage, sentences
from rrp_sheets.web.models import date_and_time
from rrp_sheets.web.workbook_repository import addressable, printable

PICTURES = {STRIP: "image/png", FILM: "image/gif", DIAGRAM: "image/svg+xml"}
_WAV = "audio/wav"
_OTHERS = {
    TABLE: XLSX, WORKBOOK: XLSX, "robot.toml": "text/plain", "gestures.toml": "text/plain",
    TRACE: "application/x-ndjson", POSES: "application/x-ndjson", CAMERA: "application/zip",
}  # fmt: skip
_MODES = ("simulated", "pilot", "real")  # those that a list shows
# The icon of a run by its end; of any other it is that of a broken one.
_STATES = {"time": "good", "end run": "good", "stopped": "stopped", "going": "going", "unreadable": "unreadable"}


@dataclass(frozen=True, slots=True)
class RunLine:
    """Run in a list.

    Attributes:
        run: the name of its folder; `opens` whether it can be opened.
        book: the workbook's file, when it is in the folder.
        who: participant and condition.
        state: `good`, `stopped`, `broken`, `going`, `unreadable`: the icon that is shown; `ended` has words for it.
        why: what is wrong, or why it broke off, and what can be done.
    """

    run: str
    opens: bool
    when: str
    workbook: str
    book: str
    who: str
    operator: str
    mode: str
    length: str
    state: str
    ended: str
    why: str
    errors: int


@dataclass(frozen=True)
class RunStore:
    """Recorded runs of a folder of workbooks.

    Attributes:
        going: the names of the folders of runs that go on now.
        writing: those of runs that are over, and whose last files are not there yet.
        forget: called with the folder names of runs that were deleted.
    """

    folder: Path
    going: Callable[[], Collection[str]] = frozenset
    writing: Callable[[], Collection[str]] = frozenset
    forget: Callable[[Collection[str]], object] = lambda folders: None

    def names(self) -> list[str]:
        """Return the names of all runs, the newest first."""
        inside = (self.folder / RUNS).resolve().is_relative_to(self.folder.resolve())
        return run_names(self.folder) if inside else []

    def metadata(self, names: list[str]) -> list[RunMetadata]:
        """Return the metadata of some runs."""
        going = self.going()
        return [metadata_of(self.folder / RUNS / name, going) for name in names]

    def place(self, name: str) -> Path:
        """Return the folder of a run; raises SheetsError when there is no such run."""
        if name not in self.names():
            message = N_("There is no run “{run}” here.", run=printable(name)[:100])
            raise SheetsError(message, N_("Choose one from the list of runs."))
        return (self.folder / RUNS / name).absolute()

    def files(self, name: str) -> dict[str, tuple[Path, str]]:
        """Return the files of a run that can be viewed or downloaded, with their types; symbolic links are left out."""
        place = self.place(name)
        found: dict[str, tuple[Path, str]] = {}
        for path in sorted(place.iterdir(), key=lambda p: p.name):
            kind = media_type(path.name)
            if kind and path.is_file() and not path.is_symlink():
                found[path.name] = (path, kind)
        return found


def media_type(name: str) -> str:
    """Return the media type of a file of a run; empty for one that is not served.

    >>> media_type("say-001.wav"), media_type("film.gif"), media_type("evil.html"), media_type("run.xlsx") == XLSX
    ('audio/wav', 'image/gif', '', True)
    """
    if name.endswith(".wav") and name[0] != ".":
        return _WAV
    return PICTURES.get(name) or _OTHERS.get(name, "")


def made(name: str, make: Callable[[Path], object]) -> BinaryIO:
    """Have `make` write a file, and return it open; it is deleted when it is closed. Raises the error of `make`."""
    with tempfile.TemporaryDirectory(prefix="rrp-sheets-") as folder:
        target = Path(folder) / name
        try:
            make(target)
        except SheetsError as error:
            if folder not in error.message:
                raise
            why = error.message.places.get("reason", "") if isinstance(error.message, LazyMessage) else ""
            plain = N_("There is no room for this file in “{folder}”, where files are made before they are sent.")
            full = N_("There is no room for this file in “{folder}”, where files are made before they are sent "
                      "({why}).")  # fmt: skip
            message = N_(full if why else plain, folder=str(Path(folder).parent), why=why)
            remedy = N_("Make room there, on the computer on which the program runs, and try again.")
            raise SheetsError(message, remedy) from None
        return target.open("rb")  # stays readable when its name is gone


def when(moment: datetime | None, today: date | None = None) -> str:
    """Format a time relative to today.

    >>> when(datetime(2026, 11, 21, 9, 5), date(2026, 11, 21)), when(datetime(2026, 11, 2, 9, 5), date(2026, 11, 21))
    ('today 09:05', '2 November, 09:05')
    """
    if moment is None:
        return ""
    today = today or datetime.now().date()
    if moment.date() in (today, today - timedelta(days=1)):
        return N_("today {time}" if moment.date() == today else "yesterday {time}", time=f"{moment:%H:%M}")
    return date_and_time(moment, year=moment.year != today.year)


def line_of(run: RunMetadata, books: Collection[str]) -> RunLine:
    """Format a run for a list; `books` are the workbooks of the folder."""
    why = sentences(run.why, run.remedy)
    if run.ended == "cut":
        why = N_("The program or the computer ended in the middle. What was recorded until then can be looked at.")
    moment = when(run.began) or ("" if run.readable else printable(run.run))
    return RunLine(
        run=printable(run.run), opens=run.readable and addressable(run.run), when=moment or printable(run.run),
        workbook=run.workbook, book=run.workbook if run.workbook in books else "",
        who=", ".join(filter(None, (run.participant, run.condition))), operator=run.operator,
        mode=run.mode if run.mode in _MODES else "", length=length(run.seconds) if run.seconds else "",
        state=_STATES.get(run.ended, "broken"), ended=ended(run), why=why, errors=sum(run.errors.values()),
    )  # fmt: skip
