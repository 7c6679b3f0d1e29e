"""PICK's draws: each member once before any repeats, never the same twice running; the seed decides."""

from __future__ import annotations

import random
from collections.abc import Sequence

from rrp_sheets.formulas.limits import Charge, free
from rrp_sheets.formulas.operations import same
from rrp_sheets.model.values import Value


class Picker:
    """The draws of one row's formula in one run; those of its PICKs that draw from one list share its sequence.

    Rows draw independently of each other; `row` is the ref of one (`Tracking!4`).

    >>> picker = Picker(7, "Play!3")
    >>> sorted(picker.pick("", ["a", "b", "c"]) for _ in range(3))
    ['a', 'b', 'c']
    """

    def __init__(self, seed: int, row: str) -> None:
        self._name = f"{seed}\n{row}"
        self._sites: dict[str, _Site] = {}

    def pick(self, site: str, members: Sequence[Value], charge: Charge = free) -> Value:
        """Return the next member for one PICK of the formula; `members` is not empty, `charge` gets the steps."""
        if site not in self._sites:
            # seeded with a text, Python hashes it the same way everywhere
            self._sites[site] = _Site(random.Random(f"{self._name}\n{site}"))
        return self._sites[site].draw(members, charge)


class _Site:
    """Draws of one PICK, as places of the list, so that a list of the same length continues the sequence."""

    def __init__(self, chance: random.Random) -> None:
        self._chance = chance
        self._count = 0
        self._left: list[int] = []
        self._last: list[Value] = []

    def draw(self, members: Sequence[Value], charge: Charge) -> Value:
        if len(members) != self._count or not self._left:
            self._count = len(members)
            self._left = list(range(len(members)))
        fresh = [i for i in self._left if not any(_equal(members[i], last, charge) for last in self._last)]
        choice = fresh or self._left
        # only random() is promised to stay the same between versions of Python
        place = choice[int(self._chance.random() * len(choice))]
        self._left.remove(place)
        self._last = [members[place]]
        return members[place]


def _equal(member: Value, last: Value, charge: Charge) -> bool:
    """Return whether two draws are equal; lists are compared by identity alone."""
    return member is last or (not isinstance(member, (list, tuple)) and same(member, last, charge))
