"""A workbook as plain rows of texts, to write it again in another format."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

from rrp_sheets.workbook.headers import recognise
from rrp_sheets.workbook.raw import Kind, RawCell, RawSheet

if TYPE_CHECKING:
    from rrp_sheets.workbook.reading import Reading


def to_sheets(reading: Reading) -> Mapping[str, Sequence[Sequence[str]]]:
    """The rows of every sheet, each cell as the user typed it, for `maker.make_workbook`.

    Rows keep their numbers (blank ones stay blank), so that every message about a cell holds for the copy too. Of an
    .xlsx the user's own sheets end at row 20; `to_rows(read_sheets(path))` has all of them.
    """
    return to_rows(reading.sheets)


def to_rows(sheets: Iterable[RawSheet]) -> dict[str, list[list[str]]]:
    """The rows of sheets as texts; see `to_sheets`."""
    found: dict[str, list[list[str]]] = {}
    for sheet in sheets:
        what = recognise(sheet)
        column = what.columns.get("Formula", 0)
        rows: list[list[str]] = []
        for number, cells in sheet.rows().items():
            rows.extend([] for _ in range(number - len(rows) - 1))
            texts = {c: _text(cell, c == column) for c, cell in cells.items()}
            rows.append([texts.get(c, "") for c in range(1, max(cells) + 1)])
        found.setdefault(sheet.name, rows)
    return found


def _text(cell: RawCell, ours: bool) -> str:
    """Return what was typed where a formula of ours is expected; elsewhere the value that the user sees, if any."""
    seen = cell.text and cell.kind is not Kind.ERROR
    return cell.text if seen and not ours else cell.typed
