"""Tables of the events of runs as .csv and .xlsx files, stamped with their origin; and the comparison of two runs.

A comment above a CSV's header breaks most programs that read it, and a file beside it gets lost when the table is
mailed; so every row of a CSV says in its columns which run, workbook and session it comes from.
"""

from __future__ import annotations

import csv
import os
import zipfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rrp_sheets.errors import SheetsError
from rrp_sheets.model.names import key
from rrp_sheets.model.run_files import PROGRAM, RecordedEvent, RecordedFailure, RecordedValue, Stamp
from rrp_sheets.recording.metadata import stamp_of
from rrp_sheets.recording.tidy import Tidy, tidy_table
from rrp_sheets.recording.timeline import build_timeline
from rrp_sheets.recording.trace_reader import TraceReader, text_of
from rrp_sheets.render.plots import Curve, draw_plots
from rrp_sheets.render.texts import texts
from rrp_sheets.texts import N_
from rrp_sheets.workbook.atomic import refuse_open_file
from rrp_sheets.workbook.package import BROKEN_ZIP
from rrp_sheets.workbook.table import MoreSheet, write_table

_FORMULA_STARTS = ("=", "+", "-", "@", "\t", "\r")
_RUN_WIDTHS = (28, 24, 68, 18, 11, 8, 14, 14, 14, 30, 10, 10)
_MOST_STREAMS = 5_000
_ABOUT = (b"About this run", b"About these runs")  # the sheet that every table of ours has
_STAMPED = (Stamp.columns()[2], Stamp.names()[2])  # the column that every CSV of ours has; before version 0.3
_SHEETS = "xl/workbook.xml"
_MOST = 1_000_000  # bytes; more is no list of sheets of ours, nor a header


def write_csv(traces: Sequence[Path], target: Path) -> None:
    """Write the events of runs as CSV (UTF-8 with a mark at its begin, which Excel needs); whole or not at all.

    Raises:
        UnreadableFile: when one of them is no trace.
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
    """Write the events of runs as .xlsx, with a sheet about the runs and one about their streams.

    Raises:
        UnreadableFile: when one of them is no trace.
    """
    table = tidy_table(traces)
    one = len(traces) == 1
    more = [about_runs(table.stamps), _streams(table, one)]
    write_table(
        target, "run" if one else "runs", table.header, table.rows, table.widths, more, properties_of(table.stamps),
        table.count,
    )  # fmt: skip


def about_runs(stamps: Sequence[Stamp]) -> MoreSheet:
    """Make the sheet that says which runs a table is of."""
    if len(stamps) == 1:
        told: dict[str, Any] = dict(stamps[0].pairs())
        if "Seed" in told:
            told["Seed"] = stamps[0].row()["seed"]
        return MoreSheet("About this run", ("What", "Value"), [list(p) for p in told.items()], (20, 72))
    return MoreSheet("About these runs", Stamp.columns(), [list(s.row().values()) for s in stamps], _RUN_WIDTHS)


def _streams(table: Tidy, one: bool) -> MoreSheet:
    """Make the sheet of the streams and the units of their fields: the key to the columns."""
    header, widths = ["stream", "kind", "device", "units"], [28.0, 12.0, 20.0, 60.0]
    rows: list[list[Any]] = []
    for stamp, streams in zip(table.stamps, table.streams, strict=True):
        rows += [[*([] if one else [stamp.run]), *stream] for stream in streams]
    return MoreSheet("Streams", header if one else ["run", *header], rows, widths if one else [28.0, *widths])


def properties_of(stamps: Sequence[Stamp]) -> dict[str, str]:
    """Return the document properties of a table's file."""
    lines = " | ".join(s.line() for s in stamps)
    first = stamps[0]
    title = f"Run {first.run} of {first.workbook}" if len(stamps) == 1 else f"{len(stamps)} runs"
    return {"title": title, "subject": lines, "description": lines, "keywords": first.digest, "creator": PROGRAM}


def csv_cell(value: Any) -> Any:
    """Return a cell of CSV; a text that a spreadsheet would take for a formula is marked as text.

    >>> csv_cell("=HYPERLINK(1)"), csv_cell(-1.5), csv_cell(True)
    ("'=HYPERLINK(1)", -1.5, 'TRUE')
    """
    if isinstance(value, bool):
        return "TRUE" if value else "FALSE"
    return f"'{value}" if isinstance(value, str) and value.startswith(_FORMULA_STARTS) else value


