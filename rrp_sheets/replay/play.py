"""Player that gives the recorded sensor values of a run to the rows of a workbook, without robot or simulator.

When another workbook is played, commands end as follows. One that was made in the session as well (the same value, on
the same actuator stream, at the same time) ends as it did there. The end of one that is not made is left out. One that
the session did not have ends, if the same value was carried out at another time in that session, after the time that
this usually took; else nothing is known of its end, and it has none.
"""

from __future__ import annotations

import heapq
import json
import tempfile
from collections import defaultdict, deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import groupby
from statistics import median
from typing import Any

from rrp_sheets.engine.builtin_devices import MIN_DELAY_US
from rrp_sheets.engine.engine import Engine, EventEngine, FrameEngine
from rrp_sheets.engine.plan import Plan
from rrp_sheets.engine.run_events import RunObserver
from rrp_sheets.errors import RunBroken, SheetsError
from rrp_sheets.graph import StreamKind
from rrp_sheets.model.exchange import DONE, commanded
from rrp_sheets.model.names import key
from rrp_sheets.model.run_files import RecordedAction, RecordedEvent, RecordedFailure, RecordedNotice, RecordedValue
from rrp_sheets.model.values import Failure, Record, RecordType, Value, record_from_mapping, to_json
from rrp_sheets.replay.edits import Editions
from rrp_sheets.replay.record import Recorded, content, moments, same_json
from rrp_sheets.replay.workbooks import Matching, ReplaySource
from rrp_sheets.texts import N_, os_reason, sentences


class ValueDecoder:
    """Decoder of the values of streams from JSON.

    The value of a command comes back in its end: a list or a record from a formula, whose type JSON does not keep. So
    commands are remembered as they are made, and their ends get the original value.
    """

    def __init__(self, plan: Plan) -> None:
        self._records: dict[str, RecordType] = {
            s.id: s.device.type.payload for s in plan.streams if s.device and s.device.type.payload
        }
        self._of = plan.dones
        self._given: dict[tuple[str, str], Value] = {}

    def command(self, stream: str, value: Value) -> None:
        """Remember a command that a row has made."""
        if isinstance(value, (list, tuple, Record)):
            told = commanded(value)
            self._given[stream, same_json(to_json(told))] = told

    def value(self, stream: str, value: Any) -> Value:
        """Return the value that a sensor stream, or one of ended commands, had."""
        kind = DONE if stream in self._of else self._records.get(stream)
        if kind is None or not isinstance(value, dict):
            return _plain(value)
        fields = {key(n): _plain(v) for n, v in value.items()}
        if kind is DONE and isinstance(value.get("value"), (list, dict)):
            given = self._given.get((self._of[stream], same_json(value["value"])))
            fields["value"] = fields["value"] if given is None else given
        if fields.keys() - kind.names.keys():  # of another version of the catalogue
            return record_from_mapping(kind.name, {n: fields[key(n)] for n in value})
        return kind.make(**{name: fields.get(k) for k, name in kind.names.items()})


def _plain(value: Any) -> Value:
    if isinstance(value, dict):
        return record_from_mapping("Record", {str(n): _plain(v) for n, v in value.items()})
    if isinstance(value, list):
        return [_plain(v) for v in value]
    return value


_ENCODE = json.JSONEncoder(separators=(",", ":")).encode


class Spool:
    """Events in a temporary file, written once and read repeatedly, but not by two readers at one time.

    >>> spool = Spool(); spool.append(RecordedValue(5, "s1", "Look!2", 0.5))
    >>> [(e.stream, content(e)) for e in spool.named({"s1": "Distance"})]
    [('Distance', 0.5)]
    """

    def __init__(self) -> None:
        self._file = tempfile.TemporaryFile("w+", encoding="utf-8")  # noqa: SIM115  # it goes with the spool
        self._count = 0

    def append(self, event: RecordedEvent) -> None:
        """Append an event; its time must not be before that of the last one."""
        parts = (event.what, event.us, event.stream, event.row, content(event))
        try:
            self._file.write(_ENCODE(parts) + "\n")
        except OSError as error:
            raise SheetsError(
                N_("The replay cannot be saved ({reason}).", reason=os_reason(error)), N_("Free space on the disk.")
            ) from None
        self._count += 1

    def __len__(self) -> int:
        return self._count

    def named(self, names: Mapping[str, str]) -> Iterator[RecordedEvent]:
        """Yield all events, with the names of the streams in place of their ids."""
        self._file.seek(0)
        while line := self._file.readline():
            what, us, stream, row, told = json.loads(line)
            stream = names.get(stream, stream)
            if what == RecordedValue.what:
                yield RecordedValue(us, stream, row, told)
            else:
                yield (RecordedFailure if what == RecordedFailure.what else RecordedNotice)(us, stream, row, *told)


