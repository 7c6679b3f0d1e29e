"""The pages that show something together: who is there, which cells they have taken, and what everyone is told."""

from __future__ import annotations

import threading
import time
from typing import Any

from rrp_sheets.web.sse import EventBacklog, EventStream


class Broadcaster:
    """The pages that show something together; from any thread.

    Attributes:
        listeners: the pages that are open.
        locks: the cells that they have taken.
    """

    def __init__(self) -> None:
        self.listeners: list[EventStream] = []
        self.locks = CellLocks()
        self._lock = threading.RLock()
        self._told = EventBacklog()

    # ---- who is there

    def _enter(self, listener: EventStream, had: str) -> None:
        """Somebody is here now; `had` is the number of what they were told last, and what they have missed follows."""
        with self._lock:
            for text in self._told.missed(listener.client, had) if had else ():
                listener.tell(text)
            listener.welcome = f"id: {self.told()}\n\n"
            self.listeners.append(listener)

    def is_of(self, client: str, person: str) -> bool:
        """Whether a page is of this session, or of nobody; also when it was loaded again."""
        mine = identity(client)
        with self._lock:
            return all(one.person == person for one in self.listeners if identity(one.client) == mine)

    def part(self, client: str) -> None:
        """A page says that it is being closed."""
        with self._lock:
            listeners = [li for li in self.listeners if li.client == client]
        for listener in listeners:
            self.leave(listener)

    def end_streams(self, client: str) -> None:
        """A page opens another stream: its older ones end, and the cells that it has taken stay its own.

        An older stream is nobody's from now on, so that its end, which its thread notices at any time later, frees no
        cell (`leave`).
        """
        with self._lock:
            older = [li for li in self.listeners if client and li.client == client]
            self.listeners = [li for li in self.listeners if li not in older]
        for listener in older:
            listener.leave()

    def leave(self, listener: EventStream) -> list[Place]:
        """The page was closed, unless it has ended this stream for another; return the cells that it had taken."""
        listener.leave()
        places: list[Place] = []
        with self._lock:
            if listener in self.listeners:
                self.listeners.remove(listener)
                places = self.locks.leave(listener.client)
        self.tell_people()
        return places

    def stand(self, client: str, name: str, place: tuple[str, str, int]) -> None:
        """Somebody's cursor is on a cell; or they have another name now."""
        with self._lock:
            for listener in self.listeners:
                if listener.client == client:
                    listener.place, listener.name = place, name or listener.name
        self.tell_people()

    # ---- what they are told

    def told(self) -> str:
        """The number of the newest thing that everyone was told."""
        with self._lock:
            return self._told.number

    def tell_people(self) -> None:
        """Tell everyone who is here."""
        with self._lock:
            people = [{"client": li.client, "name": li.name, "place": li.place} for li in self.listeners]
        self.tell("people", {"people": people})

    def tell(self, event: str, data: dict[str, Any], but: str = "") -> None:
        """Tell every page, but perhaps one, that something happened."""
        with self._lock:  # also while it is handed over: what is numbered comes in its order
            text = self._told.add(event, data, but)
            for listener in self.listeners:
                if listener.client != but:
                    listener.tell(text)

    def tell_all(self, text: str) -> None:
        """Tell every page something of the moment; `text` as it is sent."""
        with self._lock:
            listeners = list(self.listeners)
        for listener in listeners:
            listener.tell(text)

    def tell_live(self, text: str) -> None:
        """Tell every page a run's newest values, which a page that lags behind may miss; `text` as it is sent."""
        with self._lock:
            listeners = list(self.listeners)
        for listener in listeners:
            listener.tell_live(text)


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
