"""Requests of pages: who may make them, and what they carry.

A browser needs a link, or with `--lan` the password, and requests of other sites are refused. What is sent is checked:
the JSON of a page, its author, and the workbook or run that an address names.
"""

from __future__ import annotations

import hashlib
import ipaddress
import json
import re
import secrets
import threading
from collections import OrderedDict, deque
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any
from urllib.parse import urlsplit

from flask import Flask, Response, abort, current_app, g, has_request_context, redirect, request, url_for
from markupsafe import escape
from werkzeug.exceptions import BadRequest, Forbidden
from werkzeug.wrappers import Response as AnyResponse

from rrp_sheets.documents import Document
from rrp_sheets.errors import SheetsError
from rrp_sheets.recording.metadata import UNNAMED
from rrp_sheets.texts import LANGUAGES, N_
from rrp_sheets.web.password import LoginThrottle, Password
from rrp_sheets.web.services import services
from rrp_sheets.web.serving import let_in
from rrp_sheets.web.statics import HEADERS, plain_name
from rrp_sheets.web.workbook_repository import refuse_text
from rrp_sheets.web.workbook_session import WorkbookSession

HOSTS = ("127.0.0.1", "localhost")
_HOST = re.compile(r"(?:\[([0-9a-f:.]+)\]|([a-z0-9.-]+))(?::[0-9]{1,5})?")
_OPEN = frozenset({"login.page", "login.enter", "language"})  # with --lan, for those who have no session yet
_FORMS = _OPEN | {"login.leave"}  # work without script, so without its header
_LOGIN_FILES = frozenset({"style.css", "login.css", "icon.svg"})


@dataclass(frozen=True, slots=True)
class Lan:
    """Settings of a server that others on the network can reach.

    Attributes:
        password: required of everyone except browsers that opened a link on this computer.
        hosts: names and addresses of this computer that were printed; others are refused, as another site's name may
            lead here as well.
    """

    password: Password
    hosts: tuple[str, ...]


class UsedLink(Forbidden):
    """Error for a link that does not work: another browser has used it, or the server was restarted since."""


def init_app(app: Flask, access: Access) -> None:
    """Install the access checks and the security headers of all responses."""
    app.extensions["access"] = access
    app.before_request(check)
    app.after_request(_finish)
    app.add_url_rule("/language", "language", choose_language, methods=["POST"])
    app.jinja_env.globals["visitor"] = lambda: visitor().name


def access() -> Access:
    """Return the access settings of the application that answers the request."""
    found: Access = current_app.extensions["access"]
    return found


def check() -> AnyResponse | None:
    """Refuse or redirect a request that may not be answered; None for one that may."""
    settings = access()
    if _host() not in settings.hosts:  # a foreign name that leads to this computer
        abort(400)
    if _is_foreign() or (request.method not in ("GET", "HEAD") and not _is_ours()):
        abort(403)
    here = settings.lan is None or (_host() in HOSTS and _is_near(request.remote_addr))
    given = request.cookies.get(settings.cookie, "")
    is_owner = here and is_same(given, settings.secret)
    if here and request.method == "GET" and "token" in request.args:
        return _opened(settings, request.args["token"], is_owner=is_owner)
    g.person = Person() if is_owner else settings.sessions.find(given)
    if g.person is None and not (settings.lan and _is_for_everyone()):
        return _sent_away(settings.lan)
    if g.person is not None:
        let_in(request.environ)
    return None


def _finish(response: Response) -> Response:
    response.headers.update(HEADERS)
    if request.endpoint != "static" or response.status_code >= 400:
        response.headers["Cache-Control"] = "no-store"
    person: Person | None = g.get("person")
    if person and person.key and response.mimetype == "text/event-stream":
        response.response = _while_open(response.response, access().sessions, person)  # type: ignore[arg-type]
    return response


def visitor() -> Person:
    """Return who makes the request; without a name for a browser on this computer."""
    return g.get("person") or Person()


def author_name(given: str, unnamed: str = UNNAMED) -> str:
    """Return the name given at login, else the `given` one, else `unnamed`."""
    return visitor().name or clean_name(given) or unnamed


