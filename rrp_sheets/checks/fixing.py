"""Application of fixes to a workbook's file, round by round until none is left."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from rrp_sheets.checks.check import Checked
from rrp_sheets.diagnostics import Diagnostic
from rrp_sheets.diagnostics.report import Delete, Fix, Insert, Put, Replace
from rrp_sheets.errors import SheetsError
from rrp_sheets.model.names import key
from rrp_sheets.model.workbook import Address
from rrp_sheets.texts import N_
from rrp_sheets.workbook.edits import DeleteRows, Edit, InsertRows, SetCell, parse_typed
from rrp_sheets.workbook.files import edit, read_sheets

MOST_ROUNDS = 100
Chosen = Mapping[str, str]
"""Id of the chosen fix for the findings of a code; empty for findings with one fix only."""
_Tried = set[tuple[object, ...]]


@dataclass(frozen=True, slots=True)
class CellChange:
    """One change of the file: its place, the old and the new text; `old` is None for an inserted row."""

    place: str
    old: str | None
    new: str
    code: str
    title: str


def apply_fixes(path: Path, check: Callable[[Path], Checked], chosen: Chosen) -> tuple[list[CellChange], Checked]:
    """Apply all safe fixes, and the chosen ones, to the workbook itself; each round starts from a new check.

    Raises SheetsError when the file cannot be changed, or no finding offers a chosen fix.
    """
    changes: list[CellChange] = []
    tried: _Tried = set()
    offered: dict[str, dict[str, None]] = {}
    checked = check(path)
    for _ in range(MOST_ROUNDS):
        for d in checked.report:
            offered.setdefault(d.code, {}).update({f"{d.code}:{fix.id}": None for fix in d.fixes})
        step = _next(checked, chosen, tried)
        if not step:
            break
        changes += _carry_out(path, step)
        checked = check(path)
    for code, wanted in chosen.items():
        known = offered.get(code) or {name: None for names in offered.values() for name in names}
        fix = f"{code}:{wanted}" if wanted else code
        if not offered.get(code) or (wanted and fix not in known):
            remedy = N_("There are: {names}.", names=", ".join(known)) if known else N_("There is nothing to choose.")
            raise SheetsError(N_("No problem here has the fix “{fix}”.", fix=fix), remedy)
    return changes, checked


def _next(checked: Checked, chosen: Chosen, tried: _Tried) -> list[tuple[Diagnostic, Fix]]:
    """Return the fixes of this round: all safe ones of different cells, or else one of the chosen ones."""
    safe: dict[Address, tuple[Diagnostic, Fix]] = {}
    for d, fix in _fixes(checked, chosen):
        if fix.safe and d.address is not None and d.address not in safe:
            name = (d.address, *_name(d, fix))
            if name not in tried:
                tried.add(name)
                safe[d.address] = (d, fix)
    if safe:
        return list(safe.values())
    for d, fix in _fixes(checked, chosen):
        name = _name(d, fix)  # without its address: the fix may have moved the row down
        if not fix.safe and name not in tried:
            tried.add(name)
            return [(d, fix)]
    return []


def _name(d: Diagnostic, fix: Fix) -> tuple[object, ...]:
    return (d.code, *sorted(d.details.items()), fix.id)


def _fixes(checked: Checked, chosen: Chosen) -> Iterator[tuple[Diagnostic, Fix]]:
    """Yield the safe fix of every finding, or the one that is chosen for its code."""
    for d in checked.report:
        wanted = chosen.get(d.code)
        for fix in d.fixes:
            if fix.safe if wanted is None else fix.id == wanted or (not wanted and len(d.fixes) == 1):
                yield d, fix
                break


def _carry_out(path: Path, wanted: Sequence[tuple[Diagnostic, Fix]]) -> list[CellChange]:
    texts = {
        Address(sheet.name, row, column): cell.text or cell.formula
        for sheet in read_sheets(path)
        for (row, column), cell in sheet.cells.items()
    }
    edits: list[Edit] = []
    changes: list[CellChange] = []
    for d, fix in wanted:
        moved = 0  # rows that this fix has inserted above
        for one in fix.edits:
            if isinstance(one, Insert):
                edits.append(InsertRows(one.sheet, one.before))
                edits += [SetCell(one.sheet, one.before, column, parse_typed(text)) for column, text in one.cells]
                new = " | ".join(text for _, text in one.cells)
                place = N_("{sheet} row {row}", sheet=one.sheet, row=one.before)
                changes.append(CellChange(place, None, new, d.code, fix.title))
                moved += 1
                continue
            if isinstance(one, Delete):
                edits.append(DeleteRows(one.sheet, one.row))
                old = " | ".join(
                    text for at, text in texts.items() if (at.sheet, at.row) == (one.sheet, one.row) and text
                )
                place = N_("{sheet} row {row}", sheet=one.sheet, row=one.row)
                changes.append(CellChange(place, old, "", d.code, fix.title))
                continue
            at = one.address
            old = texts.get(Address(at.sheet, at.row - moved, at.column), "")
            text = one.text if isinstance(one, Put) else replaced(old, one)
            if text != old:
                edits.append(SetCell(at.sheet, at.row, at.column, parse_typed(text)))
                changes.append(CellChange(str(at), old, text, d.code, fix.title))
    if edits:
        edit(path, edits)
    return changes


def replaced(text: str, change: Replace) -> str:
    """Return a cell's text with the first matching word or name replaced, but none between quotes.

    >>> at = Address("T", 2, 1)
    >>> replaced("Red bal, Face", Replace(at, "red_bal", "Red ball"))
    'Red ball, Face'
    >>> replaced("abs(redBal.x)", Replace(at, "redBal", "redBall"))
    'abs(redBall.x)'
    """
    if key(text) == key(change.old):
        return change.new
    parts = re.split(r"([,\n])", text)
    for i, part in enumerate(parts):
        if key(part.strip()) == key(change.old):
            parts[i] = part.replace(part.strip(), change.new)
            return "".join(parts)
    pattern = re.compile(rf'"[^"]*"|(?<!\w)(?P<word>{re.escape(change.old)})(?!\w)', re.IGNORECASE)
    for match in pattern.finditer(text):
        if match["word"]:
            return text[: match.start()] + change.new + text[match.end() :]
    return text
