"""Wrong passwords: after some of them, an address has to wait, and longer every time."""

from __future__ import annotations

import ipaddress
import threading
import time
from collections import OrderedDict, deque
from collections.abc import Callable
from dataclasses import dataclass

FREE = 5  # wrong ones without a wait
_LONGEST = 300.0  # seconds to wait
_FORGOTTEN = 1800.0  # seconds after which an address begins anew
_MANY = 60  # wrong ones of all addresses in _WINDOW seconds: then an address has to wait after its first already
_WINDOW = 600.0
_ADDRESSES = 5_000


@dataclass
class _Tried:
    wrong: int = 0
    last: float = 0.0
    until: float = 0.0


class LoginThrottle:
    """Who has given how many wrong passwords. Safe to use from several threads.

    The first try of an address is always looked at, so no flood from elsewhere locks anybody out.

    Args:
        now: a clock, in seconds.

    >>> tries = LoginThrottle(lambda: 0.0)
    >>> [tries.begin("10.0.0.7") for _ in range(7)]
    [0, 0, 0, 0, 0, 2, 2]
    """

    def __init__(self, now: Callable[[], float] = time.monotonic) -> None:
        self._now = now
        self._lock = threading.Lock()
        self._by_address: OrderedDict[str, _Tried] = OrderedDict()
        self._all: deque[float] = deque(maxlen=_MANY)

    def begin(self, address: str) -> int:
        """Seconds that the address has to wait; 0 when it may try, which counts as wrong until `right` says otherwise.

        So tries at the same moment cannot pass together.
        """
        now = self._now()
        with self._lock:
            one = self._by_address.setdefault(_who(address), _Tried())
            self._by_address.move_to_end(_who(address))
            while len(self._by_address) > _ADDRESSES:
                self._by_address.popitem(last=False)
            if now < one.until:
                return max(1, round(one.until - now))
            if now - one.last > _FORGOTTEN:
                one.wrong = 0
            free = 1 if self._flooded(now) else FREE
            one.wrong, one.last = one.wrong + 1, now
            self._all.append(now)
            if one.wrong >= free:
                one.until = now + min(_LONGEST, 2.0 ** (one.wrong - free + 1))
            return 0

    def right(self, address: str) -> None:
        """It was the password."""
        with self._lock:
            self._by_address.pop(_who(address), None)
            if self._all:
                self._all.pop()

    def _flooded(self, now: float) -> bool:
        return len(self._all) == _MANY and now - self._all[0] < _WINDOW


def _who(address: str) -> str:
    """An address; of IPv6 the network, as everyone has many addresses in it.

    >>> _who("10.0.0.7"), _who("2001:db8:1:2:3:4:5:6"), _who("?")
    ('10.0.0.7', '2001:db8:1:2::/64', '?')
    """
    try:
        known = ipaddress.ip_address(address.partition("%")[0])
    except ValueError:
        return address
    if known.version == 4:
        return address
    return str(ipaddress.ip_network((known, 64), strict=False))
