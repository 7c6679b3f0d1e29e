"""Wraps texts in which some words are marked."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from rrp_sheets.model.changed import Run
from rrp_sheets.render.measure import clean, wrap

Line = tuple[Run, ...]
SetInLines = Callable[[str, int, int], tuple[str, ...]]


def marked_lines(
    runs: Sequence[Run], most_columns: int, most_lines: int, set_in_lines: SetInLines = wrap
) -> tuple[Line, ...]:
    """Wrap a text and keep the marks on its words; `set_in_lines` decides whether it may be cut.

    >>> marked_lines(((False, "steady < "), (True, "20")), 22, 3)
    (((False, 'steady < '), (True, '20')),)
    >>> marked_lines(((False, "one two "), (True, "three four")), 9, 3)
    (((False, 'one two'),), ((True, 'three'),), ((True, 'four'),))
    """
    marks = [marked for marked, text in runs for character in text if not character.isspace()]
    whole = clean("".join(text for _, text in runs))
    if not whole:
        return ()
    out, at = [], 0
    for line in set_in_lines(whole, most_columns, most_lines):
        parts: list[tuple[bool, str]] = []
        for character in line:
            if character.isspace():
                marked = parts[-1][0] if parts else False
                if not (at < len(marks) and marks[at] == marked):
                    marked = False  # a space between what is marked and what is not belongs to neither
            else:
                marked = marks[at] if at < len(marks) else False
                at += 1
            if parts and parts[-1][0] == marked:
                parts[-1] = (marked, parts[-1][1] + character)
            else:
                parts.append((marked, character))
        out.append(tuple(parts))
    return tuple(out)


def plain(line: Line) -> str:
    """Return the text of a line without its marks."""
    return "".join(text for _, text in line)
