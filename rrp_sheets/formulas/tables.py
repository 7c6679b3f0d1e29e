"""Tables: the user's own sheets, as formulas use them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from rrp_sheets.formulas.limits import LARGEST_NUMBER
from rrp_sheets.model.names import key
from rrp_sheets.model.values import Field, Record, RecordType, Value

_NUMBER = re.compile(r"[+-]?(0|[1-9]\d{0,15}|(?=\.\d))(\.\d{0,16})?([eE][+-]?\d{1,2})?", re.ASCII)
_TRUTHS = {"true": True, "false": False}


@dataclass(frozen=True, eq=False)
class Table:
    """A sheet as a list of records. It is read-only and does not travel on streams; its rows may.

    Attributes:
        type: of a row: a field for each column that has a header.
    """

    name: str
    type: RecordType
    rows: tuple[Record, ...]

    def column(self, name: str) -> list[Value]:
        """Return the values of a column from top to bottom; raises KeyError when there is none of that name."""
        k = self.type.keys[key(name)]
        return [row.values[k] for row in self.rows]

    def __len__(self) -> int:
        return len(self.rows)

    def __deepcopy__(self, memo: dict[int, Any]) -> Table:
        return self


def make_table(name: str, rows: Sequence[Sequence[str]]) -> Table:
    """Return a table from its cells' texts, the header first. Of columns with one name, the first counts.

    >>> table = make_table("Parts", [["Ask", "Zone"], ["Where is my head?", "1"], ["And my hand?", ""]])
    >>> table.rows[0], table.column("zone")
    (Parts(Ask='Where is my head?', Zone=1), [1, None])
    """
    header = rows[0] if rows else ()
    places: dict[str, int] = {}
    for i, title in enumerate(header):
        if key(title):
            places.setdefault(key(title), i)
    cells = [{k: value_of(row[i]) if i < len(row) else None for k, i in places.items()} for row in rows[1:]]
    fields = []
    for k, i in places.items():
        values = [row[k] for row in cells]
        filled = [v for v in values if v is not None]
        kinds = {"truth" if isinstance(v, bool) else "text" if isinstance(v, str) else "number" for v in filled}
        example = values[0] if values else None
        fields.append(Field(header[i], kinds.pop() if len(kinds) == 1 else "any", example=example))
    kind = RecordType(name, tuple(fields))
    return Table(name, kind, tuple(Record(kind, row) for row in cells))


def value_of(text: str) -> Value:
    """Return the value of a cell's text: a number, TRUE or FALSE, blank, or the text.

    Numbers with leading zeros (`007`, `0170 123`) are names of something, not amounts.

    >>> [value_of(t) for t in ("2", "-0.5", "TRUE", "", "007", "2 m")]
    [2, -0.5, True, None, '007', '2 m']
    """
    short = text.strip().replace("−", "-")
    if not short:
        return None
    if _NUMBER.fullmatch(short):
        found = float(short) if any(c in short for c in ".eE") else int(short)
        return found if abs(found) <= LARGEST_NUMBER else text
    return _TRUTHS.get(short.casefold(), text)
