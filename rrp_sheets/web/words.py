"""Sentences for the pages: texts with formulas in backticks, cut into their pieces."""

from __future__ import annotations

import re

from rrp_sheets.render.sentences import BehaviourText
from rrp_sheets.web.pages import Piece, Sentence, Words

MOST_ROWS = 2000
_CODE = re.compile(r"(`+)(.+?)\1(?!`)")


def words_of(said: BehaviourText) -> Words:
    """A behaviour in words, as the pages show it."""
    rows = tuple(Sentence(r.number, pieces(r.text), r.active) for r in said.rows[:MOST_ROWS])
    return Words(pieces(said.paragraph), said.sensors, said.actuators, rows)


def pieces(text: str) -> tuple[Piece, ...]:
    """A text with formulas in backticks, in its pieces.

    >>> [(p.text, p.code) for p in pieces("When `x > 1` holds")]
    [('When ', False), ('x > 1', True), (' holds', False)]
    """
    found: list[Piece] = []
    end = 0
    for match in _CODE.finditer(text):
        found += [Piece(text[end : match.start()]), Piece(match[2].strip(), code=True)]
        end = match.end()
    return tuple(p for p in (*found, Piece(text[end:])) if p.text)
