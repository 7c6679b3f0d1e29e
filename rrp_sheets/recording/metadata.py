"""Metadata of runs, and lists of runs; of each only the first and the last line of its trace are read.

A run's folder is untrusted and may be half written: what can be read is used, and the metadata names what is wrong.
"""

from __future__ import annotations

import errno
import math
import os
import stat
import time
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field
from datetime import datetime
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeVar

from rrp_sheets.engine.file_lock import is_locked
from rrp_sheets.errors import SheetsError
from rrp_sheets.model.run_files import RUNS, TRACE, Stamp, kind_of_end
from rrp_sheets.recording.messages import as_message
from rrp_sheets.recording.trace_reader import TraceSummary, read_ends, text_of
from rrp_sheets.texts import N_, known_language, os_reason

T = TypeVar("T")
UNNAMED = "Somebody"
"""In requests and recordings, who has given no name on the page."""
EXACT = 2
"""Digits of the seconds in lists of events, so that one can read how long after another an event came."""
STILL_WRITTEN = 15.0  # s: a trace without an end that was written so recently belongs to a run that goes on


@dataclass(frozen=True)
class RunMetadata:
    """Metadata of a recorded run.

    Attributes:
        ended: `time`, `stopped`, `end run`, `killed` (its program ended), `broken`, `going`,
            `cut` (its record has no end), `unreadable`.
    """

    run: str  # the name of its folder
    began: datetime | None = None  # wall clock at time 0, when that is known
    workbook: str = ""  # the file that ran
    digest: str = ""  # of that file
    participant: str = ""
    condition: str = ""
    operator: str = ""
    mode: str = ""
    robot: str = ""
    engine: str = ""
    frame_rate: str = ""
    seed: str = ""
    program: str = ""
    language: str = "en"  # of pictures and accounts that are made of its record
    seconds: float = 0.0  # on its own clock
    ended: str = "unreadable"
    ended_by: str = ""  # the row or the person that ended it, where there is one
    why: str = ""  # it broke off, or cannot be read
    remedy: str = ""
    events: Mapping[str, int] = field(default_factory=dict)  # by stream or row, as the two below
    errors: Mapping[str, int] = field(default_factory=dict)
    commands: Mapping[str, int] = field(default_factory=dict)

    @property
    def readable(self) -> bool:
        """True when the record can be opened."""
        return self.ended != "unreadable"


def run_names(folder: Path) -> list[str]:
    """Return the names of the runs' folders beside the workbooks of a folder, from the last name to the first."""
    try:
        with os.scandir(folder / RUNS) as found:
            return sorted((e.name for e in found if e.is_dir(follow_symlinks=False) and e.name[0] != "."), reverse=True)
    except OSError:
        return []


def newest_first(runs: Iterable[RunMetadata]) -> list[RunMetadata]:
    """Sort runs by the time they began, whatever their folders are called; those without a known one come first."""
    return sorted(runs, key=lambda f: f.began.timestamp() if f.began else math.inf, reverse=True)


def metadata_of(place: Path, going: Collection[str] = ()) -> RunMetadata:
    """Return the metadata of a run's folder; never raise: those of an unreadable record have the reason.

    `going`: the names of the folders of runs that are known to go on.
    """
    run, trace = place.name, place / TRACE
    try:
        about = trace.stat()
        if not stat.S_ISREG(about.st_mode):  # a pipe would be waited for without an end
            raise IsADirectoryError(errno.EISDIR, N_("it is not a file"))
        header, summary, seconds = read_ends(trace)
    except OSError as error:
        missing = isinstance(error, FileNotFoundError)
        cannot = N_("Its {file} cannot be read: {reason}.", file=TRACE, reason=os_reason(error))
        why = N_("There is no {file} in it.", file=TRACE) if missing else cannot
        remedy = N_("The folder of a run contains the whole recording. Copy all of it.")
        return RunMetadata(run, why=why, remedy=remedy)
    if header is None or not header.fields:
        if header is not None and run in going:
            return RunMetadata(run, ended="going")
        why = N_("Its {file} does not start like the recording of a run.", file=TRACE)
        remedy = N_("Copy the folder again from its source. Perhaps the copy is incomplete.")
        return RunMetadata(run, why=why, remedy=remedy)
    if summary is not None:
        ended = kind_of_end(summary.text("ended") or "cut", summary.text("stopped_by"))
    else:
        summary = TraceSummary()
        fresh = 0 <= time.time() - about.st_mtime < STILL_WRITTEN
        ended = "going" if run in going or fresh or is_locked(trace) else "cut"
    return RunMetadata(
        run=run, began=_when(header.fields.get("began")), workbook=header.text("name"), digest=header.text("workbook"),
        participant=header.text("participant"), condition=header.text("condition"), operator=header.text("operator"),
        mode=header.text("mode"), robot=header.text("robot"), engine=header.text("engine"),
        frame_rate=header.text("frame_rate"), seed=header.text("seed"), program=header.text("program"),
        language=known_language(header.fields.get("language")),
        seconds=seconds, ended=ended, ended_by=summary.text("stopped_by") or summary.text("by"),
        why=as_message(summary.text("why")), remedy=as_message(summary.text("remedy")),
        events=_counts(summary.fields.get("events")),
        errors=_counts(summary.fields.get("errors")), commands=_counts(summary.fields.get("actuator_commands")),
    )  # fmt: skip


