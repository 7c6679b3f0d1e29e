"""Replay of a recorded run from its sensor values, here or in a worker, and its comparison with the record."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from rrp_sheets.errors import SheetsError
from rrp_sheets.graph import StreamKind
from rrp_sheets.model.run_files import WORKBOOK, RecordedEvent, RecordedFailure, RecordedNotice, RecordedValue
from rrp_sheets.recording.metadata import stamp_of
from rrp_sheets.replay.edits import Editions
from rrp_sheets.replay.play import Ends, Played, ReplayPlayer, Script, Told
from rrp_sheets.replay.record import Events, Recorded, moments, read_record
from rrp_sheets.replay.report import ending, unknown
from rrp_sheets.replay.result import Comparer, Replayed
from rrp_sheets.replay.workbooks import (
    Matching,
    ReplaySource,
    another,
    differing_remarks,
    itself,
    matching,
    remarks,
    the_one_that_ran,
)
from rrp_sheets.texts import N_
from rrp_sheets.workers.worker_process import WorkerError, WorkerProcess

_SAYS = ("SayInput", "SayParameter")
_SWITCHED = (" is switched on.", " is switched off.")


def replay(trace: Path, other: Path | None = None, told: Told = lambda part: None) -> Replayed:
    """Replay a recorded run, with its own workbook or with another one.

    Args:
        trace: a run's folder, or its trace.jsonl.
        other: the workbook to play instead of the one that ran.
        told: called with the progress, from 0 to 1; what it raises breaks the replay off.

    Raises:
        UnreadableFile: when the trace or a workbook cannot be read.
        SheetsError: when a workbook has errors, or the one that ran is not there and no other is named.
    """
    recorded = read_record(trace)
    ran = _ran(recorded, needed=other is None)
    if other is None:
        assert ran is not None
        return _exactly(recorded, ran, told)
    source = another(other, recorded, ran)
    if source.reading.digest == recorded.header.text("workbook"):
        return _exactly(recorded, source, told)
    return _otherwise(recorded, ran, source, told)


def _ran(recorded: Recorded, *, needed: bool) -> ReplaySource | None:
    """Return the workbook that ran; when it is not needed, None for one that cannot be used."""
    try:
        found = the_one_that_ran(recorded)
    except SheetsError:
        if needed:
            raise
        return None
    if found is None and needed:
        raise SheetsError(
            N_("The workbook that ran is not beside “{trace}” ({file}).", trace=recorded.path.name, file=WORKBOOK),
            N_(
                "Name the run's folder, or the workbook: --with {file}.",
                file=recorded.header.text("name") or "FILE.xlsx",
            ),
        )
    return found


def _exactly(recorded: Recorded, source: ReplaySource, told: Told) -> Replayed:
    """Replay with the same workbook: everything is to be the same."""
    found = itself(source)
    events, cut = _whole(recorded)
    engines = partial(_is_engines, source=source, found=found)
    script = _script(recorded, events, found)
    played = ReplayPlayer(source, script, Editions, told=told).play()
    tally = _Tally(engines)
    kinds = (RecordedValue, RecordedFailure)
    expected = Events(lambda: tally.expected(events, lambda e: isinstance(e, kinds) or engines(e)))
    came = _named(played, found)
    if recorded.ended == "cut":
        came = _as_long(came, expected)
    differences, counts = Comparer(lambda row: row, lambda row: row, exact=True).compare(expected, came)
    unread = tally.streams - found.streams.keys()
    notes = [*remarks(recorded, source, own=True), *played.left_out]
    if unread:
        notes.append(N_("The workbook has no stream {names}, which the run had.", names=", ".join(sorted(unread))))
    return replace(
        _about(recorded, source, None), compared=tally.count, differences=differences,
        counts=counts, ending=ending(recorded, played), remarks=tuple(notes),
        unknown=tuple(unknown(recorded, tally.world, cut)), recorded=expected, came=came,
    )  # fmt: skip


def _otherwise(recorded: Recorded, ran: ReplaySource | None, source: ReplaySource, told: Told) -> Replayed:
    """Replay with another workbook: find what would have been different."""
    found = matching(recorded, ran, source)
    events, cut = _whole(recorded)
    engines = partial(_is_engines, source=source, found=found)
    script = _script(recorded, events, found)
    dones = {d: a for d, a in source.plan.dones.items() if a not in source.plan.own}
    ends = Ends(events, found.streams, dones)
    base = ran.checked.workbook if ran is not None else None
    editions = partial(Editions, rows=found.rows, ran=base)
    played = ReplayPlayer(source, script, editions, ends, told=told).play()
    own = _own(source, found)
    tally = _Tally(engines)
    expected = Events(lambda: tally.expected(events, lambda e: _is_rows(e, own) or engines(e)))
    everything = _named(played, found)
    came = Events(lambda: (e for e in everything if _is_rows(e, own) or isinstance(e, RecordedNotice)))
    back = {there: here for here, there in found.rows.items()}
    ids = {s.ref for s in source.plan.steps}
    differences, counts = Comparer(
        lambda row: there if (there := found.rows.get(row, "")) in ids else "", lambda row: back.get(row, ""),
        exact=False,
    ).compare(expected, came)  # fmt: skip
    notes = [*remarks(recorded, source, own=False), *differing_remarks(ran, source, found), *played.left_out]
    return replace(
        _about(recorded, source, ran), other=source.name, compared=tally.count, differences=differences,
        counts=counts, ending=ending(recorded, played), remarks=tuple(notes),
        unknown=tuple(unknown(recorded, tally.world, cut, ends)), recorded=expected, came=came,
    )  # fmt: skip


class _Tally:
    """Counts of the events of a record, taken while they are compared.

    Attributes:
        count: of the events that are compared.
        streams: that have values among these.
        world: what the robot and its world did, with how often.
    """

    def __init__(self, engines: Callable[[RecordedEvent], bool]) -> None:
        self._engines = engines
        self._begin()

    def _begin(self) -> None:
        self.count = 0
        self.streams: set[str] = set()
        self.world: Counter[str] = Counter()

    def expected(self, events: Events, is_wanted: Callable[[RecordedEvent], bool]) -> Iterator[RecordedEvent]:
        """Yield the events that are compared, counting them anew."""
        self._begin()
        for event in events:
            if isinstance(event, RecordedNotice) and not self._engines(event):
                self.world[event.kind] += 1
            if is_wanted(event):
                self.count += 1
                if isinstance(event, RecordedValue):
                    self.streams.add(event.stream)
                yield event


def _about(recorded: Recorded, source: ReplaySource, ran: ReplaySource | None) -> Replayed:
    """Return the part of the result that is known before anything is compared."""
    names = [n for n, kind in recorded.streams.items() if kind == StreamKind.ACTUATOR.value]
    names += [s.name for s in source.plan.streams if s.kind is StreamKind.ACTUATOR]
    spoken = {name: text for s in (source, ran) if s is not None for name, text in _spoken(s)}
    for stream in recorded.header.streams:  # without the workbook that ran
        if stream.device == _SAYS[0]:
            spoken.setdefault(stream.name, "")
    return Replayed(
        run=recorded.place.resolve().name, workbook=recorded.header.text("name") or N_("the workbook"), other="",
        engine=source.checked.run.engine, seconds=recorded.last_us / 1e6, compared=0, differences=(), counts=(),
        stamp=stamp_of(recorded.place), actuators=tuple(dict.fromkeys(names)), spoken=spoken,
    )  # fmt: skip


def _spoken(source: ReplaySource) -> Iterator[tuple[str, str]]:
    """Yield the actuator streams that speak, each with the text of its own if it has one."""
    for stream in source.plan.streams:
        if stream.kind is StreamKind.ACTUATOR and stream.device and stream.device.type.name in _SAYS:
            own = stream.device.type.name == _SAYS[1]
            yield stream.name, str(stream.settings.get("text") or "") if own else ""


# ---- the script
def _whole(recorded: Recorded) -> tuple[Events, str]:
    """Return the lines that are played, and in words what is left out of a run that broke off."""
    if recorded.ended != "broken":
        return recorded.events, ""
    last = recorded.last_us
    why = recorded.summary.text("why") if recorded.summary else ""
    at = N_("{n:g} s", n=last / 1e6)
    words = N_("The run broke off at {at}. That last moment is not replayed.", at=at)
    if why:
        words = N_("The run broke off at {at}: {message} That last moment is not replayed.", at=at, message=why)
    return Events(lambda: (e for e in recorded.events if e.us < last)), words


def _script(recorded: Recorded, events: Events, found: Matching) -> Script:
    at_end = _at_end(recorded)
    gone = {e.number for e in at_end or ()}
    until = recorded.last_us
    if recorded.ended == "broken":
        final = recorded.tail[-1].us if recorded.tail else 0
        until = final if final < until else recorded.before_us
    played = moments(e for e in events if e.number not in gone)
    return Script(played, at_end, found.streams, recorded.header.fields.get("seed", 0), until, found.behaviours)


def _at_end(recorded: Recorded) -> tuple[RecordedEvent, ...] | None:
    """Return the ends of commands that the end of the run has ended: the last lines, which no row has seen."""
    last, found = recorded.last_us, []
    if recorded.ended in ("cut", "broken"):
        return None
    for event in reversed(recorded.tail):
        if isinstance(event, RecordedNotice) and event.us == last:
            continue
        if event.us != last or not isinstance(event, RecordedValue) or event.row or event.by is not None:
            break
        ended = event.value if isinstance(event.value, dict) else {}
        is_end = recorded.streams.get(event.stream) == StreamKind.DONE.value
        if not is_end or ended.get("completed") is not False:
            break
        found.append(event)
    return tuple(reversed(found))


# ---- what is compared
def _own(source: ReplaySource, found: Matching) -> set[str]:
    """Return the record's names of the streams that the engine's own devices give."""
    plan = source.plan
    own = {s for s in plan.own if s not in {a.stream for a in plan.actuators}}
    own |= {done for done, actuator in plan.dones.items() if actuator in plan.own}
    return {name for name, there in found.streams.items() if there in own}


def _is_rows(event: RecordedEvent, own: set[str]) -> bool:
    """Return whether an event comes from rows, and not from the world."""
    if isinstance(event, RecordedValue):
        return event.by is None and (bool(event.row) or event.stream in own)
    return isinstance(event, RecordedFailure)


def _is_engines(event: RecordedEvent, source: ReplaySource, found: Matching) -> bool:
    """Return whether an event is a notice of the engine, and not of the world."""
    if not isinstance(event, RecordedNotice):
        return False
    if event.kind == "note":
        return not event.row and not event.stream and event.text.endswith(_SWITCHED)
    return event.kind == "error" and found.streams.get(event.stream) in source.plan.own


def _named(played: Played, found: Matching) -> Events:
    """Return what came, with streams called as in the record."""
    return Events(lambda: played.events.named(found.names))


def _as_long(came: Events, expected: Events) -> Events:
    """Leave out what came after the record was cut off, in the middle of a moment perhaps."""
    last = most = 0
    for event in expected:
        last, most = (last, most + 1) if event.us == last else (event.us, 1)

    def until() -> Iterator[RecordedEvent]:
        count = 0
        for event in came:
            count += event.us == last
            if event.us > last or (event.us == last and count > most):
                return
            yield event

    return Events(until)


WITHIN = 180.0
"""Seconds for one replay: several times what an hour of a busy session takes."""
_NICE = 5  # a run that somebody watches comes first
_TASK = f"{__name__}.replay_as_account"


class Stopped(SheetsError):
    """Error of a replay that nobody wants any more."""


def replay_apart(
    trace: Path,
    other: Path | None,
    told: Callable[[float], None],
    stopped: Callable[[], bool] = lambda: False,
    within: float = WITHIN,
) -> dict[str, Any]:
    """Replay a run in a worker process; return the account of :func:`rrp_sheets.replay.output.account`.

    A server replays in this way, as it never evaluates untrusted formulas itself.

    Args:
        trace: a run's folder.
        other: the workbook to play instead of the one that ran.
        told: called with the progress, from 0 to 1.
        stopped: polled; the process is ended when it returns True.
        within: seconds for all of it.

    Raises:
        UnreadableFile: when the trace or a workbook cannot be read.
        Stopped: when it was stopped.
        SheetsError: when it cannot be replayed, needs too much memory or too long.
    """

    def listen(part: float | None) -> None:
        if stopped():
            worker.kill()
            raise Stopped(N_("The replay was stopped."), N_("Replay it again."))
        if part is not None:
            told(part)

    worker = WorkerProcess()
    try:
        listen(None)
        return dict(worker.ask([_TASK, str(trace), str(other or "")], within, listen))
    except WorkerError as none:
        remedy = N_("Try it again.") if none.gone else N_("Replay it by rrp-sheets replay.")
        raise SheetsError(N_("The replay {why}.", why=none.why), remedy) from None
    finally:
        worker.close(0.5)


def replay_as_account(trace: str, other: str, report_progress: Callable[[float], None]) -> dict[str, Any]:
    """Replay a run in the worker process; see `replay_apart`."""
    from rrp_sheets.replay.output import account

    if hasattr(os, "nice"):
        os.nice(_NICE)
    return account(replay(Path(trace), Path(other) if other else None, report_progress))
