"""Check that a table of runs replaces only another table of runs, never a workbook or other data."""

from __future__ import annotations

import zipfile
from pathlib import Path

from rrp_sheets.errors import SheetsError
from rrp_sheets.model.stamp import Stamp
from rrp_sheets.workbook.atomic import refuse_open_file
from rrp_sheets.workbook.package import BROKEN_ZIP

_ABOUT = (b"About this run", b"About these runs")  # the sheet that every table of ours has
_STAMPED = (Stamp.columns()[2], Stamp.names()[2])  # the column that every CSV of ours has; before version 0.3
_SHEETS = "xl/workbook.xml"
_MOST = 1_000_000  # bytes; more is no list of sheets of ours, nor a header


def refuse_other_table(target: Path) -> None:
    """Raise SheetsError when `target` is an .xlsx or .csv that is there and was not exported from runs, or is open."""
    refuse_open_file(target)
    ours = {".xlsx": _ours_xlsx, ".csv": _ours_csv}.get(target.suffix.casefold())
    try:
        if ours is None or not target.is_file() or not target.stat().st_size or ours(target):
            return
    except OSError as error:
        raise SheetsError(f"“{target}” cannot be written ({error.strerror}).", "Name another file.") from None
    raise SheetsError(
        f"“{target}” is there already and is no table of a run; it was left as it is.", "Give the file another name."
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
