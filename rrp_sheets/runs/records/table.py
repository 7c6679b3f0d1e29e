"""The events of runs as files: .csv for any program that counts, .xlsx as the run's folder has it; both stamped.

A comment above a CSV's header breaks most programs that read it, and a file beside it gets lost when the table is
mailed; so every row of a CSV says in its columns which run, workbook and session it comes from.
"""

from __future__ import annotations

import csv
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rrp_sheets.model.stamp import PROGRAM, Stamp
from rrp_sheets.runs.records.tidy import Tidy, tidy_table, unreadable
from rrp_sheets.workbook.table import MoreSheet, write_table

_FORMULA_STARTS = ("=", "+", "-", "@", "\t", "\r")
_RUN_WIDTHS = (28, 24, 68, 18, 11, 8, 14, 14, 14, 30, 10, 10)


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
            writer.writerow([_cell(h) for h in table.header])
            writer.writerows([_cell(v) for v in row] for row in table.rows)
        os.replace(half, target)
    except (AttributeError, KeyError, TypeError, ValueError, RecursionError):
        raise unreadable(traces[0]) from None
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
    try:
        write_table(
            target, "run" if one else "runs", table.header, table.rows, table.widths, more,
            properties_of(table.stamps), table.count,
        )  # fmt: skip
    except (AttributeError, KeyError, TypeError, ValueError, RecursionError):
        raise unreadable(traces[0]) from None


def about_runs(stamps: Sequence[Stamp]) -> MoreSheet:
    """A sheet that says which runs a table is of."""
    if len(stamps) == 1:
        told: dict[str, Any] = dict(stamps[0].pairs())
        if "Seed" in told:
            told["Seed"] = stamps[0].row()["seed"]
        return MoreSheet("About this run", ("What", "Value"), [list(p) for p in told.items()], (20, 72))
    return MoreSheet("About these runs", Stamp.columns(), [list(s.row().values()) for s in stamps], _RUN_WIDTHS)


def _streams(table: Tidy, one: bool) -> MoreSheet:
    """What the streams are and which units their fields have: the key to the columns."""
    header, widths = ["stream", "kind", "device", "units"], [28.0, 12.0, 20.0, 60.0]
    rows: list[list[Any]] = []
    for stamp, streams in zip(table.stamps, table.streams, strict=True):
        rows += [[*([] if one else [stamp.run]), s.name, s.kind, s.device, s.units] for s in streams]
    return MoreSheet("Streams", header if one else ["run", *header], rows, widths if one else [28.0, *widths])


def properties_of(stamps: Sequence[Stamp]) -> dict[str, str]:
    """What a table's file says in its properties."""
    lines = " | ".join(s.line() for s in stamps)
    first = stamps[0]
    title = f"Run {first.run} of {first.workbook}" if len(stamps) == 1 else f"{len(stamps)} runs"
    return {"title": title, "subject": lines, "description": lines, "keywords": first.digest, "creator": PROGRAM}


def _cell(value: Any) -> Any:
    """A text that a spreadsheet would take for a formula is marked as text.

    >>> _cell("=HYPERLINK(1)"), _cell(-1.5), _cell(True)
    ("'=HYPERLINK(1)", -1.5, 'TRUE')
    """
    if isinstance(value, bool):
        return "TRUE" if value else "FALSE"
    return f"'{value}" if isinstance(value, str) and value.startswith(_FORMULA_STARTS) else value
