"""An order in which each thing comes after what it needs."""

from __future__ import annotations

import heapq
from collections.abc import Callable, Collection, Mapping
from typing import TypeVar

T = TypeVar("T")


def after_needs(needs: Mapping[T, Collection[T]], place: Callable[[T], object]) -> list[T]:
    """The things in an order in which each comes after those it needs, by their places where there is a choice.

    Things in circles, and those that need them, are left out.

    Args:
        needs: by thing what it needs, each once; nothing but keys of the mapping.
        place: what is to come first; no two things share one.

    >>> after_needs({"a": ["b"], "b": [], "c": []}, "cba".index), after_needs({"a": ["b"], "b": ["a"]}, str)
    (['c', 'b', 'a'], [])
    """
    waiting = {thing: len(needed) for thing, needed in needs.items()}
    needed_by: dict[T, list[T]] = {thing: [] for thing in needs}
    for thing, needed in needs.items():
        for other in needed:
            needed_by[other].append(thing)
    ready: list[tuple[object, T]] = [(place(thing), thing) for thing, count in waiting.items() if not count]
    heapq.heapify(ready)
    order = []
    while ready:
        thing = heapq.heappop(ready)[1]
        order.append(thing)
        for other in needed_by[thing]:
            waiting[other] -= 1
            if not waiting[other]:
                heapq.heappush(ready, (place(other), other))
    return order
