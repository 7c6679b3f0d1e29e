"""Who is editing which cell."""

from __future__ import annotations

import time

LOCK_SECONDS = 120.0  # a cell is given free when its editor was silent for so long
Place = tuple[str, str, int]
"""Sheet, row's id, column."""


def identity(client: str) -> str:
    """What stays the same of a page's name when the page is loaded again: all before its last dot.

    >>> identity("4f1c.2")
    '4f1c'
    """
    return client.rpartition(".")[0] or client


class CellLocks:
    """The cells that are taken for editing; whoever owns it calls it under a thread lock."""

    def __init__(self) -> None:
        self._taken: dict[Place, tuple[str, str, float]] = {}

    def taken(self, sheet: str = "") -> dict[Place, str]:
        """Who is editing which cell, of one sheet or of all."""
        old = self._expired()
        return {p: name for p, (_, name, _) in self._taken.items() if sheet in ("", p[0]) and p not in old}

    def _expired(self) -> list[Place]:
        now = time.monotonic()
        return [p for p, (_, _, since) in self._taken.items() if now - since > LOCK_SECONDS]

    def expire(self) -> list[Place]:
        """Give free what was taken too long ago; the places."""
        return self._free(self._expired())

    def take(self, client: str, name: str, place: Place) -> str:
        """Take a cell; who has it already, or an empty text."""
        holder = self.taken().get(place)
        if holder is not None and identity(self._taken[place][0]) != identity(client):
            return holder
        self._taken[place] = (client, name, time.monotonic())
        return ""

    def release(self, client: str, place: Place) -> None:
        """Give a cell free."""
        if self._taken.get(place, ("",))[0] == client:
            del self._taken[place]

    def leave(self, client: str) -> list[Place]:
        """Somebody's page was closed: give free what it had; the places."""
        return self._free([p for p, held in self._taken.items() if held[0] == client])

    def again(self, client: str) -> list[Place]:
        """A page is loaded again, and edits nothing yet: give free what it had; the places."""
        mine = identity(client)
        return self._free([p for p, held in self._taken.items() if held[0] != client and identity(held[0]) == mine])

    def _free(self, places: list[Place]) -> list[Place]:
        for place in places:
            del self._taken[place]
        return places

    def rename(self, old: str, new: str) -> None:
        """A sheet has another name now."""
        self._taken = {(new if p[0] == old else p[0], *p[1:]): held for p, held in self._taken.items()}

    def holders(self, sheet: str) -> dict[Place, tuple[str, str]]:
        """Whose page edits which cell of a sheet, and that person's name."""
        return {place: (self._taken[place][0], name) for place, name in self.taken(sheet).items()}

    def others(self, client: str, sheet: str) -> list[str]:
        """Who else is editing a cell of a sheet."""
        taken = self.taken(sheet)
        return sorted({name for place, name in taken.items() if identity(self._taken[place][0]) != identity(client)})
