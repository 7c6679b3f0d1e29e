"""Plays the rows of one test in virtual time: only the frames in which something happens are worked out."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from rrp_sheets.checks.tests import Case, CaseRow
from rrp_sheets.engine.frame import FrameEngine
from rrp_sheets.engine.plan import Plan
from rrp_sheets.engine.value_injector import Sender, ended_now, sensed_now
from rrp_sheets.errors import RunBroken
from rrp_sheets.graph import StreamKind
from rrp_sheets.model.values import Failure, Value
from rrp_sheets.testing.frames import TOLERANCE, Frames
from rrp_sheets.testing.judge import seconds
from rrp_sheets.testing.results import Event, Fault, failure_words

MOST_EVENTS = 200_000  # of one test: some seconds of work, and 200 MB


class Player:
    """One test being played; an engine's observer.

    Attributes:
        events: what came on streams, in order.
        faults: formulas that failed.
        broken: rows that could not send, by row number.
        ended_us: where the clock stood at the end.
        ended_by: the row that ended the run early; empty otherwise.
    """

    def __init__(self, plan: Plan, case: Case, seed: int) -> None:
        self.plan = plan
        self.case = case
        self.frames = Frames(plan.checked.run.frame_rate)
        self.events: list[Event] = []
        self.faults: list[Fault] = []
        self.broken: dict[int, str] = {}
        self.ended_us = 0
        self.ended_by = ""
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
        self.faults.append(Fault(us, row, failure_words(failure)))

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
                self.broken[begun.row] = f"{error.message} It was at {engine.row}. {error.remedy}"
                self.ended_us, self.ended_by = now, engine.row
                engine.close()
                return
            self.faults += [Fault(now, h.row, h.text) for h in engine.take_happenings() if h.kind == "error"]
            sent = due
            if len(self.events) > MOST_EVENTS:
                self.broken[self.case.rows[0].row] = (
                    f"More than {MOST_EVENTS:,} values had come by {seconds(now)}, so the test was broken off. Let the "
                    "last row stand at an earlier time, or what comes again and again come less often."
                )
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
            value = self._value(row, now)
            if type(value) is Failure:
                self.broken[row.row] = failure_words(value)
            else:
                arrivals.append((row.stream, value))
                if row.stream not in self._engine.streams:  # a done stream that no row reads: it is seen all the same
                    self.events.append(Event(now, row.stream, "", value))
        return arrivals

    def _value(self, row: CaseRow, now: int) -> Value:
        """What a row sends."""
        assert row.sending is not None
        return self._sender.value(row.sending, self._base(row.stream, now), row.name)

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
