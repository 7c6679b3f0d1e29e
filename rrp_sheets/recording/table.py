"""Tables of the events of runs as .csv and .xlsx files: one row per event, one column per attribute.

The table of one run is that in its run.xlsx. In a table of several, the first columns tell the runs apart, so that a
study is one table, in the long form that statistics programs want. Column names are snake_case and differ also when
case is ignored, so that R, SQL and spreadsheets take them as they are. A comment above a CSV's header breaks most
programs that read it, and a file beside it gets lost when the table is mailed; so every row of a CSV says in its
columns which run, workbook and session it comes from.
"""

from __future__ import annotations

import csv
import json
import os
import re
import unicodedata
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from rrp_sheets.diagnostics.report import UnreadableWorkbook
from rrp_sheets.errors import SheetsError
from rrp_sheets.help.recording_columns import COLUMNS, FIELD, MOVEMENTS, explained
from rrp_sheets.model.names import key
from rrp_sheets.model.run_files import PROGRAM, RecordedAction, RecordedEvent, RecordedNotice, RecordedValue, Stamp
from rrp_sheets.recording.metadata import stamp_of
from rrp_sheets.recording.movements import movements
from rrp_sheets.recording.trace_reader import TraceReader
from rrp_sheets.robots import Robot, load_robot, robot_names
from rrp_sheets.robots.own_robot import own_robot
from rrp_sheets.texts import N_, translate
from rrp_sheets.workbook.files import refuse_open_file, unwritable
from rrp_sheets.workbook.table import MoreSheet, write_table
from rrp_sheets.workbook.xlsx import BROKEN_ZIP

_FORMULA_STARTS = ("=", "+", "-", "@", "\t", "\r")
_RUN_WIDTHS = (28, 24, 68, 18, 11, 8, 14, 14, 14, 30, 10, 10)
_ABOUT = (b"About this run", b"About these runs")  # the sheet that every table of ours has
_STAMPED = (Stamp.columns()[2], Stamp.names()[2])  # the column that every CSV of ours has; before version 0.3
_SHEETS = "xl/workbook.xml"
_MOST = 1_000_000  # bytes; more is no list of sheets of ours, nor a header


def write_csv(traces: Sequence[Path], target: Path) -> None:
    """Write the events of runs as CSV (UTF-8 with a mark at its begin, which Excel needs); whole or not at all.

    It raises UnreadableFile when one of them is no trace.
    """
    table = tidy_table(traces, stamped=True)
    half = target.with_name(target.name + ".part")
    try:
        with half.open("w", encoding="utf-8-sig", newline="", errors="replace") as file:
            writer = csv.writer(file)
            writer.writerow([csv_cell(h) for h in table.header])
            writer.writerows([csv_cell(v) for v in row] for row in table.rows)
        os.replace(half, target)
    finally:
        half.unlink(missing_ok=True)


def write_xlsx(traces: Sequence[Path], target: Path) -> None:
    """Write the events of runs as .xlsx, with sheets about the runs, their streams and the columns.

    It raises UnreadableFile when one of them is no trace.
    """
    table = tidy_table(traces)
    more = [_movements(traces, table), about_runs(table.stamps), _streams(table), _column_meanings(table)]
    properties = properties_of(table.stamps)
    name = "run" if len(traces) == 1 else "runs"
    write_table(target, name, table.header, table.rows, table.widths, more, properties, table.count)


def about_runs(stamps: Sequence[Stamp]) -> MoreSheet:
    """Make the sheet that says which runs a table is of."""
    if len(stamps) == 1:
        told: dict[str, Any] = dict(stamps[0].pairs())
        if "Seed" in told:
            told["Seed"] = stamps[0].row()["seed"]
        return MoreSheet("About this run", ("What", "Value"), [list(p) for p in told.items()], (20, 72))
    return MoreSheet("About these runs", Stamp.columns(), [list(s.row().values()) for s in stamps], _RUN_WIDTHS)


def _streams(table: Tidy) -> MoreSheet:
    """Make the sheet of the streams and the units of their fields: the key to the columns."""
    header, widths = ["run", "stream", "kind", "device", "units"], [28.0, 28.0, 12.0, 20.0, 60.0]
    runs = zip(table.stamps, table.streams, strict=True)
    rows = [[stamp.run, *stream] for stamp, streams in runs for stream in streams]
    first = 1 if len(table.stamps) == 1 else 0  # of one run, its name is left out
    return MoreSheet("Streams", header[first:], [row[first:] for row in rows], widths[first:])


