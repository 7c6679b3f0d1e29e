"""Opens the files to be compared: workbooks, and the files that git passes for them."""

from __future__ import annotations

import os
from pathlib import Path

from rrp_sheets.checks import Checked, check_workbook
from rrp_sheets.diagnostics import Report
from rrp_sheets.model.workbook import Workbook
from rrp_sheets.workbook import Reading, read

_KNOWN = {".xlsx", ".xlsm", ".xltm", ".xlam", ".xls", ".ods", ".md", ".markdown", ".csv", ".tsv"}
_HEAD = 8_192  # bytes that tell a format


def open_workbook(path: Path) -> Reading:
    """Read a workbook of any file name; without a known ending, its first bytes decide the format.

    The null device, which git gives for a file that is not there, is a workbook without sheets.

    Raises:
        UnreadableFile: when it cannot be read at all, or is refused.
    """
    if str(path) == os.devnull:
        return Reading(Workbook("nothing", ()), Report(), "", "none")
    return read(path, _format(path))


def open_checked(path: Path) -> tuple[Reading, Checked]:
    """Read and check a workbook, without lints."""
    reading = open_workbook(path)
    return reading, check_workbook(reading.workbook, reading.report, lints=False)


def _format(path: Path) -> str:
    """Return the ending for the format that the first bytes show, if the file's own is unknown; else empty."""
    if path.suffix.casefold() in _KNOWN or "\0" in str(path) or not path.is_file():
        return ""
    try:
        with path.open("rb") as file:
            head = file.read(_HEAD)
    except OSError:
        return ""
    if b"\0" in head[:4] or head.startswith(b"PK"):
        return ""
    lines = [line.strip() for line in head.decode("utf-8", "replace").splitlines() if line.strip()]
    if any(line.startswith("## ") for line in lines) and any(line.startswith("|") for line in lines):
        return ".md"
    return ".csv" if lines and any(mark in lines[0] for mark in ",;\t") else ""