def _opened(settings: Access, token: str, *, is_owner: bool) -> AnyResponse:
    """Answer a link: redirect to the page without the token, and set the cookie if the browser has none.

    Raises UsedLink when the link is not valid and the browser has no cookie.
    """
    headers = request.headers
    if "prefetch" in headers.get("Sec-Purpose", "") + headers.get("Purpose", "") + headers.get("X-Moz", ""):
        return Response(status=503)  # nobody has opened it yet
    if not is_owner and headers.get("Sec-Fetch-Site") == "cross-site":
        # clicked in another site's page: the browser sends the cookie only with what our own page asks for
        page = f'<!doctype html><meta http-equiv="refresh" content="0; url={escape(request.full_path)}">'
        return Response(page, mimetype="text/html")
    if not settings.links.use(token) and not is_owner:
        raise UsedLink
    place = url_for(request.endpoint, **(request.view_args or {})) if request.endpoint else url_for("workbooks.shelf")
    response = redirect(place)
    if not is_owner:
        response.set_cookie(settings.cookie, settings.secret, httponly=True, samesite="Strict")
    return response


def _sent_away(lan: Lan | None) -> AnyResponse:
    by_script = "X-RRP" in request.headers or "HX-Request" in request.headers  # which would show the login as an answer
    wants_page = request.method == "GET" and request.accept_mimetypes.accept_html and not by_script
    if lan is None or not wants_page or request.headers.get("Accept", "*/*") == "*/*":
        abort(403)
    return redirect(url_for("login.page", next=request.path), 303)


def _is_for_everyone() -> bool:
    if request.endpoint == "static":
        return plain_name((request.view_args or {}).get("filename", "")) in _LOGIN_FILES
    return request.endpoint in _OPEN


def _while_open(messages: Iterable[str], sessions: Sessions, person: Person) -> Iterator[str]:
    """Yield the messages for a page until its session is ended."""
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
    found = _HOST.fullmatch(request.headers.get("Host", "").casefold())
    return (found[1] or found[2]) if found else ""


def _is_near(address: str | None) -> bool:
    try:
        return ipaddress.ip_address(address or "").is_loopback
    except ValueError:
        return False


def _is_ours() -> bool:
    """Return whether our own page requests a change: other sites' scripts and forms cannot send this header."""
    headed = request.headers.get("X-RRP") == "grid" or request.endpoint in _FORMS
    return headed and request.headers.get("Origin") == _own_origin()


def _is_foreign() -> bool:
    """Return whether the page of another site, or of another port, makes the request; links are allowed."""
    origin = request.headers.get("Origin")
    if origin is not None and origin != _own_origin():
        return True
    headers = request.headers
    return headers.get("Sec-Fetch-Site") in {"cross-site", "same-site"} and headers.get("Sec-Fetch-Mode") != "navigate"


def _own_origin() -> str:
    return f"{request.scheme}://{request.headers.get('Host', '').casefold()}"


Asked = dict[str, Any]
_LANGUAGE = "rrp-language"  # the cookie with the language that a reader has chosen
_YEAR = 365 * 24 * 3600  # s
_MOST_ROWS = 200  # that marbles are asked for
_WORD = re.compile("[0-9a-f]{16}")
_HALF = re.compile(rb"\\u[dD][89a-fA-F]")  # how JSON writes half a letter, which browsers do only for a lone one


def page_language() -> str:
    """Return the code of the language of the page that is asked for: the reader's choice, else the browser's."""
    if not has_request_context():
        return "en"
    chosen = request.cookies.get(_LANGUAGE, "")
    return chosen if chosen in LANGUAGES else request.accept_languages.best_match(list(LANGUAGES), default="en")


def choose_language() -> AnyResponse:
    """Keep the language that a reader has chosen, and go back to the page."""
    response = redirect(inside(request.form.get("next", "/")), 303)
    if (chosen := request.form.get("language", "")) in LANGUAGES:
        response.set_cookie(_LANGUAGE, chosen, max_age=_YEAR, samesite="Strict")
    return response


def other_languages() -> list[tuple[str, str]]:
    """Return the code and the name of each language that the page is not in."""
    return [(code, name) for code, name in LANGUAGES.items() if code != page_language()]


