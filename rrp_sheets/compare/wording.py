"""Words for changes: `Tracking row 5: 20 → 15 in the formula distance < 15`."""

from __future__ import annotations

import unicodedata

from rrp_sheets.compare.changes import Change
from rrp_sheets.compare.tokens import single
from rrp_sheets.diagnostics.phrase import Phrase

LONGEST = 160  # letters of one value
_PARTS = {"scene": "Scene", "test": "Test", "table": "Table", "gesture": "Gesture"}


def place(change: Change) -> str:
    """Return the place of a change, without punctuation: `Tracking row 5`, `Devices: Hello`, `Helper near`."""
    sheet, row = one_line(change.sheet), change.rows[1] or change.rows[0]
    name = one_line(change.name)
    match change.part:
        case "device" | "protocol":
            return Phrase("{sheet}: {name}", sheet=sheet, name=name)
        case "helper":
            return Phrase("Helper {name}", name=name)
        case "behaviour":
            return Phrase("Behaviour {sheet}", sheet=sheet)
        case "stream":
            return sheet
        case "sheet":
            return Phrase("Sheet {sheet}", sheet=sheet) if sheet else "Sheets"
        case "table":
            words = "Table {sheet} row {row}" if row else "Table {sheet}"
            return Phrase(words, sheet=sheet, row=row)
    return Phrase("{sheet} row {number}", sheet=sheet, number=row) if row else sheet


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
            return f"{at}: notes {before} → {after}"
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
