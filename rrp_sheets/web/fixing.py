"""What the check offers to mend a finding, applied as an edit that can be undone."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from rrp_sheets.checks.fixing import replaced
from rrp_sheets.diagnostics.fix import Fix, Insert, Put
from rrp_sheets.documents import CellText, Changed, Document, Refused
from rrp_sheets.documents.grid import Grid
from rrp_sheets.documents.undo import Cells, RestoreRows
from rrp_sheets.web.analysis import Analysis

_OLD = "This is no longer what the check says."
_LOOK = "Look at the problems again."


def make_fix(document: Document, look: Analysis, author: str, asked: dict[str, Any]) -> Changed:
    """Apply the fix that somebody has chosen in the list of problems.

    `asked` holds `code`, `place` and `title` of the fix as the page showed them.

    Raises:
        Refused: the problem is not there any more, or the fix does not fit the sheet as it is now.
    """
    wanted = asked.get("code"), asked.get("place"), asked.get("title")
    for d in look.findings:
        for fix in d.fixes:
            if wanted == (d.code, str(d.address or ""), fix.title):
                return _apply(document, author, fix)
    raise Refused(_OLD, _LOOK)


def _apply(document: Document, author: str, fix: Fix) -> Changed:
    sheets = {e.sheet if isinstance(e, Insert) else e.address.sheet for e in fix.edits}
    missing = sorted(name for name in sheets if name not in document.grids)
    if missing:
        raise Refused(f"There is no sheet “{missing[0]}” that this fix could change.", "Make it, or mend it by hand.")
    steps = list(_steps(document.grids, fix))
    if not steps:
        raise Refused(_OLD, _LOOK)
    return document.together(author, steps)


def _steps(grids: Mapping[str, Grid], fix: Fix) -> Iterator[Cells | RestoreRows]:
    """The fix by the ids of rows; its numbers count rows as the edit before left them."""
    order: dict[str, list[str]] = {}
    for one in fix.edits:
        grid = grids[one.sheet if isinstance(one, Insert) else one.address.sheet]
        rows = order.setdefault(grid.name, list(grid.rows))
        if isinstance(one, Insert):
            place = one.before - grid.first
            if not 0 <= place <= len(rows):
                raise Refused(_OLD, _LOOK)
            row = grid.new_id()
            yield RestoreRows(grid.name, ((row, dict(one.cells)),), rows[place] if place < len(rows) else None)
            rows.insert(place, row)
            continue
        place = one.address.row - grid.first
        if not 0 <= place < len(rows):
            raise Refused(_OLD, _LOOK)
        now = grid.text(rows[place], one.address.column)
        if isinstance(one, Put) and one.was not in (None, now):
            raise Refused(_OLD, _LOOK)
        text = one.text if isinstance(one, Put) else replaced(now, one)
        if text != now:
            yield Cells(grid.name, (CellText(rows[place], one.address.column, text, now),))
