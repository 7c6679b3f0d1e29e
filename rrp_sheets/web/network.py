"""By which names and addresses others reach this computer."""

from __future__ import annotations

import contextlib
import ipaddress
import socket

import ifaddr

# Addresses that belong to nobody (RFC 5737, RFC 3849): asked which way would lead there, the system names its own end.
_ELSEWHERE = ((socket.AF_INET, "192.0.2.1"), (socket.AF_INET6, "2001:db8::1"))
_INNER = ("docker", "br-", "veth", "virbr")  # networks of this computer with its own containers: nobody sits there
_LAST_RESORT = ipaddress.ip_network("169.254.0.0/16")


def own_addresses() -> tuple[str, ...]:
    """The addresses of this computer in its networks, those that lead furthest first; nothing is sent to find them.

    A network without a way out counts too: a router without internet, or a cable between two computers, whose
    addresses of last resort (169.254…) are given when there are no others.
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
