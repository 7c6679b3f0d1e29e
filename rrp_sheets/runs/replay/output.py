"""The differences of a replay as a file: a table, or marbles."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from rrp_sheets.errors import SheetsError
from rrp_sheets.model.stamp import Stamp
from rrp_sheets.runs.records.replacing import refuse_other_table
from rrp_sheets.runs.records.table import about_runs, properties_of
from rrp_sheets.runs.records.tidy import Seconds
from rrp_sheets.runs.replay.record import same_json
from rrp_sheets.runs.replay.replay_marbles import difference_scores
from rrp_sheets.runs.replay.result import Replayed
from rrp_sheets.workbook.atomic import write_atomically

SUFFIXES = (".xlsx", ".csv", ".svg", ".pdf", ".png")
_HEADER = ("time_s", "kind", "stream", "row", "row_now", "recorded", "came", "came_at_s", "what")
_WIDTHS = (10, 10, 24, 16, 16, 30, 30, 12, 10)
_FORMULA_STARTS = ("=", "+", "-", "@", "\t", "\r")


def write(found: Replayed, target: Path) -> list[str]:
    """Write the differences in the format of the suffix; return what the picture lacks, in words.

    Raises:
        SheetsError: when it cannot be written, or would take the place of what is no table of a run.
    """
    suffix = target.suffix.casefold()
    refuse_other_table(target)
    try:
        if suffix == ".csv":
            write_atomically(target, _csv(found).encode("utf-8-sig", "replace"))
            return []
        if suffix == ".xlsx":
            from rrp_sheets.workbook.table import write_table

            more = [about_runs([found.stamp])]
            properties = properties_of([found.stamp])
            count = len(found.differences)
            write_table(target, "differences", _HEADER, _rows(found), _WIDTHS, more, properties, count)
            return []
    except OSError as error:
        raise SheetsError(f"“{target}” cannot be written ({error.strerror}).", "Name another file.") from None
    scores = difference_scores(found)
    if not scores:
        return [f"Nothing differs that could be drawn, so “{target.name}” is not written."]
    from rrp_sheets.render.output import write_marbles

    return write_marbles(scores, target)


def _rows(found: Replayed) -> Iterator[list[Any]]:
    for d in found.differences:
        recorded, came = (_cell(v) for v in (d.recorded, d.came))
        yield [Seconds(d.us / 1e6), d.kind, d.stream or None, d.row or None, d.came_row or None, recorded, came,
               Seconds(d.came_us / 1e6), d.what]  # fmt: skip


def _cell(value: Any) -> Any:
    return same_json(value) if isinstance(value, (list, dict)) else value


def _csv(found: Replayed) -> str:
    out = io.StringIO(newline="")
    writer = csv.writer(out)
    stamp = found.stamp.row().values()  # in every row, as in the table of a run: a file beside it gets lost
    writer.writerow([*_HEADER, *Stamp.columns()])
    writer.writerows([_text(v) for v in (*row, *stamp)] for row in _rows(found))
    return out.getvalue()


def _text(value: Any) -> Any:
    """Return a cell of CSV; a text that a spreadsheet would take for a formula is marked as text."""
    if isinstance(value, bool):
        return "TRUE" if value else "FALSE"
    return f"'{value}" if isinstance(value, str) and value.startswith(_FORMULA_STARTS) else value