@dataclass
class Seen:
    """Number of values of a stream, and the times of the first and the last (s)."""

    name: str
    kind: str
    count: int = 0
    first: float | None = None
    last: float | None = None


def pair(first: Path, second: Path) -> dict[str, Any]:
    """Compare two runs, as JSON: `streams` with the counts and first times of both, and `svg`, blank without numbers.

    Args:
        first: the folder of a run.
        second: that of another.

    Raises:
        UnreadableFile: when one of them is no record of a run.
    """
    left, right = streams_of(first), streams_of(second)
    names = list(dict.fromkeys([*left, *right]))
    return {
        "streams": [_both(left.get(n), right.get(n)) for n in names],
        "svg": _overlaid(first, second),
    }


def streams_of(place: Path) -> dict[str, Seen]:
    """Return the streams of a run by key, in the order of its record; errors of a row are one more, `row: error`."""
    reader = TraceReader(place)
    streams = [(text_of(stream.name), stream.kind) for stream in reader.header.streams]
    found = {key(name): Seen(name, kind) for name, kind in streams}
    for event in reader:
        _note(found, event)
    return found


def _note(found: dict[str, Seen], event: RecordedEvent) -> None:
    if isinstance(event, RecordedFailure):
        name, kind = f"{text_of(event.row)}: error", event.kind
    elif isinstance(event, RecordedValue):
        name, kind = text_of(event.stream), "stream"
    else:
        return
    seen = found.get(key(name))
    if seen is None:
        if len(found) >= _MOST_STREAMS:
            return
        seen = found[key(name)] = Seen(name, kind)
    seen.count += 1
    seen.last = event.t
    if seen.first is None:
        seen.first = event.t


def _both(left: Seen | None, right: Seen | None) -> dict[str, Any]:
    known = left or right
    assert known is not None
    return {
        "name": known.name, "kind": known.kind,
        "counts": [s.count if s else None for s in (left, right)],
        "firsts": [s.first if s else None for s in (left, right)],
    }  # fmt: skip


def _overlaid(first: Path, second: Path) -> str:
    """Draw the numbers of both runs over each other; those that both have come first."""
    told = [build_timeline(first), build_timeline(second)]
    curves = [{key(c["name"]): c for c in one["curves"]} for one in told]
    names = sorted(dict.fromkeys([*curves[0], *curves[1]]), key=lambda n: (n not in curves[0]) + (n not in curves[1]))
    if not names:
        return ""
    drawn = [_curve(curves[0].get(name), curves[1].get(name)) for name in names]
    stamps = [stamp_of(first), stamp_of(second)]
    foot = "\n".join(stamp.line() for stamp in stamps)
    seconds = max(float(one["seconds"]) for one in told)
    language = stamps[0].language
    say = texts(language)
    legend = (say.get("plots.first"), say.get("plots.second"))
    return draw_plots(say.get("plots.both"), drawn, [], seconds, foot=foot, legend=legend, language=language)[0]


def _curve(left: dict[str, Any] | None, right: dict[str, Any] | None) -> Curve:
    known: Any = left or right
    return Curve(
        known["name"], known["kind"], known["unit"], _points(left), left["count"] if left else 0, _points(right)
    )


def _points(curve: dict[str, Any] | None) -> Sequence[tuple[float, float]]:
    return [(t, v) for t, v in curve["points"]] if curve else []


def refuse_other_table(target: Path) -> None:
    """Raise SheetsError when `target` is an .xlsx or .csv that is there and was not exported from runs, or is open."""
    refuse_open_file(target)
    ours = {".xlsx": _ours_xlsx, ".csv": _ours_csv}.get(target.suffix.casefold())
    try:
        if ours is None or not target.is_file() or not target.stat().st_size or ours(target):
            return
    except OSError as error:
        raise SheetsError(
            N_("“{path}” cannot be written ({reason}).", path=target, reason=error.strerror), N_("Name another file.")
        ) from None
    raise SheetsError(
        N_("“{path}” is there already and is no table of a run; it was left as it is.", path=target),
        N_("Give the file another name."),
    )


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
