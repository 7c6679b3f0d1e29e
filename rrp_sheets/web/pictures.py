"""Diagram of a behaviour as an SVG file of its own: pages embed it as an image, which cannot run scripts."""

from __future__ import annotations

from rrp_sheets.errors import SheetsError
from rrp_sheets.graph import BehaviourGraph
from rrp_sheets.render.diagram import draw_diagram
from rrp_sheets.render.svg import frame, text
from rrp_sheets.web.workbook_repository import CheckedWorkbook

_SECONDS = 15.0  # for the layout; a larger diagram is told as too large
_LINE = 16.0
MOST_ROWS = 500
"""Of a behaviour that is drawn and told in words here: nobody reads more beside a table."""


def picture(book: CheckedWorkbook, behaviour: BehaviourGraph) -> str:
    """Draw the behaviour's diagram, or a picture with the reason why there is none."""
    if not book.look.understood:
        return _in_words(["This cannot be drawn yet.", "First mend the problems beside it."])
    if len(behaviour.steps) > MOST_ROWS:
        return _in_words([f"This is too long to be drawn here: more than {MOST_ROWS} rows.", "Divide the sheet."])
    try:
        drawn = draw_diagram(
            book.look.graph, behaviour, problems=book.look.flags(behaviour), whole=True, timeout=_SECONDS
        )
    except SheetsError as error:
        return _in_words([error.message, error.remedy])
    return drawn[0].svg if drawn else _in_words(["There is no row to draw yet."])


def _in_words(lines: list[str]) -> str:
    body = "".join(text(8, 4 + _LINE * (n + 1), line, 11) for n, line in enumerate(lines))
    high = _LINE * len(lines) + 16
    return frame(body, 440, high, ident="why", title="No diagram", description=" ".join(lines))
