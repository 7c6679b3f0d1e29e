"""Workbooks to print."""

from __future__ import annotations

from datetime import date
from pathlib import Path

DAY = date(2026, 11, 21)
HEAD = "| Input streams | Connector | Formula | Output stream | Priority |\n|---|---|---|---|---|\n"


def workbook(folder: Path, rows: str, name: str = "w.md", *, protocol: str = "", rest: str = "") -> Path:
    path = folder / name
    field = f"## Protocol\n| Field | Value |\n|---|---|\n| Title | T |\n{protocol}\n"
    path.write_text(f"{field}\n## Play\n{HEAD}{rows}\n{rest}", encoding="utf-8")
    return path
