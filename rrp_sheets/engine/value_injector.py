"""Values that somebody sends into a stream: from the text in the cell or the field to the value."""

from __future__ import annotations

from rrp_sheets.checks import Checked
from rrp_sheets.checks.facts import sensor_fact
from rrp_sheets.checks.send_expect import Given, Sending, read_send
from rrp_sheets.diagnostics import Report
from rrp_sheets.engine.engine import Engine, LiveStream
from rrp_sheets.errors import SheetsError
from rrp_sheets.formulas import Formula
from rrp_sheets.formulas.evaluator import GuardedInterpreter
from rrp_sheets.graph import Stream, StreamKind
from rrp_sheets.model.exchange import DONE, commanded
from rrp_sheets.model.names import key, nearest
from rrp_sheets.model.values import Failure, Record, Value, record_from_mapping
from rrp_sheets.model.workbook import Address, Cell
from rrp_sheets.robots import Robot
from rrp_sheets.texts import N_

OPEN_KINDS = (StreamKind.SENSOR, StreamKind.DONE)
_HERE = Address("Send")


class Sender:
    """Works out what is sent. One per thread: it has an interpreter of its own."""

    def __init__(self) -> None:
        self._interpreter = GuardedInterpreter()

    def value(self, sending: Sending, base: Value, name: str) -> Value:
        """Return the value, or a Failure of its formula.

        Args:
            sending: what the cell says.
            base: the example of which fields may be changed; None where there is none, and the fields are all there is.
            name: of the stream, as it is called.
        """
        if sending.whole:
            return self._given(sending.value)
        changed: dict[str, Value] = {}
        for field, given in sending.fields:
            value = self._given(given)
            if type(value) is Failure:
                return value
            changed[field] = value
        if isinstance(base, Record):
            kind = base.type
            return Record(kind, {**base.values, **{kind.keys[key(name)]: value for name, value in changed.items()}})
        return record_from_mapping(name, changed) if base is None else base

    def _given(self, given: Given) -> Value:
        return given.prepare(self._interpreter)() if isinstance(given, Formula) else given


def sensed_now(stream: Stream, robot: Robot, count: int) -> Value:
    """Return the example of a sensor stream; `count` of its values, this one included: presses are counted."""
    value = sensor_fact(stream, robot).example
    if isinstance(value, Record) and key("count") in value.values and not stream.settings.get("rate"):
        return Record(value.type, {**value.values, key("count"): count})
    return value


def ended_now(command: tuple[Value, float] | None) -> Record:
    """Return the example of an ended command, with what the actuator stream was last told and how many seconds ago."""
    record = DONE.example()
    if command is None:
        return record
    value, seconds = command
    return Record(DONE, {**record.values, "value": commanded(value), "seconds": seconds})


class ValueInjector:
    """Reads what somebody wants to send into a stream of a run."""

    def __init__(self, engine: Engine) -> None:
        self._engine = engine
        self._open = {key(s.name): s for s in engine.plan.streams if s.kind in OPEN_KINDS}
        self._sender = Sender()

    def read(self, name: str, text: str, checked: Checked) -> tuple[Stream, Value]:
        """Return the stream and the value. Raises SheetsError when one is not understood, or the formula fails.

        Args:
            name: of a sensor stream, or of one that tells the ends of commands.
            text: as the Send cell of a test has it; blank is the example.
            checked: the workbook, with its helpers.
        """
        stream = self._open.get(key(name))
        if stream is None:
            raise self._no_stream(name)
        if stream.kind is StreamKind.DONE:
            base: Value = ended_now(self._commanded(stream))
        else:
            base = sensed_now(stream, checked.robot, self._engine.streams[stream.id].arrived + 1)
        value = self._sender.value(self._sending(text, stream, checked), base, stream.name)
        if type(value) is Failure:
            why = N_("“{text}” cannot be calculated: {reason}", text=text, reason=value.message)
            raise SheetsError(why, N_("Change it, then send it again."))
        return stream, value

    def _sending(self, text: str, stream: Stream, checked: Checked) -> Sending:
        if not text.strip():
            return Sending("")
        record = DONE if stream.kind is StreamKind.DONE else stream.device.type.payload if stream.device else None
        report = Report()
        sending = read_send(Cell(text.strip(), _HERE), record, checked.scope(()), report)
        for finding in report:  # a record that is sent as a plain value makes the rows after it fail: refused here
            raise SheetsError(finding.message, finding.remedy)
        assert sending is not None
        return sending

    def _commanded(self, stream: Stream) -> tuple[Value, float] | None:
        live: LiveStream | None = self._engine.streams.get(stream.done_of)
        if live is None or live.at_us < 0:
            return None
        return live.latest, (self._engine.clock.us - live.at_us) / 1e6

    def _no_stream(self, name: str) -> SheetsError:
        known = [s.name for s in self._open.values()]
        remedy = N_("You can send values into: {names}.", names=", ".join(known))
        if not known:
            remedy = N_("This run has no sensor streams.")
        other = next((s for s in self._engine.plan.streams if key(s.name) == key(name) and s.name), None)
        if other is not None:
            words = N_("“{name}” is not a sensor stream. Its values come from rows.", name=other.name)
            return SheetsError(words, remedy)
        if near := nearest(name, known):
            remedy = N_("Did you mean {guess}?", guess=near)
        return SheetsError(N_("No row of this run reads a sensor stream “{name}”.", name=name), remedy)
