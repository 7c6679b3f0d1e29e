"""Names of sheets: the rules of spreadsheet programs, and ours (one key for every name)."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from itertools import count

from rrp_sheets.errors import SheetsError
from rrp_sheets.model.names import key
from rrp_sheets.texts import N_, listed
from rrp_sheets.workbook import limits

LONGEST = 31  # letters, as Excel counts them
FORBIDDEN = re.compile(r"[\[\]:*?/\\\x00-\x1f]")
_CONTROL = re.compile("[\x00-\x1f\x7f-\x9f\ud800-\udfff\ufffe\uffff\u202a-\u202e\u2066-\u2069]")


def sheet_name(text: str, others: Iterable[str] = ()) -> str:
    """The name as it is used, without spaces at its ends; raises SheetsError when no sheet can have this name.

    >>> sheet_name("  Say  hello ")
    'Say hello'
    """
    name = " ".join(_CONTROL.sub(" ", text).split())
    if not name:
        raise SheetsError(N_("A sheet needs a name."), N_("Write a short one, such as “Greeting”."))
    if found := FORBIDDEN.search(name):
        message = N_("The name of a sheet cannot contain “{mark}”.", mark=found[0])
        raise SheetsError(message, N_(r"Leave out [ ] : * ? / and \, which Excel refuses."))
    if (n := len(name.encode("utf-16-le")) // 2) > LONGEST:
        message = N_("This name has {n} letters; Excel takes {most}.", n=n, most=LONGEST)
        raise SheetsError(message, N_("Shorten it."))
    if name[0] == "'" or name[-1] == "'":
        raise SheetsError(N_("A sheet's name cannot begin or end with an apostrophe."), N_("Leave it out."))
    if not any(c.isalnum() for c in name):
        raise SheetsError(N_("A sheet's name needs a letter or a digit."), N_("Write a short one, such as “Greeting”."))
    if key(name) == "history":
        raise SheetsError(N_("Excel keeps the name “History” for itself."), N_("Choose another one."))
    if taken := next((other for other in others if key(other) == key(name)), ""):
        remedy = N_("Choose another name.")
        if taken.casefold() != name.casefold():
            remedy = N_("Choose another name. Capitals, spaces, - and _ make no difference.")
        raise SheetsError(N_("There is a sheet “{sheet}” already.", sheet=taken), remedy)
    return name


def sheet_named(names: Sequence[str], sheet: str) -> str:
    """The sheet of that name in its spelling; raises SheetsError when there is none."""
    found = [n for n in names if n == sheet] or [n for n in names if key(n) == key(sheet)]
    if not found:
        remedy = N_("The sheets are: {names}.", names=listed(names))
        raise SheetsError(N_("There is no sheet “{sheet}”.", sheet=sheet), remedy)
    return found[0]


def refuse_more(names: Sequence[str]) -> None:
    """Raise SheetsError when there can be no further sheet."""
    if len(names) >= limits.SHEETS:
        message = N_("A workbook has at most {n} sheets.", n=limits.SHEETS)
        raise SheetsError(message, N_("Delete one first, or start another workbook."))


def header_row(sheet: str, row: int) -> SheetsError:
    """The error for rows that cannot be changed, as the headers stand there or below."""
    told = N_("Row {row} of “{sheet}” has the headers. You cannot move them or the rows above them.",
              row=row, sheet=sheet)  # fmt: skip
    return SheetsError(told, N_("Choose rows from {row} on.", row=row + 1))


def free_name(stem: str, others: Iterable[str], number: int = 1) -> str:
    """A name that no other sheet has: the stem, with a number behind it from 2 on.

    >>> free_name("Devices", []), free_name("Behaviour", ["Tracking"], 2), free_name("Tests", ["tests", "Tests 2"])
    ('Devices', 'Behaviour 2', 'Tests 3')
    """
    taken = {key(other) for other in others}
    ends = (f" {n}" if n > 1 else "" for n in count(number))
    names = (f"{stem[: LONGEST - len(end)].rstrip()}{end}" for end in ends)
    return next(name for name in names if key(name) not in taken)
