"""HTTP server: its sockets, addresses, threads and temporary folders; limits of connections; Stop comes first."""

from __future__ import annotations

import contextlib
import ipaddress
import os
import select
import shutil
import socket
import stat
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import ifaddr
from flask import Flask
from waitress.channel import HTTPChannel
from waitress.server import create_server
from waitress.task import ErrorTask, ThreadedTaskDispatcher, WSGITask

from rrp_sheets.engine.file_lock import is_locked, locked
from rrp_sheets.errors import SheetsError
from rrp_sheets.services.query_worker import MOST_OF_ALL
from rrp_sheets.texts import N_
from rrp_sheets.web.statics import HEADERS
from rrp_sheets.web.workbook_session import MOST_LISTENERS

MOST_CONNECTIONS = 240  # at once; macOS gives a program 256 files
MOST_OF_ADDRESS = 80  # connections of one address
HEAD_SECONDS = 5.0  # for the head of a request, from the opening of the connection or from the head's first byte
_SLOW_SECONDS = 1.0  # a head that takes longer has to make room for others
_SPARE = 20  # of all connections: a place is free for the next one before the limit is reached
_STOP_THREADS = 2
_STREAM_BUFFER = 65_536  # bytes that the system keeps for a page that reads slowly
_BUSY = 5  # how much a connection matters whose request is being answered
_STOP = "/run/stop"
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
        environ = super().get_environment()
        environ[_CHANNEL] = self.channel
        return environ


def let_in(environ: Mapping[str, Any]) -> None:
    """Mark the connection of a request as one of an authorised user."""
    channel = environ.get(_CHANNEL)
    if channel is not None:
        channel.is_known = True


def unsent(environ: Mapping[str, Any]) -> Callable[[], int]:
    """Return what tells how many bytes of an answer wait here for its reader; the system is to keep few of them."""
    channel = environ.get(_CHANNEL)
    if channel is None:
        return int
    with suppress(OSError, AttributeError):  # it has gone meanwhile
        channel.socket.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _STREAM_BUFFER)
    return lambda: int(channel.total_outbufs_len)


