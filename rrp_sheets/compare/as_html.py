"""Renders a comparison as one page of HTML: no scripts, no other files, everything escaped, legible in grey."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from rrp_sheets import page_texts
from rrp_sheets.compare.as_text import cautions, one_line, place, shorten, value, verdict
from rrp_sheets.compare.changes import Change, ComparedWorkbook, Comparison
from rrp_sheets.model.changed import ADDED, REMOVED
from rrp_sheets.resources import bundled
from rrp_sheets.texts import N_

MOST = 2_000  # rows of each table: a browser shows no more with ease
_KINDS = {
    "added": (ADDED, N_("added")), "removed": (REMOVED, N_("removed")),
    "changed": ("≠", N_("changed")), "renamed": ("✎", N_("renamed")),
    "moved": ("↕", N_("moved")), "on": ("●", N_("switched on")), "off": ("○", N_("switched off")),
    "notes": ("✎", N_("notes")), "written": ("≈", N_("written differently")),
}  # fmt: skip
Runs = Sequence[tuple[str, str]]  # texts, each with the tag of its mark


def render(template: str, *, language: str = "en", **shown: object) -> Markup:
    """Render a template of `templates/compare/` in a language; all texts in it are escaped."""
    return Markup(_templates().get_template(template).render(shown, language=language))


@lru_cache(maxsize=1)
def _templates() -> Environment:
    loader = FileSystemLoader(bundled("templates", "compare"))
    made = Environment(loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    page_texts.install(made, lambda context: str(context["language"]))
    made.filters |= {"one_line": one_line, "brief": shorten}
    return made


def as_html(comparison: Comparison, drawn: Markup | None = None) -> str:
    """Return the comparison as a page of its own; `drawn` is what `services.changes_drawn` makes of the changes."""
    names = file_name(comparison.first), file_name(comparison.second)
    title = N_("{first} compared with {second}", first=names[0], second=names[1])
    style = "".join(bundled("templates", "compare", n).read_text(encoding="utf-8") for n in ("page.css", "changes.css"))
    return render("page.html", title=title, style=Markup(style), comparison=as_part(comparison, drawn))


def as_part(comparison: Comparison, drawn: Markup | None = None, later: str = "", language: str = "en") -> Markup:
    """Return the comparison as a part of a page that has changes.css: no style, no script.

    Args:
        comparison: what to show.
        drawn: pictures and rows of what changed.
        later: the address from which the page fetches them instead.
        language: of the texts around what is compared.
    """
    compared = ((N_("Before"), comparison.first), (N_("After"), comparison.second))
    versions = [(which, one_line(v.source), one_line(v.digest[:16])) for which, v in compared]
    tables = [
        _table(N_("What changes the behaviour"), comparison.effects),
        _table(N_("Differences without effect on the behaviour"), comparison.others),
    ]
    sections = [table for table in tables if table["lines"]]
    kinds = {c.kind for c in comparison.changes} - {"notes"}
    return render(
        "comparison.html", language=language, same=comparison.same, verdict=one_line(verdict(comparison)),
        cautions=cautions(comparison), versions=versions, later=later, drawn=drawn, sections=sections,
        signs=[_KINDS[kind] for kind in _KINDS if kind in kinds], footed=bool(comparison.changes),
    )  # fmt: skip


def file_name(version: ComparedWorkbook) -> str:
    """Return the name of a workbook's file, for a title."""
    return one_line(version.source).replace("\\", "/").rstrip("/").rsplit("/", 1)[-1] or "nothing"


def _table(title: str, changes: Sequence[Change]) -> dict[str, object]:
    shown = changes[:MOST]
    return {
        "title": title, "count": N_("{n:,} entry" if len(changes) == 1 else "{n:,} entries", n=len(changes)),
        "lines": [_line(c) for c in shown], "noted": any(c.note for c in shown),
        "left": f"{len(changes) - MOST:,}" if len(changes) > MOST else "",  # that are not shown
    }  # fmt: skip


def _line(change: Change) -> dict[str, object]:
    sign, word = _KINDS[change.kind]
    what = N_("{what} {change}", what=change.what, change=word) if change.what and change.what != word else word
    first, second = change.rows
    before, after = _sides(change)
    return {
        "kind": change.kind, "where": place(change), "was": first if first and second and first != second else 0,
        "sign": sign, "what": what, "before": before, "after": after, "note": change.note,
    }  # fmt: skip


def _sides(change: Change) -> tuple[Runs, Runs]:
    """Return the cells before and after, with removed and added parts marked."""
    if change.pieces:
        return (
            [("del" if p.kind == "gone" else "", shorten(p.text)) for p in change.pieces if p.kind != "new"],
            [("ins" if p.kind == "new" else "", shorten(p.text)) for p in change.pieces if p.kind != "gone"],
        )
    before, after = value(change.before), value(change.after)
    match change.kind:
        case "added":
            return (), [("ins", after)] if change.after else ()
        case "removed":
            return [("del", before)] if change.before else (), ()
        case "on" | "off":
            before, after = (N_("off"), N_("on")) if change.kind == "on" else (N_("on"), N_("off"))
            return [("del", before)], [("ins", after)]
        case "moved" if not change.before and change.rows[0] == change.rows[1]:
            return (), ()
        case "moved" if not change.before:
            return [("", N_("row {n}", n=change.rows[0]))], [("", N_("row {n}", n=change.rows[1]))]
        case "changed":
            return [("del", before)], [("ins", after)]
    return [("", before)], [("", after)]
