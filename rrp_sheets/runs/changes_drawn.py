"""Pictures and tables of the changes between two workbooks."""

from __future__ import annotations

import html
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from rrp_sheets.compare import Comparison, compare_in_detail
from rrp_sheets.compare.as_html import file_name
from rrp_sheets.compare.as_text import one_line, shorten, verdict
from rrp_sheets.compare.side import open_checked
from rrp_sheets.errors import SheetsError
from rrp_sheets.model.changed import ADDED, CHANGED, REMOVED, SAME, ChangedBehaviour, ChangedRow, ComparableText
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


MOST = 1_000  # rows of one table
_AROUND = 1  # unchanged rows that are shown above and below a changed one
_HEADS = ("", "Row", "Input streams", "Connector", "Formula", "Output stream")
_NAMES = {ADDED: ("added", "new"), REMOVED: ("removed", "gone"), CHANGED: ("changed", "changed"), SAME: ("kept", "")}


def rows_table(behaviour: ChangedBehaviour) -> str:
    """Return the changed rows and their neighbours as an HTML table; of the other rows only the numbers."""
    heads = "".join(f'<th scope="col">{h or "<span class=sr>Change</span>"}</th>' for h in _HEADS)
    return (
        f'<table class="rows">\n<thead><tr>{heads}</tr></thead>\n<tbody>\n'
        + "\n".join(_lines(behaviour.rows))
        + "\n</tbody>\n</table>"
    )


def _lines(rows: tuple[ChangedRow, ...]) -> Iterator[str]:
    near = {
        n + d for n, row in enumerate(rows) if row.sign for d in range(-_AROUND, _AROUND + 1)
    }  # places that are shown
    count, n = 0, 0
    while n < len(rows):
        if n in near and count < MOST:
            count += 1
            yield _row(rows[n])
            n += 1
            continue
        start = n
        while n < len(rows) and (n not in near or count >= MOST):
            n += 1
        yield _left_out(rows[start:n])


def _left_out(rows: tuple[ChangedRow, ...]) -> str:
    changed = sum(1 for row in rows if row.sign)
    if changed:
        words = f"… and {changed:,} more changed rows; the list has them"
    else:
        first, last = rows[0].number, rows[-1].number
        words = f"Row {first}: unchanged" if first == last else f"Rows {first} to {last}: unchanged"
    return f'<tr class="left-out"><td colspan="{len(_HEADS)}">{words}</td></tr>'


def _row(row: ChangedRow) -> str:
    kind, word = _NAMES[row.sign]
    was = f' <small class="was">(was {row.was})</small>' if row.was and row.was != row.number else ""
    sign = f'<span class="sign" aria-hidden="true">{row.sign}</span><span class="sr">{word}</span>' if row.sign else ""
    remarks = "".join(f'<small class="remark">{_e(remark)}</small>' for remark in row.remarks)
    cells = (
        _cell("Input streams", row.inputs), _cell("Connector", row.connector), _cell("Formula", row.formula, remarks),
        _cell("Output stream", row.output),
    )  # fmt: skip
    return (
        f'<tr class="{kind}{" off" if row.off else ""}"><td>{sign}</td><th scope="row">{row.number}{was}</th>'
        + "".join(cells)
        + "</tr>"
    )


def _cell(head: str, words: ComparableText, more: str = "") -> str:
    if words.changed:
        was = "".join(f"<del>{_e(t)}</del>" if marked else _e(t) for marked, t in words.was())
        now = "".join(f"<ins>{_e(t)}</ins>" if marked else _e(t) for marked, t in words.now())
        between = '<span class="then" aria-hidden="true"> → </span>' if was and now else ""
        said = f'<span class="was-text">{was}</span>{between}<span>{now}</span>'
        said = was + now if not (was and now) else said
    else:
        said = _e(words.after)
    empty = "" if said or more else ' class="empty"'
    return f'<td data-head="{head}"{empty}>{said}{more}</td>'


def _e(text: str) -> str:
    return html.escape(shorten(one_line(text)) if len(text) > 160 else one_line(text))