def kept_while_unchanged(make: Callable[..., T], file: str, most: int) -> Callable[..., T]:
    """Return a function of a run's folder that keeps its newest results while this file in the folder is the same."""
    kept = lru_cache(maxsize=most)(lambda _state, *given: make(*given))

    def result(place: Path, *more: str) -> T:
        try:
            about = (place / file).stat()
        except FileNotFoundError:
            return kept(None, place, *more)
        return kept((about.st_mtime_ns, about.st_size), place, *more)

    return result


def _when(value: Any) -> datetime | None:
    try:
        return datetime.fromisoformat(value).astimezone()
    except (TypeError, ValueError, OverflowError, OSError):
        return None


def _counts(value: Any) -> dict[str, int]:
    given = value if isinstance(value, dict) else {}
    return {text_of(k): v for k, v in given.items() if isinstance(v, int) and not isinstance(v, bool)}


def stamp_of(place: Path) -> Stamp:
    """Return the stamp of a run's folder; what its record does not say is blank. Never raise."""
    run = metadata_of(place)
    return Stamp(
        workbook=run.workbook, digest=run.digest, program=run.program, mode=run.mode, seed=run.seed,
        participant=run.participant, condition=run.condition, operator=run.operator,
        began=run.began.isoformat(timespec="milliseconds") if run.began else "",
        ended=run.ended if run.readable else "", run=run.run, language=run.language,
    )  # fmt: skip


def runs_place(folder: Path) -> Path:
    """Return the folder in which the runs of a folder are: its `runs`, or itself when it is named so.

    It raises SheetsError when there is no such folder, or its `runs` leads elsewhere.
    """
    if not folder.is_dir():
        remedy = N_("Name the folder with the workbooks.")
        raise SheetsError(N_("There is no folder “{folder}”.", folder=folder), remedy)
    inside = folder / RUNS
    if not inside.is_dir():
        return folder if folder.resolve().name == RUNS else inside
    if not inside.resolve().is_relative_to(folder.resolve()):
        remedy = N_("Name that folder itself: {path}", path=inside.resolve())
        raise SheetsError(N_("“{path}” leads to another folder.", path=inside), remedy)
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
    found = newest_first(metadata_of(place, going) for place in places)
    return [
        f for f in found
        if (not participant or f.participant == participant)
        and (not workbook or workbook.casefold() in (f.workbook.casefold(), Path(f.workbook).stem.casefold()))
    ]  # fmt: skip


def as_dict(run: RunMetadata) -> dict[str, Any]:
    """Return the metadata of a run as JSON."""
    return {
        "run": run.run, "began": run.began.isoformat() if run.began else None, "workbook": run.workbook,
        "sha256": run.digest, "participant": run.participant, "condition": run.condition,
        "operator": run.operator, "mode": run.mode, "seed": run.seed, "program": run.program,
        "seconds": run.seconds, "ended": run.ended, "ended_by": run.ended_by, "why": run.why,
        "errors": sum(run.errors.values()),
    }  # fmt: skip


def length(seconds: float) -> str:
    """Format a length of time.

    >>> length(8.24), length(222), length(4000)
    ('8.2 s', '3:42 min', '1:06:40 h')
    """
    if seconds < 60:
        return N_("{s:.1f} s", s=seconds)
    whole = round(seconds)
    if whole < 3600:
        return N_("{m}:{s:02d} min", m=whole // 60, s=whole % 60)
    return N_("{h}:{m:02d}:{s:02d} h", h=whole // 3600, m=whole % 3600 // 60, s=whole % 60)


def clock(seconds: float, digits: int = 1) -> str:
    """Format a moment of a run, rounded to tenths or more digits. time.js of the pages does the same.

    >>> clock(49.467), clock(49.467, EXACT), clock(59.96), clock(3723)
    ('0:49.5', '0:49.47', '1:00.0', '1:02:03.0')
    """
    parts = 10**digits
    whole, rest = divmod(int(seconds * parts + 0.5), parts)
    minutes = f"{whole // 60}" if whole < 3600 else f"{whole // 3600}:{whole // 60 % 60:02}"
    return f"{minutes}:{whole % 60:02}.{rest:0{digits}}"


def who(name: str) -> str:
    """Return a person's name; of one without a name, that it was somebody."""
    return N_("somebody") if name == UNNAMED else name


def ended(metadata: RunMetadata) -> str:
    """Describe the end of a run in words."""
    by = who(metadata.ended_by)
    match metadata.ended:
        case "time":
            return N_("ended as planned")
        case "end run":
            return N_("ended by the row {row}", row=by) if by else N_("ended by a row")
        case "stopped":
            return N_("stopped by {name}", name=by) if by else N_("stopped manually")
        case "killed":
            return N_("stopped because the program that started it ended")
        case "broken":
            return N_("stopped unexpectedly at row {row}", row=by) if by else N_("stopped unexpectedly")
        case "going":
            return N_("in progress")
        case "unreadable":
            return N_("cannot be read")
    return N_("stopped unexpectedly: the recording has no end")
