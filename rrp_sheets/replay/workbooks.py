"""Workbooks of a replay: the copy beside the trace or another one, its plan, and its matching with the record."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

from rrp_sheets import __version__
from rrp_sheets.checks import Checked
from rrp_sheets.checks.protocol import RunPlan
from rrp_sheets.compare.match import match
from rrp_sheets.compare.side import Side, open_checked
from rrp_sheets.engine.plan import Plan, make_plan
from rrp_sheets.engine.trace import stream_label
from rrp_sheets.errors import SheetsError, UnreadableFile
from rrp_sheets.graph import StreamKind
from rrp_sheets.model.names import key
from rrp_sheets.model.run_files import WORKBOOK
from rrp_sheets.replay.record import Recorded
from rrp_sheets.replay.report import in_words
from rrp_sheets.texts import N_, listed
from rrp_sheets.workbook import Reading


@dataclass(frozen=True)
class ReplaySource:
    """A workbook without errors, which can be played; `name` is that of its file, for people."""

    name: str
    reading: Reading
    checked: Checked
    plan: Plan

    @property
    def labels(self) -> dict[str, str]:
        """Names of the streams as traces have them, by their ids."""
        return {s.id: stream_label(s) for s in self.plan.streams}


def the_one_that_ran(recorded: Recorded) -> ReplaySource | None:
    """Read the workbook of the run's folder; return None when it is not there.

    Raises UnreadableFile when it cannot be read, SheetsError when it has errors now.
    """
    path = recorded.path.with_name(WORKBOOK)
    if not path.is_file():
        return None
    try:
        reading, checked = open_checked(path)
    except UnreadableFile as error:
        raise UnreadableFile(
            error.code,
            N_("The workbook of this run, “{name}”, cannot be read: {message}", name=path.name, message=error.message),
            N_("Copy the run's folder again, or name the workbook: --with FILE."),
        ) from None
    if checked.report.errors:
        message, program = checked.report.errors[0].message, recorded.header.text("program")
        words = N_("The workbook of this run has errors for this version of the program ({version}): {message}")
        remedy = N_("Replay it with the version that recorded it ({program}), or use --with and a corrected "
                    "workbook.", program=program)  # fmt: skip
        raise SheetsError(N_(words, version=__version__, message=message), remedy)
    name = recorded.header.text("name") or path.name
    return ReplaySource(name, reading, checked, _plan(checked, recorded))


def another(path: Path, recorded: Recorded, like: ReplaySource | None) -> ReplaySource:
    """Read another workbook, to be played with a record.

    Raises UnreadableFile when it cannot be read, SheetsError when it has errors.
    """
    reading, checked = open_checked(path)
    if checked.report.errors:
        first = checked.report.errors[0]
        words = N_("“{name}” has errors and cannot run: {message}")
        if first.address:
            words = N_("“{name}” has errors and cannot run ({address}): {message}")
        raise SheetsError(
            N_(words, name=path.name, address=str(first.address or ""), message=first.message),
            N_("See `rrp-sheets check`, fix them, and replay again."),
        )
    plan = _plan(checked, recorded) if like is None else make_plan(checked, everything=like.plan.everything)
    if not plan.steps:
        words = N_("No row of “{name}” is switched on.", name=path.name)
        raise SheetsError(words, N_("Write TRUE in the On cells of some rows."))
    return ReplaySource(path.name, reading, checked, plan)


def _plan(checked: Checked, recorded: Recorded) -> Plan:
    """Return the plan whose streams are those of the record: of two that fit, the one where more can be switched on."""
    whole = make_plan(checked, everything=True)
    fits = {stream_label(s) for s in whole.streams} == set(recorded.streams)
    return whole if fits else make_plan(checked)


def remarks(recorded: Recorded, source: ReplaySource, *, own: bool) -> list[str]:
    """Return in words what to know of a record and the workbook it is replayed with, before anything is compared."""
    found: list[str] = []
    program = recorded.header.text("program") or N_("unknown")
    if program != __version__:
        words = N_("The run was recorded with version {program} of the program and is replayed with {version}.")
        found.append(N_(words, program=program, version=__version__))
    digest = recorded.header.text("workbook")
    was_xlsx = recorded.header.text("name").casefold().endswith(".xlsx")
    if own and digest != source.reading.digest and was_xlsx:
        words = N_("The copy of the workbook next to the recording is not the one that ran (SHA-256 {own}… instead "
                   "of {ran}…).")  # fmt: skip
        found.append(N_(words, own=source.reading.digest[:12], ran=digest[:12]))
    changed = []
    for name in ("robot.toml", "gestures.toml") if own else ():
        kept, now = recorded.place / name, source.checked.robot.folder / name
        with suppress(OSError):
            if kept.is_file() and now.is_file() and kept.read_bytes() != now.read_bytes():
                changed.append(name)
    if changed:
        words = N_("The robot's catalogue ({changed}) has changed since the run. The current one is used.")
        found.append(N_(words, changed=", ".join(changed)))
    return found


_FED = (StreamKind.SENSOR, StreamKind.DONE)


@dataclass(frozen=True)
class Matching:
    """Streams, rows and behaviours of a workbook that correspond to those of a record.

    Attributes:
        streams: ids of streams of the workbook that is played, by their names in the record.
        names: the record's names of streams, by those ids; what the record does not have is called as in the workbook.
        rows: places of rows in the workbook that is played, by those in the one that ran.
        behaviours: the same for behaviours, by key.
    """

    streams: Mapping[str, str]
    names: Mapping[str, str]
    rows: Mapping[str, str] = field(default_factory=dict)
    behaviours: Mapping[str, str] = field(default_factory=dict)


def itself(source: ReplaySource) -> Matching:
    """Match a workbook with the record of its own run: every stream with itself."""
    return Matching({label: i for i, label in source.labels.items()}, source.labels)


def matching(recorded: Recorded, ran: ReplaySource | None, other: ReplaySource) -> Matching:
    """Match streams, rows and behaviours of another workbook with the record's; without what ran, by names alone."""
    labels = other.labels
    if ran is None:
        by_name = {key(label): i for i, label in labels.items()}
        streams = {name: by_name[key(name)] for name in recorded.streams if key(name) in by_name}
        rows = {s.ref: s.ref for s in other.plan.steps}
        return Matching(streams, _names(streams, labels), rows)
    first, second = Side(ran.reading, ran.checked), Side(other.reading, other.checked)
    found = match(first, second)
    streams = {label: there for i, label in ran.labels.items() if (there := found.streams.of(i)) and there in labels}
    rows, behaviours = {}, {}
    for (a, b), pairs in found.rows.items():
        mine, theirs = first.behaviours[a], second.behaviours[b]
        behaviours[mine.key] = theirs.key
        for i, j in pairs.to.items():
            rows[f"{mine.name}!{mine.rows[i].row.number}"] = f"{theirs.name}!{theirs.rows[j].row.number}"
    return Matching(streams, _names(streams, labels), rows, behaviours)


