"""Runs the tests of a checked workbook, or of the part of one that has no errors."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from rrp_sheets.checks import Checked, check_workbook
from rrp_sheets.checks.tests import Case, CaseRow
from rrp_sheets.diagnostics import Report
from rrp_sheets.engine.engine import FrameEngine
from rrp_sheets.engine.plan import Plan, make_plan
from rrp_sheets.engine.run_events import RunObserver
from rrp_sheets.engine.value_injector import Sender, ended_now, sensed_now
from rrp_sheets.errors import RunBroken, SheetsError
from rrp_sheets.graph import StreamKind
from rrp_sheets.model.names import key
from rrp_sheets.model.values import Failure, Value
from rrp_sheets.model.workbook import Address, Behaviour, Workbook
from rrp_sheets.testing.judge import TOLERANCE, CaseResult, Event, Fault, Frames, RowResult, judge, seconds
from rrp_sheets.texts import N_, sentences
from rrp_sheets.workbook import Reading


@dataclass(frozen=True)
class TestReport:
    """The results of a workbook's tests."""

    __test__ = False  # no test of pytest's

    checked: Checked
    cases: tuple[CaseResult, ...]  # a result for every test sheet that was run
    stopped: bool = False  # whether somebody stopped it before all of them were

    @property
    def passed(self) -> bool:
        """True when every test holds."""
        return all(c.passed for c in self.cases)


def run_tests(checked: Checked, stopped: Callable[[], bool] = lambda: False) -> TestReport:
    """Run every test sheet of a workbook in virtual time, each from a fresh start; `stopped` is asked every frame.

    Raises SheetsError when the workbook has errors.
    """
    if checked.report.errors:
        raise SheetsError(N_("This workbook has errors, so its tests cannot run."), N_("See `rrp-sheets check`."))
    plan = make_plan(checked)
    cases: list[CaseResult] = []
    for case in checked.tests:
        result = run_case(plan, case, stopped)
        if stopped():
            break
        cases.append(result)
    return TestReport(checked, tuple(cases), stopped())


def run_case(plan: Plan, case: Case, stopped: Callable[[], bool] = lambda: False) -> CaseResult:
    """Run one test."""
    began = time.perf_counter()
    player = Player(plan, case, plan.checked.run.seed)
    player.play(stopped)
    judged = judge(case, player.events, player.faults, player.frames)
    rows = tuple(_explained(r, player) for r in judged)
    took = time.perf_counter() - began
    return CaseResult(case, rows, tuple(player.events), tuple(player.faults), player.ended_us, took, player.broken)


def _explained(result: RowResult, player: Player) -> RowResult:
    """A result with the reasons that only the run knows."""
    if result.passed:
        return result
    row, hints = result.row, list(result.hints)
    if row.why_silent:
        hints.append(N_("No value can arrive there: {why}.", why=row.why_silent))
    if player.ended_by and row.time_us > player.ended_us:
        hints.append(N_("{row} ended the run at {ms}.", row=player.ended_by, ms=seconds(player.ended_us)))
    return RowResult(row, False, result.event, result.got, tuple(hints))


MOST_EVENTS = 200_000  # of one test: some seconds of work, and 200 MB


