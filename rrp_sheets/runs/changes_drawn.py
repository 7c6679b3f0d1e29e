"""Pictures and tables of the changes between two workbooks."""

from __future__ import annotations

import html
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from rrp_sheets.compare import Comparison, compare_in_detail
from rrp_sheets.compare.as_html import file_name
from rrp_sheets.compare.as_rows import rows_table
from rrp_sheets.compare.as_text import verdict
from rrp_sheets.compare.opening import open_checked
from rrp_sheets.errors import SheetsError
from rrp_sheets.model.changed import ChangedBehaviour
from rrp_sheets.render.changes.pages import draw_changes, legend_page
from rrp_sheets.render.diagram import Page
from rrp_sheets.render.output import stack

_MOST_BEHAVIOURS = 12  # that are drawn; lists name all
Drawn = tuple[ChangedBehaviour, list[Page], str]  # a behaviour, its pictures, and what is wrong with them


@dataclass(frozen=True)
class Compared:
    """Two workbooks compared, with the behaviours that changed."""

    comparison: Comparison
    behaviours: tuple[ChangedBehaviour, ...]

    def drawn(self) -> list[Drawn]:
        """Draw the changed behaviours; of one that cannot be drawn, return the reason."""
        out: list[Drawn] = []
        for number, behaviour in enumerate(self.behaviours[:_MOST_BEHAVIOURS], 1):
            try:
                out.append((behaviour, draw_changes(behaviour, number), ""))
            except SheetsError as error:
                out.append((behaviour, [], f"It could not be drawn: {error}"))
        return out

    def svg(self) -> str:
        """Return all pictures below each other, with the legend on top.

        Raises:
            SheetsError: when it cannot be drawn.
        """
        first, second = (file_name(v) for v in (self.comparison.first, self.comparison.second))
        none = "" if self.behaviours else " No row is different: there is nothing to draw."
        pages = [legend_page(f"{first} → {second}. {verdict(self.comparison)}{none}")]
        for number, behaviour in enumerate(self.behaviours[:_MOST_BEHAVIOURS], 1):
            pages += draw_changes(behaviour, number)
        return stack(pages)[0]

    def html(self) -> str:
        """Return pictures and tables of rows as a part of a page: no script, nothing loaded, everything escaped."""
        if not self.behaviours:
            return ""
        drawn = self.drawn()
        legend = legend_page("").svg if any(pages for _, pages, _ in drawn) else ""
        left = len(self.behaviours) - len(drawn)
        more = f"<p>… and {left} more behaviours; the list has them all.</p>" if left > 0 else ""
        return (
            f'<div class="changed-rows">\n<div class="change-legend">{legend}</div>\n'
            + "\n".join(_section(*entry) for entry in drawn)
            + f"{more}\n</div>"
        )


def compared(first: Path, second: Path) -> Compared:
    """Compare two workbooks, with all that is needed to draw the changes."""
    return Compared(*compare_in_detail(open_checked(first), open_checked(second)))


def _section(behaviour: ChangedBehaviour, pages: Sequence[Page], trouble: str) -> str:
    pictures = "".join(
        f'<figure tabindex="0">'
        f"{page.svg}{f'<figcaption>{html.escape(page.caption)}</figcaption>' if page.caption else ''}</figure>"
        for page in pages
    )
    word = {"+": " is new", "−": " is gone"}.get(behaviour.sign, ": what changed")
    return (
        f'<section class="changed-behaviour">\n<h2>{html.escape(behaviour.name)}{word}</h2>\n'
        '<div class="side-by-side">\n'
        f'<div class="pictures">{pictures}{f"<p>{html.escape(trouble)}</p>" if trouble else ""}</div>\n'
        f"{rows_table(behaviour)}\n</div>\n</section>"
    )
