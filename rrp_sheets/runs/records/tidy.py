"""The records of runs as a tidy table: one row per event, one column per thing that is told of it.

One run is what its run.xlsx has. Of several runs, what tells them apart stands in the first columns, so that a study
is one table, in the long form that statistics programs want.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rrp_sheets.devices import load_robot, robot_names
from rrp_sheets.errors import UnreadableFile
from rrp_sheets.model.names import key
from rrp_sheets.model.stamp import Stamp
from rrp_sheets.runs.records.facts import text_of
from rrp_sheets.runs.records.stamp import stamp_of
from rrp_sheets.runtime.trace import read_trace

SENT = "sent by hand"  # the kind of a value that somebody sent into a sensor stream
TRACE = "trace.jsonl"
TELL_APART = ("Run", "Participant", "Condition")
_MOST_FIELDS = 500  # columns of a table: more is no record of ours
_FIRST = ("Time (s)", "Kind", "Stream", "Row", "Value", "Message")
_WIDTHS = (10.0, 11.0, 24.0, 16.0, 18.0, 40.0)


@dataclass(frozen=True)
class StreamLine:
    """A stream of a run, for the table of streams: units are per field, `distance: m`."""

    name: str
    kind: str
    device: str
    units: str


@dataclass
class _Look:
    """What one pass over a trace tells of its columns."""

    kinds: dict[str, str] = field(default_factory=dict)
    fields: dict[str, set[str]] = field(default_factory=dict)  # with the units that they have
    people: bool = False
    count: int = 0
    streams: list[StreamLine] = field(default_factory=list)


@dataclass(frozen=True)
class Tidy:
    """A table of events.

    Attributes:
        rows: read while they are written; a table can be made once.
        widths: of the columns, in characters.
        stamps: one for each run.
        streams: of each run.
        count: how many rows there are.
    """

    header: list[str]
    rows: Iterator[list[Any]]
    widths: list[float]
    stamps: list[Stamp]
    streams: list[tuple[StreamLine, ...]]
    count: int


def tidy(trace: Path) -> tuple[list[str], Iterator[list[Any]], list[float]]:
    """A trace as a tidy table: header, rows (one per event), column widths."""
    table = tidy_table([trace])
    return table.header, table.rows, table.widths


def tidy_table(traces: Sequence[Path], *, stamped: bool = False) -> Tidy:
    """The events of some runs as one table.

    A record's fields stand in columns of their own (with their unit, where all devices that have it agree), so that a
    plain value is always in the column Value. Runs in which people did something have a column more, which says who.

    Args:
        traces: each a trace.jsonl.
        stamped: whether every row says which run it comes from; a table of several runs says so in any case.

    Raises:
        UnreadableFile: when one of them is no trace.
    """
    looks = [_look(trace) for trace in traces]
    fields: dict[str, set[str]] = {}
    for look in looks:
        for name, units in look.fields.items():
            fields.setdefault(name, set()).update(units)
    people = any(look.people for look in looks)
    stamps = [stamp_of(trace.parent) for trace in traces]
    apart = list(TELL_APART) if len(traces) > 1 else []
    behind = [name for name in Stamp.names() if name not in apart] if stamped else []
    names = list(fields)
    header = [*apart, *_FIRST, *(["By"] if people else []), *(_headed(n, fields[n]) for n in names), *behind]
    widths = [*[18.0] * len(apart), *_WIDTHS, *[12.0] * (people + len(names) + len(behind))]

    def rows() -> Iterator[list[Any]]:
        for trace, look, stamp in zip(traces, looks, stamps, strict=True):
            told = dict(zip(Stamp.names(), stamp.values(), strict=True))
            before, after = [told[n] or None for n in apart], [told[n] or None for n in behind]
            for row in _rows(trace, look.kinds, names, people):
                yield [*before, *row, *after]

    return Tidy(
        header, rows(), widths, stamps, [tuple(look.streams) for look in looks], sum(look.count for look in looks)
    )


def _headed(name: str, units: set[str]) -> str:
    known = units - {""}  # what rows make has no unit of its own
    unit = next(iter(known)) if len(known) == 1 else ""
    return f"{name} ({unit})" if unit else name


def _look(trace: Path) -> _Look:
    found = _Look()
    units: Mapping[str, Mapping[str, str]] = {}
    try:
        for line in read_trace(trace):
            if line.get("type") == "header":
                found.kinds = {s["stream"]: s["kind"] for s in line["streams"]}
                units = units_of(line)
                found.streams = [_stream_line(s, units) for s in line["streams"]]
            found.count += "type" not in line
            value = line.get("value")
            if isinstance(value, dict):
                known = units.get(text_of(line.get("stream")), {})
                for name in value:
                    if len(found.fields) < _MOST_FIELDS or name in found.fields:
                        found.fields.setdefault(name, set()).add(known.get(key(name), ""))
            found.people = found.people or ("by" in line and "type" not in line)
    except (AttributeError, KeyError, TypeError, ValueError, RecursionError):
        raise unreadable(trace) from None
    return found


def unreadable(trace: Path) -> UnreadableFile:
    """The error of a trace that has not the form of one."""
    return UnreadableFile("FILE001", f"“{trace.parent.name}” is not a record of a run.", "Copy its folder again.")


def _stream_line(stream: Mapping[str, Any], units: Mapping[str, Mapping[str, str]]) -> StreamLine:
    name = text_of(stream.get("stream"))
    told = ", ".join(f"{field}: {unit}" if field else unit for field, unit in units.get(name, {}).items() if unit)
    return StreamLine(name, text_of(stream.get("kind")), text_of(stream.get("device")), told)


def units_of(header: Mapping[str, Any]) -> dict[str, dict[str, str]]:
    """The units of the sensor and actuator streams of a trace, by the key of a field; a plain value's by `""`.

    Streams that rows make have none: a formula does not say what its number means.
    """
    robot = text_of(header.get("robot"))
    if robot not in robot_names():
        return {}
    devices = load_robot(robot).devices
    found: dict[str, dict[str, str]] = {}
    for stream in header.get("streams") or ():
        device = devices.get(key(text_of(stream.get("device")))) if isinstance(stream, dict) else None
        if device is None:
            continue
        fields = {key(f.name): f.unit for f in device.payload.fields} if device.payload else {}
        found[text_of(stream.get("stream"))] = {"": device.unit, **fields}
    return found


def _rows(trace: Path, kinds: dict[str, str], fields: list[str], people: bool) -> Iterator[list[Any]]:
    for line in read_trace(trace):
        if "type" in line:
            continue
        value = line.get("value")
        record = value if isinstance(value, dict) else {}
        message = line.get("error") or line.get("text")
        plain = None if record else _plain(value)
        row = [line["t"], _kind(line, kinds), line.get("stream"), line.get("row") or None, plain, message]
        by = [line.get("by") or None] if people else []
        yield [*row, *by, *(_plain(record.get(f)) for f in fields)]


def _kind(line: dict[str, Any], kinds: dict[str, str]) -> str:
    if line.get("stimulated"):
        return SENT
    return "error" if "error" in line else line.get("happening") or kinds.get(line.get("stream", ""), "stream")


def _plain(value: Any) -> Any:
    if isinstance(value, bool):
        return value
    if isinstance(value, (list, dict)):
        return str(value)
    return value
