"""Names of the folder of runs beside a workbook, and of the files in the folder of a run."""

from __future__ import annotations

from pathlib import Path

RUNS = "runs"
TRACE = "trace.jsonl"
WORKBOOK = "protocol.xlsx"  # the one that ran
TABLE = "run.xlsx"
DIAGRAM = "diagram.svg"
POSES = "poses.jsonl"
CAMERA = "camera.zip"
FILM = "film.gif"
STRIP = "strip.png"


def faces_file(folder: Path) -> Path:
    """Return the file that keeps remembered faces for the workbooks of a folder."""
    return folder.absolute() / RUNS / "faces.json"
