"""Which row of a sheet is which, after another program has written the file."""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Mapping, Sequence

Cells = Mapping[int, str]
_MOST = 10_000  # pairs of rows that are compared cell by cell; beyond, rows are paired in their order


def match(old: Sequence[Cells], new: Sequence[Cells]) -> list[int | None]:
    """For each new row the place of the old row that it was; None for a row that came.

    Equal rows are the same row; of the others between two equal ones, those that share most cells.

    >>> match([{1: "a"}, {1: "b", 2: "x"}], [{1: "new"}, {1: "a"}, {1: "b", 2: "y"}])
    [None, 0, 1]
    """
    top, most = 0, min(len(old), len(new))
    while top < most and old[top] == new[top]:
        top += 1
    end = 0
    while end < most - top and old[-1 - end] == new[-1 - end]:
        end += 1
    found: list[int | None] = [*range(top), *([None] * (len(new) - top - end)), *range(len(old) - end, len(old))]
    left, right = old[top : len(old) - end], new[top : len(new) - end]
    matcher = difflib.SequenceMatcher(None, [_tag(c) for c in left], [_tag(c) for c in right], autojunk=False)
    for op, a, b, c, d in matcher.get_opcodes():
        for i, j in (
            zip(range(a, b), range(c, d), strict=True) if op == "equal" else _alike(left, right, (a, b), (c, d))
        ):
            found[top + j] = top + i
    return found


def _alike(
    old: Sequence[Cells], new: Sequence[Cells], some: tuple[int, int], others: tuple[int, int]
) -> Iterator[tuple[int, int]]:
    """Pairs of rows in their order, as many as there can be, so that they share as many cells as possible."""
    (a, b), (c, d) = some, others
    if (b - a) * (d - c) > _MOST:
        yield from zip(range(a, b), range(c, d), strict=False)
        return
    best = [[0] * (d - c + 1) for _ in range(b - a + 1)]
    for i in range(b - a - 1, -1, -1):
        for j in range(d - c - 1, -1, -1):
            paired = best[i + 1][j + 1] + _likeness(old[a + i], new[c + j])
            best[i][j] = max(paired, best[i + 1][j], best[i][j + 1])
    i = j = 0
    while i < b - a and j < d - c:
        if best[i][j] == best[i + 1][j + 1] + _likeness(old[a + i], new[c + j]):
            yield a + i, c + j
            i, j = i + 1, j + 1
        elif best[i][j] == best[i + 1][j]:
            i += 1
        else:
            j += 1


def _likeness(one: Cells, other: Cells) -> int:
    """One for being a pair at all, and much more for each cell with the same text."""
    return 1 + 1000 * sum(other.get(column) == text for column, text in one.items())


def _tag(cells: Cells) -> tuple[tuple[int, str], ...]:
    return tuple(sorted(cells.items()))
