"""The tests beside the sheet: which of them hold, and what the first that does not is missing."""

from __future__ import annotations

from dataclasses import dataclass

from rrp_sheets.documents import Document
from rrp_sheets.testing.judge import seconds
from rrp_sheets.web.testing.results import FAILS, HOLDS, IDLE, LATE, WAITS, Missed, Results, RoomTests, Tested, counted

MOST_MISSED = 3  # rows of a test that are told beside the sheet
_SIGNS = {HOLDS: "✓", FAILS: "✗", IDLE: "–", WAITS: "!", LATE: "…"}
_WORDS = {
    HOLDS: "holds", FAILS: "does not hold", IDLE: "expects nothing", WAITS: "waits for errors to be mended",
    LATE: "was not reached in time",
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class TestLine:
    """A test in the list: its state, the sign and the words for that; `here` when its sheet is shown."""

    __test__ = False  # no test of pytest's

    sheet: str
    state: str
    sign: str
    words: str
    here: bool


@dataclass(frozen=True, slots=True)
class MissedLine:
    """A row that does not hold; `at` is its time, in words as `got` tells times, `hints` explain it."""

    row: int
    at: str
    stream: str
    expected: str
    got: str
    notes: str
    hints: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class TestsPanel:
    """The tests of a workbook beside the sheet.

    Attributes:
        count: how many hold, in words.
        done: whether all hold.
        lines: a line for each test.
        first: the name of the test whose rows are told; empty for none.
        missed: those of its rows that do not hold; `left_out` are more than are told.
        unsent: what could not be sent, in words.
        notes: what is to be known besides, in words.
        running: they are being run.
    """

    __test__ = False  # no test of pytest's

    count: str
    done: bool
    lines: tuple[TestLine, ...]
    first: str
    missed: tuple[MissedLine, ...]
    left_out: int
    unsent: tuple[str, ...]
    notes: tuple[str, ...]
    running: bool


def panel_of(tests: RoomTests, document: Document, sheet: str) -> TestsPanel | None:
    """What is shown of a workbook's tests beside a sheet; None of a workbook without tests."""
    names = tests.sheets
    if not names:
        return None
    results = tests.results
    lines = tuple(_line(t, sheet) for t in results.tests)
    first = _first(results, sheet)
    missed = first.missed[:MOST_MISSED] if first is not None else ()
    more = len(first.missed) - len(missed) + first.left_out if first is not None else 0
    return TestsPanel(
        count=counted(results) if results.tests else "", done=bool(lines) and results.holding == len(lines),
        lines=lines, first=first.sheet if first is not None else "", missed=tuple(map(_missed, missed)), left_out=more,
        unsent=first.unsent[:MOST_MISSED] if first is not None else (), notes=tuple(_notes(results)),
        running=results.running or not (results.tests or results.why),
    )  # fmt: skip


def _line(test: Tested, sheet: str) -> TestLine:
    return TestLine(test.sheet, test.state, _SIGNS[test.state], _WORDS[test.state], test.sheet == sheet)


def _first(results: Results, sheet: str) -> Tested | None:
    """The test whose rows are told: that of the sheet, or the first that does not hold."""
    here = results.of(sheet)
    if here is not None:
        return here if here.state == FAILS else None
    return next((t for t in results.tests if t.state == FAILS), None)


def _missed(row: Missed) -> MissedLine:
    time = seconds(round(row.ms * 1000))
    when = f"up to {time}" if row.expected.strip().casefold() == "nothing" else f"at {time}"
    expected = "any value" if row.expected.strip().casefold() == "any" else row.expected
    return MissedLine(row.number, when, row.stream, expected, row.got, row.notes, row.hints)


def _notes(results: Results) -> list[str]:
    notes = []
    if results.why:
        notes.append(results.why)
    elif results.rows:
        rows = ", ".join(results.rows[:3]) + (f" and {len(results.rows) - 3} more" if len(results.rows) > 3 else "")
        notes.append(f"Left out, because of errors there: {rows}.")
    if results.stale:
        notes.append(
            "This is from before the newest change. These tests take long: press Run tests to see how it is now."
        )
    if any(t.state == LATE for t in results.tests):
        notes.append("The tests take long. Press Run tests to let them have more time.")
    return notes
