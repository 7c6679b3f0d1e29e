"""Names of the files that a run leaves, events of its trace, and the stamp that its exports bear.

Each event is one class for a kind of line, which the engine writes and others read. A stamp tells the origin: which
workbook ran, by which program, in which session.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any, ClassVar

RUNS = "runs"
TRACE = "trace.jsonl"
WORKBOOK = "protocol.xlsx"  # the one that ran
TABLE = "run.xlsx"
DIAGRAM = "diagram.svg"
POSES = "poses.jsonl"
CAMERA = "camera.zip"
FILM = "film.gif"
STRIP = "strip.png"


def faces_file(folder: Path) -> Path:
    """Return the file that keeps remembered faces for the workbooks of a folder."""
    return folder.absolute() / RUNS / "faces.json"


ACTIONS = frozenset(("mark", "switch", "press", "scene", "speed", "edit", "pause", "resume", "step"))


@dataclass(slots=True)  # not frozen, which takes three times as long: a long run has a million of them
class _Event:
    """Event of a run."""

    what: ClassVar[str]
    us: int  # time on the run's clock, in µs
    stream: str  # its name in the trace; empty where there is none
    row: str  # the row that it comes from; empty for sensor streams
    number: int = field(default=-1, compare=False, kw_only=True)  # its place in the record; -1 outside of one

    @property
    def t(self) -> float:
        """Time on the run's clock, in seconds."""
        return self.us / 1_000_000


@dataclass(slots=True)
class RecordedValue(_Event):
    """Value on a stream, as JSON; `by` whoever sent it by hand, None for one that nobody sent."""

    what: ClassVar[str] = "event"
    value: Any
    by: str | None = None

    def entry(self) -> dict[str, Any]:
        """Return the event as a line of the trace has it."""
        entry = {"t": self.t, "stream": self.stream, "row": self.row, "value": self.value}
        return entry if self.by is None else {**entry, "stimulated": True, "by": self.by}


@dataclass(slots=True)
class RecordedFailure(_Event):
    """Failure of a row's formula: message, code of the diagnostic, and values of the inputs as JSON."""

    what: ClassVar[str] = "error"
    kind: ClassVar[str] = "error"
    text: str
    code: str
    inputs: list[Any]

    def entry(self) -> dict[str, Any]:
        """Return the event as a line of the trace has it."""
        return {"t": self.t, "row": self.row, "error": self.text, "code": self.code, "inputs": self.inputs}


@dataclass(slots=True)
class RecordedNotice(_Event):
    """Notice of the world or of the engine: speech, a clamped command, a note; `sound` is the file of what was said."""

    what: ClassVar[str] = "happening"
    kind: str
    text: str
    sound: str = ""

    def entry(self) -> dict[str, Any]:
        """Return the event as a line of the trace has it."""
        more = {"stream": self.stream, "row": self.row, "sound": self.sound}
        return {"t": self.t, "happening": self.kind, "text": self.text} | {n: text for n, text in more.items() if text}


@dataclass(slots=True)
class RecordedAction(_Event):
    """Action of an operator."""

    what: ClassVar[str] = "action"
    kind: str  # one of `ACTIONS`; a sent value is a `RecordedValue` instead
    text: str  # in words
    by: str
    # seconds of the wall clock since the beginning, by which films are aligned; the changes of one edit have the same
    wall: float
    detail: Mapping[str, Any] = field(default_factory=dict)  # all that is needed to do it again

    def entry(self) -> dict[str, Any]:
        """Return the event as a line of the trace has it."""
        entry = {"t": self.t, "happening": self.kind, "text": self.text, "by": self.by, "wall": self.wall}
        more = {"row": self.row, "detail": dict(self.detail)}
        return {**entry, **{name: part for name, part in more.items() if part}}


RecordedHappening = RecordedFailure | RecordedNotice | RecordedAction
RecordedEvent = RecordedValue | RecordedHappening

