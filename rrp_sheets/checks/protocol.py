"""Reads the Protocol sheet's settings of a run: behaviours, frame rate, seed, time limit, engine, memory, language."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from rrp_sheets.diagnostics import Report
from rrp_sheets.diagnostics.phrase import Phrase
from rrp_sheets.model.durations import meant_duration, parse_duration
from rrp_sheets.model.languages import language_code
from rrp_sheets.model.names import key, nearest
from rrp_sheets.model.workbook import Protocol, Workbook

ENGINES = ("frame", "event loop")
FORGETS, KEEPS = "ends with the run", "kept"
"""What Face memory may say."""
NOT_KEPT = "not kept"
"""What Camera pictures may say besides `kept`."""
PHYSICS_RATE = 240  # Hz; frames are whole steps of the physics


@dataclass(frozen=True)
class RunPlan:
    """The settings of a run, as the Protocol sheet gives them.

    Attributes:
        behaviours: keys of the behaviours that run.
        frame_rate: frames a second.
        seed: of everything random.
        time_limit_us: when the run ends by itself; None for no limit.
        engine: `frame` or `event loop`.
        keeps_faces: whether remembered faces are kept beyond the run.
        language: the code of the one that explanations, diagrams and the printed protocol are in.
        keeps_pictures: whether pictures of the robot's camera may be kept with the record of a run.
    """

    behaviours: frozenset[str]
    frame_rate: int = 30
    seed: int = 0
    time_limit_us: int | None = None
    engine: str = "frame"
    keeps_faces: bool = False
    language: str = "en"
    keeps_pictures: bool = True


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
    engine = _meant(protocol, "Engine", "PROT002", lambda t: _one_of(ENGINES, t), report) or "frame"
    if text := protocol.text("Seed"):
        if re.fullmatch(r"\d{1,15}", text):
            seed = int(text)
        else:
            report.add("PROT005", protocol.fields["seed"].address, text=text)
    if text := protocol.text("Time limit"):
        limit = parse_duration(text, bare="s")
        if not limit:
            meant = meant_duration(text, "s") or "10 min or 90 s"
            report.add("PROT006", protocol.fields["timelimit"].address, text=text, meant=meant)
    memory = _meant(protocol, "Face memory", "PROT007", lambda t: _one_of((FORGETS, KEEPS), t), report)
    pictures = _meant(protocol, "Camera pictures", "PROT009", lambda t: _one_of((KEEPS, NOT_KEPT), t), report)
    language = _meant(protocol, "Language", "PROT008", language_code, report) or "en"
    behaviours = _behaviours(workbook, report)
    return RunPlan(
        behaviours, rate, seed, limit or None, engine, memory == KEEPS, language, keeps_pictures=pictures != NOT_KEPT
    )


def _meant(protocol: Protocol, field: str, code: str, meaning: Callable[[str], str], report: Report) -> str:
    """Return the meaning of a field that allows only a few texts; empty when it is blank, or wrong and reported."""
    text = protocol.text(field)
    found = meaning(text) if text else ""
    if text and not found:
        report.add(code, protocol.fields[key(field)].address, text=text, name=text)
    return found


def _one_of(words: Sequence[str], text: str) -> str:
    return next((word for word in words if key(word) == key(text)), "")


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
            remedy = (
                Phrase("Did you mean {guess}?", guess=guess)
                if guess
                else Phrase("The behaviours are: {names}.", names=", ".join(known.values()))
            )
            report.add("PROT004", workbook.protocol.fields["run"].address, name=name, remedy=remedy)
    return frozenset(chosen)
