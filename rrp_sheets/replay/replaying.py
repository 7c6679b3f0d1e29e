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
from rrp_sheets.replay.play import Ends, ReplayPlayer, Told
from rrp_sheets.replay.record import Events, Recorded, read_record
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
    try:
        ran = the_one_that_ran(recorded)
    except SheetsError:
        if other is None:
            raise
        ran = None
    if other is not None:
        source = another(other, recorded, ran)
        if source.reading.digest != recorded.header.text("workbook"):
            return _otherwise(recorded, ran, source, told)
        return _exactly(recorded, source, told)
    if ran is None:
        words = N_(
            "The workbook of the run is not next to “{trace}” ({file}).", trace=recorded.path.name, file=WORKBOOK
        )
        name = recorded.header.text("name") or "FILE.xlsx"
        raise SheetsError(words, N_("Name the run's folder, or the workbook: --with {file}.", file=name))
    return _exactly(recorded, ran, told)


def _exactly(recorded: Recorded, source: ReplaySource, told: Told) -> Replayed:
    """Replay with the same workbook: everything is to be the same."""
    found = itself(source)
    player = ReplayPlayer(recorded, source, found, Editions(source.plan), told=told)
    player.play()
    is_engines = partial(_is_engines, source=source, found=found)
    world: Counter[str] = Counter()  # what the robot and its world did, with how often
    streams: set[str] = set()

    def of_the_engine() -> Iterator[RecordedEvent]:
        """Give what the engine recorded, and count the rest."""
        world.clear()
        for event in recorded.played:
            if isinstance(event, RecordedValue):
                streams.add(event.stream)
            if isinstance(event, (RecordedValue, RecordedFailure)) or is_engines(event):
                yield event
            elif isinstance(event, RecordedNotice):
                world[event.kind] += 1

    expected = Events(of_the_engine)
    came = Events(lambda: player.events.named(found.names))
    if recorded.ended == "cut":
        came = _as_long(came, expected)
    differences, counts = Comparer(lambda row: row, lambda row: row, exact=True).compare(expected, came)
    notes = [*remarks(recorded, source, own=True), *player.left_out]
    if unread := streams - found.streams.keys():
        notes.append(N_("The workbook has no stream {names}, which the run had.", names=", ".join(sorted(unread))))
    return replace(
        _about(recorded, source, None), compared=sum(c.recorded for c in counts), differences=differences,
        counts=counts, ending=ending(recorded, player), remarks=tuple(notes),
        unknown=tuple(unknown(recorded, world, _cut(recorded))), recorded=expected, came=came,
    )  # fmt: skip


def _otherwise(recorded: Recorded, ran: ReplaySource | None, source: ReplaySource, told: Told) -> Replayed:
    """Replay with another workbook: find what would have been different."""
    found = matching(recorded, ran, source)
    dones = {d: a for d, a in source.plan.dones.items() if a not in source.plan.own}
    ends = Ends(recorded.played, found.streams, dones)
    editions = Editions(source.plan, found.rows, ran.checked.workbook if ran is not None else None)
    player = ReplayPlayer(recorded, source, found, editions, ends, told)
    player.play()
    own = _own(source, found)
    expected = Events(lambda: (e for e in recorded.played if _is_rows(e, own) or _is_engines(e, source, found)))
    named = Events(lambda: player.events.named(found.names))
    came = Events(lambda: (e for e in named if _is_rows(e, own) or isinstance(e, RecordedNotice)))
    back = {there: here for here, there in found.rows.items()}
    ids = {s.ref for s in source.plan.steps}
    differences, counts = Comparer(
        lambda row: there if (there := found.rows.get(row, "")) in ids else "", lambda row: back.get(row, ""),
        exact=False,
    ).compare(expected, came)  # fmt: skip
    notes = [*remarks(recorded, source, own=False), *differing_remarks(ran, source, found), *player.left_out]
    return replace(
        _about(recorded, source, ran), other=source.name, compared=sum(c.recorded for c in counts),
        differences=differences, counts=counts, ending=ending(recorded, player), remarks=tuple(notes),
        unknown=tuple(unknown(recorded, {}, _cut(recorded), ends)), recorded=expected, came=came,
    )  # fmt: skip


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


def _cut(recorded: Recorded) -> str:
    """Return in words what is left out of a run that broke off."""
    if recorded.ended != "broken":
        return ""
    why = recorded.summary.text("why") if recorded.summary else ""
    at = N_("{n:g} s", n=recorded.last_us / 1e6)
    if why:
        return N_(
            "The run stopped unexpectedly at {at}: {message} That last moment is not replayed.", at=at, message=why
        )
    return N_("The run stopped unexpectedly at {at}. That last moment is not replayed.", at=at)


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
    language: str,
    told: Callable[[float], None],
    stopped: Callable[[], bool] = lambda: False,
    within: float = WITHIN,
) -> dict[str, Any]:
    """Replay a run in a worker process; return the :func:`rrp_sheets.replay.output.account` in a language.

    A server replays in this way, as it never evaluates untrusted formulas itself. `stopped` is polled: the process is
    ended when it returns True, or after `within` seconds; for the others see `replay`.

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
        return dict(worker.ask([_TASK, str(trace), str(other or ""), language], within, listen))
    except WorkerError as none:
        remedy = N_("Try it again.") if none.gone else N_("Replay it with rrp-sheets replay.")
        raise SheetsError(N_("The replay {why}.", why=none.why), remedy) from None
    finally:
        worker.close(0.5)


def replay_as_account(
    trace: str, other: str, language: str, report_progress: Callable[[float], None]
) -> dict[str, Any]:
    """Replay a run in the worker process; see `replay_apart`."""
    from rrp_sheets.replay.output import account

    if hasattr(os, "nice"):
        os.nice(_NICE)
    found = replay(Path(trace), Path(other) if other else None, report_progress)
    return account(replace(found, stamp=replace(found.stamp, language=language)))
