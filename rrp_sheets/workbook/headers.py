"""Recognising a sheet by its header row."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from rrp_sheets.model.names import key, nearest
from rrp_sheets.workbook import limits
from rrp_sheets.workbook.cleaning import clean_name
from rrp_sheets.workbook.raw import RawCell, RawSheet


@dataclass(frozen=True, slots=True)
class SheetKind:
    """A kind of sheet: its name in the code, what it is called in messages, its headers with their synonyms.

    Attributes:
        any_name: a sheet of any name may be of this kind, so a header row that nearly fits is surely meant.
        open: columns with other headers belong to it too (the settings of devices, the joints of gestures).
    """

    name: str
    shown: str
    required: Mapping[str, tuple[str, ...]]
    optional: Mapping[str, tuple[str, ...]]
    any_name: bool = False
    open: bool = False

    def columns(self) -> dict[str, str]:
        """Return the standard header for the key of every accepted spelling."""
        return {
            key(spelling): header
            for headers in (self.required, self.optional)
            for header, synonyms in headers.items()
            for spelling in (header, *synonyms)
        }

    def spellings(self, header: str) -> list[str]:
        """Return the keys of every accepted spelling of a standard header."""
        return [spelling for spelling, name in self.columns().items() if name == header]


_NOTES: Mapping[str, tuple[str, ...]] = {"Notes": ("Comment",)}
BEHAVIOUR = SheetKind(
    "behaviour", "a behaviour",
    {"Input streams": ("Inputs", "Input", "From"), "Connector": ("Operator",),
     "Formula": ("Parameter", "Parameter formula"), "Output stream": ("Output", "To")},
    {"On": (), "Priority": (), **_NOTES}, any_name=True,
)  # fmt: skip
TEST = SheetKind(
    "test", "a test", {"Time (ms)": (), "Stream": (), "Send": (), "Expect": ()}, _NOTES, any_name=True
)  # fmt: skip
SCENE = SheetKind("scene", "the scene", {"Time (s)": (), "Thing": (), "Does": (), "Value": ()}, _NOTES)
HELPERS = SheetKind("helpers", "the list of helpers", {"Name": (), "Inputs": (), "Formula": ()}, _NOTES)
DEVICES = SheetKind("devices", "the list of devices", {"Stream": (), "Device": ()}, _NOTES, open=True)
GESTURES = SheetKind("gestures", "the list of gestures", {"Name": (), "Time (s)": ()}, _NOTES, open=True)
PROTOCOL = SheetKind("protocol", "the protocol", {"Field": (), "Value": ()}, _NOTES)
KINDS = (BEHAVIOUR, TEST, SCENE, HELPERS, DEVICES, GESTURES, PROTOCOL)
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
        found.extend(
            _match(kind, number, headers)
            for kind in KINDS
            if all(any(key(s) in keys for s in (h, *synonyms)) for h, synonyms in kind.required.items())
        )
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
    known = kind.columns()
    columns: dict[str, int] = {}
    others: dict[int, str] = {}
    twice: dict[int, int] = {}
    seen: dict[str, int] = {}
    for column, header in headers.items():
        name = known.get(key(header))
        if name is None:
            others[column] = header
            name = key(header) if kind.open else ""
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
    for kind in KINDS:
        missing = [h for h, synonyms in kind.required.items() if not any(key(s) in keys for s in (h, *synonyms))]
        if len(missing) != 1:
            continue
        wanted = missing[0]
        known = kind.columns()
        free = [h for h in headers.values() if key(h) not in known]
        meant = next((n for s in (wanted, *kind.required[wanted]) if (n := nearest(s, free))), None)
        certain = kind.any_name or key(sheet) == kind.name
        if meant or certain:
            found.append(NearMiss(kind, wanted, row, keys[key(meant)] if meant else 0, meant or "", certain))
    return found