MOST_CAME = 3_000_000  # events of one replay: a gigabyte
_TOLD_EVERY = 200  # moments between two words to whoever waits
Told = Callable[[float], None]


class ReplayPlayer(RunObserver):
    """Player of a recorded run, and observer of the engine.

    Args:
        recorded: what is played; its moments are gone through once.
        source: the workbook that plays it.
        found: what of that workbook corresponds to the record.
        editions: applies the edits of the run again.
        ends: the source of the ends of commands; None: as recorded.
        told: called with the progress, from 0 to 1; may raise to break off.

    Attributes:
        events: what came, in order, streams by the ids of the workbook that was played.
        until_us: where the clock stood at the end.
        ended_by: the row that ended it.
        broken: why it broke off; empty when it did not.
        left_out: what of the record could not be done again, in words.
    """

    def __init__(
        self, recorded: Recorded, source: ReplaySource, found: Matching, editions: Editions, ends: Ends | None = None,
        told: Told = lambda part: None,
    ) -> None:  # fmt: skip
        self.events = Spool()
        self.until_us = 0
        self.ended_by = self.broken = ""
        self.left_out: list[str] = []
        self._plan = plan = source.plan
        self._found = found
        self._ends = ends or Ends((), {}, {})
        self._told = told
        self._at_end, self._last_us = recorded.at_end, recorded.until_us
        gone = {e.number for e in self._at_end or ()}
        self._moments = moments(e for e in recorded.played if e.number not in gone)
        self._count = 0  # of the moments so far
        self._senses = ValueDecoder(plan)
        self._actuators = {s.id for s in plan.streams if s.kind is StreamKind.ACTUATOR}
        kind = FrameEngine if plan.checked.run.engine == "frame" else EventEngine
        self._engine: Engine = kind(plan, self, recorded.header.fields.get("seed", 0))
        self._editions = editions
        outer = {s.stream for s in plan.outer_sensors}
        self._fed = outer | {done for done, actuator in plan.dones.items() if actuator not in plan.own}

    # ---- the observer
    def event(self, us: int, stream: str, row: str, value: Value) -> None:
        """Store a value on a stream."""
        told = to_json(value)
        self.events.append(RecordedValue(us, stream, row, told))
        if stream in self._actuators:
            self._senses.command(stream, value)
            self._ends.made(us, stream, value, told)
        if len(self.events) > MOST_CAME:
            raise RunBroken(N_("More than {most:,} values arrived.", most=MOST_CAME), N_("Replay a shorter run."))

    def error(self, us: int, row: str, failure: Failure, values: tuple[Value, ...]) -> None:
        """Store the failure of a formula."""
        inputs = [to_json(v) for v in values]
        self.events.append(RecordedFailure(us, "", row, failure.message, failure.code, inputs))

    # ---- playing
    def play(self) -> None:
        """Play the run to its end."""
        engine = self._engine
        try:
            if isinstance(engine, EventEngine):
                self._one_by_one(engine)
            else:
                self._by_frames(engine)
        except RunBroken as error:
            row = engine.row
            self.broken = sentences(error.message, N_("It was at {row}.", row=row) if row else "")
        if self.broken or self._at_end is None:
            engine.close()
        else:  # with the recorded ends of what still goes on; the engine's own devices add theirs
            engine.finish(self._values(e for e in self._at_end if self._is_fed(e)))
        self.until_us = engine.clock.us
        self.ended_by = engine.ended_by
        self.left_out += self._editions.left_out

    def _by_frames(self, engine: Engine) -> None:
        rate = engine.plan.checked.run.frame_rate
        last = _frame(self._last_us, rate)
        frame = 0
        coming = next(self._moments, None)
        while True:
            now = frame * 1_000_000 // rate
            events: list[RecordedEvent] = []
            while coming is not None and _frame(coming[0], rate) <= frame:
                events += coming[1]
                self._tell(coming[0])
                coming = next(self._moments, None)
            self._send(events)
            self._settle(now, [*self._values(e for e in events if self._is_fed(e)), *self._ends.take(now)])
            if engine.ended_by:
                return
            actions = [e for e in events if isinstance(e, RecordedAction)]
            self._act(actions)
            if frame >= last:
                return
            following = [last]
            if actions:  # what they leave is carried out in the next frame
                following.append(frame + 1)
            if coming is not None:
                following.append(_frame(coming[0], rate))
            following += [_frame(due, rate) for due in (engine.clock.next_due, self._ends.next_us) if due is not None]
            frame = max(frame + 1, min(following))

    def _one_by_one(self, engine: Engine) -> None:
        """Settle every arrival at an instant of its own; timers that are due before it come at their own times."""
        for us, events in self._moments:
            self._tell(us)
            self._due_before(us)
            first = next((e for e in events if not isinstance(e, RecordedNotice)), None)
            if first is not None and not self._is_fed(first) and not _is_by_hand(first):
                self._settle(us, [])  # a timer of just this time came first
            waiting = False
            for event in events:
                if engine.ended_by:
                    return
                if isinstance(event, RecordedAction):
                    self._settle(us, [])
                    self._act([event])
                    waiting = True
                elif _is_by_hand(event):
                    if not waiting:
                        self._settle(us, [])  # else a timer's instant, of before, would take it along
                    self._send([event])
                    waiting = True
                else:
                    if waiting:
                        self._settle(us, [])
                        waiting = False
                    if self._is_fed(event):
                        self._settle(us, self._values([event]))
            if waiting:
                self._settle(us, [])
        self._due_before(self._last_us)
        if not engine.ended_by:
            self._settle(self._last_us, [])

    def _due_before(self, us: int) -> None:
        """Settle the ends of commands that the record does not have, each at its own time."""
        while not self._engine.ended_by and (due := self._ends.next_us) is not None and due < us:
            self._settle(due, self._ends.take(due))

    def _settle(self, now: int, arrivals: Sequence[tuple[str, Value]]) -> None:
        self._engine.settle(now, arrivals)
        for notice in self._engine.take_notices():
            recorded = RecordedNotice(now, notice.stream, notice.row, notice.kind, notice.text)
            self.events.append(recorded)
        self._engine.triggers.take()

    # ---- from the record to the engine
    def _is_fed(self, event: RecordedEvent) -> bool:
        """Return whether an event is a value from the world; the engine's own devices give theirs by themselves."""
        if not isinstance(event, RecordedValue) or event.row or event.by is not None:
            return False
        return self._found.streams.get(event.stream) in self._fed and self._ends.kept(event)

    def _values(self, events: Iterable[RecordedEvent]) -> list[tuple[str, Value]]:
        found = []
        for event in events:
            stream = self._found.streams.get(event.stream, "")
            if isinstance(event, RecordedValue) and stream in self._engine.streams:
                found.append((stream, self._senses.value(stream, event.value)))
        return found

    def _send(self, events: Iterable[RecordedEvent]) -> None:
        for event in events:
            if isinstance(event, RecordedValue) and event.by is not None:
                for stream, value in self._values([event]):
                    self._engine.stimulate(stream, value, event.by)

    def _act(self, actions: Sequence[RecordedAction]) -> None:
        """Repeat what people did to the rows; what they did to the world is in the sensor values."""
        for (kind, _), together in groupby(actions, key=lambda a: (a.kind, a.wall)):
            details = [action.detail for action in together]
            if kind == "edit":  # the changes of one have one time
                self._editions.use(self._engine, details)
            elif kind == "switch":
                for detail in details:
                    self._switch(detail)

    def _switch(self, detail: Mapping[str, Any]) -> None:
        name = str(detail.get("behaviour") or "")
        behaviour = self._found.behaviours.get(key(name), key(name))
        if behaviour in self._plan.behaviours:
            self._engine.turn(behaviour, bool(detail.get("on")))
        else:
            words = N_("The behaviour {name} was switched manually. It does not run here.", name=name)
            self.left_out.append(words)

    def _tell(self, us: int) -> None:
        self._count += 1
        if self._count % _TOLD_EVERY == 0:
            self._told(min(us / max(1, self._last_us), 1.0))