def _movements(traces: Sequence[Path], table: Tidy) -> MoreSheet:
    """Make the sheet that says when the robot began and ended to move after each command."""
    rows = []
    for trace, stamp in zip(traces, table.stamps, strict=True):
        reader = TraceReader(trace)
        for one in movements(reader, _robot_of(reader)):
            sent = one.command
            times = [None if t is None else Seconds(t) for t in (one.begin, one.end)]
            response = None if one.begin is None else round(one.begin - sent.t, 3)
            rows.append([stamp.run, Seconds(sent.t), sent.stream, sent.row or None, _plain(sent.value), one.commands,
                         *times, response])  # fmt: skip
    first = 1 if len(traces) == 1 else 0  # of one run, its name is left out
    header = ["run", "time_s", "stream", "row", "value", *MOVEMENTS]
    widths = [28.0, 10.0, 24.0, 16.0, 30.0, *[12.0] * len(MOVEMENTS)]
    return MoreSheet("Movements", header[first:], [row[first:] for row in rows], widths[first:])


def _column_meanings(table: Tidy) -> MoreSheet:
    """Make the sheet that explains the columns, in the language of the first run's workbook."""
    language = table.stamps[0].language
    known = {name: (name, unit, meaning) for name, unit, meaning in explained(language)}
    kinds = [line for name, line in known.items() if name not in COLUMNS]
    field = translate(FIELD, language)
    lines = [known.get(name) or (name, table.units.get(name, ""), field) for name in table.header]
    heads = [translate(text, language) for text in (N_("Column"), N_("Unit"), N_("Meaning"))]
    return MoreSheet("Columns", heads, [*lines, *kinds], (24, 10, 120))


def properties_of(stamps: Sequence[Stamp]) -> dict[str, str]:
    """Return the document properties of a table's file."""
    lines = " | ".join(s.line() for s in stamps)
    first = stamps[0]
    one = N_("Run {run} of {workbook}", run=first.run, workbook=first.workbook)
    title = translate(one if len(stamps) == 1 else N_("{n} runs", n=len(stamps)), first.language)
    return {"title": title, "subject": lines, "description": lines, "keywords": first.digest, "creator": PROGRAM}


def csv_cell(value: Any) -> Any:
    """Return a cell of CSV; a text that a spreadsheet would take for a formula is marked as text.

    >>> csv_cell("=HYPERLINK(1)"), csv_cell(-1.5), csv_cell(True)
    ("'=HYPERLINK(1)", -1.5, 'TRUE')
    """
    if isinstance(value, bool):
        return "TRUE" if value else "FALSE"
    return f"'{value}" if isinstance(value, str) and value.startswith(_FORMULA_STARTS) else value


def refuse_other_table(target: Path) -> None:
    """Raise SheetsError when `target` is an .xlsx or .csv that is there and was not exported from runs, or is open."""
    refuse_open_file(target)
    ours = {".xlsx": _ours_xlsx, ".csv": _ours_csv}.get(target.suffix.casefold())
    try:
        if ours is None or not target.is_file() or not target.stat().st_size or ours(target):
            return
    except OSError as error:
        raise unwritable(target, error) from None
    message = N_("“{path}” already exists and is not a table of a run, so it was not changed.", path=target)
    raise SheetsError(message, N_("Give the file another name."))


def _ours_xlsx(path: Path) -> bool:
    try:
        with zipfile.ZipFile(path) as package, package.open(_SHEETS) as part:
            sheets = part.read(_MOST)
    except OSError:
        raise  # told by whoever asks: the file itself cannot be read
    except (*BROKEN_ZIP, KeyError):
        return False
    return any(about in sheets for about in _ABOUT)


def _ours_csv(path: Path) -> bool:
    with path.open(encoding="utf-8-sig", errors="replace") as file:
        header = file.readline(_MOST)
        return any(name in header for name in _STAMPED)


class Seconds(float):
    """A time, which a CSV shows to the microsecond.

    >>> str(Seconds(0.5)), Seconds(0.5) == 0.5
    ('0.500000', True)
    """

    def __str__(self) -> str:
        return f"{float(self):.6f}"


