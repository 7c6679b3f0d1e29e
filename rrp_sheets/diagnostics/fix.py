"""Fixes of findings, as plain data that a program can apply."""

from __future__ import annotations

from dataclasses import dataclass

from rrp_sheets.model.workbook import Address


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
