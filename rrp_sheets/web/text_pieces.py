"""Behaviours in words for the pages: sentences split at the formulas in backticks."""

from __future__ import annotations

import re

from rrp_sheets.render.sentences import BehaviourText
from rrp_sheets.web.pages import BehaviourWords, RowSentence, TextPiece

MOST_ROWS = 2000
_CODE = re.compile(r"(`+)(.+?)\1(?!`)")


def words_of(said: BehaviourText) -> BehaviourWords:
    """Convert the description of a behaviour for the pages."""
    rows = tuple(RowSentence(r.number, pieces(r.text), r.active) for r in said.rows[:MOST_ROWS])
    return BehaviourWords(pieces(said.paragraph), said.sensors, said.actuators, rows)


def pieces(text: str) -> tuple[TextPiece, ...]:
    """Split a text at its formulas in backticks.

    >>> [(p.text, p.code) for p in pieces("When `x > 1` holds")]
    [('When ', False), ('x > 1', True), (' holds', False)]
    """
    found: list[TextPiece] = []
    end = 0
    for match in _CODE.finditer(text):
        found += [TextPiece(text[end : match.start()]), TextPiece(match[2].strip(), code=True)]
        end = match.end()
    return tuple(p for p in (*found, TextPiece(text[end:])) if p.text)
