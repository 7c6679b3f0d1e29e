"""Event streams and cell locks of the pages that show the same workbook."""

from __future__ import annotations

import json
import secrets
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

from rrp_sheets.texts import N_

LOCK_SECONDS = 120.0  # a cell is given free when its editor was silent for so long
_KEEP_ALIVE = 5.0  # seconds of silence after which a comment is sent, which shows whether the page is still there
_LASTING = frozenset({"grid", "sheets", "checked", "tested", "reload", "trouble"})  # events that are numbered and kept
_KEPT = 300  # of them: who was away for more must load the page again
_WAITING = 200  # messages that a slow browser may lag behind before it must load the page again
_MOST_LIVE = 20  # those of a run's values: whoever lags behind more gets the newest instead
Place = tuple[str, str, int]
"""Sheet, row's id, column."""


class Broadcaster:
    """Event streams of the pages that show the same workbook, and their cell locks; thread-safe."""

    def __init__(self) -> None:
        self.listeners: list[EventStream] = []
        self.locks = CellLocks()
        self._lock = threading.RLock()
        self._told = EventBacklog()

    # ---- event streams of the pages

    def _enter(self, listener: EventStream, had: str) -> None:
        """Register an event stream; if `had` is the number of an event, first send those that came after it."""
        with self._lock:
            for text in self._told.missed(listener.client, had) if had else ():
                listener.tell(text)
            listener.welcome = f"id: {self.newest_event()}\n\n"
            self.listeners.append(listener)

    def is_of(self, client: str, person: str) -> bool:
        """Return whether no stream of a page, earlier loads of it included, belongs to another session."""
        mine = identity(client)
        with self._lock:
            return all(one.person == person for one in self.listeners if identity(one.client) == mine)

    def part(self, client: str) -> None:
        """Remove the streams of a page that reports that it is being closed."""
        with self._lock:
            listeners = [li for li in self.listeners if li.client == client]
        for listener in listeners:
            self.leave(listener)

    def end_streams(self, client: str) -> None:
        """End the older streams of a page that opens a new one; its cell locks are kept.

        An older stream is no longer registered, so that `leave`, which its thread calls at any time later, releases no
        cell.
        """
        with self._lock:
            older = [li for li in self.listeners if client and li.client == client]
            self.listeners = [li for li in self.listeners if li not in older]
        for listener in older:
            listener.leave()

    def leave(self, listener: EventStream) -> list[Place]:
        """End an event stream; unless a newer one has replaced it, release the page's cells and return them."""
        listener.leave()
        places: list[Place] = []
        with self._lock:
            if listener in self.listeners:
                self.listeners.remove(listener)
                places = self.locks.leave(listener.client)
        self.tell_people()
        return places

    def stand(self, client: str, name: str, place: tuple[str, str, int]) -> None:
        """Update the cell on which a page's cursor is, and its user's name if one is given."""
        with self._lock:
            for listener in self.listeners:
                if listener.client == client:
                    listener.place, listener.name = place, name or listener.name
        self.tell_people()

    # ---- events that they are sent

    def newest_event(self) -> str:
        """Return the number of the newest numbered event."""
        with self._lock:
            return self._told.number

    def tell_people(self) -> None:
        """Send every page the list of the users present."""
        with self._lock:
            people = [{"client": li.client, "name": li.name, "place": li.place} for li in self.listeners]
        self.tell("people", {"people": people})

    def tell(self, event: str, data: dict[str, Any], but: str = "") -> None:
        """Send an event to every page except `but`."""
        with self._lock:  # also while it is handed over: what is numbered comes in its order
            text = self._told.add(event, data, but)
            for listener in self.listeners:
                if listener.client != but:
                    listener.tell(text)

    def tell_all(self, text: str) -> None:
        """Send every page an unnumbered message, which is not kept for pages that reconnect."""
        with self._lock:
            listeners = list(self.listeners)
        for listener in listeners:
            listener.tell(text)

    def tell_live(self, text: str) -> None:
        """Send every page the newest values of a run; a page that lags behind may skip them."""
        with self._lock:
            listeners = list(self.listeners)
        for listener in listeners:
            listener.tell_live(text)


def identity(client: str) -> str:
    """Return the part of a page's name that survives a reload: all before its last dot.

    >>> identity("4f1c.2")
    '4f1c'
    """
    return client.rpartition(".")[0] or client


