"""Login with `--lan` by a name and the password, and the limit on wrong passwords; works without JavaScript."""

from __future__ import annotations

import ipaddress
import threading
import time
from collections import OrderedDict, deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar
from urllib.parse import urlsplit

from flask import Blueprint, abort, g, redirect, render_template, request, url_for
from werkzeug.wrappers import Response as AnyResponse

from rrp_sheets.web.password import LONGEST
from rrp_sheets.web.security import Lan, Sessions, clean_name

Answer = AnyResponse | tuple[str, int] | tuple[str, int, dict[str, str]]


@dataclass(frozen=True, slots=True)
class LoginPage:
    """Login form.

    Attributes:
        trouble: why the last attempt failed; empty at first.
        next: the page that was asked for.
        name: as it was typed.
    """

    template: ClassVar[str] = "login.html"
    trouble: str = ""
    next: str = "/"
    name: str = ""


def make_login(
    lan: Lan, sessions: Sessions, cookie: str, tell: Callable[[str], None], tries: LoginThrottle | None = None
) -> Blueprint:
    """Make the blueprint with the routes for logging in and out.

    Args:
        lan: has the password.
        sessions: where logins are kept.
        cookie: the name of the cookie.
        tell: called with one line for each login or wrong password.
        tries: limits the wrong passwords.
    """
    pages = Blueprint("login", __name__)
    counted = tries or LoginThrottle()

    @pages.get("/login")
    def page() -> AnyResponse | str:
        if g.person is not None:
            return redirect(_inside(request.args.get("next", "/")), 303)
        return _shown(LoginPage(next=_inside(request.args.get("next", "/"))))

    @pages.post("/login")
    def enter() -> Answer:
        return _entered(lan, sessions, cookie, tell, counted)

    @pages.post("/logout")
    def leave() -> AnyResponse:
        if g.person is None:
            abort(403)
        sessions.close(g.person)
        response = redirect(url_for("login.page"), 303)
        response.delete_cookie(cookie, httponly=True, samesite="Strict")
        return response

    return pages


def _entered(lan: Lan, sessions: Sessions, cookie: str, tell: Callable[[str], None], tries: LoginThrottle) -> Answer:
    """Check the submitted name and password; open a session, or show the form again with the reason."""
    name, given = clean_name(request.form.get("name", "")), request.form.get("password", "")
    place = _inside(request.form.get("next", "/"))
    if not name:
        return _shown(LoginPage("Type your name: the others see it beside what you do.", place)), 400
    address = request.remote_addr or ""
    with lan.password.place() as free:
        wait = tries.begin(address) if free else 2
        fits = not wait and len(given) <= LONGEST and lan.password.fits(given)
    if wait:
        why = "Too many wrong passwords came from here." if free else "Many log in at this moment."
        words = f"{why} Wait {_told(wait)}, then try again."
        return _shown(LoginPage(words, place, name)), 429, {"Retry-After": str(wait)}
    if not fits:
        tell(f"A wrong password came from {address}.")
        words = "This is not the password. Whoever started the server knows it."
        return _shown(LoginPage(words, place, name)), 403
    tries.right(address)
    if g.person is not None:
        sessions.close(g.person)
    secret, person = sessions.open(name, address)
    tell(f"{person.name} has logged in from {address}.")
    response = redirect(place, 303)
    response.set_cookie(cookie, secret, httponly=True, samesite="Strict")
    return response


def _shown(page: LoginPage) -> str:
    return render_template(page.template, page=page)


def _inside(place: str) -> str:
    r"""Return an address if it is a path on this server, else that of the start page.

    >>> _inside("/book/a.xlsx"), _inside("//evil.example"), _inside("/\\evil.example"), _inside("https://evil.example/")
    ('/book/a.xlsx', '/', '/', '/')
    """
    fine = place.startswith("/") and not place.startswith("//") and place.isprintable() and "\\" not in place
    if not fine or len(place) > 500:
        return "/"
    parts = urlsplit(place)
    return place if not parts.scheme and not parts.netloc and not parts.path.startswith(("/login", "//")) else "/"


def _told(seconds: int) -> str:
    """Format a waiting time.

    >>> _told(1), _told(8), _told(300)
    ('1 second', '8 seconds', '5 minutes')
    """
    if seconds >= 120:
        return f"{-(-seconds // 60)} minutes"
    return f"{seconds} second{'' if seconds == 1 else 's'}"


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
    """Limit on wrong passwords, by address. Safe to use from several threads.

    The first attempt of an address is always checked, so no flood from elsewhere locks anybody out.

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
        """Return the seconds that an address must wait; 0 if it may try, which counts as wrong until `right` is called.

        So attempts at the same moment cannot bypass the limit.
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
        """Forget the wrong attempts of an address that gave the password."""
        with self._lock:
            self._by_address.pop(_who(address), None)
            if self._all:
                self._all.pop()

    def _flooded(self, now: float) -> bool:
        return len(self._all) == _MANY and now - self._all[0] < _WINDOW


def _who(address: str) -> str:
    """Return the key under which an address is counted; for IPv6 its /64 network, where one user has many addresses.

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