class Channel(HTTPChannel):  # type: ignore[misc]
    """Connection of a browser, with its timeouts; `is_known` when a request on it came from an authorised user.

    The head of a request must arrive within 5 s, the rest within the server's time limit, even if data keeps coming.
    The number of connections of one address is limited: when it opens another, the least important one is closed. A
    connection whose request is being answered is never closed for that; those of authorised users are closed last.
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
        waits_since = None if self.requests else self._head_began
        if self._is_over or (waits_since is not None and time.monotonic() - waits_since > HEAD_SECONDS):
            self.handle_close()
            return False
        return bool(super().readable())

    def _make_room(self) -> None:
        """Close the least important connection, if there are too many."""
        everyone = [one for one in list(self._map.values()) if isinstance(one, Channel) and not one._is_over]
        mine = [one for one in everyone if one.addr[0] == self.addr[0]]
        crowd = mine if len(mine) > MOST_OF_ADDRESS else everyone if len(everyone) > MOST_CONNECTIONS - _SPARE else []
        if crowd:
            others = [one for one in crowd if one is not self and one._worth() < _BUSY]
            min(others, key=lambda one: (one._worth(), one.creation_time), default=self)._is_over = True

    def _worth(self) -> int:
        if self.requests:
            return _BUSY
        if self._head_began is not None:
            return 0 if time.monotonic() - self._head_began > _SLOW_SECONDS else 4
        return (1 if self.request is None else 2) + (2 if self.is_known else 0)


class Dispatcher(ThreadedTaskDispatcher):  # type: ignore[misc]
    """Worker threads. Stop has its own; requests of authorised users come before all others."""

    def __init__(self, threads: int) -> None:
        super().__init__()
        self._stops = ThreadedTaskDispatcher()
        self._stops.set_thread_count(_STOP_THREADS)
        self.set_thread_count(threads)

    def add_task(self, task: Channel) -> None:
        """Queue the request of a connection."""
        request = task.requests[0]
        if not request.error and request.command == "POST" and request.path == _STOP:
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


THREADS = MOST_LISTENERS + MOST_OF_ALL + 8  # each page that listens keeps one, and the others are for requests
LARGEST_BODY = 8_500_000  # bytes; what is larger is refused while it comes, so that it fills no disk
_SWITCH_SECONDS = 0.0005  # a tenth of Python's: Stop waited up to 0.3 s for its turn among 60 pages that joined at once
_SECONDS = 60  # that a request may take to arrive, and that a connection may be silent between two requests


def make_server(app: Flask, sockets: Sequence[socket.socket]) -> Any:
    """Create a server on sockets that are bound already; `run` lets it serve."""
    everything: dict[int, Any] = {}
    server = create_server(
        app, map=everything, sockets=list(sockets), _dispatcher=Dispatcher(THREADS), ident="",
        connection_limit=MOST_CONNECTIONS,
        channel_timeout=_SECONDS, max_request_body_size=LARGEST_BODY, max_request_header_size=32_768,
        channel_request_lookahead=1,  # looks at lines that are busy too, and so sees that a page was closed
        asyncore_use_poll=hasattr(select, "poll"),
    )  # fmt: skip
    for one in everything.values():
        if hasattr(one, "channel_class"):
            one.channel_class = Channel
    return server


def run(server: Any) -> None:
    """Serve until Ctrl-C, which is taken quietly, or until the server is closed; all threads then take short turns."""
    interval = sys.getswitchinterval()
    sys.setswitchinterval(_SWITCH_SECONDS)
    try:
        server.run()
    finally:
        sys.setswitchinterval(interval)


def bind(hosts: Sequence[str], port: int | None) -> list[socket.socket]:
    """Bind sockets to addresses of this computer, all with one port; None is for a free one.

    Without the first address there is no server, and the others may be missing. Raises SheetsError for a used port.
    """
    bound: list[socket.socket] = []
    for host in hosts:
        try:
            bound.append(_bound(host, bound[0].getsockname()[1] if bound else port or 0))
        except OSError as error:
            if bound:
                continue
            why = error.strerror or N_("the system refuses it")
            raise SheetsError(
                N_("The port {port} cannot be used: {why}.", port=port, why=why),
                N_("Choose another, or leave --port out."),
            ) from error
    return bound


def _bound(host: str, port: int) -> socket.socket:
    made = socket.socket(socket.AF_INET6 if ":" in host else socket.AF_INET, socket.SOCK_STREAM)
    try:
        if sys.platform == "win32":  # there the other option lets another program take the same port
            made.setsockopt(socket.SOL_SOCKET, socket.SO_EXCLUSIVEADDRUSE, 1)
        else:
            made.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        if made.family == socket.AF_INET6:
            made.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_V6ONLY, 1)
        made.bind((host, port))
    except OSError:
        made.close()
        raise
    return made


# Addresses that belong to nobody (RFC 5737, RFC 3849): asked which way would lead there, the system names its own end.
_ELSEWHERE = ((socket.AF_INET, "192.0.2.1"), (socket.AF_INET6, "2001:db8::1"))
_INNER = ("docker", "br-", "veth", "virbr")  # networks of this computer with its own containers: nobody sits there
_LAST_RESORT = ipaddress.ip_network("169.254.0.0/16")


def own_addresses() -> tuple[str, ...]:
    """Return the network addresses of this computer, those of the default routes first; sends nothing.

    Networks without internet count too; link-local addresses (169.254…) are given when there are no others.
    """
    found: list[str] = []
    for family, elsewhere in _ELSEWHERE:
        with contextlib.suppress(OSError), socket.socket(family, socket.SOCK_DGRAM) as asked:
            asked.connect((elsewhere, 9))
            found.append(asked.getsockname()[0])
    for adapter in ifaddr.get_adapters():
        if not adapter.nice_name.startswith(_INNER):
            found += [ip.ip if isinstance(ip.ip, str) else ip.ip[0] for ip in adapter.ips]
    known = {address: ipaddress.ip_address(address) for address in found}
    leading = [a for a, ip in known.items() if not (ip.is_loopback or ip.is_link_local or ip.is_unspecified)]
    return tuple(leading or [a for a, ip in known.items() if ip in _LAST_RESORT])


def own_name() -> str:
    """Return the name for others in the same network: `anna-laptop.local`; empty if it is not usable."""
    name = socket.gethostname().casefold().removesuffix(".local")
    fine = name and name != "localhost" and all(c.isascii() and (c.isalnum() or c == "-") for c in name)
    return f"{name}.local" if fine else ""


def address_of(host: str, port: int) -> str:
    """Return the URL to type into a browser.

    >>> address_of("192.168.0.7", 8000), address_of("fd00::7", 8000)
    ('http://192.168.0.7:8000/', 'http://[fd00::7]:8000/')
    """
    return f"http://[{host}]:{port}/" if ":" in host else f"http://{host}:{port}/"


_PREFIX = "rrp-sheets-server-"
_NEW_S = 5  # so long may a server take from making its folder to holding it


@contextmanager
def own_temp_folder() -> Iterator[Path]:
    """Put the temporary files of this process and its children into a folder of their own during the block."""
    system = tempfile.gettempdir()
    with tempfile.TemporaryDirectory(prefix=_PREFIX, ignore_cleanup_errors=True) as name, locked(Path(name)):
        if is_locked(Path(name)):  # else nobody can tell which of the others are in use
            _remove_abandoned(Path(system))
        before, tempfile.tempdir = tempfile.tempdir, name
        try:
            yield Path(name)
        finally:
            tempfile.tempdir = before


def _remove_abandoned(system: Path) -> None:
    limit = time.time() - _NEW_S
    for folder in system.glob(f"{_PREFIX}*"):
        with suppress(OSError):
            about = folder.lstat()
            ours = stat.S_ISDIR(about.st_mode) and about.st_uid == os.getuid() and about.st_mtime < limit
            if ours and not is_locked(folder):
                shutil.rmtree(folder, ignore_errors=True)
