"""HTTP server: its sockets, threads and limits, its addresses, and its temporary folders."""

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
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import ifaddr
from flask import Flask
from waitress.server import create_server

from rrp_sheets.engine.file_lock import is_locked, locked
from rrp_sheets.errors import SheetsError
from rrp_sheets.services.query_worker import MOST_OF_ALL
from rrp_sheets.texts import N_
from rrp_sheets.web.collab.workbook_session import MOST_LISTENERS
from rrp_sheets.web.connections import MOST_CONNECTIONS, Channel, Dispatcher

THREADS = MOST_LISTENERS + MOST_OF_ALL + 8  # each page that listens keeps one, and the others are for requests
LARGEST_BODY = 8_500_000  # bytes; what is larger is refused while it comes, so that it fills no disk
_SECONDS = 60  # that a request may take to arrive, and that a connection may be silent between two requests


def make_server(app: Flask, sockets: Sequence[socket.socket]) -> Any:
    """Create a server on sockets that are bound already; `.run()` serves until Ctrl-C."""
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


def bind(hosts: Sequence[str], port: int | None) -> list[socket.socket]:
    """Bind sockets to addresses of this computer, all with one port.

    Args:
        hosts: addresses; without the first there is no server, and the others may be missing on this computer.
        port: None for a free one.

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

    Networks without internet count too: a router, or a cable between two computers, whose
    link-local addresses (169.254…) are given when there are no others.
    """
    found: list[str] = []
    for family, elsewhere in _ELSEWHERE:
        with contextlib.suppress(OSError), socket.socket(family, socket.SOCK_DGRAM) as asked:
            asked.connect((elsewhere, 9))
            found.append(asked.getsockname()[0])
    for adapter in ifaddr.get_adapters():
        if not adapter.nice_name.startswith(_INNER):
            found += [ip.ip if isinstance(ip.ip, str) else ip.ip[0] for ip in adapter.ips]
    leading = [address for address in dict.fromkeys(found) if _leads_here(address)]
    last = [a for a in dict.fromkeys(found) if ipaddress.ip_address(a) in _LAST_RESORT]
    return tuple(leading or last)


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


def _leads_here(address: str) -> bool:
    try:
        known = ipaddress.ip_address(address)
    except ValueError:
        return False
    return not (known.is_loopback or known.is_link_local or known.is_unspecified)


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
    """Remove the folders that servers of this user left behind."""
    limit = time.time() - _NEW_S
    for folder in system.glob(f"{_PREFIX}*"):
        with suppress(OSError):
            about = folder.lstat()
            ours = stat.S_ISDIR(about.st_mode) and about.st_uid == os.getuid() and about.st_mtime < limit
            if ours and not is_locked(folder):
                shutil.rmtree(folder, ignore_errors=True)
