"""Pictures and tables of the changes between two workbooks."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

from markupsafe import Markup

from rrp_sheets.compare import Comparison, compare_in_detail
from rrp_sheets.compare.as_html import file_name, render
from rrp_sheets.compare.as_text import verdict
from rrp_sheets.compare.side import open_checked
from rrp_sheets.errors import SheetsError
from rrp_sheets.model.changed import ADDED, REMOVED, SIGN_NAMES, ChangedBehaviour, ChangedRow
from rrp_sheets.render.change_diagram import draw_changes, legend_page
from rrp_sheets.render.diagram import Page
from rrp_sheets.render.output import stack
from rrp_sheets.texts import N_, sentences, translate

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
                why = sentences(error.message, error.remedy)
                out.append((behaviour, [], N_("It could not be drawn: {why}", why=why)))
        return out

    def svg(self, language: str = "en") -> str:
        """Return all pictures below each other, under a title in a language and the legend.

        Raises:
            SheetsError: when it cannot be drawn.
        """
        first, second = (file_name(v) for v in (self.comparison.first, self.comparison.second))
        none = "" if self.behaviours else N_("No row is different: there is nothing to draw.")
        title = sentences(N_("{first} → {second}.", first=first, second=second), verdict(self.comparison), none)
        pages = [legend_page(translate(title, language))]
        for number, behaviour in enumerate(self.behaviours[:_MOST_BEHAVIOURS], 1):
            pages += draw_changes(behaviour, number)
        return stack(pages)[0]

    def html(self, language: str = "en") -> Markup:
        """Return pictures and tables of rows as a part of a page: no script, nothing loaded, everything escaped."""
        if not self.behaviours:
            return Markup("")
        drawn = self.drawn()
        return render(
            "changed_rows.html", language=language,
            legend=Markup(legend_page("").svg if any(pages for _, pages, _ in drawn) else ""),
            behaviours=[_shown(*entry) for entry in drawn], kinds=SIGN_NAMES, left=len(self.behaviours) - len(drawn),
        )  # fmt: skip


def compared(first: Path, second: Path) -> Compared:
    """Compare two workbooks, with all that is needed to draw the changes."""
    return Compared(*compare_in_detail(open_checked(first), open_checked(second)))


def _shown(behaviour: ChangedBehaviour, pages: Sequence[Page], trouble: str) -> dict[str, object]:
    words = {ADDED: N_("{name} is new"), REMOVED: N_("{name} is gone")}
    title = N_(words.get(behaviour.sign, N_("{name}: what changed")), name=behaviour.name)
    pictures = [(Markup(page.svg), page.caption) for page in pages]  # of our own drawing, with all texts escaped
    return {"title": title, "pictures": pictures, "trouble": trouble, "lines": list(_lines(behaviour.rows))}


MOST = 1_000  # rows of one table
_AROUND = 1  # unchanged rows that are shown above and below a changed one


def _lines(rows: Sequence[ChangedRow]) -> Iterator[tuple[ChangedRow | None, str]]:
    """Yield the changed rows and their neighbours, and between them in words which others there are."""
    changed = [n for n, row in enumerate(rows) if row.sign]
    near = {n + d for n in changed for d in range(-_AROUND, _AROUND + 1)} & set(range(len(rows)))
    shown = set(sorted(near)[:MOST])
    for is_shown, places in groupby(range(len(rows)), shown.__contains__):
        group = [rows[n] for n in places]
        if is_shown:
            yield from ((row, "") for row in group)
        else:
            yield None, _left_out(group)


def _left_out(rows: Sequence[ChangedRow]) -> str:
    changed = sum(1 for row in rows if row.sign)
    if changed:
        return N_("… and {n:,} more changed rows; the list has them", n=changed)
    first, last = rows[0].number, rows[-1].number
    words = N_("Row {first}: unchanged") if first == last else N_("Rows {first} to {last}: unchanged")
    return N_(words, first=first, last=last)
