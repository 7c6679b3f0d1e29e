"""Refusals of edits, in words."""

from __future__ import annotations

from collections.abc import Iterable

from rrp_sheets.documents.grid import Grid
from rrp_sheets.documents.row_changes import Clash, Refused

_AGAIN = "Look at it, and change it again if you still want to."


def must_have(grid: Grid, rows: Iterable[str]) -> None:
    """Refuse when one of the rows is gone."""
    if not all(grid.has(row) for row in rows):
        raise Refused("A row that this changes was deleted meanwhile.", _AGAIN)


def clash(grid: Grid, clashes: list[Clash]) -> Refused:
    """Return the refusal for cells that somebody has changed meanwhile."""
    first = clashes[0]
    by = first.by or "Someone"
    where = f"{grid.name}, row {grid.number(first.row)}"
    return Refused(
        f"{by} has changed this cell meanwhile ({where}): it is “{first.theirs}” now; yours was “{first.mine}”.",
        _AGAIN, tuple(clashes),
    )  # fmt: skip
