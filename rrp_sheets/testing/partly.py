"""Part of a workbook with errors that can be tested: while one row is being typed, the tests of others go on."""

from __future__ import annotations

from dataclasses import dataclass, replace

from rrp_sheets.checks import Checked, check_workbook
from rrp_sheets.diagnostics import Report
from rrp_sheets.model.names import key
from rrp_sheets.model.workbook import Address, Behaviour, Workbook
from rrp_sheets.workbook import Reading

_ROUNDS = 8  # of leaving out what has errors; each may bring others to light


@dataclass(frozen=True)
class Partly:
    """A workbook without what has errors.

    Attributes:
        checked: has no errors; None where those that there are concern all of it.
        rows: the rows with errors, which are taken as switched off with those that follow from them.
        waiting: the names of the test sheets that have errors themselves, or need what has.
        errors: how many errors the whole workbook has.
    """

    checked: Checked | None
    rows: tuple[Address, ...] = ()
    waiting: tuple[str, ...] = ()
    errors: int = 0


def in_order(reading: Reading) -> Partly:
    """The part of a workbook that has no errors.

    Args:
        reading: the workbook, and what reading it has found, to which the check's findings are added.
    """
    book = reading.workbook
    checked = check_workbook(book, reading.report, lints=False)
    errors = len(checked.report.errors)
    rows: dict[Address, None] = {}
    waiting: dict[str, None] = {}
    for _ in range(_ROUNDS):
        found = checked.report.errors
        if not found:
            return Partly(checked, tuple(rows), tuple(waiting), errors)
        places = [d.address for d in found if d.address is not None]
        if len(places) < len(found):
            break  # something about the whole file
        smaller = _without(book, places, rows, waiting)
        if smaller is None:
            break
        book = smaller
        checked = check_workbook(book, Report(), lints=False)
    return Partly(None, tuple(rows), tuple(waiting), errors)


def _without(
    book: Workbook, places: list[Address], rows: dict[Address, None], waiting: dict[str, None]
) -> Workbook | None:
    """A workbook without these places, which are noted; None when one of them cannot be left out."""
    behaviours = {key(b.name): b for b in book.behaviours}
    tests = {key(t.name): t for t in book.tests}
    scene = {a.sheet for r in book.scene or () for a in (r.time.address, r.does.address)}
    for at in places:
        sheet = key(at.sheet)
        if sheet in behaviours:
            smaller = _row_off(behaviours[sheet], at.row)
            if smaller is None:
                return None
            behaviours[sheet] = smaller
            rows[Address(at.sheet, at.row)] = None
        elif sheet in tests:
            waiting[tests[sheet].name] = None
        elif at.sheet in scene:
            book = replace(book, scene=None)  # tests need none
        else:
            return None
    return replace(
        book,
        behaviours=tuple(behaviours.values()),
        tests=tuple(t for t in tests.values() if t.name not in waiting),
    )


def _row_off(behaviour: Behaviour, number: int) -> Behaviour | None:
    """A behaviour with a row switched off, and the rows below that take what it gives by a blank input.

    A row that is off already, and has errors all the same, goes.
    """
    place = next((i for i, row in enumerate(behaviour.rows) if row.number == number), None)
    if place is None:
        return None
    rows = list(behaviour.rows)
    if not rows[place].on:
        del rows[place]
        return replace(behaviour, rows=tuple(rows))
    rows[place] = replace(rows[place], on=False)
    for i in range(place + 1, len(rows)):
        if rows[i].inputs:
            break
        rows[i] = replace(rows[i], on=False)
    return replace(behaviour, rows=tuple(rows))
