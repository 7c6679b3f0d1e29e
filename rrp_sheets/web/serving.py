"""The server itself: its sockets, its threads, and the limits of what a connection may take."""

from __future__ import annotations

import select
import socket
import sys
from collections.abc import Sequence
from typing import Any

from flask import Flask
from waitress.channel import HTTPChannel
from waitress.server import create_server
from waitress.task import ErrorTask

from rrp_sheets.errors import SheetsError
from rrp_sheets.runs.records.clerk import MOST_OF_ALL
from rrp_sheets.web.desk import MOST_LISTENERS
from rrp_sheets.web.headers import HEADERS

THREADS = MOST_LISTENERS + MOST_OF_ALL + 8  # each page that listens keeps one, and the others are for requests
LARGEST_BODY = 8_500_000  # bytes; what is larger is refused while it comes, so that it fills no disk
MOST_CONNECTIONS = 240  # at once; macOS gives a program 256 files
MOST_OF_ONE = 80  # connections of one address, so that nobody takes them all
_SECONDS = 60  # that a request may take to arrive, and that a connection may be silent


def make_server(app: Flask, sockets: Sequence[socket.socket]) -> Any:
    """A server that answers on sockets which are bound already; `.run()` serves until Ctrl-C."""
    everything: dict[int, Any] = {}
    server = create_server(
        app, map=everything, sockets=list(sockets), threads=THREADS, ident="", connection_limit=MOST_CONNECTIONS,
        channel_timeout=_SECONDS, max_request_body_size=LARGEST_BODY, max_request_header_size=32_768,
        channel_request_lookahead=1,  # looks at lines that are busy too, and so sees that a page was closed
        asyncore_use_poll=hasattr(select, "poll"),
    )  # fmt: skip
    for one in everything.values():
        if hasattr(one, "channel_class"):
            one.channel_class = _Channel
    return server


def bind(hosts: Sequence[str], port: int | None) -> list[socket.socket]:
    """Sockets for addresses of this computer, all with one port.

    Args:
        hosts: addresses; without the first there is no server, and the others may be missing on this computer.
        port: None takes a free one.

    Raises:
        SheetsError: the port cannot be used.
    """
    bound: list[socket.socket] = []
    for host in hosts:
        try:
            bound.append(_bound(host, bound[0].getsockname()[1] if bound else port or 0))
        except OSError as error:
            if bound:
                continue
            why = error.strerror or "the system refuses it"
            raise SheetsError(
                f"The port {port} cannot be used: {why}.", "Choose another, or leave --port out."
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


class _Refusal(ErrorTask):  # type: ignore[misc]
    """What the server answers before the application is asked, with the same headers as every other answer."""

    def execute(self) -> None:
        self.response_headers += [*HEADERS.items(), ("Cache-Control", "no-store")]
        super().execute()


class _Channel(HTTPChannel):  # type: ignore[misc]
    """A connection. One address gets only so many, and a request must arrive in time, however lively it trickles."""

    error_task_class = _Refusal
    last_activity: float
    _begun = 0.0

    def __init__(self, server: Any, sock: socket.socket, addr: Any, adj: Any, map: Any = None) -> None:
        super().__init__(server, sock, addr, adj, map=map)
        mine = sum(1 for channel in list(server.active_channels.values()) if channel.addr[0] == addr[0])
        if mine > MOST_OF_ONE:
            self.handle_close()

    def handle_read(self) -> None:
        waited = self.request is not None  # for the rest of a request
        super().handle_read()
        if not waited:
            self._begun = self.last_activity
        elif self.request is not None:
            self.last_activity = self._begun  # the clean-up counts from the request's beginning
