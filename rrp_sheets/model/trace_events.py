"""Events of a run as its trace has them: one class for each kind of line, which the engine writes and others read."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

ACTIONS = frozenset(("mark", "switch", "press", "scene", "speed", "edit", "pause", "resume", "step"))
FACE_REMEMBERED = "The face is remembered as "
"""Beginning of a notice; the name and a full stop follow. Who deletes a participant's faces looks for it."""


@dataclass(slots=True)  # not frozen, which takes three times as long: a long run has a million of them
class _Event:
    """Event of a run.

    Attributes:
        us: time on the run's clock, in µs.
        stream: its name in the trace; empty where there is none.
        row: the row that it comes from; empty for sensor streams.
        number: its place in the record; -1 outside of one.
    """

    what: ClassVar[str]
    us: int
    stream: str
    row: str
    number: int = field(default=-1, compare=False, kw_only=True)

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
        entry = {"t": self.t, "happening": self.kind, "text": self.text}
        return {**entry, **{name: text for name, text in more.items() if text}}


@dataclass(slots=True)
class RecordedAction(_Event):
    """Action of an operator.

    Attributes:
        kind: one of `ACTIONS`; `send` of a value that a trace has as a `RecordedValue`.
        text: in words.
        by: who.
        wall: seconds of the wall clock since the beginning, by which films are aligned; the changes of one edit have
            the same.
        detail: all that is needed to do it again.
    """

    what: ClassVar[str] = "action"
    kind: str
    text: str
    by: str
    wall: float
    detail: Mapping[str, Any] = field(default_factory=dict)

    def entry(self) -> dict[str, Any]:
        """Return the event as a line of the trace has it."""
        entry = {"t": self.t, "happening": self.kind, "text": self.text, "by": self.by, "wall": self.wall}
        more = {"row": self.row, "detail": dict(self.detail)}
        return {**entry, **{name: part for name, part in more.items() if part}}


RecordedHappening = RecordedFailure | RecordedNotice | RecordedAction
RecordedEvent = RecordedValue | RecordedHappening
