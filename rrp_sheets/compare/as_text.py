"""Renders a comparison as text or as data, and each change in words: `Tracking row 5: 20 → 15`."""

from __future__ import annotations

import unicodedata
from collections.abc import Callable, Sequence
from dataclasses import asdict
from typing import Any

from rrp_sheets.compare.changes import Change, Comparison, single
from rrp_sheets.texts import N_

SCHEMA = 1  # of the data; grows when an entry changes its meaning or goes
MOST = 200  # lines of each kind; the JSON has all
Style = Callable[[str, str], str]


def as_text(comparison: Comparison, *, brief: bool = False, style: Style = lambda text, role: text) -> str:
    """Return the comparison for people to read.

    Args:
        comparison: what to show.
        brief: leave out what has no effect on the behaviour.
        style: colours a text by its role: `added`, `removed`, `changed`, `quiet`, `verdict`.
    """
    others = comparison.others
    lines = [style(verdict(comparison), "verdict"), *(style(text, "quiet") for text in cautions(comparison))]
    lines += _list(comparison.effects, style)
    if others and not brief:
        one = N_("{n:,} difference without effect on the behaviour:")
        many = N_("{n:,} differences without effect on the behaviour:")
        lines += ["", style(N_(one if len(others) == 1 else many, n=len(others)), "quiet"), *_list(others, style)]
    return "\n".join(lines)


def as_dict(comparison: Comparison) -> dict[str, Any]:
    """Return the data that `diff --json` prints."""
    changes = []
    for c in comparison.changes:
        entry = {**asdict(c), "row_before": c.rows[0] or None, "row_after": c.rows[1] or None, "text": say(c)}
        del entry["rows"], entry["field"]
        changes.append(entry)
    first, second = asdict(comparison.first), asdict(comparison.second)
    return {"schema": SCHEMA, "same_behaviour": comparison.same, "first": first, "second": second, "changes": changes}


def verdict(comparison: Comparison) -> str:
    """Return the sentence that says whether the behaviour is the same."""
    if comparison.same:
        if not comparison.others:
            return N_("Same behaviour. There is no difference.")
        if all(c.kind == "notes" for c in comparison.others):
            return N_("Same behaviour. Only notes are different.")
        return N_("Same behaviour.")
    n = len(comparison.effects)
    return N_("Different behaviour: {n:,} change." if n == 1 else "Different behaviour: {n:,} changes.", n=n)


def cautions(comparison: Comparison) -> list[str]:
    """Return a caution for each workbook with errors, as parts of it are compared by their text only."""
    first = N_("The first workbook ({source}) has {errors}. Parts that could not be read are compared as text.")
    second = N_("The second workbook ({source}) has {errors}. Parts that could not be read are compared as text.")
    return [
        N_(text, source=one_line(version.source),
           errors=N_("{n} error" if version.errors == 1 else "{n} errors", n=f"{version.errors:,}"))
        for text, version in ((first, comparison.first), (second, comparison.second))
        if version.errors
    ]  # fmt: skip


def _list(changes: Sequence[Change], style: Style) -> list[str]:
    lines = []
    for change in changes[:MOST]:
        role = change.kind if change.kind in ("added", "removed") else "changed" if change.effect else "quiet"
        note = style(N_(" – {note}", note=change.note), "quiet") if change.note else ""
        lines.append(f"  {style(say(change), role)}{note}")
    if len(changes) > MOST:
        lines.append(style(N_("  … and {n:,} more (--json lists them all)", n=len(changes) - MOST), "quiet"))
    return lines


LONGEST = 160  # letters of one value


