"""Names of sheets: the rules of spreadsheet programs, and ours (one key for every name)."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

from rrp_sheets.errors import SheetsError
from rrp_sheets.model.names import key
from rrp_sheets.texts import N_
from rrp_sheets.workbook import limits

LONGEST = 31  # letters, as Excel counts them
FORBIDDEN = re.compile(r"[\[\]:*?/\\\x00-\x1f]")
_CONTROL = re.compile("[\x00-\x1f\x7f-\x9f\ud800-\udfff\ufffe\uffff\u202a-\u202e\u2066-\u2069]")


def sheet_name(text: str, others: Iterable[str] = ()) -> str:
    """The name as it is used, without spaces at its ends.

    Args:
        text: as somebody typed it.
        others: the names of the other sheets.

    Raises:
        SheetsError: no sheet can have this name, and why.

    >>> sheet_name("  Say  hello ")
    'Say hello'
    """
    name = " ".join(_CONTROL.sub(" ", text).split())
    if not name:
        raise SheetsError("A sheet needs a name.", "Write a short one, such as “Greeting”.")
    if found := FORBIDDEN.search(name):
        raise SheetsError(
            f"“{found[0]}” cannot stand in the name of a sheet.", r"Leave out [ ] : * ? / and \, which Excel refuses."
        )
    if len(name.encode("utf-16-le")) // 2 > LONGEST:
        count = len(name.encode("utf-16-le")) // 2
        raise SheetsError(f"This name has {count} letters; Excel takes {LONGEST}.", "Shorten it.")
    if name[0] == "'" or name[-1] == "'":
        raise SheetsError("A sheet's name cannot begin or end with an apostrophe.", N_("Leave it out."))
    if not any(c.isalnum() for c in name):
        raise SheetsError("A sheet's name needs a letter or a digit.", "Write a short one, such as “Greeting”.")
    if key(name) == "history":
        raise SheetsError("Excel keeps the name “History” for itself.", "Choose another one.")
    taken = next((other for other in others if key(other) == key(name)), "")
    if taken:
        told = "" if taken.casefold() == name.casefold() else " Capitals, spaces, - and _ make no difference."
        raise SheetsError(f"There is a sheet “{taken}” already.", f"Choose another name.{told}")
    return name


def sheet_named(names: Sequence[str], sheet: str) -> str:
    """The sheet of that name in its spelling; raises SheetsError when there is none."""
    found = [n for n in names if n == sheet] or [n for n in names if key(n) == key(sheet)]
    if not found:
        raise SheetsError(f"There is no sheet “{sheet}”.", f"The sheets are: {', '.join(names)}.")
    return found[0]


def refuse_more(names: Sequence[str]) -> None:
    """Raise SheetsError when there can be no further sheet."""
    if len(names) >= limits.SHEETS:
        raise SheetsError(
            f"A workbook has at most {limits.SHEETS} sheets.", "Delete one first, or begin another workbook."
        )


def free_name(stem: str, others: Iterable[str], number: int = 1) -> str:
    """A name that no other sheet has: the stem, with a number behind it from 2 on.

    >>> free_name("Devices", []), free_name("Behaviour", ["Tracking"], 2), free_name("Tests", ["tests", "Tests 2"])
    ('Devices', 'Behaviour 2', 'Tests 3')
    """
    taken = {key(other) for other in others}
    while True:
        end = f" {number}" if number > 1 else ""
        name = f"{stem[: LONGEST - len(end)].rstrip()}{end}"
        if key(name) not in taken:
            return name
        number += 1
