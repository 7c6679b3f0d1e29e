"""Results of tests: events, failed formulas, the result of each row and each test sheet, and times in frames."""

from __future__ import annotations

from dataclasses import dataclass, field

from rrp_sheets.checks.tests import Case, CaseRow
from rrp_sheets.model.values import Value


@dataclass(frozen=True, slots=True)
class Event:
    """A value on a stream (its id), with the row that gave it; empty for what was sent."""

    us: int
    stream: str
    row: str
    value: Value


@dataclass(frozen=True, slots=True)
class Fault:
    """A formula that failed in a row (its ref, `Tracking!4`), or an actuator that could not use its value."""

    us: int
    row: str
    message: str


@dataclass(frozen=True)
class RowResult:
    """Result of one expecting row of a test: whether what it expects came.

    Attributes:
        row: of the test sheet.
        passed: whether it holds.
        event: what came, when it was expected and came; for `nothing`, what came all the same.
        got: in words what came instead; empty when it passed.
        hints: what else may explain it, in words.
    """

    row: CaseRow
    passed: bool
    event: Event | None = None
    got: str = ""
    hints: tuple[str, ...] = ()


@dataclass(frozen=True)
class CaseResult:
    """A test sheet that was run.

    Attributes:
        case: the test.
        rows: a result for every row that expects, in the order of the sheet.
        events: everything that came on any stream, in order.
        faults: formulas that failed.
        ended_us: where the test's clock stood at the end.
        seconds: that it took.
        broken: rows that could not send what they should, by row number, in words.
    """

    case: Case
    rows: tuple[RowResult, ...]
    events: tuple[Event, ...] = ()
    faults: tuple[Fault, ...] = ()
    ended_us: int = 0
    seconds: float = 0.0
    broken: dict[int, str] = field(default_factory=dict)

    @property
    def passed(self) -> bool:
        """True when every row holds."""
        return not self.broken and all(r.passed for r in self.rows)

    @property
    def idle(self) -> bool:
        """True when nothing was expected, so that nothing can hold or fail."""
        return not self.rows and not self.broken

    @property
    def failed_rows(self) -> list[RowResult]:
        """The rows that do not hold."""
        return [r for r in self.rows if not r.passed]


TOLERANCE = 1
"""Frames by which something may come earlier or later than a row says."""


@dataclass(frozen=True)
class Frames:
    """The frames of a run at a rate (frames a second).

    >>> frames = Frames(30)
    >>> frames.at(100_000), frames.at(100_001), frames.time(3)
    (3, 4, 100000)
    """

    rate: int

    def at(self, us: int) -> int:
        """The first frame at or after a time."""
        return -(-us * self.rate // 1_000_000)

    def time(self, frame: int) -> int:
        """Return the time of a frame, in microseconds."""
        return frame * 1_000_000 // self.rate
