"""Pairs corresponding elements of two lists, and finds those that changed their order, without quadratic cost."""

from __future__ import annotations

import bisect
import difflib
from collections import defaultdict, deque
from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from itertools import pairwise
from typing import TypeVar

A = TypeVar("A")

_CANDIDATES = 10  # looked at for each thing: the nearest of those that share something with it
_NEAR = 2
_MOST_ORDERED = 400  # things that are compared each with each


class Pairs:
    """Pairs of indexes into two lists, found in several passes."""

    def __init__(self, first: int, second: int) -> None:
        self.to: dict[int, int] = {}
        self.back: dict[int, int] = {}
        self._sizes = (first, second)

    def add(self, a: int, b: int) -> None:
        """Pair an index of the first list with one of the second."""
        self.to[a], self.back[b] = b, a

    def inverse(self) -> Pairs:
        """Return the same pairs, from the second list to the first."""
        other = Pairs(self._sizes[1], self._sizes[0])
        other.to, other.back = self.back, self.to
        return other

    @property
    def left(self) -> list[int]:
        """Indexes of the first list that have no partner yet."""
        return [i for i in range(self._sizes[0]) if i not in self.to]

    @property
    def right(self) -> list[int]:
        """Indexes of the second list that have no partner yet."""
        return [i for i in range(self._sizes[1]) if i not in self.back]

    def by_key(
        self,
        first: Sequence[A],
        second: Sequence[A],
        of_first: Callable[[A], Hashable],
        of_second: Callable[[A], Hashable],
    ) -> None:
        """Pair elements with the same key, in order; a key of None pairs nothing."""
        waiting: dict[Hashable, deque[int]] = defaultdict(deque)
        for j in self.right:
            k = of_second(second[j])
            if k is not None:
                waiting[k].append(j)
        for i in self.left:
            queue = waiting.get(of_first(first[i]))
            if queue:
                self.add(i, queue.popleft())

    def in_order(self, first: Sequence[Hashable], second: Sequence[Hashable]) -> None:
        """Pair equal elements at the beginning and at the end, and between them those in the same order."""
        begin, end = 0, 0
        least = min(len(first), len(second))
        while begin < least and first[begin] == second[begin]:
            self.add(begin, begin)
            begin += 1
        while end < least - begin and first[-1 - end] == second[-1 - end]:
            end += 1
            self.add(len(first) - end, len(second) - end)
        a, b = first[begin : len(first) - end], second[begin : len(second) - end]
        if max(len(a), len(b)) > _MOST_ORDERED:
            return
        for block in difflib.SequenceMatcher(None, a, b, autojunk=False).get_matching_blocks():
            for n in range(block.size):
                self.add(begin + block.a + n, begin + block.b + n)

    def between(self, alike: Callable[[int, int], bool]) -> None:
        """Pair, by position, elements between the same partners: a single one, or those that `alike` accepts."""
        for (i, j), (k, m) in _gaps(self.to, self._sizes):
            if k - i != m - j:
                continue
            for n in range(1, k - i):
                if (k - i == 2 or alike(i + n, j + n)) and i + n not in self.to and j + n not in self.back:
                    self.add(i + n, j + n)

    def by_likeness(
        self,
        first: Sequence[A],
        second: Sequence[A],
        features: Callable[[A], Iterable[Hashable]],
        score: Callable[[A, A], float],
        least: float,
    ) -> None:
        """Pair similar elements, the most similar first; only those that share a feature or stand near are scored."""
        left, right = self.left, self.right
        if not left or not right:
            return
        places: dict[Hashable, list[int]] = defaultdict(list)  # places within `right`, ascending
        for place, j in enumerate(right):
            for feature in features(second[j]):
                places[feature].append(place)
        found: list[tuple[float, int, int, int]] = []
        for place, i in enumerate(left):
            here = place * len(right) // len(left)
            near = set(range(max(0, here - _NEAR), min(len(right), here + _NEAR + 1)))
            for feature in features(first[i]):
                near.update(_nearest(places.get(feature, ()), here))
            for other in near:
                alike = score(first[i], second[right[other]])
                if alike >= least:
                    found.append((-alike, abs(other - here), i, right[other]))
        for _, _, i, j in sorted(found):
            if i not in self.to and j not in self.back:
                self.add(i, j)

    def moved(self, turned: bool = False) -> set[int]:
        """Return the indexes of the first list whose partners changed their order among the others' partners.

        Args:
            turned: look from the second list. Of two that were swapped one has moved: it is to be the same one
                whichever list is the first.
        """
        pairs = sorted((j, i) for i, j in self.to.items()) if turned else sorted(self.to.items())
        names = out_of_order([a for a, _ in pairs], [b for _, b in pairs])
        return {self.back[j] for j in names} if turned else names


def _gaps(to: Mapping[int, int], sizes: tuple[int, int]) -> list[tuple[tuple[int, int], tuple[int, int]]]:
    """Return neighbouring pairs with elements between them in both lists; the ends of the lists count as pairs."""
    pairs = [(-1, -1), *sorted(to.items()), sizes]
    return [(a, b) for a, b in pairwise(pairs) if b[0] - a[0] > 1 and b[1] - a[1] > 1]


def _nearest(places: Sequence[int], here: int) -> Sequence[int]:
    middle = bisect.bisect_left(places, here)
    start = max(0, min(middle - _CANDIDATES // 2, len(places) - _CANDIDATES))
    return places[start : start + _CANDIDATES]


def out_of_order(names: Sequence[A], places: Sequence[int]) -> set[A]:
    """Return the fewest names without which the places ascend.

    >>> sorted(out_of_order("abcd", [0, 2, 3, 1]))
    ['d']
    """
    tails: list[int] = []  # the last place of the best run of each length
    at: list[int] = []  # and whose it is
    before: list[int] = [-1] * len(places)
    for i, place in enumerate(places):
        length = bisect.bisect_left(tails, place)
        before[i] = at[length - 1] if length else -1
        if length == len(tails):
            tails.append(place)
            at.append(i)
        else:
            tails[length], at[length] = place, i
    keep: set[int] = set()
    i = at[-1] if at else -1
    while i >= 0:
        keep.add(i)
        i = before[i]
    return {name for i, name in enumerate(names) if i not in keep}
