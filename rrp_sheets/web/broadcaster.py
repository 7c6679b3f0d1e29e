"""The pages that show something together: who is there, which cells they have taken, and what everyone is told."""

from __future__ import annotations

import threading
from typing import Any

from rrp_sheets.web.cell_locks import CellLocks, Place, identity
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
