"""Metadata of a run, from the first and the last line of its trace: a long run costs what a short one does.

A run's folder is untrusted and may be half written: what can be read is used, and the metadata names what is wrong.
"""

from __future__ import annotations

import errno
import json
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
from rrp_sheets.model.languages import known_language
from rrp_sheets.model.stamp import Stamp

__all__ = ["Stamp", "stamp_of", "stamp_of_facts"]


RUNS = "runs"
TRACE = "trace.jsonl"
STILL_WRITTEN = 15.0  # s: a trace without an end that was written so recently belongs to a run that goes on
_LONGEST_LINE = 1 << 20  # bytes of a header or a summary
_USUAL_LINE = 1 << 14
_LONGEST_TEXT = 300


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
            raise IsADirectoryError(errno.EISDIR, "it is no file")
        first, last = _ends(trace)
    except OSError as error:
        missing = isinstance(error, FileNotFoundError)
        why = f"There is no {TRACE} in it." if missing else f"Its {TRACE} cannot be read: {error.strerror}."
        return RunMetadata(
            run, why=why, remedy="The folder of a run holds everything that was recorded; copy it whole."
        )
    header = entry_of(first)
    if header is None or header.get("type") != "header":
        if not first and run in going:
            return RunMetadata(run, ended="going")
        why = f"Its {TRACE} does not begin as a record of a run does."
        return RunMetadata(run, why=why, remedy="Copy the folder again from where it comes; it was perhaps cut off.")
    summary = entry_of(last) or {}
    closed = summary.get("type") == "summary"
    if closed:
        ended = text_of(summary.get("ended")) or "cut"
    else:
        fresh = 0 <= time.time() - about.st_mtime < STILL_WRITTEN
        ended = "going" if run in going or fresh or is_locked(trace) else "cut"
    return RunMetadata(
        run=run, began=_when(header.get("began")), workbook=text_of(header.get("name")),
        digest=text_of(header.get("workbook")), participant=text_of(header.get("participant")),
        condition=text_of(header.get("condition")), operator=text_of(header.get("operator")),
        mode=text_of(header.get("mode")), robot=text_of(header.get("robot")), engine=text_of(header.get("engine")),
        frame_rate=text_of(header.get("frame_rate")), seed=text_of(header.get("seed")),
        program=text_of(header.get("program")), language=known_language(header.get("language")),
        seconds=_seconds(summary.get("simulated_seconds", summary.get("t"))),
        ended=ended, ended_by=text_of(summary.get("stopped_by") or summary.get("by")), why=text_of(summary.get("why")),
        remedy=text_of(summary.get("remedy")), events=_counts(summary.get("events")),
        errors=_counts(summary.get("errors")), commands=_counts(summary.get("actuator_commands")),
    )  # fmt: skip


def _ends(trace: Path) -> tuple[bytes, bytes]:
    """Return the first line and the last whole one."""
    with trace.open("rb") as file:
        first = file.readline(_LONGEST_LINE)
        size = file.seek(0, os.SEEK_END)
        whole: list[bytes] = []
        for most in (_USUAL_LINE, _LONGEST_LINE):
            file.seek(max(0, size - most))
            *whole, _ = file.read(most).split(b"\n")
            if len(whole) > 1:
                break
    return first if first.endswith(b"\n") else b"", whole[-1] if whole else b""


def entry_of(line: bytes) -> dict[str, Any] | None:
    """Return the entry on a line of a trace; None when it is none.

    >>> entry_of(b'{"t": 1.5}'), entry_of(b'{"t": 1.'), entry_of(b"[1]")
    ({'t': 1.5}, None, None)
    """
    try:
        found = json.loads(line)
    except (ValueError, RecursionError):
        return None
    return found if isinstance(found, dict) else None


def text_of(value: Any) -> str:
    """Return a value of a record as a short text; blank for none, and for what is no plain value.

    >>> text_of("P-07"), text_of(7), text_of(None), text_of([1])
    ('P-07', '7', '', '')
    """
    if isinstance(value, str):
        return value.encode("utf-8", "replace").decode()[:_LONGEST_TEXT]
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return f"{value:g}" if isinstance(value, float) else str(value)[:_LONGEST_TEXT]
    return ""


def _when(value: Any) -> datetime | None:
    try:
        return datetime.fromisoformat(value).astimezone()
    except (TypeError, ValueError, OverflowError, OSError):
        return None


def _seconds(value: Any) -> float:
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    return float(value) if number and 0 <= value < 1e9 else 0.0


def _counts(value: Any) -> dict[str, int]:
    if not isinstance(value, dict):
        return {}
    return {str(k)[:_LONGEST_TEXT]: v for k, v in value.items() if isinstance(v, int) and not isinstance(v, bool)}


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
