"""Access to the runs recorded beside the workbooks of a folder, by name; no name leads out of it."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass
from pathlib import Path

from rrp_sheets.errors import SheetsError
from rrp_sheets.runs.records.metadata import RUNS, RunMetadata, facts_of, run_names
from rrp_sheets.web.workbook_repository import printable

PICTURES = {"strip.png": "image/png", "film.gif": "image/gif", "diagram.svg": "image/svg+xml"}
_WAV = "audio/wav"
_SHEET = "application/vnd.openxmlformats-officedocument.spreadsheetml.sheet"
_OTHERS = {
    "run.xlsx": _SHEET, "protocol.xlsx": _SHEET, "robot.toml": "text/plain", "gestures.toml": "text/plain",
    "trace.jsonl": "application/x-ndjson",
    "poses.jsonl": "application/x-ndjson", "camera.zip": "application/zip",
}  # fmt: skip


@dataclass(frozen=True)
class RunStore:
    """Recorded runs of a folder of workbooks.

    Args:
        folder: of the workbooks.
        going: the names of the folders of runs that go on now.
        writing: those of runs that are over, and whose last files are not there yet.
        forget: called with the folder names of runs that were deleted.
    """

    folder: Path
    going: Callable[[], Collection[str]] = frozenset
    writing: Callable[[], Collection[str]] = frozenset
    forget: Callable[[Collection[str]], object] = len

    def names(self) -> list[str]:
        """Return the names of all runs, the newest first."""
        inside = (self.folder / RUNS).resolve().is_relative_to(self.folder.resolve())
        return run_names(self.folder) if inside else []

    def facts(self, names: list[str]) -> list[RunMetadata]:
        """Return the metadata of some runs."""
        going = self.going()
        return [facts_of(self.folder / RUNS / name, going) for name in names]

    def place(self, name: str) -> Path:
        """Return the folder of a run.

        Raises:
            SheetsError: there is no such run.
        """
        if name not in self.names():
            raise SheetsError(f"There is no run “{printable(name)[:100]}” here.", "Choose one from the list of runs.")
        return (self.folder / RUNS / name).absolute()

    def files(self, name: str) -> dict[str, tuple[Path, str]]:
        """Return the files of a run that can be viewed or downloaded, with their types; symbolic links are left out."""
        place = self.place(name)
        found: dict[str, tuple[Path, str]] = {}
        for path in sorted(place.iterdir(), key=lambda p: p.name):
            kind = kind_of(path.name)
            if kind and path.is_file() and not path.is_symlink():
                found[path.name] = (path, kind)
        return found


def kind_of(name: str) -> str:
    """Return the media type of a file of a run; empty for one that is not served.

    >>> kind_of("say-001.wav"), kind_of("film.gif"), kind_of("evil.html"), kind_of("run.xlsx") == _SHEET
    ('audio/wav', 'image/gif', '', True)
    """
    if name.endswith(".wav") and name[0] != ".":
        return _WAV
    return PICTURES.get(name) or _OTHERS.get(name, "")
