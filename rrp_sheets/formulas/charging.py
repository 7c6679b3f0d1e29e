"""What work costs in steps of a formula's budget: by what it reads, letters included, and never by its result alone.

What a handler or a function does in one go is charged before it is done, so that no formula takes longer than its
steps allow. `tests/test_formula_cost.py` measures every function with the largest values that there may be.
"""

from __future__ import annotations

from collections.abc import Callable

LETTERS_A_STEP = 100  # so many letters are read, folded or compared in about the time of one step
PAIRS_A_STEP = 4_000  # so many pairs of letters a search compares in that time

Charge = Callable[[int], None]


def free(steps: int) -> None:
    """What a function that charges is given when it is called outside of a formula."""


def letters(*texts: str) -> int:
    """The steps that reading texts takes.

    >>> letters("Kim"), letters("a" * 2000, "b" * 500)
    (0, 25)
    """
    return sum(map(len, texts)) // LETTERS_A_STEP


def searching(what: str, text: str) -> int:
    """The steps that looking for a text in another takes at worst: each of its letters at each place of the other.

    >>> searching("ball", "red ball"), searching("a" * 1000, "a" * 2000)
    (0, 530)
    """
    return letters(what, text) + len(what) * len(text) // PAIRS_A_STEP
