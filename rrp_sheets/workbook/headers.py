"""Recognising a sheet by its header row."""

from __future__ import annotations

from collections.abc import Container, Mapping
from dataclasses import dataclass, field, replace

from rrp_sheets.model.names import key, nearest
from rrp_sheets.workbook import limits
from rrp_sheets.workbook.cleaning import clean_name
from rrp_sheets.workbook.raw import RawCell, RawSheet
from rrp_sheets.workbook.schema import SHEETS, Column, SheetKind

_KINDS = sorted(SHEETS.values(), key=lambda kind: (-len(kind.required), not kind.any_name))
"""Those with more required headers first: a header row that fits several is of the first."""


@dataclass(frozen=True, slots=True)
class NearMiss:
    """A header row that lacks one header: which, and the column of the header that may be meant (0: none)."""

    kind: SheetKind
    wanted: str
    row: int
    column: int
    header: str
    certain: bool


@dataclass(frozen=True, slots=True)
class Recognised:
    """Kind and columns of a sheet; `kind` is None for a sheet of the user's own.

    A sheet with one misspelt header is read as if it were spelt right, so that one mistake gives one finding.

    Attributes:
        row: the header row.
        columns: column by the standard header.
        others: header by column, for the columns that are not ours.
        twice: columns whose header stands already further left, with that column.
    """

    kind: SheetKind | None = None
    row: int = 0
    columns: Mapping[str, int] = field(default_factory=dict)
    others: Mapping[int, str] = field(default_factory=dict)
    twice: Mapping[int, int] = field(default_factory=dict)
    near: NearMiss | None = None


def recognise(sheet: RawSheet) -> Recognised:
    """Find the header row among the first 20 rows."""
    rows = [(n, cells) for n, cells in _head(sheet).items() if n <= limits.HEADER_ROWS]
    found: list[Recognised] = []
    for number, cells in rows:
        headers = {c: clean_name(cell.text) for c, cell in cells.items()}
        keys = {key(h) for h in headers.values()}
        found.extend(_match(kind, number, headers) for kind in _KINDS if all(_has(c, keys) for c in kind.required))
        if found:
            named = [f for f in found if f.kind and f.kind.name == key(sheet.name)]
            return (named or found)[0]
    misses = [m for number, cells in rows for m in _near_misses(sheet.name, number, cells)]
    best = min(misses, key=lambda m: (not m.certain, not m.column, m.row), default=None)
    if best is None or not best.certain or not best.column:
        return Recognised(near=best)
    meant = {c: clean_name(cell.text) for c, cell in dict(rows)[best.row].items()}
    return replace(_match(best.kind, best.row, {**meant, best.column: best.wanted}), near=best)


def _head(sheet: RawSheet) -> dict[int, dict[int, RawCell]]:
    rows: dict[int, dict[int, RawCell]] = {}
    for (row, column), cell in sheet.cells.items():
        if row <= limits.HEADER_ROWS and len(cell.text) <= 100:
            rows.setdefault(row, {})[column] = cell
    return {row: dict(sorted(rows[row].items())) for row in sorted(rows)}


def _match(kind: SheetKind, row: int, headers: Mapping[int, str]) -> Recognised:
    columns: dict[str, int] = {}
    others: dict[int, str] = {}
    twice: dict[int, int] = {}
    seen: dict[str, int] = {}
    for column, header in headers.items():
        name = kind.spellings.get(key(header))
        if name is None:
            others[column] = header
            name = key(header) if kind.other else ""
        elif name not in columns:
            columns[name] = column
        if name in seen:
            twice[column] = seen[name]
        elif name:
            seen[name] = column
    return Recognised(kind, row, columns, {c: h for c, h in others.items() if c not in twice}, twice)


def _near_misses(sheet: str, row: int, cells: Mapping[int, RawCell]) -> list[NearMiss]:
    headers = {c: clean_name(cell.text) for c, cell in cells.items()}
    keys = {key(h): c for c, h in headers.items()}
    found = []
    for kind in _KINDS:
        missing = [c for c in kind.required if not _has(c, keys)]
        if len(missing) != 1:
            continue
        wanted = missing[0]
        free = [h for h in headers.values() if key(h) not in kind.spellings]
        meant = next((n for s in (wanted.name, *wanted.synonyms) if (n := nearest(s, free))), None)
        certain = kind.any_name or key(sheet) == kind.name
        if meant or certain:
            found.append(NearMiss(kind, wanted.name, row, keys[key(meant)] if meant else 0, meant or "", certain))
    return found


def _has(column: Column, keys: Container[str]) -> bool:
    return any(key(header) in keys for header in (column.name, *column.synonyms))
