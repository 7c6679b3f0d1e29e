"""Renders a comparison as text, and each change in words: `Tracking row 5: 20 → 15`."""

from __future__ import annotations

import unicodedata
from collections.abc import Callable, Sequence

from rrp_sheets.compare.changes import Change, ComparedWorkbook, Comparison
from rrp_sheets.compare.tokens import single
from rrp_sheets.texts import N_

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


LONGEST = 160  # letters of one value
_PARTS = {"scene": "Scene", "test": "Test", "table": "Table", "gesture": "Gesture"}


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
            return f"{at} added{f': {after}' if change.after else ''}"
        case "removed":
            return f"{at} removed{f': {before}' if change.before else ''}"
        case "renamed" if change.part == "stream":
            name = f"stream {before}" if change.before else f"the unnamed stream of row {change.rows[0]}"
            return f"{at}: {name} " + (f"is now called {after}" if change.after else "has no name now")
        case "renamed":
            return f"{change.part.capitalize()} {before} is now called {after}"
        case "moved" if change.part == "sheet":
            return f"The sheets stand in another order: {before} → {after}"
        case "moved":
            same = change.rows[0] == change.rows[1]
            return f"{at} acts in another order" if same else f"{at} moved (was row {change.rows[0]})"
        case "on" | "off":
            return f"{at} switched {change.kind}"
        case "written":
            what = f": {one_line(change.what)}" if change.what else ""
            return f"{at}{what} is written differently: {before} → {after}"
        case "notes":
            return f"{at}: {change.what} {before} → {after}"
    return _changed(change, at, before, after)


def _changed(change: Change, at: str, before: str, after: str) -> str:
    what = one_line(change.what)
    if change.pieces and any(p.kind == "same" for p in change.pieces):
        one = single(change.pieces)
        if one is not None:
            old, new = (shorten(one_line(t)) for t in one)
            return f"{at}: {old} → {new} in the {what} {after}"
    return f"{at}: {what} {before} → {after}" if what else f"{at}: {before} → {after}"


def value(text: str) -> str:
    """Return a cell's text as it is shown; `blank` when it is empty."""
    return shorten(one_line(text)) or "blank"


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
