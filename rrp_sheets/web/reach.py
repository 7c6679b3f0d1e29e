"""By which names and addresses others reach this computer."""

from __future__ import annotations

import contextlib
import ipaddress
import socket

# Addresses that belong to nobody (RFC 5737, RFC 3849): asked which way would lead there, the system names its own end.
_ELSEWHERE = ((socket.AF_INET, "192.0.2.1"), (socket.AF_INET6, "2001:db8::1"))


def own_addresses() -> tuple[str, ...]:
    """The addresses of this computer in its networks, those that lead furthest first; nothing is sent to find them."""
    found: list[str] = []
    for family, elsewhere in _ELSEWHERE:
        with contextlib.suppress(OSError), socket.socket(family, socket.SOCK_DGRAM) as asked:
            asked.connect((elsewhere, 9))
            found.append(asked.getsockname()[0])
    with contextlib.suppress(OSError):
        found += [str(known[4][0]) for known in socket.getaddrinfo(socket.gethostname(), None)]
    return tuple(dict.fromkeys(address for address in found if _leads_here(address)))


def own_name() -> str:
    """The name that others of the same network may use: `anna-laptop.local`; empty when it would be none."""
    name = socket.gethostname().casefold().removesuffix(".local")
    fine = name and name != "localhost" and all(c.isascii() and (c.isalnum() or c == "-") for c in name)
    return f"{name}.local" if fine else ""


def address_of(host: str, port: int) -> str:
    """What one types into a browser.

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