class Player(RunObserver):
    """One test being played; an engine's observer."""

    def __init__(self, plan: Plan, case: Case, seed: int) -> None:
        self.plan = plan
        self.case = case
        self.frames = Frames(plan.checked.run.frame_rate)
        self.events: list[Event] = []  # what came on streams, in order
        self.faults: list[Fault] = []  # formulas that failed
        self.broken: dict[int, str] = {}  # rows that could not send, by row number
        self.ended_us = 0  # where the clock stood at the end
        self.ended_by = ""  # the row that ended the run early; empty otherwise
        self._engine = FrameEngine(plan, self, seed)
        self._sender = Sender()
        self._commanded: dict[str, tuple[int, Value]] = {}  # the last command of each actuator stream

    # ---- the observer
    def event(self, us: int, stream: str, row: str, value: Value) -> None:
        """A value on a stream."""
        self.events.append(Event(us, stream, row, value))
        found = self.plan.checked.graph.streams.get(stream)  # None of a done stream that only the scene waits for
        if found is not None and found.kind is StreamKind.ACTUATOR and value is not None:
            self._commanded[stream] = (us, value)

    def error(self, us: int, row: str, failure: Failure, values: tuple[Value, ...]) -> None:
        """A formula failed."""
        self.faults.append(Fault(us, row, failure.message))

    # ---- playing
    def play(self, stopped: Callable[[], bool] = lambda: False) -> None:
        """Send what is to be sent, until the last row's time is over."""
        engine, frames = self._engine, self.frames
        sends = self.case.sends
        last = max((frames.at(r.time_us) for r in self.case.rows), default=0) + TOLERANCE
        frame = sent = 0
        while True:
            now = frames.time(frame)
            due = sent
            while due < len(sends) and frames.at(sends[due].time_us) <= frame:
                due += 1
            try:
                engine.settle(now, self._arrivals(now, sends[sent:due]))
            except RunBroken as error:  # the rows drown in values: it began with what was sent last
                begun = sends[due - 1] if due else self.case.rows[0]
                self.broken[begun.row] = sentences(error.message, N_("It was at {row}.", row=engine.row), error.remedy)
                self.ended_us, self.ended_by = now, engine.row
                engine.close()
                return
            self.faults += [Fault(now, h.row, h.text) for h in engine.take_notices() if h.kind == "error"]
            sent = due
            if len(self.events) > MOST_EVENTS:
                self.broken[self.case.rows[0].row] = N_(
                    "More than {most:,} values arrived by {ms}, so the test was stopped. Move the last row to an "
                    "earlier time, or send repeated values less often.",
                    most=MOST_EVENTS, ms=seconds(now),
                )  # fmt: skip
                stop = True
            else:
                stop = stopped()
            self.ended_us, self.ended_by = now, engine.ended_by
            if engine.ended_by or frame >= last or stop:
                engine.close()
                return
            following = [last]
            if sent < len(sends):
                following.append(frames.at(sends[sent].time_us))
            if engine.clock.next_due is not None:
                following.append(frames.at(engine.clock.next_due))
            frame = max(frame + 1, min(following))

    def _arrivals(self, now: int, rows: Sequence[CaseRow]) -> list[tuple[str, Value]]:
        arrivals = []
        for row in rows:
            assert row.sending is not None
            value = self._sender.value(row.sending, self._base(row.stream, now), row.name)
            if type(value) is Failure:
                self.broken[row.row] = value.message
            else:
                arrivals.append((row.stream, value))
                if row.stream not in self._engine.streams:  # a done stream that no row reads: it is seen all the same
                    self.events.append(Event(now, row.stream, "", value))
        return arrivals

    def _base(self, stream_id: str, now: int) -> Value:
        """The example whose fields a row may change; None of a stream that rows make."""
        stream = self.plan.checked.graph.streams.get(stream_id)
        if stream_id.endswith("done") and (stream is None or stream.kind is StreamKind.DONE):
            last = self._commanded.get(stream.done_of if stream else stream_id.removesuffix("done"))
            return ended_now((last[1], (now - last[0]) / 1e6) if last else None)
        if stream is None or stream.kind is not StreamKind.SENSOR:
            return None
        live = self._engine.streams.get(stream_id)
        return sensed_now(stream, self.plan.checked.robot, live.arrived + 1 if live else 1)


_ROUNDS = 8  # of leaving out what has errors; each may bring others to light


@dataclass(frozen=True)
class Partly:
    """A workbook without what has errors."""

    checked: Checked | None  # has no errors; None where those that there are concern all of it
    # the rows with errors, which are taken as switched off with those that follow from them
    rows: tuple[Address, ...] = ()
    waiting: tuple[str, ...] = ()  # the names of the test sheets that have errors themselves, or need what has
    errors: int = 0  # how many errors the whole workbook has


def in_order(reading: Reading) -> Partly:
    """The part of a workbook that has no errors.

    The findings of the whole workbook's check are added to those of reading it.
    """
    book = reading.workbook
    checked = check_workbook(book, reading.report, lints=False)
    errors = len(checked.report.errors)
    rows: dict[Address, None] = {}
    waiting: dict[str, None] = {}
    for _ in range(_ROUNDS):
        found = checked.report.errors
        if not found:
            return Partly(checked, tuple(rows), tuple(waiting), errors)
        places = [d.address for d in found if d.address is not None]
        if len(places) < len(found):
            break  # something about the whole file
        smaller = _without(book, places, rows, waiting)
        if smaller is None:
            break
        book = smaller
        checked = check_workbook(book, Report(), lints=False)
    return Partly(None, tuple(rows), tuple(waiting), errors)


def _without(
    book: Workbook, places: list[Address], rows: dict[Address, None], waiting: dict[str, None]
) -> Workbook | None:
    """A workbook without these places, which are noted; None when one of them cannot be left out."""
    behaviours = {key(b.name): b for b in book.behaviours}
    tests = {key(t.name): t for t in book.tests}
    scene = {a.sheet for r in book.scene or () for a in (r.time.address, r.does.address)}
    for at in places:
        sheet = key(at.sheet)
        if sheet in behaviours:
            smaller = _row_off(behaviours[sheet], at.row)
            if smaller is None:
                return None
            behaviours[sheet] = smaller
            rows[Address(at.sheet, at.row)] = None
        elif sheet in tests:
            waiting[tests[sheet].name] = None
        elif at.sheet in scene:
            book = replace(book, scene=None)  # tests need none
        else:
            return None
    kept = tuple(t for t in tests.values() if t.name not in waiting)
    return replace(book, behaviours=tuple(behaviours.values()), tests=kept)


def _row_off(behaviour: Behaviour, number: int) -> Behaviour | None:
    """A behaviour with a row switched off, and the rows below that take what it gives by a blank input.

    A row that is off already, and has errors all the same, goes.
    """
    place = next((i for i, row in enumerate(behaviour.rows) if row.number == number), None)
    if place is None:
        return None
    rows = list(behaviour.rows)
    if not rows[place].on:
        del rows[place]
        return replace(behaviour, rows=tuple(rows))
    rows[place] = replace(rows[place], on=False)
    for i in range(place + 1, len(rows)):
        if rows[i].inputs:
            break
        rows[i] = replace(rows[i], on=False)
    return replace(behaviour, rows=tuple(rows))
