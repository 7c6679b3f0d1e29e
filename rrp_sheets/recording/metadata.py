"""Metadata of a run, from the first and the last line of its trace: a long run costs what a short one does.

A run's folder is untrusted and may be half written: what can be read is used, and the metadata names what is wrong.
"""

from __future__ import annotations

import errno
import math
import os
import stat
import time
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Any

from rrp_sheets.engine.file_lock import is_locked
from rrp_sheets.model.run_files import RUNS, TRACE, Stamp
from rrp_sheets.recording.trace_reader import TraceSummary, read_ends, text_of
from rrp_sheets.texts import N_, known_language

STILL_WRITTEN = 15.0  # s: a trace without an end that was written so recently belongs to a run that goes on


@dataclass(frozen=True)
class RunMetadata:
    """Facts about a recorded run.

    Attributes:
        run: the name of its folder.
        began: wall clock at time 0; None when it is not known.
        workbook: the file that ran.
        language: of pictures and accounts that are made of its record.
        digest: of that file.
        seconds: how long it was, on its own clock.
        ended: `time`, `stopped`, `end run`, `broken`, `going`, `cut` (its record has no end), `unreadable`.
        ended_by: the row or the person that ended it, where there is one.
        why: why it broke off, or what is wrong with the record.
        events, errors, commands: how many of them by stream or row.
    """

    run: str
    began: datetime | None = None
    workbook: str = ""
    digest: str = ""
    participant: str = ""
    condition: str = ""
    operator: str = ""
    mode: str = ""
    robot: str = ""
    engine: str = ""
    frame_rate: str = ""
    seed: str = ""
    program: str = ""
    language: str = "en"
    seconds: float = 0.0
    ended: str = "unreadable"
    ended_by: str = ""
    why: str = ""
    remedy: str = ""
    events: Mapping[str, int] = field(default_factory=dict)
    errors: Mapping[str, int] = field(default_factory=dict)
    commands: Mapping[str, int] = field(default_factory=dict)

    @property
    def readable(self) -> bool:
        """True when the record can be opened."""
        return self.ended != "unreadable"


def run_names(folder: Path) -> list[str]:
    """Return the names of the runs' folders beside the workbooks of a folder, from the last name to the first."""
    place = folder / RUNS
    try:
        with os.scandir(place) as found:
            names = [e.name for e in found if e.is_dir(follow_symlinks=False) and e.name[0] != "."]
    except OSError:
        return []
    return sorted(names, reverse=True)


def newest_first(runs: Iterable[RunMetadata]) -> list[RunMetadata]:
    """Sort runs by the time they began, whatever their folders are called; those without a known one come first."""
    return sorted(runs, key=lambda f: f.began.timestamp() if f.began else math.inf, reverse=True)


def facts_of(place: Path, going: Collection[str] = ()) -> RunMetadata:
    """Return the facts about a run; never raise: those of an unreadable record have the reason.

    Args:
        place: the run's folder.
        going: the names of the folders of runs that are known to go on.
    """
    run, trace = place.name, place / TRACE
    try:
        about = trace.stat()
        if not stat.S_ISREG(about.st_mode):  # a pipe would be waited for without an end
            raise IsADirectoryError(errno.EISDIR, N_("it is no file"))
        header, summary, seconds = read_ends(trace)
    except OSError as error:
        missing = isinstance(error, FileNotFoundError)
        cannot = N_("Its {file} cannot be read: {reason}.", file=TRACE, reason=error.strerror)
        why = N_("There is no {file} in it.", file=TRACE) if missing else cannot
        remedy = N_("The folder of a run holds everything that was recorded; copy it whole.")
        return RunMetadata(run, why=why, remedy=remedy)
    if header is None or not header.fields:
        if header is not None and run in going:
            return RunMetadata(run, ended="going")
        why = N_("Its {file} does not begin as a record of a run does.", file=TRACE)
        remedy = N_("Copy the folder again from where it comes; it was perhaps cut off.")
        return RunMetadata(run, why=why, remedy=remedy)
    if summary is not None:
        ended = summary.text("ended") or "cut"
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
        why=summary.text("why"), remedy=summary.text("remedy"), events=_counts(summary.fields.get("events")),
        errors=_counts(summary.fields.get("errors")), commands=_counts(summary.fields.get("actuator_commands")),
    )  # fmt: skip


def _when(value: Any) -> datetime | None:
    try:
        return datetime.fromisoformat(value).astimezone()
    except (TypeError, ValueError, OverflowError, OSError):
        return None


def _counts(value: Any) -> dict[str, int]:
    if not isinstance(value, dict):
        return {}
    return {text_of(k): v for k, v in value.items() if isinstance(v, int) and not isinstance(v, bool)}


def stamp_of(place: Path) -> Stamp:
    """Return the stamp of a run's folder; what its record does not say is blank. Never raise."""
    return stamp_of_facts(facts_of(place))


def stamp_of_facts(facts: RunMetadata) -> Stamp:
    """Return the stamp of a run whose facts are known already."""
    return Stamp(
        workbook=facts.workbook, digest=facts.digest, program=facts.program, mode=facts.mode, seed=facts.seed,
        participant=facts.participant, condition=facts.condition, operator=facts.operator,
        began=facts.began.isoformat(timespec="milliseconds") if facts.began else "",
        ended=facts.ended if facts.readable else "", run=facts.run, language=facts.language,
    )  # fmt: skip
