"""What the Protocol sheet says about running (which behaviours, frame rate, seed, time limit) and its language."""

from __future__ import annotations

import re
from dataclasses import dataclass

from rrp_sheets.diagnostics import Report
from rrp_sheets.model.durations import meant_duration, parse_duration
from rrp_sheets.model.languages import language_code
from rrp_sheets.model.names import key, nearest
from rrp_sheets.model.workbook import Workbook

ENGINES = ("frame", "event loop")
FORGETS, KEEPS = "ends with the run", "kept"
"""What Face memory may say."""
PHYSICS_RATE = 240  # Hz; frames are whole steps of the physics


@dataclass(frozen=True)
class RunPlan:
    """How a workbook wants to be run.

    Attributes:
        behaviours: keys of the behaviours that run.
        frame_rate: frames a second.
        seed: of everything random.
        time_limit_us: when the run ends by itself; None for no limit.
        engine: `frame` or `event loop`.
        keeps_faces: whether remembered faces are kept beyond the run.
        language: the code of the one that explanations, diagrams and the printed protocol are in.
    """

    behaviours: frozenset[str]
    frame_rate: int = 30
    seed: int = 0
    time_limit_us: int | None = None
    engine: str = "frame"
    keeps_faces: bool = False
    language: str = "en"


def check_protocol(workbook: Workbook, report: Report) -> RunPlan:
    """The run's plan; what cannot be understood is reported and replaced by the default."""
    protocol = workbook.protocol
    rate, seed, limit = 30, 0, None
    if text := protocol.text("Frame rate"):
        digits = re.fullmatch(r"(\d{1,3})(?:\.0)?(\s*(hz|fps|/s))?", text.casefold())
        if digits and int(digits[1]) and PHYSICS_RATE % int(digits[1]) == 0:
            rate = int(digits[1])
        else:
            report.add("PROT003", protocol.fields["framerate"].address, text=text)
    engine = "frame"
    if text := protocol.text("Engine"):
        engine = next((e for e in ENGINES if key(e) == key(text)), "")
        if not engine:
            report.add("PROT002", protocol.fields["engine"].address, name=text)
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
    memory = FORGETS
    if text := protocol.text("Face memory"):
        memory = next((m for m in (FORGETS, KEEPS) if key(m) == key(text)), "")
        if not memory:
            report.add("PROT007", protocol.fields["facememory"].address, text=text)
    language = "en"
    if text := protocol.text("Language"):
        language = language_code(text)
        if not language:
            report.add("PROT008", protocol.fields["language"].address, text=text)
    return RunPlan(
        _behaviours(workbook, report), rate, seed, limit or None, engine or "frame", memory == KEEPS, language or "en"
    )


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
            remedy = f"Did you mean {guess}?" if guess else f"The behaviours are: {', '.join(known.values())}."
            report.add("PROT004", workbook.protocol.fields["run"].address, name=name, remedy=remedy)
    return frozenset(chosen)
