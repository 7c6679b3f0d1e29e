"""Plays the rows of one test in virtual time: only the frames in which something happens are worked out."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from rrp_sheets.checks.facts import sensor_fact
from rrp_sheets.checks.sending import Given
from rrp_sheets.checks.tests import Case, CaseRow
from rrp_sheets.errors import RunBroken
from rrp_sheets.formulas import Formula
from rrp_sheets.formulas.evaluator import GuardedInterpreter
from rrp_sheets.graph import StreamKind
from rrp_sheets.model.exchange import DONE, commanded
from rrp_sheets.model.names import key
from rrp_sheets.model.values import Failure, Record, RecordType, Value, record_from_mapping
from rrp_sheets.runtime.frame import FrameEngine
from rrp_sheets.runtime.plan import Plan
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
        self._interpreter = GuardedInterpreter()
        self._commanded: dict[str, tuple[int, Value]] = {}  # the last command of each actuator stream

    # ---- the observer
    def event(self, us: int, stream: str, row: str, value: Value) -> None:
        """A value on a stream."""
        self.events.append(Event(us, stream, row, value))
        kind = self.plan.checked.graph.streams[stream].kind
        if kind is StreamKind.ACTUATOR and value is not None:
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

    # ---- what is sent
    def _value(self, row: CaseRow, now: int) -> Value:
        sending = row.sending
        assert sending is not None
        if sending.whole:
            return self._given(sending.value)
        changed = {}
        for name, given in sending.fields:
            value = self._given(given)
            if type(value) is Failure:
                return value
            changed[name] = value
        stream = self.plan.checked.graph.streams.get(row.stream)
        if row.stream.endswith("done") and (stream is None or stream.kind is StreamKind.DONE):
            of = stream.done_of if stream else row.stream.removesuffix("done")
            return _changed(DONE, self._done(of, now), changed)
        if stream is None or stream.kind is not StreamKind.SENSOR:
            return record_from_mapping(row.name, changed)
        value = sensor_fact(stream, self.plan.checked.robot).example
        if isinstance(value, Record) and key("count") in value.values and not stream.settings.get("rate"):
            value = _changed(value.type, value, {"count": self._counted(row.stream)})
        return _changed(value.type, value, changed) if isinstance(value, Record) else value

    def _counted(self, stream: str) -> int:
        """How often a sensor stream has had a value, this one included: presses are counted."""
        return self._engine.streams[stream].arrived + 1 if stream in self._engine.streams else 1

    def _done(self, actuator: str, now: int) -> Record:
        """The example of an ended command, with what the actuator stream was last told and how long ago."""
        record = DONE.example()
        if actuator in self._commanded:
            began, value = self._commanded[actuator]
            record = Record(DONE, {**record.values, "value": commanded(value), "seconds": (now - began) / 1e6})
        return record

    def _given(self, given: Given) -> Value:
        return given.prepare(self._interpreter)() if isinstance(given, Formula) else given


def _changed(kind: RecordType, base: Record, changed: dict[str, Value]) -> Record:
    return Record(kind, {**base.values, **{kind.keys[key(name)]: value for name, value in changed.items()}})
