"""Settings, events and results of a run, and the commands that displays show: light to import and easy to send."""

from __future__ import annotations

import unicodedata
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rrp_sheets.diagnostics import Diagnostic
from rrp_sheets.engine.run_events import RunEvent
from rrp_sheets.errors import RunBroken
from rrp_sheets.model.values import Record, Value
from rrp_sheets.texts import N_

_TOLD = {"by": "ended_by", "stopped_by": "stopped_by", "why": "why", "remedy": "remedy"}  # by their names in a trace


@dataclass(frozen=True)
class RunSettings:
    """Options for running a workbook.

    Attributes:
        seconds: of the run's clock; None: the last scene time plus 5 s, 30 s without a Scene sheet.
        fast: as fast as the machine can, instead of in real time.
        out: the folder to leave everything in; None: `runs/<time>-<name>/` beside the workbook.
        seed: None takes the Protocol's.
        mode: `simulated`, or `pilot` for a rehearsal whose data never counts as a session.
        participant, condition, operator: of the session, as codes.
        film: whether to film the robot.
        camera: whether pictures of the robot's camera may be kept; the Protocol may say no as well.
        everything: whether behaviours that no row can switch on are loaded too, for somebody who can by hand.
        home: the folder whose `runs` keeps the run and the faces; None: that of the workbook.
    """

    seconds: float | None = None
    fast: bool = False
    out: Path | None = None
    seed: int | None = None
    mode: str = "simulated"
    participant: str = ""
    condition: str = ""
    operator: str = ""
    film: bool = True
    camera: bool = True
    everything: bool = False
    home: Path | None = None


def name_warning(participant: str) -> str:
    """Return a warning if a participant's code looks like a name, else an empty text.

    >>> [bool(name_warning(code)) for code in ("Anna Smith", "Anna", "花子", "P-07", "Anna 2", "anna", "A", "")]
    [True, True, True, False, False, False, False, False]
    """
    words = unicodedata.normalize("NFKC", participant).split()
    letters = bool(words) and all(word.strip(".").isalpha() for word in words)
    if not letters or (len(words) == 1 and (len(words[0]) == 1 or words[0][0].islower())):
        return ""
    return N_("“{code}” looks like a name. Recordings should have a code, such as P-07.", code=participant)


@dataclass(frozen=True)
class RunStart:
    """Description of a run, given to its view at the beginning.

    Attributes:
        until_us: when it ends by itself.
        findings: warnings about the workbook.
        streams: every stream's name as in the trace, by its id.
        actuators: the names of the actuator streams, by their ids.
        rows: the rows that run, by their place in the order.
        behaviours: those that are loaded, each with whether it is on.
        sensors: the streams that values can be sent into: name, device, and an example as a Send cell has it.
        buttons: the operator's: stream name and label.
        things: of the scene: name, the same in the workbook's language, kind (`ball`, `person`, `cup`, …), and where it
            is at the beginning (m), if it is.
        hfov, vfov: opening angles of the robot's camera, rad; 0 when it has none.
        resources: what each actuator stream (its id) needs of the robot.
    """

    title: str
    until_us: int
    folder: Path
    findings: tuple[Diagnostic, ...] = ()
    language: str = "en"
    streams: Mapping[str, str] = field(default_factory=dict)
    actuators: Mapping[str, str] = field(default_factory=dict)
    rows: Mapping[int, str] = field(default_factory=dict)
    behaviours: tuple[tuple[str, bool], ...] = ()
    sensors: tuple[tuple[str, str, str], ...] = ()
    buttons: tuple[tuple[str, str], ...] = ()
    things: tuple[tuple[str, str, str, tuple[float, float, float] | None], ...] = ()
    hfov: float = 0.0
    vfov: float = 0.0
    resources: Mapping[str, tuple[str, ...]] = field(default_factory=dict)


