"""Lists of recorded runs: those of a folder, selections of them, and folders below that have runs."""

from __future__ import annotations

import os
import time
from collections.abc import Collection
from pathlib import Path
from typing import Any

from rrp_sheets.errors import SheetsError
from rrp_sheets.model.run_files import RUNS, TRACE
from rrp_sheets.recording.metadata import RunMetadata, facts_of, newest_first, run_names
from rrp_sheets.texts import N_

_LIBRARIES = "node_modules"
_MOST_FOLDERS = 50_000
_MOST_SECONDS = 10.0


def runs_place(folder: Path) -> Path:
    """Return the folder in which the runs of a folder are: its `runs`, or itself when it is named so.

    Raises:
        SheetsError: there is no such folder, or its `runs` leads elsewhere.
    """
    if not folder.is_dir():
        raise SheetsError(
            N_("There is no folder “{folder}”.", folder=folder), N_("Name the folder with the workbooks.")
        )
    inside = folder / RUNS
    if inside.is_dir():
        if not inside.resolve().is_relative_to(folder.resolve()):
            raise SheetsError(
                N_("“{path}” leads to another folder.", path=inside),
                N_("Name that folder itself: {path}", path=inside.resolve()),
            )
        return inside
    if folder.resolve().name == RUNS:
        return folder
    return inside


def runs_in(folder: Path) -> list[Path]:
    """Return the folders of the runs of a folder, from the last name to the first; of a run's own folder that one."""
    if (folder / TRACE).is_file():
        return [folder]
    place = runs_place(folder)
    return [place / name for name in run_names(place.parent)] if place.name == RUNS else []


def chosen(
    places: Collection[Path], *, participant: str = "", workbook: str = "", going: Collection[str] = ()
) -> list[RunMetadata]:
    """Return the metadata of the runs of a participant and of a workbook, newest first; blank selects all."""
    found = newest_first(facts_of(place, going) for place in places)
    return [
        f for f in found
        if (not participant or f.participant == participant)
        and (not workbook or workbook.casefold() in (f.workbook.casefold(), Path(f.workbook).stem.casefold()))
    ]  # fmt: skip


def as_dict(facts: RunMetadata) -> dict[str, Any]:
    """Return the metadata of a run as JSON."""
    return {
        "run": facts.run, "began": facts.began.isoformat() if facts.began else None, "workbook": facts.workbook,
        "sha256": facts.digest, "participant": facts.participant, "condition": facts.condition,
        "operator": facts.operator, "mode": facts.mode, "seed": facts.seed, "program": facts.program,
        "seconds": facts.seconds, "ended": facts.ended, "ended_by": facts.ended_by, "why": facts.why,
        "errors": sum(facts.errors.values()),
    }  # fmt: skip


def is_software(root: str, name: str) -> bool:
    """Return whether a folder holds installed software, which would take long to search and has nothing of ours."""
    return name == _LIBRARIES or Path(root, name, "pyvenv.cfg").is_file()


def folders_below(folder: Path) -> tuple[list[Path], bool]:
    """Return the folders below a folder that have a `runs`, by name, and whether everything was looked at.

    No link is followed, and the folders of runs are not searched.
    """
    deadline = time.monotonic() + _MOST_SECONDS
    found: list[Path] = []
    for number, (root, folders, _) in enumerate(os.walk(folder)):
        if number >= _MOST_FOLDERS or time.monotonic() > deadline:
            return found, False
        runs = Path(root, RUNS)
        if RUNS in folders and not runs.is_symlink():
            folders.remove(RUNS)
            if number:
                found.append(Path(root))
        folders[:] = sorted(n for n in folders if not is_software(root, n))
    return found, True


def length(seconds: float) -> str:
    """Format a length of time.

    >>> length(8.24), length(222), length(4000)
    ('8.2 s', '3:42 min', '1:06:40 h')
    """
    if seconds < 60:
        return f"{seconds:.1f} s"
    whole = round(seconds)
    if whole < 3600:
        return f"{whole // 60}:{whole % 60:02} min"
    return f"{whole // 3600}:{whole % 3600 // 60:02}:{whole % 60:02} h"


def clock(seconds: float) -> str:
    """Format a moment of a run.

    >>> clock(3.0333), clock(83.5)
    ('0:03.0', '1:23.5')
    """
    tenths = round(seconds * 10)
    return f"{tenths // 600}:{tenths % 600 // 10:02}.{tenths % 10}"


def ended(facts: RunMetadata) -> str:
    """Describe the end of a run in words."""
    by = facts.ended_by
    match facts.ended:
        case "time":
            return N_("its time was over")
        case "end run":
            return N_("ended by the row {row}", row=by) if by else N_("ended by a row")
        case "stopped":
            return N_("stopped by {name}", name=by) if by else N_("stopped by hand")
        case "broken":
            return N_("broke off at the row {row}", row=by) if by else N_("broke off")
        case "going":
            return N_("is going")
        case "unreadable":
            return N_("cannot be read")
    return N_("broke off: the record has no end")
