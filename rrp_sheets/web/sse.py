"""Server-sent events: the streams of pages, and the backlog for pages that reconnect."""

from __future__ import annotations

import json
import secrets
import threading
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

_KEEP_ALIVE = 5.0  # seconds of silence after which a comment is sent, which shows whether the page is still there
_LASTING = frozenset({"grid", "sheets", "checked", "tested", "reload", "trouble"})
_KEPT = 300  # of them: who was away for more must load the page again
_WAITING = 200  # messages that a slow browser may lag behind before it must load the page again
_MOST_LIVE = 20  # those of a run's values: whoever lags behind more gets the newest instead


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
        self._opened = secrets.token_hex(4)  # tells this room from one of an earlier start
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
            return [message("reload", {"why": "The server was restarted."})]
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
