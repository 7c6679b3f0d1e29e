"""Renders a comparison as one page of HTML: no scripts, no other files, everything escaped, legible in grey."""

from __future__ import annotations

import html
from collections.abc import Iterable, Sequence

from rrp_sheets.compare.as_text import cautions, counted, one_line, place, shorten, shown_source, value, verdict
from rrp_sheets.compare.changes import Change, ComparedWorkbook, Comparison
from rrp_sheets.resources import bundled

MOST = 2_000  # rows of each table: a browser shows no more with ease
_KINDS = {
    "added": ("+", "added"), "removed": ("−", "removed"), "changed": ("≠", "changed"), "renamed": ("✎", "renamed"),
    "moved": ("↕", "moved"), "on": ("●", "switched on"), "off": ("○", "switched off"), "notes": ("✎", "notes"),
    "written": ("≈", "written differently"),
}  # fmt: skip
_HEADS = ("Where", "What", "Before", "After", "Remark")


def as_html(comparison: Comparison, drawn: str = "") -> str:
    """Return the comparison as a page of its own, which needs no other file.

    Args:
        comparison: what to show.
        drawn: pictures and rows of what changed, as `runs.changes_drawn` makes them.
    """
    title = f"{file_name(comparison.first)} and {file_name(comparison.second)} compared"
    style = "".join(bundled("templates", "compare", n).read_text(encoding="utf-8") for n in ("page.css", "changes.css"))
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{_e(title)}</title>\n<style>\n{style}</style>\n</head>\n<body>\n<main>\n<h1>{_e(title)}</h1>\n"
        f"{as_part(comparison, drawn)}\n</main>\n</body>\n</html>\n"
    )


def as_part(comparison: Comparison, drawn: str = "") -> str:
    """Return the comparison as a part of a page that has changes.css: no style, no script, everything escaped."""
    parts = [
        f'<p class="verdict {"same" if comparison.same else "different"}">'
        f"{'✓' if comparison.same else '≠'} {_e(verdict(comparison))}</p>",
        *(f'<p class="caution">{_e(text)}</p>' for text in cautions(comparison)),
        _versions(comparison),
        *([drawn] if drawn else []),
    ]
    if comparison.effects:
        parts.append(_section("What changes the behaviour", comparison.effects))
    if comparison.others:
        parts.append(_section("Differences without effect on the behaviour", comparison.others))
    if comparison.changes:
        parts.append(_legend(comparison.changes))
    return '<div class="comparison">\n' + "\n".join(parts) + "\n</div>"


def _e(text: str) -> str:
    return html.escape(one_line(text))


def file_name(version: ComparedWorkbook) -> str:
    """Return the name of a workbook's file, for a title."""
    return shown_source(version).replace("\\", "/").rstrip("/").rsplit("/", 1)[-1] or "nothing"


def _versions(comparison: Comparison) -> str:
    rows = ""
    for which, v in (("Before", comparison.first), ("After", comparison.second)):
        digest = f"<br><small>SHA-256 <code>{_e(v.digest[:16])}…</code></small>" if v.digest else ""
        rows += f"<div><dt>{which}</dt><dd>{_e(shown_source(v))}{digest}</dd></div>"
    return f'<dl class="versions">{rows}</dl>'


def _section(title: str, changes: Sequence[Change]) -> str:
    shown = _HEADS if any(c.note for c in changes[:MOST]) else _HEADS[:-1]
    heads = "".join(f'<th scope="col">{h}</th>' for h in shown)
    rows = "\n".join(_row(c, shown) for c in changes[:MOST])
    more = (
        f"<p>… and {len(changes) - MOST:,} more; <code>--json</code> lists them all.</p>" if len(changes) > MOST else ""
    )
    return (
        f"<section>\n<h2>{title} <small>({counted(changes, 'entry').replace('entrys', 'entries')})</small></h2>\n"
        f"<table>\n<thead><tr>{heads}</tr></thead>\n<tbody>\n{rows}\n</tbody>\n</table>\n{more}</section>"
    )


def _row(change: Change, heads: Sequence[str]) -> str:
    sign, word = _KINDS[change.kind]
    before, after = _sides(change)
    what = f"{change.what} {word}" if change.what and change.what != word else word
    cells = (what, before, after, _e(change.note))
    sign_html = f'<span class="sign" aria-hidden="true">{sign}</span> '
    out = [f'<th scope="row">{_where(change)}</th>']
    for head, cell in zip(heads[1:], cells, strict=False):
        content = sign_html + _e(cell) if head == "What" else cell
        empty = "" if content else ' class="empty"'
        out.append(f'<td data-head="{head}"{empty}>{content}</td>')
    return f'<tr class="{change.kind}">{"".join(out)}</tr>'


def _where(change: Change) -> str:
    was = ""
    if change.rows[0] and change.rows[1] and change.rows[0] != change.rows[1]:
        was = f' <small class="was">(was row {change.rows[0]})</small>'
    return _e(place(change)) + was


def _sides(change: Change) -> tuple[str, str]:
    """Return the cells before and after, with removed and added parts marked."""
    if change.pieces:
        return (
            "".join(_piece(p.kind, p.text, "del") for p in change.pieces if p.kind != "new"),
            "".join(_piece(p.kind, p.text, "ins") for p in change.pieces if p.kind != "gone"),
        )
    before, after = value(change.before), value(change.after)
    match change.kind:
        case "added":
            return "", f"<ins>{_e(after)}</ins>" if change.after else ""
        case "removed":
            return f"<del>{_e(before)}</del>" if change.before else "", ""
        case "on" | "off":
            before, after = ("off", "on") if change.kind == "on" else ("on", "off")
            return f"<del>{before}</del>", f"<ins>{after}</ins>"
        case "moved" if not change.before and change.rows[0] == change.rows[1]:
            return "", ""
        case "moved" if not change.before:
            return f"row {change.rows[0]}", f"row {change.rows[1]}"
        case "changed":
            return f"<del>{_e(before)}</del>", f"<ins>{_e(after)}</ins>"
    return _e(before), _e(after)


def _piece(kind: str, text: str, tag: str) -> str:
    return _e(shorten(text)) if kind == "same" else f"<{tag}>{_e(shorten(text))}</{tag}>"


def _legend(changes: Iterable[Change]) -> str:
    kinds = {c.kind for c in changes}
    entries = "".join(
        f'<li><span class="sign" aria-hidden="true">{sign}</span> {word}</li>'
        for kind, (sign, word) in _KINDS.items()
        if kind in kinds and kind != "notes"
    )
    return (
        '<footer><ul class="legend">' + entries + "</ul>"
        "<p><del>Struck out</del>: what went. <ins>Underlined</ins>: what came. Rows are compared by what they mean, "
        "not by where they stand; row numbers are those of the second workbook, of removed rows those of the first.</p>"
        "</footer>"
    )