SENT = "sent by hand"  # the kind of a value that somebody sent into a sensor stream
TELL_APART = ("run", "participant", "condition")
_MOST_FIELDS = 500  # columns of a table: more is no record of ours
_FIRST = ("time_s", "kind", "stream", "row", "value", "message", "blank")
_WIDTHS = (10.0, 11.0, 24.0, 16.0, 18.0, 40.0, 14.0)
_BY = "by"
_R_WORDS = frozenset(("if", "else", "repeat", "while", "function", "for", "next", "break", "in"))
"""Words that R does not take as a column's name (`?Reserved`), as far as they are written small."""


class _Look:
    """Facts about the columns of a trace, from one pass over it."""

    def __init__(self, reader: TraceReader) -> None:
        units, streams = units_of(reader), reader.header.streams
        self._reader = reader
        self._printing = {s.name for s in streams if s.device == "Print"}
        self.kinds = {s.name: s.kind for s in streams}
        self.streams = [[s.name, s.kind, s.device, _units_told(units.get(s.name, {}))] for s in streams]
        self.fields: dict[str, set[str]] = {}  # with the units that they have
        self.together: set[str] = set()  # fields of one record that are spelt nearly alike
        self.people = False
        self.count = 0
        for event in self.events():
            self.count += 1
            sent = isinstance(event, RecordedValue) and event.by is not None
            self.people = self.people or sent or isinstance(event, RecordedAction)
            if isinstance(event, RecordedValue) and isinstance(event.value, dict):
                self._take_fields(event.value, units.get(event.stream, {}))

    def _take_fields(self, record: Mapping[str, Any], units: Mapping[str, str]) -> None:
        stems = [snake_case(name) for name in record] if len(record) <= _MOST_FIELDS else []
        if len(set(stems)) < len(stems):
            self.together.update(n for n, stem in zip(record, stems, strict=True) if stems.count(stem) > 1)
        for name in record:
            if len(self.fields) < _MOST_FIELDS or name in self.fields:
                self.fields.setdefault(name, set()).add(units.get(key(name), ""))

    def events(self) -> Iterator[RecordedEvent]:
        """Yield the events; without the notes with which the world repeats what another one has sent to Print."""
        for event in self._reader:
            is_note = isinstance(event, RecordedNotice) and event.kind == "note"
            if not (is_note and event.stream in self._printing):
                yield event


@dataclass(frozen=True)
class Tidy:
    """A table of events."""

    header: list[str]
    rows: Iterator[list[Any]]  # read while they are written; a table can be made once
    widths: list[float]  # of the columns, in characters
    stamps: list[Stamp]  # one for each run
    streams: list[list[list[str]]]  # of each run: name, kind, device, and units per field, `distance: m`
    count: int  # of the rows
    units: Mapping[str, str]  # of the columns that are fields


def tidy_table(traces: Sequence[Path], *, stamped: bool = False) -> Tidy:
    """Return the events of some runs as one table.

    A record's fields stand in columns of their own (with their unit, where all devices that have it agree), so that a
    plain value is always in the column `value`; lists and records within records are JSON. The column `blank` names the
    columns in which a blank came; a cell without anything means that nothing came. Runs in which people did something
    have a column more, which says who.

    Args:
        traces: each a trace.jsonl.
        stamped: whether every row says which run it comes from; a table of several runs says so in any case.

    Raises:
        UnreadableFile: when one of them is no trace.
    """
    readers = [TraceReader(trace) for trace in traces]
    looks = [_Look(reader) for reader in readers]
    people = any(look.people for look in looks)
    stamps = [stamp_of(trace.parent) for trace in traces]
    apart = list(TELL_APART) if len(traces) > 1 else []
    behind = [name for name in Stamp.columns() if name not in apart and (stamped or name in ("ended", "complete"))]
    fixed = [*apart, *_FIRST, *([_BY] if people else [])]
    columns, units = _columns(looks, [*fixed, *Stamp.columns(), _BY])
    headers = list(units)
    header = [*fixed, *headers, *behind]
    widths = [*[18.0] * len(apart), *_WIDTHS, *[12.0] * (people + len(headers) + len(behind))]

    def rows() -> Iterator[list[Any]]:
        for look, stamp in zip(looks, stamps, strict=True):
            told = stamp.row()
            before, after = [told[n] for n in apart], [told[n] for n in behind]
            for row in _rows(look, columns, headers, people):
                yield [*before, *row, *after]

    streams, count = [look.streams for look in looks], sum(look.count for look in looks)
    return Tidy(header, rows(), widths, stamps, streams, count, units)


