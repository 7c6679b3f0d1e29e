"""A trace as CSV: the same table as the run's run.xlsx, for any program that counts."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

from rrp_sheets.errors import UnreadableFile
from rrp_sheets.runs.folder import tidy
from rrp_sheets.runs.records.facts import TRACE

_FORMULA_STARTS = ("=", "+", "-", "@", "\t", "\r")


def write_csv(place: Path, target: Path) -> None:
    """Write the events of a run as CSV (UTF-8 with a mark at its begin, which Excel needs).

    Raises:
        UnreadableFile: when it is no trace.
    """
    try:
        header, rows, _ = tidy(place / TRACE)
        with target.open("w", encoding="utf-8-sig", newline="", errors="replace") as file:
            writer = csv.writer(file)
            writer.writerow([_cell(h) for h in header])
            writer.writerows([_cell(v) for v in row] for row in rows)
    except (AttributeError, KeyError, TypeError, ValueError, RecursionError):
        raise UnreadableFile("FILE001", f"“{place.name}” is not a record of a run.", "Copy its folder again.") from None


def _cell(value: Any) -> Any:
    """A text that a spreadsheet would take for a formula is marked as text.

    >>> _cell("=HYPERLINK(1)"), _cell(-1.5), _cell(True)
    ("'=HYPERLINK(1)", -1.5, 'TRUE')
    """
    if isinstance(value, bool):
        return "TRUE" if value else "FALSE"
    return f"'{value}" if isinstance(value, str) and value.startswith(_FORMULA_STARTS) else value