@dataclass
class Summary:
    """Counts, times and end of a run.

    Attributes:
        events: how many values each stream had, by its name in the trace.
        errors: how often each row's formula failed.
        commands: how many commands each actuator stream was given.
        simulated: seconds of the run's clock.
        wall: seconds that passed meanwhile.
        ended: `time` (its time was over), `stopped` (by the user), `end run` (by a row), `broken`.
        ended_by: the row that ended the run, or was being worked out when it broke off; empty where there is none.
        stopped_by: who stopped it, where that is known.
        why, remedy: of a run that broke off.
    """

    events: dict[str, int] = field(default_factory=dict)
    errors: dict[str, int] = field(default_factory=dict)
    commands: dict[str, int] = field(default_factory=dict)
    simulated: float = 0.0
    wall: float = 0.0
    ended: str = "time"
    ended_by: str = ""
    stopped_by: str = ""
    why: str = ""
    remedy: str = ""

    def as_dict(self, *, wall: bool) -> dict[str, Any]:
        """Return the summary as JSON; for the trace without the wall clock, on which its bytes must not depend."""
        told = {key: getattr(self, name) for key, name in _TOLD.items()}
        entry: dict[str, Any] = {
            "ended": self.ended, **{k: v for k, v in told.items() if v},
            "simulated_seconds": self.simulated, "events": self.events, "errors": self.errors,
            "actuator_commands": self.commands,
        }  # fmt: skip
        return {**entry, "wall_seconds": round(self.wall, 3)} if wall else entry

    @classmethod
    def from_dict(cls, entry: Mapping[str, Any]) -> Summary:
        """Return the summary that a trace has."""
        counts = (entry["events"], entry["errors"], entry["actuator_commands"], entry["simulated_seconds"])
        return cls(*counts, ended=entry["ended"], **{name: entry.get(key, "") for key, name in _TOLD.items()})


@dataclass(slots=True)
class StartEvent(RunEvent):
    """The beginning of a run."""

    method = "started"
    start: RunStart


@dataclass(slots=True)
class FinishingEvent(RunEvent):
    """The end of the rows: the robot is being brought to rest."""

    method = "finishing"


@dataclass(slots=True)
class RestedEvent(RunEvent):
    """The robot is at rest and all is recorded; table and diagram are still to be written."""

    method = "rested"
    summary: Summary
    broken: RunBroken | None


@dataclass(frozen=True)
class RunResult:
    """Folder, files and summary that a run left.

    Attributes:
        files: in the folder, with what each is.
        broken: what broke the run off; None when it ended by itself or by the user.
        problems: files that could not be made, in words.
    """

    folder: Path
    files: dict[str, str]
    summary: Summary
    broken: RunBroken | None = None
    problems: tuple[str, ...] = ()


QUIET_US = 2_000_000  # a row that keeps driving its actuator is told again only after such a pause
CHANGE_US = 1_000_000  # and changes of what it sends at most so often


class Commands:
    """The commands of a run so far, by the row that gave them."""

    def __init__(self) -> None:
        self._last: dict[str, int] = {}
        self._told: dict[str, tuple[int, Value]] = {}
        self._given: dict[str, Value] = {}  # what each actuator stream was sent last

    def tell(self, us: int, row: str, value: Value, stream: str = "") -> bool:
        """Return whether a command is worth showing: no mere repetition, and no blank for a stream that does nothing.

        >>> commands = Commands()
        >>> sent = ((0.0, 1.0), (0.1, 5.0), (1.1, 5.0), (1.2, 1.0), (4.0, 1.0))
        >>> [commands.tell(round(seconds * 1e6), "T!2", value) for seconds, value in sent]
        [True, False, True, False, True]
        """
        idle = value is None and self._given.get(stream) is None
        self._given[stream] = value
        if idle:
            return False
        last = self._last.get(row)
        self._last[row] = us
        told, shown = self._told.get(row, (0, None))
        if last is None or us - last > QUIET_US or (us - told >= CHANGE_US and differs(value, shown)):
            self._told[row] = (us, value)
            return True
        return False


def differs(value: Value, shown: Value) -> bool:
    """Return whether a value clearly differs from the one shown: a number by a quarter, anything else at all.

    >>> differs(1.0, 1.1), differs(1, 2), differs("red", "blue")
    (False, True, True)
    """
    if isinstance(value, Record):
        return not isinstance(shown, Record)
    if isinstance(value, float) and isinstance(shown, (int, float)):
        return abs(value - shown) > 0.25 * max(abs(value), abs(shown), 0.4)
    return bool(value != shown)
