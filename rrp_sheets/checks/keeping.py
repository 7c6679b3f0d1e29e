"""Compare the data that a run keeps with the Protocol sheet's field Data kept."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Any

from rrp_sheets.checks.protocol import RunPlan
from rrp_sheets.devices import DeviceType, Robot
from rrp_sheets.diagnostics import Report
from rrp_sheets.diagnostics.phrase import Phrase, listed
from rrp_sheets.graph import Graph, StreamKind
from rrp_sheets.model.names import key
from rrp_sheets.model.workbook import Workbook

FIELD = "Data kept"
_NAMES = {
    "events": "every value with its time", "words": "the words that it hears",
    "camera": "pictures of the robot's camera", "film": "a film of the robot",
    "speech": "the sound of what the robot says", "faces": "what remembered faces look like",
}  # fmt: skip
# How people name each kind: beginnings of English words, and Japanese words.
_ENGLISH = {
    "events": "value|event|trace|record|log|time|press|touch|step|word|sentence|answer|exercise|data|measure|which",
    "words": "word|hear|recogni|speech|utter|answer|transcript|sentence",
    "camera": "picture|image|photo|camera|video|footage", "film": "film|video|movie|animation|footage",
    "speech": "sound|audio|speech|spoken|sentence|say|said|voice|utter", "faces": "face|biometric",
}  # fmt: skip
_JAPANESE = {
    "events": "値|時刻|記録|出来事|データ", "words": "言葉|ことば|単語|認識|聞", "camera": "画像|写真|映像|カメラ",
    "film": "動画|映像|フィルム|ビデオ", "speech": "音|発話|話|声|文", "faces": "顔",
}  # fmt: skip
_NAMED = {kind: re.compile(rf"\b(?:{_ENGLISH[kind]})|{_JAPANESE[kind]}") for kind in _NAMES}
_CLAUSE = re.compile(r"[;,.:、。；，：\n]|\b(?:but|and(?= no\b))")
_NOT = re.compile(r"\b(?:no|not|none|nothing|never|neither|nor|without)\b|n't\b|ない|ません|なし|せず|残さず")


def channel(robot: Robot, device: DeviceType | None) -> str:
    """Return the source of a sensor's values: `camera`, `touch`, `microphone`, `operator`, `clock`, …, `other`."""
    entry: Mapping[str, Any] = next(
        (s for s in robot.data["sensor"] if device is not None and s["name"] == device.name), {}
    )
    known = {"press": "operator", "touch": "touch", "say": "microphone"}
    shows = [known[s.split()[0]] for s in entry.get("shows", ()) if s.split()[0] in known]
    return str(entry.get("perception") or (shows[0] if shows else "clock" if entry.get("engine") else "other"))


def kept_kinds(robot: Robot, graph: Graph, run: RunPlan) -> list[str]:
    """List the kinds of data that a run stores: `events`, `words`, `camera`, `film`, `speech`, `faces`."""
    steps = [s for b in graph.behaviours for s in b.steps if s.active]
    streams = [graph.streams[i] for i in dict.fromkeys(i for s in steps for i in s.inputs)]
    sensors = [s for s in streams if s.kind is StreamKind.SENSOR and s.device is not None]
    channels = {channel(robot, s.device.type) for s in sensors if s.device}
    used = {
        resource
        for s in steps
        if s.connector.is_sink and (device := graph.streams[s.output].device) is not None
        for resource in device.type.resources
    }
    sees_faces = any("person" in s.device.type.shows for s in sensors if s.device)
    holds = {
        "events": True, "words": "microphone" in channels, "camera": "camera" in channels and run.keeps_pictures,
        "film": True, "speech": "voice" in used, "faces": run.keeps_faces and (sees_faces or "memory" in used),
    }  # fmt: skip
    return [kind for kind in _NAMES if holds[kind]]


def names_of(kinds: Iterable[str]) -> str:
    """Return the kinds of data as a list in words, in the reader's language."""
    return listed([Phrase(_NAMES[kind]) for kind in kinds], "and")


def unnamed(text: str, kinds: Iterable[str]) -> list[str]:
    """Return the kinds of data that a text does not mention, or mentions only to deny them.

    A text without any known word may be in another language; it counts as complete.

    >>> unnamed("Every value; no sound of a person, no pictures", ["events", "camera"])
    ['camera']
    >>> unnamed("Alles", ["events"])
    []
    """
    clauses = [clause for clause in _CLAUSE.split(text.casefold()) if clause.strip()]
    stated = [clause for clause in clauses if not _NOT.search(clause)]
    understood = len(stated) < len(clauses) or any(named.search(text.casefold()) for named in _NAMED.values())
    return [k for k in kinds if understood and not any(_NAMED[k].search(clause) for clause in stated)]


def check_kept(workbook: Workbook, robot: Robot, graph: Graph, run: RunPlan, report: Report) -> None:
    """Report a field Data kept that names less than what a run keeps."""
    text = workbook.protocol.text(FIELD)
    kinds = kept_kinds(robot, graph, run)
    missing = unnamed(text, kinds) if text else []
    if missing:
        address = workbook.protocol.fields[key(FIELD)].address
        report.add("PROT010", address, what=names_of(missing), example=names_of(kinds))