def place(change: Change) -> str:
    """Return the place of a change, without punctuation: `Tracking row 5`, `Devices: Hello`, `Helper near`."""
    sheet, row = one_line(change.sheet), change.rows[1] or change.rows[0]
    name = one_line(change.name)
    match change.part:
        case "device" | "protocol":
            return N_("{sheet}: {name}", sheet=sheet, name=name)
        case "helper":
            return N_("Helper {name}", name=name)
        case "behaviour":
            return N_("Behaviour {sheet}", sheet=sheet)
        case "stream":
            return sheet
        case "sheet":
            return N_("Sheet {sheet}", sheet=sheet) if sheet else N_("Sheets")
        case "table":
            words = N_("Table {sheet} row {row}") if row else N_("Table {sheet}")
            return N_(words, sheet=sheet, row=row)
    return N_("{sheet} row {number}", sheet=sheet, number=row) if row else sheet


def say(change: Change) -> str:
    """Return a change in one line, without the reason why it has no effect."""
    at, before, after = place(change), value(change.before), value(change.after)
    match change.kind:
        case "added":
            return N_("{at} added: {after}", at=at, after=after) if change.after else N_("{at} added", at=at)
        case "removed":
            return N_("{at} removed: {before}", at=at, before=before) if change.before else N_("{at} removed", at=at)
        case "renamed":
            return _renamed(change, at, before, after)
        case "moved" if change.part == "sheet":
            return N_("The sheets have another order: {before} → {after}", before=before, after=after)
        case "moved" if change.rows[0] == change.rows[1]:
            return N_("{at} acts in another order", at=at)
        case "moved":
            return N_("{at} moved (was row {row})", at=at, row=change.rows[0])
        case "on":
            return N_("{at} switched on", at=at)
        case "off":
            return N_("{at} switched off", at=at)
        case "written" if not change.what:
            return N_("{at} is written differently: {before} → {after}", at=at, before=before, after=after)
        case "written":
            return N_("{at}: {what} is written differently: {before} → {after}",
                      at=at, what=one_line(change.what), before=before, after=after)  # fmt: skip
        case "notes":
            return N_("{at}: {what} {before} → {after}", at=at, what=change.what, before=before, after=after)
    return _changed(change, at, before, after)


def _renamed(change: Change, at: str, before: str, after: str) -> str:
    if change.part == "behaviour":
        return N_("Behaviour {before} is now called {after}", before=before, after=after)
    if change.part == "helper":
        return N_("Helper {before} is now called {after}", before=before, after=after)
    if change.before and change.after:
        return N_("{at}: stream {before} is now called {after}", at=at, before=before, after=after)
    if change.before:
        return N_("{at}: stream {before} has no name now", at=at, before=before)
    if change.after:
        return N_("{at}: the unnamed stream of row {row} is now called {after}",
                  at=at, row=change.rows[0], after=after)  # fmt: skip
    return N_("{at}: the unnamed stream of row {row} has no name now", at=at, row=change.rows[0])


def _changed(change: Change, at: str, before: str, after: str) -> str:
    what = one_line(change.what)
    if change.pieces and any(p.kind == "same" for p in change.pieces):
        one = single(change.pieces)
        if one is not None:
            old, new = (shorten(one_line(t)) for t in one)
            return N_("{at}: {old} → {new} in the {what} {after}", at=at, old=old, new=new, what=what, after=after)
    if what:
        return N_("{at}: {what} {before} → {after}", at=at, what=what, before=before, after=after)
    return N_("{at}: {before} → {after}", at=at, before=before, after=after)


def value(text: str) -> str:
    """Return a cell's text as it is shown; `blank` when it is empty."""
    return shorten(text) or N_("blank")


def shorten(text: str) -> str:
    """Return the text on one line, cut to `LONGEST` letters."""
    text = one_line(text)
    return text if len(text) <= LONGEST else text[: LONGEST - 1] + "…"


def one_line(text: str) -> str:
    r"""Return a text without line breaks and without characters that act on a terminal or turn its direction.

    >>> one_line("a\nb\x1b[31m")
    'a b�[31m'
    """
    if text.isprintable():
        return text
    spaced = " ".join(text.split("\n")).replace("\t", " ")
    return "".join(c if unicodedata.category(c) not in ("Cc", "Cf", "Cs", "Zl", "Zp") else "�" for c in spaced)
