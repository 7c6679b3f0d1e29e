"""A workbook as plain rows of texts, to write it again in another format."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rrp_sheets.workbook.reading import Reading


def to_sheets(reading: Reading) -> Mapping[str, Sequence[Sequence[str]]]:
    """The rows of every sheet, each cell as the user typed it, for `maker.make_workbook`.

    Rows keep their numbers (blank ones stay blank), so that every message about a cell holds for the copy too. Of an
    .xlsx the user's own sheets end at row 20; copy the file itself instead.
    """
    sheets: dict[str, list[list[str]]] = {}
    for sheet in reading.sheets:
        rows: list[list[str]] = []
        for number, cells in sheet.rows().items():
            rows.extend([] for _ in range(number - len(rows) - 1))
            rows.append([cells[c].typed if c in cells else "" for c in range(1, max(cells) + 1)])
        sheets.setdefault(sheet.name, rows)
    return sheets
