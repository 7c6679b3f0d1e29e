"""Heartbeat of an engine: three numbers that a watchdog in another process can read at any time.

The engine writes them as it goes: no call, no lock, no message (20 to 40 ns a row). A plain list does when nobody
watches; a run's process puts them into memory that it shares with the program that started it.
"""

from __future__ import annotations

from typing import Protocol

INSTANT, SETTLING, RANK = range(3)
"""Places: how many instants (frames) have begun; 1 while one settles, else 0; the rank of the row being worked out."""
PLACES = 3
NO_ROW = -1


class Heartbeat(Protocol):
    """Whole numbers by place: a list, or a memory view."""

    def __getitem__(self, place: int, /) -> int: ...

    def __setitem__(self, place: int, number: int, /) -> None: ...


def new_cell() -> Heartbeat:
    """A cell that nobody watches."""
    return [0, 0, NO_ROW]