def _frame(us: int, rate: int) -> int:
    """Return the number of the first frame at or after a time."""
    return -(-us * rate // 1_000_000)


def _is_by_hand(event: RecordedEvent) -> bool:
    return isinstance(event, RecordedAction) or (isinstance(event, RecordedValue) and event.by is not None)


class Ends:
    """Source of the ends of commands while another workbook is played with a record.

    Args:
        events: of the record.
        streams: ids of the streams of the workbook that is played, by their names in the record.
        dones: ids of its streams that tell ends, each with its actuator stream; of the world's actuators only.

    Attributes:
        usual: commands that are taken to end after their usual time.
        unknown: commands of whose end nothing is known.
    """

    def __init__(self, events: Iterable[RecordedEvent], streams: Mapping[str, str], dones: Mapping[str, str]) -> None:
        self.usual: list[tuple[str, Value, float]] = []
        self.unknown: list[tuple[str, Value]] = []
        self._done = {actuator: done for done, actuator in dones.items()}
        self._commands: dict[tuple[str, str, int], deque[int]] = defaultdict(deque)  # the numbers of their events
        self._by_end: dict[int, int] = {}  # the same by the numbers of the events that are their ends
        self._made: set[int] = set()  # those that are made in what is played now, too
        self._times: dict[tuple[str, str], list[float]] = defaultdict(list)
        self._coming: list[tuple[int, int, str, Value]] = []
        self._number = 0
        waiting: dict[tuple[str, str], deque[int]] = defaultdict(deque)
        for event in events:
            stream = streams.get(event.stream, "")
            if not isinstance(event, RecordedValue) or event.by is not None:
                continue
            if event.row and stream in self._done and event.value is not None:
                mine = stream, same_json(_told(event.value))
                self._commands[*mine, event.us].append(event.number)
                waiting[mine].append(event.number)
            elif not event.row and stream in dones and isinstance(event.value, dict):
                mine = dones[stream], same_json(event.value.get("value"))
                if waiting[mine]:
                    self._by_end[event.number] = waiting[mine].popleft()
                seconds = event.value.get("seconds")
                if event.value.get("completed") is True and isinstance(seconds, (int, float)):
                    self._times[mine].append(float(seconds))

    @property
    def dropped(self) -> int:
        """Number of ends in the record that belong to commands that are not made now."""
        return sum(command not in self._made for command in self._by_end.values())

    def made(self, us: int, stream: str, value: Value, told: Any) -> None:
        """Take note of a command that a row of the workbook that is played has made."""
        if value is None or stream not in self._done:
            return
        mine = stream, same_json(_told(told))
        same = self._commands.get((*mine, us))
        if same:
            self._made.add(same.popleft())
        elif mine in self._times:
            seconds = median(self._times[mine])
            self.usual.append((stream, value, seconds))
            self._number += 1
            end = DONE.make(value=commanded(value), completed=True, seconds=seconds)
            due = us + max(MIN_DELAY_US, round(seconds * 1_000_000))
            heapq.heappush(self._coming, (due, self._number, self._done[stream], end))
        else:
            self.unknown.append((stream, value))

    def kept(self, event: RecordedEvent) -> bool:
        """Return whether a value of the record comes now as well: ends of commands that are not made do not."""
        command = self._by_end.get(event.number)
        return command is None or command in self._made

    @property
    def next_us(self) -> int | None:
        """Time (µs) of the next end that the record does not have; None when there is none."""
        return self._coming[0][0] if self._coming else None

    def take(self, now_us: int) -> list[tuple[str, Value]]:
        """Remove and return the ends that have come by now."""
        found = []
        while self._coming and self._coming[0][0] <= now_us:
            _, _, stream, value = heapq.heappop(self._coming)
            found.append((stream, value))
        return found


def _told(value: Any) -> Any:
    """Return a command's value as its end has it: ends within it lose the value of the command that they ended."""
    if isinstance(value, dict):
        if set(value) == {f.name for f in DONE.fields}:
            return {**value, "value": None}
        return {n: _told(v) for n, v in value.items()}
    return [_told(v) for v in value] if isinstance(value, list) else value
