"""Fixes of findings, as plain data that a program can apply, and those that write a proposed spelling."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from rrp_sheets.model.names import key
from rrp_sheets.model.workbook import Address
from rrp_sheets.texts import N_


@dataclass(frozen=True, slots=True)
class Put:
    """Put a text into a cell; an empty text clears it. If `was` is given, the cell must still hold that text."""

    address: Address
    text: str
    was: str | None = None


@dataclass(frozen=True, slots=True)
class Insert:
    """Insert a row before another one; `cells` are the texts by column, counted from 1."""

    sheet: str
    before: int
    cells: tuple[tuple[int, str], ...]


@dataclass(frozen=True, slots=True)
class Replace:
    """Write one word or name in a cell in another way: `redBal` → `redBall`."""

    address: Address
    old: str
    new: str


FixEdit = Put | Insert | Replace


@dataclass(frozen=True, slots=True)
class Fix:
    """A fix of a finding.

    Attributes:
        id: names it among the fixes of its finding, in any language: lower-case words with hyphens.
        title: what it does, in the user's words.
        edits: one after the other; each counts rows as the one before left them.
        safe: whether it is surely what was meant, so that it needs no decision.
    """

    id: str
    title: str
    edits: tuple[FixEdit, ...]
    safe: bool = False


_MISSPELT = {"FORM003": "typed", "FORM007": "field", "SHEET002": "header", "CONN008": "text"}
"""The detail that holds what is misspelt; of other codes it is `name`."""
LONGEST = 60  # letters of a name that are compared


def meant(guess: str | None, otherwise: str, quoted: bool = False) -> dict[str, Any]:
    """Return the details `remedy` and `guess` for a name that is not known; `otherwise` is the remedy without a guess.

    With `quoted` the guess is put into quotes.

    >>> meant("Red ball", "Choose a device.")
    {'remedy': 'Did you mean Red ball?', 'guess': 'Red ball'}
    """
    if not guess:
        return {"remedy": otherwise}
    remedy = N_("Did you mean “{guess}”?", guess=guess) if quoted else N_("Did you mean {guess}?", guess=guess)
    return {"remedy": remedy, "guess": guess}


def proposed(code: str, address: Address | None, details: Mapping[str, object]) -> tuple[Fix, ...]:
    """Return the fix `correct-spelling`, which writes the detail `guess`, as a tuple; empty without a guess."""
    wrong, guess = details.get(_MISSPELT.get(code, "name")), details.get("guess")
    if address is None or not (isinstance(wrong, str) and isinstance(guess, str) and wrong and guess):
        return ()
    title = N_("Write {value}", value=guess)
    safe = code == "CONN008" or surely(wrong, guess)
    return (Fix("correct-spelling", title, (Replace(address, wrong, guess),), safe),)


def surely(wrong: str, guess: str) -> bool:
    """Return whether a guess is surely meant: at most one typing error, or one for every four letters.

    >>> surely("Red bal", "Red ball"), surely("Sce", "Score")
    (True, False)
    """
    return slips(wrong, guess) <= max(1, len(key(wrong)) // 4)


def slips(first: str, second: str, most: int = LONGEST) -> int:
    """Count the typing errors between two names: letters missing, added, wrong, or in the wrong order.

    Beyond `most` they are not counted exactly, which is quicker for names that are not alike.

    >>> slips("Red bal", "red_ball"), slips("SQTR", "SQRT"), slips("Touch", "Say"), slips("Touch", "Say", most=2) > 2
    (1, 1, 5, True)
    """
    a, b = key(first)[:LONGEST], key(second)[:LONGEST]
    apart = max(abs(len(a) - len(b)), len(b) - sum(map(frozenset(a).__contains__, b)))
    if apart > most:
        return apart
    before: list[int] = []
    row = list(range(len(b) + 1))
    for i, x in enumerate(a, 1):
        older, before, row = before, row, [i]
        for j, y in enumerate(b, 1):
            row.append(min(before[j] + 1, row[j - 1] + 1, before[j - 1] + (x != y)))
            if i > 1 and j > 1 and x == b[j - 2] and a[i - 2] == y:
                row[j] = min(row[j], older[j - 2] + 1)
        if min(row) > most and min(before) > most:
            return most + 1
    return row[-1]
