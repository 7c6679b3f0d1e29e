"""Lessons: tests named “Lesson 1 …” that are done one after the other; a comment `# LESSON 1: …` says what to do.

A lesson that was not begun is no failure: it is shown as “not yet”, and the first of them as the one to do now.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from rrp_sheets.connectors import connectors
from rrp_sheets.documents.grid import Grid

_NAME = re.compile(r"lesson\s+(\d{1,3})\b", re.IGNORECASE)
_TOLD = re.compile(r"#+\s*lesson\s+(\d{1,3})\b", re.IGNORECASE)
_WORD = re.compile(r"[A-Za-z]+")
MOST_TERMS = 4
WORDS = frozenset(("stream", "event", "field", "formula", "connector", "actuator", "sensor", "trace"))
"""Words of the field that there is help on; connectors are such words too."""


@dataclass(frozen=True, slots=True)
class Lesson:
    """Place of a lesson in a workbook, and the terms that it introduces.

    Attributes:
        sheet: the behaviour whose comments describe it.
        row: the id of the row that begins it.
        terms: words with a help topic that no earlier lesson uses.
    """

    sheet: str
    row: str
    terms: tuple[str, ...]


def number_of(test: str) -> int | None:
    """Return the number of the lesson that a test belongs to; None for other tests.

    >>> number_of("Lesson 3 Name it"), number_of("Lessons"), number_of("Speaks")
    (3, None, None)
    """
    found = _NAME.match(test.strip())
    return int(found[1]) if found else None


def lessons_of(grids: Mapping[str, Grid]) -> dict[int, Lesson]:
    """Return the lessons in the behaviours of a workbook, by their numbers."""
    told: dict[int, Lesson] = {}
    met: set[str] = set()
    for grid in grids.values():
        if grid.kind != "behaviour":
            continue
        for number, row, words in _told(grid):
            terms = tuple(dict.fromkeys(t for t in _terms(words) if t not in met))
            met |= set(terms)
            told.setdefault(number, Lesson(grid.name, row, terms[:MOST_TERMS]))
    return told


def _told(grid: Grid) -> Iterator[tuple[int, str, str]]:
    """Yield the number, first row and comments of each lesson; the first includes the comments before it."""
    number, first, words = 0, "", ""
    for row in grid.rows:
        texts = grid.texts.get(row, {})
        text = texts[min(texts)].strip() if texts else ""
        if not text.startswith("#"):
            continue
        begins = _TOLD.match(text)
        if begins:
            if number:
                yield number, first, words
            number, first, words = int(begins[1]), row, "" if number else words
        words += f" {text}"
    if number:
        yield number, first, words


def _terms(words: str) -> Iterator[str]:
    """Yield the connectors and the words of the glossary in a text, in their order."""
    names = {c.name for c in connectors()}
    for word in _WORD.findall(words):
        single = word.lower().removesuffix("s")
        if word in names:
            yield word
        elif single in WORDS:
            yield single