def _names(streams: Mapping[str, str], labels: Mapping[str, str]) -> dict[str, str]:
    return {**labels, **{i: name for name, i in streams.items()}}


def differing_remarks(ran: ReplaySource | None, other: ReplaySource, found: Matching) -> list[str]:
    """Return in words what to know of the two workbooks before they are compared in a session."""
    told: list[str] = []
    if ran is None:
        told.append(
            N_("The workbook of the run is not next to the recording, so streams are identified by their names alone.")
        )
    else:
        was, now = ran.checked.run, other.checked.run
        if was.engine != now.engine or (now.engine == "frame" and was.frame_rate != now.frame_rate):
            words = N_("The engine is different ({value} → {value2}), so times can differ by one frame.")
            told.append(N_(words, value=_engine(was), value2=_engine(now)))
        told += _settings(ran, other, found)
        if ran.checked.scene != other.checked.scene and ran.reading.workbook.scene != other.reading.workbook.scene:
            told.append(N_("Its Scene is different, but the sensor values are those of the recording."))
    own, dones = other.plan.own, other.plan.dones
    known = own.union(found.streams.values())
    for stream in other.plan.streams:
        if stream.kind in _FED and stream.id not in known and dones.get(stream.id, "") not in own:
            rows = [in_words(s.ref) for s in other.plan.steps if stream.id in s.inputs]
            if rows:  # else a row that is switched off, or something else of the workbook, names it
                get = N_("{row} gets", row=rows[0]) if len(rows) == 1 else N_("{rows} get", rows=listed(rows))
                words = N_("The session has no recording of “{name}”, so {rows} no value from it.")
                told.append(N_(words, name=stream.name, rows=get))
    return told


def _engine(run: RunPlan) -> str:
    if run.engine != "frame":
        return run.engine
    return N_("{engine}, {rate} frames a second", engine=run.engine, rate=run.frame_rate)


def _settings(ran: ReplaySource, other: ReplaySource, found: Matching) -> list[str]:
    """Return remarks on sensors that are set otherwise now, as the record has what they gave then."""
    ids = {label: i for i, label in ran.labels.items()}
    was = {u.stream: u for u in ran.plan.outer_sensors}
    now = {u.stream: u for u in other.plan.outer_sensors}
    told: list[str] = []
    for label, there in found.streams.items():
        a, b = was.get(ids[label]), now.get(there)
        if a and b and (a.device, dict(a.settings)) != (b.device, dict(b.settings)):
            words = N_("“{name}” is another device or has other settings. Its values are the recorded ones.")
            told.append(N_(words, name=b.name))
    return told
