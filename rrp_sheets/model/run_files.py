"""Names of the folder of runs beside a workbook, and of its files."""

from __future__ import annotations

from pathlib import Path

RUNS = "runs"


def faces_file(folder: Path) -> Path:
    """Return the file that keeps remembered faces for the workbooks of a folder."""
    return folder.absolute() / RUNS / "faces.json"