def inside(place: str) -> str:
    r"""Return an address if it is a path on this server, else that of the start page.

    >>> inside("/book/a.xlsx"), inside("//evil.example"), inside("/\\evil.example"), inside("https://evil.example/")
    ('/book/a.xlsx', '/', '/', '/')
    """
    fine = place.startswith("/") and not place.startswith("//") and place.isprintable() and "\\" not in place
    if not fine or len(place) > 500:
        return "/"
    parts = urlsplit(place)
    return place if not parts.scheme and not parts.netloc and not parts.path.startswith(("/login", "//")) else "/"


def json_body() -> Asked:
    """Return the JSON object of the request; anything else is refused."""
    if not request.is_json:
        raise BadRequest
    try:
        sent = json.loads(request.get_data().decode())
    except (ValueError, RecursionError) as error:  # the latter: nested deeper than anything a page sends
        raise BadRequest from error
    if not isinstance(sent, dict):
        raise BadRequest
    if _HALF.search(request.get_data()):
        try:
            json.dumps(sent, ensure_ascii=False).encode()
        except UnicodeEncodeError as error:  # a lone surrogate
            raise BadRequest from error
    return sent


def text_of(sent: Asked, name: str, longest: int = 200) -> str:
    """Return a text field; empty when it is missing, refused when it is no text or too long."""
    value = sent.get(name, "")
    if not isinstance(value, str) or len(value) > longest:
        raise BadRequest
    return value


def number_of(sent: Asked, name: str, low: float, high: float) -> float:
    """Return a number field; refused unless it is between two limits."""
    value = sent.get(name)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not low <= value <= high:
        raise BadRequest
    return float(value)


def truth_of(sent: Asked, name: str) -> bool:
    """Return a boolean field; anything else is refused."""
    value = sent.get(name)
    if not isinstance(value, bool):
        raise BadRequest
    return value


def sender_of(session: WorkbookSession, sent: Asked) -> tuple[str, str]:
    """Return the page that sends a request, and its author; refused when the page belongs to another login."""
    client = text_of(sent, "client")
    author = author_of(sent, client)
    if not session.is_of(client, visitor().key):  # nobody moves another's cursor, nor opens what another is editing
        abort(403)
    return client, author


def author_of(sent: Asked, unnamed: str = UNNAMED) -> str:
    """Return the author of a request: the name given at login, else the one on the page, else `unnamed`."""
    return author_name(text_of(sent, "name"), unnamed)


def workbook_or_404(name: str) -> WorkbookSession:
    """Return a workbook's session; answer 404 if there is no such file, raise SheetsError if it is none."""
    repository, open_workbooks = services().repository, services().open_workbooks
    if session := open_workbooks.find(name):  # which may have lost its last sheet: undo brings it back
        session.languages |= {page_language()}
        return session
    if not repository.has(name):
        abort(404)
    refuse_text(repository, name)
    session = open_workbooks.session(repository.path(name))
    session.languages |= {page_language()}
    return session


def sheet_or_404(document: Document, sheet: str) -> str:
    """Return the present name of a sheet that a page names; answer 404 when there is none."""
    sheet = document.current(sheet)
    if sheet not in document.grids and sheet not in document.own:
        abort(404)
    return sheet


def run_or_404(run: str) -> str:
    """Return the name of a recorded run; answer 404 if there is none of that name."""
    if run not in services().runs.names():
        abort(404)
    return run


def rows_asked() -> list[int]:
    """Return the numbers of the rows that the address names, up to a limit."""
    return [int(r) for r in request.args.getlist("row") if r.isdecimal() and len(r) < 7][:_MOST_ROWS]


def seconds_of(text: str) -> float | None:
    """Parse a time in seconds; None for a blank text."""
    if not text.strip():
        return None
    try:
        value = float(text.replace(",", ".").removesuffix("s"))
    except ValueError:
        value = -1.0
    if not 0 <= value < 1e8:
        raise SheetsError(N_("“{text}” is not a time in seconds.", text=text), N_("Write a number, such as 12.5."))
    return value


def confirm_download(answer: Response) -> Response:
    """Set a cookie that tells the page that the file it requested has arrived."""
    word = request.args.get("made", "")
    if _WORD.fullmatch(word):
        answer.set_cookie(f"made-{word}", "1", max_age=60, samesite="Strict", path="/")
    return answer


