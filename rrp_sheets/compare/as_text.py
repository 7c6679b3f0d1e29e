"""Renders a comparison as text."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from rrp_sheets.compare.changes import Change, ComparedWorkbook, Comparison
from rrp_sheets.compare.wording import one_line, say

MOST = 200  # lines of each kind; the JSON has all
Style = Callable[[str, str], str]


def _plain(text: str, role: str) -> str:
    return text


def as_text(comparison: Comparison, *, brief: bool = False, style: Style = _plain) -> str:
    """Return the comparison for people to read.

    Args:
        comparison: what to show.
        brief: leave out what has no effect on the behaviour.
        style: colours a text by its role: `added`, `removed`, `changed`, `quiet`, `verdict`.
    """
    effects, others = comparison.effects, comparison.others
    lines = [style(verdict(comparison), "verdict")]
    lines += [style(text, "quiet") for text in cautions(comparison)]
    lines += _list(effects, style)
    if others and not brief:
        lines += ["", style(f"{counted(others, 'difference')} without effect on the behaviour:", "quiet")]
        lines += _list(others, style)
    return "\n".join(lines)


def verdict(comparison: Comparison) -> str:
    """Return the sentence that says whether the behaviour is the same."""
    if comparison.same:
        if not comparison.others:
            return "Same behaviour. There is no difference."
        if all(c.kind == "notes" for c in comparison.others):
            return "Same behaviour. Only notes are different."
        return "Same behaviour."
    return f"Different behaviour: {counted(comparison.effects, 'change')}."


def cautions(comparison: Comparison) -> list[str]:
    """Return a caution for each workbook with errors, as parts of it are compared by their text only."""
    return [
        f"{which} workbook ({shown_source(version)}) has {counted(range(version.errors), 'error')}: what could not be "
        "understood is compared by its text."
        for which, version in (("The first", comparison.first), ("The second", comparison.second))
        if version.errors
    ]


def shown_source(version: ComparedWorkbook) -> str:
    """Return the workbook's source on one line, safe to print."""
    return one_line(version.source)


def counted(things: Sequence[object], word: str) -> str:
    """Return `1 change`, `2 changes`."""
    return f"{len(things):,} {word}{'' if len(things) == 1 else 's'}"


def _list(changes: Sequence[Change], style: Style) -> list[str]:
    lines = []
    for change in changes[:MOST]:
        role = change.kind if change.kind in ("added", "removed") else "changed" if change.effect else "quiet"
        lines.append("  " + style(say(change), role) + (style(f" – {change.note}", "quiet") if change.note else ""))
    if len(changes) > MOST:
        lines.append(f"  … and {len(changes) - MOST:,} more (--json lists them all)")
    return lines
