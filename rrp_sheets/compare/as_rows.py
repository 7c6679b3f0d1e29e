"""Renders the rows of a changed behaviour as an HTML table, with removed and added words marked."""

from __future__ import annotations

import html
from collections.abc import Iterator

from rrp_sheets.compare.wording import one_line, shorten
from rrp_sheets.model.changed import ADDED, CHANGED, REMOVED, SAME, ChangedBehaviour, ChangedRow, ComparableText

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