class CellLocks:
    """Cells that are locked for editing; not thread-safe, the owner holds its own lock."""

    def __init__(self) -> None:
        self._taken: dict[Place, tuple[str, str, float]] = {}

    def holders(self, sheet: str = "") -> dict[Place, tuple[str, str]]:
        """Return the page and the name of the editor of each locked cell, of one sheet or of all."""
        old = self._expired()
        return {p: held[:2] for p, held in self._taken.items() if sheet in ("", p[0]) and p not in old}

    def _expired(self) -> list[Place]:
        now = time.monotonic()
        return [p for p, (_, _, since) in self._taken.items() if now - since > LOCK_SECONDS]

    def expire(self) -> list[Place]:
        """Release the cells that were locked too long ago, and return them."""
        return self._free(self._expired())

    def take(self, client: str, name: str, place: Place) -> str:
        """Lock a cell; return the name of the holder if another page has it, else an empty text."""
        holder = self.holders().get(place)
        if holder is not None and identity(holder[0]) != identity(client):
            return holder[1]
        self._taken[place] = (client, name, time.monotonic())
        return ""

    def release(self, client: str, place: Place) -> None:
        """Release a cell, if this page holds it."""
        if place in self._taken and self._taken[place][0] == client:
            del self._taken[place]

    def leave(self, client: str) -> list[Place]:
        """Release the cells of a page that was closed, and return them."""
        return self._free([p for p, held in self._taken.items() if held[0] == client])

    def again(self, client: str) -> list[Place]:
        """Release the cells that a page held before it was reloaded, and return them."""
        mine = identity(client)
        return self._free([p for p, held in self._taken.items() if held[0] != client and identity(held[0]) == mine])

    def _free(self, places: list[Place]) -> list[Place]:
        for place in places:
            del self._taken[place]
        return places

    def rename(self, old: str, new: str) -> None:
        """Carry the locks of a renamed sheet over to its new name."""
        self._taken = {(new if p[0] == old else p[0], *p[1:]): held for p, held in self._taken.items()}

    def others(self, client: str, sheet: str) -> list[str]:
        """Return the names of those who are editing a cell of a sheet on other pages."""
        return sorted({name for page, name in self.holders(sheet).values() if identity(page) != identity(client)})


@dataclass
class EventStream:
    """Event stream of one browser page.

    Attributes:
        person: the key of the login; empty for a browser on this computer.
        behind: it could not keep up with a run's values, and gets all of them again.
    """

    client: str
    name: str
    person: str = ""
    ready: threading.Condition = field(default_factory=threading.Condition)
    messages: deque[str] = field(default_factory=deque)
    lives: deque[str] = field(default_factory=deque)
    gone: bool = False
    behind: bool = False
    place: tuple[str, str, int] | None = None
    welcome: str = ": welcome\n\n"

    def tell(self, text: str) -> None:
        """Queue a message; a browser that lags too far behind is made to reload instead."""
        with self.ready:
            if len(self.messages) >= _WAITING:
                self.messages.clear()
                text = message("reload", {})
            self.messages.append(text)
            self.ready.notify()

    def tell_live(self, text: str) -> None:
        """Queue a message with a run's values, which may be dropped when newer ones follow."""
        with self.ready:
            if len(self.lives) >= _MOST_LIVE:
                self.lives.clear()
                self.behind = True
            if not self.behind:
                self.lives.append(text)
            self.ready.notify()

    def leave(self) -> None:
        """End the stream."""
        with self.ready:
            self.gone = True
            self.ready.notify()

    def take(self, anew: Callable[[], str]) -> str:
        """Wait for messages and return them; `anew` returns a run's state for a page that has lagged behind."""
        with self.ready:
            if not (self.messages or self.lives or self.behind or self.gone):
                self.ready.wait(_KEEP_ALIVE)
            texts = [*self.messages, *self.lives]
            behind, self.behind = self.behind, False
            self.messages.clear()
            self.lives.clear()
        if behind:
            texts.append(anew())
        return "".join(texts) or ": still here\n\n"


def message(event: str, data: dict[str, Any], number: str = "") -> str:
    """Format an event; a browser that reconnects sends the last `number` it got."""
    begin = f"id: {number}\n" if number else ""
    return f"{begin}event: {event}\ndata: {json.dumps(data, ensure_ascii=False, separators=(',', ':'))}\n\n"


class EventBacklog:
    """Numbered events that a page in the background must not miss; not thread-safe, its owner locks it."""

    def __init__(self) -> None:
        self._opened = secrets.token_hex(4)  # of this session, not of one of an earlier start
        self._count = 0
        self._kept: deque[tuple[int, str, str]] = deque(maxlen=_KEPT)  # number, whom not to tell, what

    @property
    def number(self) -> str:
        """Identifier of the newest event."""
        return f"{self._opened}.{self._count}"

    def add(self, event: str, data: dict[str, Any], but: str) -> str:
        """Format an event; number and keep it if it is of a lasting kind."""
        if event not in _LASTING:
            return message(event, data)
        self._count += 1
        text = message(event, data, self.number)
        self._kept.append((self._count, but, text))
        return text

    def missed(self, client: str, had: str) -> list[str]:
        """Return the events after the last one that a page got, or a reload if that is too long ago."""
        opened, _, number = had.partition(".")
        last = int(number) if number.isascii() and number.isdigit() and len(number) < 12 else -1
        oldest = self._kept[0][0] if self._kept else self._count + 1
        if opened != self._opened:
            return [message("reload", {"why": N_("The server was restarted.")})]
        if not oldest - 1 <= last <= self._count:
            return [message("reload", {})]
        return [text for count, but, text in self._kept if count > last and but != client]


def stream(listener: EventStream, anew: Callable[[], str], leave: Callable[[EventStream], object]) -> Iterator[str]:
    """Yield the messages for one page until it is closed; then call `leave`."""
    try:
        yield listener.welcome
        while not listener.gone:
            yield listener.take(anew)
    finally:
        leave(listener)