_MOST_LINKS = 50  # that nobody has used yet; the oldest is no longer good then


class OneTimeTokens:
    """Tokens of links that work for one browser each. Safe to use from several threads."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._unused: deque[str] = deque(maxlen=_MOST_LINKS)

    def new(self) -> str:
        """Create a token for another link."""
        token = secrets.token_urlsafe(32)
        with self._lock:
            self._unused.append(token)
        return token

    def use(self, given: str) -> bool:
        """Return whether this is the token of an unused link, and mark it as used."""
        with self._lock:
            found = [token for token in self._unused if is_same(given, token)]
            for token in found:
                self._unused.remove(token)
        return bool(found)


def is_same(given: str, secret: str) -> bool:
    """Compare two texts in constant time, so that the time tells nothing about the secret."""
    return secrets.compare_digest(given.encode("utf-8", "replace"), secret.encode())


def cookie_name(secret: str) -> str:
    """Return a cookie name that differs for each folder: browsers share cookies between the ports of a host."""
    return f"rrp-sheets-{hashlib.sha256(secret.encode()).hexdigest()[:8]}"


LONGEST_NAME = 40
_MOST = 500


@dataclass(frozen=True, slots=True)
class Person:
    """User who may see the pages.

    Attributes:
        name: as the others see it; empty for a browser on this computer, whose user types it on the page.
        key: identifies the login; it is not the secret, and grants no access.
    """

    name: str = ""
    key: str = ""
    address: str = ""


class Sessions:
    """Login sessions of a server, by the hash of their secret. Safe to use from several threads."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._people: OrderedDict[str, Person] = OrderedDict()

    def open(self, name: str, address: str) -> tuple[str, Person]:
        """Open a session; return its secret and its user. A name in use at another address becomes `Anna (2)`.

        So nobody can impersonate another user, or undo another user's edits.
        """
        secret = secrets.token_urlsafe(32)
        with self._lock:
            taken = {p.name.casefold() for p in self._people.values() if p.address != address}
            count, wanted = 1, name
            while wanted.casefold() in taken:
                count += 1
                wanted = f"{name} ({count})"
            person = Person(wanted, _key(secret), address)
            self._people[person.key] = person
            while len(self._people) > _MOST:
                self._people.popitem(last=False)
        return secret, person

    def find(self, secret: str) -> Person | None:
        """Return the user of a session; None if there is none, or it was ended."""
        with self._lock:
            return self._people.get(_key(secret))

    def is_open(self, person: Person) -> bool:
        """Return whether a user's session has not been ended."""
        with self._lock:
            return person.key in self._people

    def close(self, person: Person) -> None:
        """End a session."""
        with self._lock:
            self._people.pop(person.key, None)


@dataclass(frozen=True, repr=False)
class Access:
    """Access to one application; `app.extensions["access"]`, in a view `access()`.

    Attributes:
        secret: what the cookie of a browser on this computer holds.
        lan: lets others in too, with a password.
        links: each lets one browser on this computer in, which gets the cookie then.
        tell: called with one line for each login or wrong password.
    """

    secret: str
    lan: Lan | None
    links: OneTimeTokens
    tell: Callable[[str], None]
    sessions: Sessions = field(default_factory=Sessions)
    throttle: LoginThrottle = field(default_factory=LoginThrottle)

    @cached_property
    def cookie(self) -> str:
        """Name of the cookie."""
        return cookie_name(self.secret)

    @cached_property
    def hosts(self) -> frozenset[str]:
        """Names of this computer under which it answers."""
        return frozenset(host.casefold() for host in (*HOSTS, *(self.lan.hosts if self.lan else ())))


def clean_name(given: str) -> str:
    r"""Clean a name for display: one line, without control or invisible characters.

    >>> clean_name("  Anna\u202e \n Lee\x1b[31m "), clean_name("\u200b")
    ('Anna Lee[31m', '')
    """
    letters = "".join(c if c.isprintable() else " " if c.isspace() else "" for c in given)
    return " ".join(letters.split())[:LONGEST_NAME].strip()


def _key(secret: str) -> str:
    """Hash a secret: lookups by hash take a time that tells nothing about the secret."""
    return hashlib.sha256(secret.encode("utf-8", "replace")).hexdigest()