PROGRAM = "RRP Sheets"
SHORT = 12  # hexadecimal digits of a hash that is read by people
_NAMES = {
    "run": "Run", "workbook": "Workbook", "digest": "Workbook SHA-256", "program": "Program", "mode": "Mode",
    "seed": "Seed", "participant": "Participant", "condition": "Condition", "operator": "Operator", "began": "Began",
    "ended": "Ended",
}  # fmt: skip
ORPHANED = "the end of the program that had started it"
"""Name under which a record says that no person stopped the run, but the end of its program; it then is `killed`."""
_WHOLE = ("time", "stopped", "end run")
"""Ends of a run that are not failures."""


def kind_of_end(ended: str, stopped_by: str) -> str:
    """Return how a run ended by the summary of its record, in which a run that was `killed` is `stopped`."""
    return "killed" if ended == "stopped" and stopped_by == ORPHANED else ended


@dataclass(frozen=True, slots=True)
class Stamp:
    """Origin of an export; what is not known, or does not apply, is blank."""

    workbook: str = ""  # its file
    digest: str = ""  # SHA-256 of that file, in hexadecimal
    program: str = ""  # the program's version, `0.2.0`
    mode: str = ""  # `simulated`, `pilot`, `real`
    seed: str = ""
    participant: str = ""
    condition: str = ""
    operator: str = ""
    began: str = ""  # the wall clock at time 0 by ISO 8601, `2026-11-21T20:54:55.120+00:00`
    ended: str = (
        ""  # how the run ended, as its record says: `time`, `stopped`, `end run`, `killed`, `broken`, `cut`, `going`
    )
    run: str = ""  # the name of the run's folder; blank for an export of a workbook that has not run
    language: str = "en"  # of the words of a picture; it is no part of the stamp

    @staticmethod
    def names() -> list[str]:
        """Return the shown names of the fields, in the order of `values`."""
        return list(_NAMES.values())

    def values(self) -> list[str]:
        """The texts, in the order of `names`; the version has the program's name with it."""
        told = {f.name: str(getattr(self, f.name)) for f in fields(self)}
        told["program"] = told["program"] and f"{PROGRAM} {told['program']}"
        return [told[name] for name in _NAMES]

    @staticmethod
    def columns() -> list[str]:
        """The columns of a table that say where its rows come from, in the order of `row`."""
        return [*("workbook_sha256" if name == "digest" else name for name in _NAMES), "complete"]

    def row(self) -> dict[str, str | int | bool | None]:
        """The cells of those columns; what is not known is None.

        >>> told = Stamp("greeter.xlsx", seed="7", ended="broken").row()
        >>> told["seed"], told["ended"], told["complete"], told["operator"]
        (7, 'broken', False, None)
        """
        texts = dict(zip(self.columns(), self.values(), strict=False))
        found: dict[str, str | int | bool | None] = {name: text or None for name, text in texts.items()}
        if self.seed.isascii() and self.seed.isdigit():
            found["seed"] = int(self.seed)
        return found | {"complete": self.ended in _WHOLE if self.ended else None}

    def pairs(self) -> list[tuple[str, str]]:
        """Names and texts of what is known: for properties of a file, and for a page about the run.

        >>> Stamp("greeter.xlsx", seed="7").pairs()
        [('Workbook', 'greeter.xlsx'), ('Seed', '7')]
        """
        return [(name, text) for name, text in zip(self.names(), self.values(), strict=True) if text]

    def line(self) -> str:
        """One line for the foot of a page or picture.

        >>> Stamp("greeter.xlsx", "37c20efdee336143", "0.2.0", "pilot", "7", "P07", began="2026-11-21 20:54:55").line()
        'greeter.xlsx · 37c20efdee33 · RRP Sheets 0.2.0 · pilot: never data · seed 7 · P07 · began 2026-11-21 20:54:55'
        """
        mode = "pilot: never data" if self.mode == "pilot" else self.mode
        parts = (
            self.workbook, self.digest[:SHORT], self.program and f"{PROGRAM} {self.program}", mode,
            self.seed and f"seed {self.seed}", self.participant, self.condition,
            self.operator and f"operator {self.operator}", self.began and f"began {self.began}",
        )  # fmt: skip
        return " · ".join(filter(None, parts))
