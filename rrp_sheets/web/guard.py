"""Who may see the pages: whoever was given the address with its token, and with `--lan` whoever has the password."""

from __future__ import annotations

import hashlib
import ipaddress
import re
import secrets
import threading
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from flask import Flask, Response, abort, g, redirect, request, url_for
from werkzeug.wrappers import Response as AnyResponse

from rrp_sheets.web import connections
from rrp_sheets.web.headers import HEADERS
from rrp_sheets.web.password import Password
from rrp_sheets.web.sessions import Person, Sessions
from rrp_sheets.web.statics import KEPT, plain_name

HOSTS = ("127.0.0.1", "localhost")
_HOST = re.compile(r"(?:\[([0-9a-f:.]+)\]|([a-z0-9.-]+))(?::[0-9]{1,5})?")
_OPEN = frozenset({"login.page", "login.enter"})  # with --lan, for those who have no session yet
_FORMS = _OPEN | {"login.leave"}  # work without script, so without its header
_LOGIN_FILES = frozenset({"style.css", "login.css", "icon.svg"})


@dataclass(frozen=True, slots=True)
class Lan:
    """What makes a server one for others too.

    Attributes:
        password: that everyone has to give, but who has the token on this computer.
        hosts: names and addresses of this computer that were printed; it answers to no other, as another site's name
            may lead here as well.
    """

    password: Password
    hosts: tuple[str, ...]


class Opening:
    """A token that opens once: the browser's, which others on this computer may see among the programs that run."""

    def __init__(self, token: str) -> None:
        self._lock = threading.Lock()
        self._token = token

    def fits(self, given: str) -> bool:
        """Whether it is this one, the first time."""
        with self._lock:
            if not self._token or not _same(given, self._token):
                return False
            self._token = ""
            return True


def protect(app: Flask, token: str, lan: Lan | None, sessions: Sessions, once: str = "") -> None:
    """Let the app answer only whom it should, and never with more than it must; `once`: a token that opens once."""
    opening = Opening(once)
    cookie = cookie_name(token)
    hosts = frozenset(host.casefold() for host in (*HOSTS, *(lan.hosts if lan else ())))

    @app.before_request
    def check() -> AnyResponse | None:
        if _host() not in hosts:  # a foreign name that leads to this computer
            abort(400)
        if _is_foreign() or (request.method not in ("GET", "HEAD") and not _is_ours()):
            abort(403)
        here = lan is None or (_host() in HOSTS and _is_near(request.remote_addr))
        given = request.args.get("token")
        if here and given is not None and (_same(given, token) or opening.fits(given)):
            place = url_for(request.endpoint, **(request.view_args or {})) if request.endpoint else url_for("shelf")
            response = redirect(place)
            response.set_cookie(cookie, token, httponly=True, samesite="Strict")
            return response
        secret = request.cookies.get(cookie, "")
        g.person = Person() if here and _same(secret, token) else sessions.find(secret)
        if g.person is None and not (lan and _is_for_everyone()):
            return _sent_away(lan)
        if g.person is not None:
            connections.let_in(request.environ)
        return None

    @app.after_request
    def finish(response: Response) -> Response:
        response.headers.update(HEADERS)
        if request.endpoint not in KEPT or response.status_code >= 400:
            response.headers["Cache-Control"] = "no-store"
        person: Person | None = g.get("person")
        if person and person.key and response.mimetype == "text/event-stream":
            response.response = _while_open(response.response, sessions, person)  # type: ignore[arg-type]
        return response

    app.jinja_env.globals["visitor"] = lambda: visitor().name


def visitor() -> Person:
    """Who asks now; without a name for the one with the address of this computer."""
    return g.get("person") or Person()


def cookie_name(token: str) -> str:
    """A name of its own for every server: browsers share cookies between the ports of a host."""
    return f"rrp-sheets-{hashlib.sha256(token.encode()).hexdigest()[:8]}"


def _sent_away(lan: Lan | None) -> AnyResponse:
    wants_page = request.method == "GET" and request.accept_mimetypes.accept_html and "X-RRP" not in request.headers
    if lan is None or not wants_page or request.headers.get("Accept", "*/*") == "*/*":
        abort(403)
    return redirect(url_for("login.page", next=request.path), 303)


def _is_for_everyone() -> bool:
    if request.endpoint == "static":
        return plain_name((request.view_args or {}).get("filename", "")) in _LOGIN_FILES
    return request.endpoint in _OPEN


def _while_open(messages: Iterable[str], sessions: Sessions, person: Person) -> Iterator[str]:
    """What a page is told, until its session is ended."""
    try:
        for message in messages:
            if not sessions.is_open(person):
                return
            yield message
    finally:
        close = getattr(messages, "close", None)
        if close is not None:
            close()


def _host() -> str:
    """The name by which this server was asked, without the port."""
    found = _HOST.fullmatch(request.headers.get("Host", "").casefold())
    return (found[1] or found[2]) if found else ""


def _is_near(address: str | None) -> bool:
    try:
        return ipaddress.ip_address(address or "").is_loopback
    except ValueError:
        return False


def _same(given: str, token: str) -> bool:
    return secrets.compare_digest(given.encode("utf-8", "replace"), token.encode())


def _is_ours() -> bool:
    """Whether a change is asked for by our own page: no form and no other site can send this header."""
    headed = request.headers.get("X-RRP") == "grid" or request.endpoint in _FORMS
    return headed and request.headers.get("Origin") == _own_origin()


def _is_foreign() -> bool:
    """Whether another site's page asks, or that of another port of this computer; links may lead here."""
    origin = request.headers.get("Origin")
    if origin is not None and origin != _own_origin():
        return True
    headers = request.headers
    return headers.get("Sec-Fetch-Site") in {"cross-site", "same-site"} and headers.get("Sec-Fetch-Mode") != "navigate"


def _own_origin() -> str:
    return f"{request.scheme}://{request.headers.get('Host', '').casefold()}"
