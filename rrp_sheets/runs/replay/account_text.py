"""Wording that all parts of a replay share: rows, values, times, lines of the account."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from rrp_sheets.diagnostics.phrase import Phrase
from rrp_sheets.model.values import record_from_mapping, show

_LONGEST = 60  # letters of a value


def in_words(row: str) -> str:
    """Return a row as people name it.

    >>> in_words("Tracking!5"), in_words("")
    ('Tracking row 5', 'a row')
    """
    sheet, mark, number = row.rpartition("!")
    return Phrase("{sheet} row {number}", sheet=sheet, number=number) if mark else row or "a row"


@dataclass(frozen=True)
class AccountLine:
    """One sentence on a difference that a replay found.

    Attributes:
        when: in words: `12.4 s`, or `6 to 6.9 s`.
        us: when it begins.
        text: what is different then.
        row: whose it is, in the workbook that was played, or in the one that ran if that has none.
    """

    when: str
    us: int
    text: str
    row: str


def shown(value: Any) -> str:
    """Return a short text of a value."""
    return show(_value(value), _LONGEST).strip()


def _value(value: Any) -> Any:
    if isinstance(value, dict):
        return record_from_mapping("", {str(n): _value(v) for n, v in value.items()})
    return [_value(v) for v in value] if isinstance(value, list) else value


def in_seconds(us: int, digits: int = 3) -> str:
    """Format a time of the run, to so many digits.

    >>> in_seconds(12_400_000), in_seconds(33_333), in_seconds(600_000_000)
    ('12.4 s', '0.033 s', '600 s')
    """
    return Phrase("{n:.10g} s", n=round(us / 1e6, digits))