def _columns(looks: Sequence[_Look], taken: Sequence[str]) -> tuple[dict[str, int], dict[str, str]]:
    """Return the column of each field, and the columns' names with their units.

    Fields that differ only in their spelling (`Zone`, `zone`) share a column, unless one record has both.
    """
    fields: dict[str, set[str]] = {}
    for look in looks:
        for name, units in look.fields.items():
            fields.setdefault(name, set()).update(units)
    apart = {name for look in looks for name in look.together}
    columns: dict[str, int] = {}
    places: dict[str, int] = {}
    found: list[tuple[str, set[str]]] = []  # the name of each column, and the units of its fields
    for name, units in fields.items():
        stem = snake_case(name)
        place = len(found) if name in apart else places.setdefault(stem, len(found))
        if place == len(found):
            found.append((stem, set()))
        found[place][1].update(units)
        columns[name] = place
    fixed = {name.casefold() for name in taken}
    headers: dict[str, str] = {}
    for stem, units in found:
        known = units - {""}  # what rows make has no unit of its own
        name = snake_case(f"{stem} {next(iter(known))}") if len(known) == 1 else stem
        if name in fixed:
            name = f"field_{name}"
        number, first = 2, name
        while name in headers or name in fixed:
            name, number = f"{first}_{number}", number + 1
        headers[name] = next(iter(known)) if len(known) == 1 else ""
    return columns, headers


@lru_cache(maxsize=1_000)
def snake_case(name: str) -> str:
    """Convert a name to a column's name that R, SQL and spreadsheets take as it is.

    >>> snake_case("Zone"), snake_case("distance (m)"), snake_case("2nd try"), snake_case("speed m/s"), snake_case("if")
    ('zone', 'distance_m', 'field_2nd_try', 'speed_m_s', 'field_if')
    """
    plain = unicodedata.normalize("NFKC", name).replace("°", " deg ").replace("%", " percent ")
    words = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", plain)  # redBall
    found = "_".join(re.findall(r"[^\W_]+", words)).casefold()
    return found if found[:1].isalpha() and found not in _R_WORDS else f"field_{found}".rstrip("_")


def _units_told(units: Mapping[str, str]) -> str:
    return ", ".join(f"{field}: {unit}" if field else unit for field, unit in units.items() if unit)


def units_of(reader: TraceReader) -> dict[str, dict[str, str]]:
    """Return the units of a trace's sensor and actuator streams, by the key of a field; a plain value's by `""`.

    Streams that rows make have none: a formula does not say what its number means. The robot is that of the run's
    folder, if it has one.
    """
    robot = _robot_of(reader)
    if robot is None:
        return {}
    found: dict[str, dict[str, str]] = {}
    for stream in reader.header.streams:
        device = robot.devices.get(key(stream.device))
        if device is not None:
            fields = {key(f.name): f.unit for f in device.payload.fields} if device.payload else {}
            found[stream.name] = {"": device.unit, **fields}
    return found


def _robot_of(reader: TraceReader) -> Robot | None:
    name = reader.header.text("robot")
    with suppress(UnreadableWorkbook):
        return own_robot(reader.path.parent, name) or (load_robot(name) if name in robot_names() else None)
    return None


def _rows(look: _Look, columns: Mapping[str, int], headers: Sequence[str], people: bool) -> Iterator[list[Any]]:
    for event in look.events():
        plain: Any = None
        cells: list[Any] = [None] * len(headers)
        blank: list[str] = []
        if isinstance(event, RecordedValue):
            value, message, by = event.value, None, event.by
            kind = look.kinds.get(event.stream, "stream") if by is None else SENT
            blank = ["value"] if value is None else []
            if isinstance(value, dict) and value:
                for name, part in value.items():
                    place = columns.get(name)
                    if place is not None:
                        cells[place] = _plain(part)
                        blank += [headers[place]] if part is None else []
            else:
                plain = _plain(value)
        else:
            kind, message, by = event.kind, event.text, event.by if isinstance(event, RecordedAction) else None
        first = [Seconds(event.t), kind, event.stream or None, event.row or None, plain, message or None]
        yield [*first, ", ".join(blank) or None, *([by or None] if people else []), *cells]


def _plain(value: Any) -> Any:
    return json.dumps(value, ensure_ascii=False) if isinstance(value, (list, dict)) else value
