"""A workbook as text, one line for each row: what git compares line by line.

The text is a Markdown workbook with the same behaviour. It holds what the sheets of ours hold, comments and the user's
own columns too; of sheets of the user's own those that formulas name, and the first rows of the others.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Sequence
from pathlib import Path

from rrp_sheets.errors import UnreadableFile
from rrp_sheets.model.names import key
from rrp_sheets.workbook import Reading
from rrp_sheets.workbook.headers import recognise
from rrp_sheets.workbook.raw import RawSheet


def text_form(reading: Reading) -> str:
    """The workbook as Markdown text."""
    parts = []
    tables = reading.workbook.tables
    for sheet in reading.sheets:
        table = _lines(tables[key(sheet.name)]) if key(sheet.name) in tables else _table(sheet)
        if table:
            parts.append(f"## {_heading(sheet.name)}\n" + "\n".join(table) + "\n")
    return "\n".join(parts)


def unreadable_text(path: Path, error: UnreadableFile) -> str:
    """What stands for a file that cannot be read as a workbook: another one whenever the file is."""
    digest = hashlib.sha256()
    with path.open("rb") as file:
        while block := file.read(1 << 20):
            digest.update(block)
    return f"Not a workbook that can be read ({error.code}). SHA-256 {digest.hexdigest()}\n"


def _heading(name: str) -> str:
    return " ".join(name.split())


def _table(sheet: RawSheet) -> list[str]:
    recognised = recognise(sheet)
    rows = {n: cells for n, cells in sheet.rows().items() if n >= (recognised.row or 1)}
    if not rows:
        return []
    width = max(column for cells in rows.values() for column in cells)
    head = min(rows)
    header = rows.pop(head)
    names = {at: header_name for header_name, at in recognised.columns.items()} if recognised.kind else {}
    top = [names.get(c) or (header[c].text if c in header else "") for c in range(1, width + 1)]
    texts = [[cells[c].typed if c in cells else "" for c in range(1, width + 1)] for cells in rows.values()]
    return _lines([top, *texts])


def _lines(rows: Sequence[Sequence[str]]) -> list[str]:
    lines = ["| " + " | ".join(_cell(text) for text in row) + " |" for row in rows]
    return [*lines[:1], "|" + "---|" * len(rows[0]), *lines[1:]] if rows else []


def _cell(text: str) -> str:
    """A cell that reads back as the same text."""
    text = re.sub(r"\r\n?", "\n", text.strip())
    return text.replace("|", "\\|").replace("\n", "<br>")
