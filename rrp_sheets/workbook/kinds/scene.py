"""Scene sheets: what happens in the simulated world, and when."""

from __future__ import annotations

from rrp_sheets.model.workbook import SceneRow
from rrp_sheets.workbook.columns import Table


def read_scene(table: Table) -> tuple[SceneRow, ...]:
    """The rows of a Scene sheet; their words are understood later."""
    lines = list(table.lines())
    table.report_hidden({line.number: line for line in lines})
    return tuple(
        SceneRow(
            table.duration(line, "Time (s)"), table.name(line, "Thing"), table.name(line, "Does"),
            table.prose(line, "Value"),
        )
        for line in lines
    )  # fmt: skip
