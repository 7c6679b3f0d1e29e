"""Reads the Protocol sheet's settings of a run, and compares its field Data kept with what a run keeps."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from rrp_sheets.diagnostics import Report
from rrp_sheets.diagnostics.report import meant
from rrp_sheets.graph import Graph, StreamKind
from rrp_sheets.model.durations import meant_duration, parse_duration
from rrp_sheets.model.names import key, nearest
from rrp_sheets.model.workbook import Protocol, Workbook
from rrp_sheets.robots import DeviceType, Robot
from rrp_sheets.texts import N_, language_code, listed
from rrp_sheets.workbook.schema import FIELDS

FACES_KEPT = FIELDS["facememory"].words[1]
NO_PICTURES = FIELDS["camerapictures"].words[1]
PHYSICS_RATE = 240  # Hz; frames are whole steps of the physics
FIELD = "Data kept"
_NAMES = {
    "events": N_("every value with its time"), "words": N_("the words that the robot hears"),
    "camera": N_("pictures of the robot's camera"), "film": N_("a film of the robot"),
    "speech": N_("the sound of what the robot says"), "faces": N_("the features of remembered faces"),
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


@dataclass(frozen=True)
class RunPlan:
    """The settings of a run, as the Protocol sheet gives them."""

    behaviours: frozenset[str]  # keys of the behaviours that run
    frame_rate: int = 30  # frames a second
    seed: int = 0
    time_limit_us: int | None = None
    engine: str = "frame"  # `frame` or `event loop`
    keeps_faces: bool = False  # whether remembered faces are kept beyond the run
    language: str = "en"  # the code of the one that explanations, diagrams and the printed protocol are in
    keeps_pictures: bool = True  # whether pictures of the robot's camera may be kept with the record of a run


def check_protocol(workbook: Workbook, report: Report) -> RunPlan:
    """Return the run's plan; what cannot be understood is reported and replaced by the default."""
    protocol = workbook.protocol
    rate, seed, limit = 30, 0, None
    if text := protocol.text("Frame rate"):
        digits = re.fullmatch(r"(\d{1,3})(?:\.0)?(\s*(hz|fps|/s))?", text.casefold())
        if digits and int(digits[1]) and PHYSICS_RATE % int(digits[1]) == 0:
            rate = int(digits[1])
        else:
            report.add("PROT003", protocol.fields["framerate"].address, text=text)
    engine = _meant(protocol, "Engine", "PROT002", FIELDS["engine"].meaning, report) or "frame"
    if text := protocol.text("Seed"):
        if re.fullmatch(r"\d{1,15}", text):
            seed = int(text)
        else:
            report.add("PROT005", protocol.fields["seed"].address, text=text)
    if text := protocol.text("Time limit"):
        limit = parse_duration(text, bare="s")
        if not limit:
            likely = meant_duration(text, "s") or N_("10 min or 90 s")
            report.add("PROT006", protocol.fields["timelimit"].address, text=text, meant=likely)
    memory = _meant(protocol, "Face memory", "PROT007", FIELDS["facememory"].meaning, report)
    pictures = _meant(protocol, "Camera pictures", "PROT009", FIELDS["camerapictures"].meaning, report)
    _meant(protocol, "Robot in sessions", "PROT011", FIELDS["robotinsessions"].meaning, report)
    language = _meant(protocol, "Language", "PROT008", language_code, report) or "en"
    return RunPlan(
        _behaviours(workbook, report), rate, seed, limit or None, engine, language=language,
        keeps_faces=memory == FACES_KEPT, keeps_pictures=pictures != NO_PICTURES,
    )  # fmt: skip


def _meant(protocol: Protocol, field: str, code: str, meaning: Callable[[str], str], report: Report) -> str:
    """Return the meaning of a field that allows only a few texts; empty when it is blank, or wrong and reported."""
    text = protocol.text(field)
    found = meaning(text) if text else ""
    if text and not found:
        report.add(code, protocol.fields[key(field)].address, text=text, name=text)
    return found


def _behaviours(workbook: Workbook, report: Report) -> frozenset[str]:
    known = {key(b.name): b.name for b in workbook.behaviours}
    text = workbook.protocol.text("Run")
    if not text or key(text) == "all":
        return frozenset(known)
    chosen = set()
    for name in (part.strip() for part in re.split(r"[,;\n]", text)):
        if key(name) in known:
            chosen.add(key(name))
        elif name and known:  # without any behaviour that is what is told
            guess = nearest(name, known.values())
            every = N_("The behaviours are: {names}.", names=", ".join(known.values()))
            report.add("PROT004", workbook.protocol.fields["run"].address, name=name, **meant(guess, every))
    return frozenset(chosen)


def channel(robot: Robot, device: DeviceType | None) -> str:
    """Return the source of a sensor's values: `camera`, `touch`, `microphone`, `operator`, `clock`, …, `other`."""
    name = device.name if device else None
    entry: Mapping[str, Any] = next((s for s in robot.data["sensor"] if s["name"] == name), {})
    known = {"press": "operator", "touch": "touch", "say": "microphone"}
    shows = [known[s.split()[0]] for s in entry.get("shows", ()) if s.split()[0] in known]
    return str(entry.get("perception") or (shows[0] if shows else "clock" if entry.get("engine") else "other"))


def kept_kinds(robot: Robot, graph: Graph, run: RunPlan) -> list[str]:
    """List the kinds of data that a run stores: `events`, `words`, `camera`, `film`, `speech`, `faces`."""
    steps = [s for b in graph.behaviours for s in b.steps if s.active]
    streams = [graph.streams[i] for i in dict.fromkeys(i for s in steps for i in s.inputs)]
    sensors = [s for s in streams if s.kind is StreamKind.SENSOR and s.device is not None]
    channels = {channel(robot, s.device.type) for s in sensors if s.device}
    driven = (graph.streams[s.output].device for s in steps if s.connector.is_sink)
    used = {resource for device in driven if device for resource in device.type.resources}
    sees_faces = any("person" in s.device.type.shows for s in sensors if s.device)
    holds = {
        "events": True, "words": "microphone" in channels, "camera": "camera" in channels and run.keeps_pictures,
        "film": True, "speech": "voice" in used, "faces": run.keeps_faces and (sees_faces or "memory" in used),
    }  # fmt: skip
    return [kind for kind in _NAMES if holds[kind]]


def names_of(kinds: Iterable[str]) -> str:
    """Return the kinds of data as a list in words, in the reader's language."""
    return listed([N_(_NAMES[kind]) for kind in kinds], "and")


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
