"""Words that all parts of a replay say."""

from __future__ import annotations


def in_words(row: str) -> str:
    """A row as people name it.

    >>> in_words("Tracking!5"), in_words("")
    ('Tracking row 5', 'a row')
    """
    sheet, mark, number = row.rpartition("!")
    return f"{sheet} row {number}" if mark else row or "a row"
