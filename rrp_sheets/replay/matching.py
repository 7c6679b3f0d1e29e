"""Matching of the streams and rows of another workbook with those of a record."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from rrp_sheets.compare.match import match
from rrp_sheets.compare.side import Side
from rrp_sheets.graph import Stream, StreamKind
from rrp_sheets.model.names import key
from rrp_sheets.replay.record import Recorded
from rrp_sheets.replay.report import in_words
from rrp_sheets.replay.source import ReplaySource
from rrp_sheets.texts import N_, listed

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
    rows: Mapping[str, str]
    behaviours: Mapping[str, str] = field(default_factory=dict)


def itself(source: ReplaySource) -> Matching:
    """Match a workbook with the record of its own run: every stream and row with itself."""
    labels = source.labels
    rows = {s.ref: s.ref for s in source.plan.steps}
    return Matching({label: i for i, label in labels.items()}, labels, rows)


def matching(recorded: Recorded, ran: ReplaySource | None, other: ReplaySource) -> Matching:
    """Match the streams, rows and behaviours of another workbook with those of the record.

    Args:
        recorded: the record.
        ran: the workbook that ran; without it names alone tell.
        other: the workbook that is played.
    """
    labels = other.labels
    if ran is None:
        by_name = {key(label): i for i, label in labels.items()}
        streams = {name: by_name[key(name)] for name in recorded.streams if key(name) in by_name}
        rows = {s.ref: s.ref for s in other.plan.steps}
        return Matching(streams, _names(streams, labels), rows)
    first, second = Side(ran.reading, ran.checked), Side(other.reading, other.checked)
    found = match(first, second)
    streams = {}
    for stream_id, label in ran.labels.items():
        there = found.streams.of(stream_id)
        if there in labels:
            streams[label] = there
    rows, behaviours = {}, {}
    for (a, b), pairs in found.rows.items():
        mine, theirs = first.behaviours[a], second.behaviours[b]
        behaviours[mine.key] = theirs.key
        for i, j in pairs.to.items():
            rows[f"{mine.name}!{mine.rows[i].row.number}"] = f"{theirs.name}!{theirs.rows[j].row.number}"
    return Matching(streams, _names(streams, labels), rows, behaviours)


def _names(streams: Mapping[str, str], labels: Mapping[str, str]) -> dict[str, str]:
    return {**labels, **{i: name for name, i in streams.items()}}


def remarks(ran: ReplaySource | None, other: ReplaySource, found: Matching) -> list[str]:
    """Return in words what to know of the two workbooks before they are compared in a session."""
    told: list[str] = []
    if ran is None:
        told.append(N_("The workbook that ran is not beside the trace: streams are told by their names alone."))
    else:
        was, now = ran.checked.run, other.checked.run
        if was.engine != now.engine or (now.engine == "frame" and was.frame_rate != now.frame_rate):
            words = [
                f"{r.engine}, {r.frame_rate} frames a second" if r.engine == "frame" else r.engine for r in (was, now)
            ]
            told.append(
                N_(
                    "The engine is another one ({value} → {value2}), so times may differ by a frame.",
                    value=words[0],
                    value2=words[1],
                )
            )
        told += _settings(ran, other, found)
        if ran.checked.scene != other.checked.scene and ran.reading.workbook.scene != other.reading.workbook.scene:
            told.append(N_("Its Scene is another one; what the robot sensed is what the record says."))
    known = set(found.streams.values())
    for stream in other.plan.streams:
        if stream.kind in _FED and stream.id not in known and _is_outer(other, stream):
            rows = [s.ref for s in other.plan.steps if stream.id in s.inputs]
            if not rows:  # no row asks for it: a row that is switched off, or something else of the workbook, names it
                continue
            told.append(
                N_(
                    "The session has no record of “{name}”, so {rows} no value of it.",
                    name=stream.name,
                    rows=_rows(rows),
                )
            )
    return told


def _is_outer(source: ReplaySource, stream: Stream) -> bool:
    own = source.plan.own
    return stream.id not in own and source.plan.dones.get(stream.id, "") not in own


def _rows(rows: list[str]) -> str:
    if len(rows) == 1:
        return N_("{row} gets", row=in_words(rows[0]))
    return N_("{rows} get", rows=listed([in_words(row) for row in rows]))


def _settings(ran: ReplaySource, other: ReplaySource, found: Matching) -> list[str]:
    """Return remarks on sensors that are set otherwise now, as the record has what they gave then."""
    ids = {label: i for i, label in ran.labels.items()}
    was = {u.stream: u for u in ran.plan.outer_sensors}
    now = {u.stream: u for u in other.plan.outer_sensors}
    told: list[str] = []
    for label, there in found.streams.items():
        a, b = was.get(ids[label]), now.get(there)
        if a and b and (a.device, dict(a.settings)) != (b.device, dict(b.settings)):
            told.append(
                N_("“{name}” is another device or set otherwise; its values are those that were recorded.", name=b.name)
            )
    return told
