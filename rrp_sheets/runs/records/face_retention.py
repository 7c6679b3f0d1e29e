"""Whose face the robot remembers: what the records say of the faces that are kept beyond a run.

A kept face has a name and numbers, and nothing says whose it is. A record says when a face was remembered under a name,
and in whose session. A name can be used again after it was wiped, so the newest session that remembered it has it.
"""

from __future__ import annotations

import json
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rrp_sheets.model.names import key
from rrp_sheets.runs.records.metadata import TRACE, RunMetadata, text_of

_REMEMBERED = re.compile(r"The face is remembered as (.+)\.", re.DOTALL)
_NOTED, _KNOWN = b"The face is remembered as ", b'"recognised":true'


@dataclass(frozen=True)
class FaceFate:
    """What becomes of a kept face; `why` in words."""

    name: str
    goes: bool
    why: str


def plan_faces(
    kept: Sequence[str],
    runs: Mapping[str, RunMetadata],
    places: Collection[Path],
    gone: Collection[str],
    participant: str,
) -> list[FaceFate]:
    """What becomes of the kept faces when some runs are deleted.

    Args:
        kept: the names in the file of faces.
        runs: all runs, by the name of their folder.
        places: the folders of all runs.
        gone: the names of those that are deleted.
        participant: whose runs they are; blank when they were chosen one by one.
    """
    newest: dict[str, str] = {}  # the run that has a name, by the name's key
    seen: set[str] = set()
    for place in sorted(places, key=lambda p: _began(runs.get(p.name))):
        for name, new in _faces(place):
            if new:
                newest[key(name)] = place.name
            elif place.name in gone:
                seen.add(key(name))
    return [_fate(name, newest.get(key(name), ""), runs, gone, participant, key(name) in seen) for name in kept]


def _began(facts: RunMetadata | None) -> float:
    return facts.began.timestamp() if facts is not None and facts.began is not None else 0.0


def _fate(
    name: str, run: str, runs: Mapping[str, RunMetadata], gone: Collection[str], participant: str, recognised: bool
) -> FaceFate:
    if participant and key(name) == key(participant):
        return FaceFate(name, True, "it has that code as its name")
    if run in gone:
        return FaceFate(name, True, f"it was remembered in the run {run}")
    also = " It was recognised in a run that is deleted." if recognised else ""
    if run:
        whose = runs[run].participant if run in runs else ""
        return FaceFate(name, False, f"it was remembered in the run {run}{f' of {whose}' if whose else ''}.{also}")
    return FaceFate(name, False, f"no run here says whose it is.{also}")


def _faces(place: Path) -> Iterator[tuple[str, bool]]:
    """The names of faces that a run remembered (True) or recognised (False)."""
    devices: dict[str, str] = {}
    kept = True
    try:
        with (place / TRACE).open("rb") as file:
            for number, line in enumerate(file):
                if number == 0 or _NOTED in line or _KNOWN in line:
                    entry = json.loads(line)
                    if number == 0:
                        kept = entry.get("faces") != "forgotten"
                        devices = {text_of(s["stream"]): text_of(s["device"]) for s in entry["streams"]}
                        continue
                    yield from _told(entry, devices, kept)
    except (OSError, ValueError, TypeError, KeyError, AttributeError, RecursionError):
        return  # a damaged record says nothing


def _told(entry: Mapping[str, Any], devices: Mapping[str, str], kept: bool) -> Iterator[tuple[str, bool]]:
    device = devices.get(text_of(entry.get("stream")))
    found = _REMEMBERED.fullmatch(text_of(entry.get("text")))
    if found and kept and device == "RememberFace":
        yield found[1], True
    value = entry.get("value")
    if isinstance(value, dict) and device == "FaceDetection" and value.get("recognised") and value.get("name"):
        yield text_of(value["name"]), False
