"""Bounds of formulas, for the check and for the evaluator, and the steps that work on texts takes."""

from __future__ import annotations

from collections.abc import Callable

LONGEST_FORMULA = 500  # characters
MOST_NODES = 150
DEEPEST = 30
LARGEST_NUMBER = 10**15
LONGEST_TEXT = 2_000
LONGEST_LIST = 1_000
MOST_LEAVES = 10_000  # of a result, lists within lists counted whole
MOST_LOOPS = 2
MOST_TEXTS_DEEP = 4  # texts with values in texts with values
LONGEST_FIELD = 200  # letters of a field's name that a formula works out
STEPS = 20_000  # per evaluation, shared with the helpers it calls
DEEPEST_HELPERS = 20  # helpers that call helpers that call …


LETTERS_A_STEP = 100  # so many letters are read, folded or compared in about the time of one step
PAIRS_A_STEP = 4_000  # so many pairs of letters a search compares in that time

Charge = Callable[[int], None]


def free(steps: int) -> None:
    """Charge nothing: the default of functions that charge, for calls outside of a formula."""


def letters(*texts: str) -> int:
    """Return the steps that reading texts takes.

    >>> letters("Kim"), letters("a" * 2000, "b" * 500)
    (0, 25)
    """
    return sum(map(len, texts)) // LETTERS_A_STEP


def searching(what: str, text: str) -> int:
    """Return the steps of a search for a text in another at worst: each of its letters at each place of the other.

    >>> searching("ball", "red ball"), searching("a" * 1000, "a" * 2000)
    (0, 530)
    """
    return letters(what, text) + len(what) * len(text) // PAIRS_A_STEP
