"""Makes fixes from remedies that propose a spelling, and counts the typing errors between names."""

from __future__ import annotations

import re
from collections.abc import Mapping

from rrp_sheets.diagnostics.fix import Fix, Put, Replace
from rrp_sheets.diagnostics.phrase import Phrase
from rrp_sheets.model.cells import Address
from rrp_sheets.model.names import key

_MEANT = re.compile(r"Did you mean “?(?P<guess>[^?”]{1,80})”?\?")
_DECIMAL = re.compile(r"Write (?P<whole>\d+)\.(?P<part>\d+)[.;]")
_WRONG = {"FORM007": "field", "FORM017": "column", "SHEET002": "header", "CONN008": "text"}
"""The detail that holds what is misspelt; of other codes it is `name`."""
_DECIMAL_COMMA = "A decimal comma"
LONGEST = 60  # letters of a name that are compared


def proposed(code: str, address: Address | None, details: Mapping[str, object], remedy: str) -> tuple[Fix, ...]:
    """Return the fix that a remedy proposes, as a tuple; empty if it proposes none."""
    if address is None:
        return ()
    if code == "CONN010":
        text = str(details["text"])
        return (Fix(Phrase("Write {value}", value=f"{text} s"), (Put(address, f"{text} s"),), safe=True),)
    comma = _DECIMAL.match(remedy)
    if code == "FORM003" and details.get("what") == _DECIMAL_COMMA and comma:
        old, new = f"{comma['whole']},{comma['part']}", f"{comma['whole']}.{comma['part']}"
        return (Fix(Phrase("Write {value}", value=new), (Replace(address, old, new),), safe=True),)
    meant = _MEANT.match(remedy)
    wrong = details.get(_WRONG.get(code, "name"))
    if meant is None or not isinstance(wrong, str) or not wrong:
        return ()
    guess = meant["guess"].strip()
    return (
        Fix(
            Phrase("Write {value}", value=guess),
            (Replace(address, wrong, guess),),
            safe=code == "CONN008" or surely(wrong, guess),
        ),
    )


def surely(wrong: str, guess: str) -> bool:
    """Return whether a guess is surely meant: at most one typing error, or one for every four letters.

    >>> surely("Red bal", "Red ball"), surely("Sce", "Score")
    (True, False)
    """
    return slips(wrong, guess) <= max(1, len(key(wrong)) // 4)


def slips(first: str, second: str, most: int = LONGEST) -> int:
    """Count the typing errors between two names: letters missing, added, wrong, or in the wrong order.

    Args:
        first: a name in any spelling.
        second: the other.
        most: beyond that many they are not counted exactly; it is quicker for names that are not alike.

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
