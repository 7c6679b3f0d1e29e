"""Limits of connections: timeouts, places per address, and worker threads; requests to stop a run come first."""

from __future__ import annotations

import re
import time
from collections.abc import Mapping
from typing import Any

from waitress.channel import HTTPChannel
from waitress.task import ErrorTask, ThreadedTaskDispatcher, WSGITask

from rrp_sheets.web.statics import HEADERS

MOST_CONNECTIONS = 240  # at once; macOS gives a program 256 files
MOST_OF_ONE = 80  # connections of one address
HEAD_SECONDS = 5.0  # for the head of a request, from the opening of the connection or from the head's first byte
_SLOW_SECONDS = 1.0  # a head that takes longer has to make room for others
_SPARE = 20  # of all connections: a place is free for the next one before the limit is reached
_STOP_THREADS = 2
_BUSY = 5  # how much a connection matters whose request is being answered
_STOP = re.compile(r"/book/[^/]+/run/stop")
_CHANNEL = "rrp_sheets.channel"


class Refusal(ErrorTask):  # type: ignore[misc]
    """Error response that the server sends without calling the application, with the usual security headers."""

    def execute(self) -> None:
        """Add the headers, and send the response."""
        self.response_headers += [*HEADERS.items(), ("Cache-Control", "no-store")]
        super().execute()


class _Request(WSGITask):  # type: ignore[misc]
    """Request whose WSGI environment names its connection."""

    def get_environment(self) -> Any:
        """Return the WSGI environment, with the connection added."""
        environ = super().get_environment()
        environ[_CHANNEL] = self.channel
        return environ


def let_in(environ: Mapping[str, Any]) -> None:
    """Mark the connection of a request as one of an authorised user."""
    channel = environ.get(_CHANNEL)
    if channel is not None:
        channel.is_known = True


class Channel(HTTPChannel):  # type: ignore[misc]
    """Connection of a browser, with its timeouts.

    The head of a request must arrive within 5 s, the rest within the server's time limit, even if data keeps coming.
    The number of connections of one address is limited: when it opens another, the least important one is closed. A
    connection whose request is being answered is never closed for that; those of authorised users are closed last.

    Attributes:
        is_known: a request on it came from an authorised user.
    """

    task_class = _Request
    error_task_class = Refusal
    last_activity: float
    is_known = False
    _is_over = False
    _request_began = 0.0  # by the clock of `last_activity`

    def __init__(self, server: Any, sock: Any, addr: Any, adj: Any, map: Any = None) -> None:
        super().__init__(server, sock, addr, adj, map=map)
        self._head_began: float | None = time.monotonic()  # None while no head is waited for
        self._make_room()

    def handle_read(self) -> None:
        """Read the data that has arrived, and note when a request and its head began."""
        waited = self.request is not None  # for the rest of a request
        super().handle_read()
        if not waited:
            self._request_began = self.last_activity
        elif self.request is not None:
            self.last_activity = self._request_began  # the clean-up counts from the request's beginning
        if self.request is not None and not self.request.headers_finished:
            self._head_began = self._head_began or time.monotonic()
        else:  # a thread may have answered the request already
            self._head_began = None

    def readable(self) -> bool:
        """Return whether to wait for data; called about every second, so it also closes overdue connections."""
        if self._is_over or self._is_late():
            self.handle_close()
            return False
        return bool(super().readable())

    def _is_late(self) -> bool:
        waits = self._head_began is not None and not self.requests
        return waits and time.monotonic() - (self._head_began or 0.0) > HEAD_SECONDS

    def _make_room(self) -> None:
        """Close the least important connection, if there are too many."""
        everyone = [one for one in list(self._map.values()) if isinstance(one, Channel) and not one._is_over]
        mine = [one for one in everyone if one.addr[0] == self.addr[0]]
        crowd = mine if len(mine) > MOST_OF_ONE else everyone if len(everyone) > MOST_CONNECTIONS - _SPARE else []
        if crowd:
            others = [one for one in crowd if one is not self and one._worth() < _BUSY]
            min(others, key=lambda one: (one._worth(), one.creation_time), default=self)._is_over = True

    def _worth(self) -> int:
        """Return the importance of the connection; the lowest is closed first."""
        if self.requests:
            return _BUSY
        if self._head_began is not None:
            return 0 if time.monotonic() - self._head_began > _SLOW_SECONDS else 4
        return (1 if self.request is None else 2) + (2 if self.is_known else 0)


class Dispatcher(ThreadedTaskDispatcher):  # type: ignore[misc]
    """Worker threads. Stop has its own; requests of authorised users come before all others.

    Args:
        threads: for all requests but Stop.
    """

    def __init__(self, threads: int) -> None:
        super().__init__()
        self._stops = ThreadedTaskDispatcher()
        self._stops.set_thread_count(_STOP_THREADS)
        self.set_thread_count(threads)

    def add_task(self, task: Channel) -> None:
        """Queue the request of a connection."""
        request = task.requests[0]
        if not request.error and request.command == "POST" and _STOP.fullmatch(request.path):
            self._stops.add_task(task)
            return
        with self.lock:
            place = sum(1 for one in self.queue if one.is_known or not task.is_known)
            self.queue.insert(place, task)
            self.queue_cv.notify()

    def shutdown(self, cancel_pending: bool = True, timeout: int = 5) -> bool:
        """End all threads, those for Stop included."""
        self._stops.shutdown(cancel_pending, timeout)
        return bool(super().shutdown(cancel_pending, timeout))
