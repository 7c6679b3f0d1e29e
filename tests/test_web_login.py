"""`serve --lan`: who gets in with the password, who has to wait, and what a session is."""

from __future__ import annotations

import http.client
import re
import threading
import time
import urllib.parse
from pathlib import Path

import pytest
from browser import GOOD, TOKEN, book
from busy import Span
from flask.testing import FlaskClient
from werkzeug.test import TestResponse

from rrp_sheets.web.app import create_app
from rrp_sheets.web.password import Password
from rrp_sheets.web.requests import Lan, OneTimeTokens
from rrp_sheets.web.serving import bind, make_server

WORDS = "green otter lamp"
LAN = Lan(Password(WORDS), ("192.168.0.7", "fd00::7", "lab.local"))
HOME = "http://192.168.0.7:8000"
PAGE = {"Accept": "text/html,application/xhtml+xml"}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "good.md").write_text(GOOD, encoding="utf-8")
    return tmp_path


@pytest.fixture
def client(folder: Path) -> FlaskClient:
    return create_app(folder, TOKEN, LAN).test_client()


def log_in(
    client: FlaskClient, name: str = "Anna", password: str = WORDS, address: str = "192.168.0.20", **more: str
) -> TestResponse:
    headers = {"Origin": HOME, **{k.replace("_", "-"): v for k, v in more.items()}}
    form = {"name": name, "password": password, "next": book("good.md")}
    place = {"REMOTE_ADDR": address}
    return client.post("/login", base_url=HOME, data=form, headers=headers, environ_overrides=place)


def ask(client: FlaskClient, address: str, **headers: str) -> TestResponse:
    place = {"REMOTE_ADDR": "192.168.0.20"}
    return client.get(address, base_url=HOME, headers=headers or PAGE, environ_overrides=place)


# ---- getting in ----


def test_who_has_no_session_is_led_to_the_login_and_back(client: FlaskClient) -> None:
    away = ask(client, book("good.md"))
    assert (away.status_code, away.headers["Location"]) == (303, "/login?next=/book/good.md")
    page = ask(client, away.headers["Location"])
    assert page.status_code == 200 and "not encrypted" in page.text and "good" not in page.text.replace("good.md", "")
    back = log_in(client)
    assert (back.status_code, back.headers["Location"]) == (303, "/book/good.md")
    assert ask(client, book("good.md")).status_code == 200


def test_scripts_and_pictures_without_a_session_are_refused(client: FlaskClient) -> None:
    for address in ("/book/good.md/events", "/book/good.md/diagram/1.svg", "/book/good.md/vocabulary", "/none"):
        assert ask(client, address, Accept="*/*").status_code == 403
    for name, code in (("style.css", 200), ("login.css", 200), ("grid/main.js", 403), ("../guard.py", 403)):
        assert ask(client, f"/static/{name}", Accept="*/*").status_code == code


def test_each_login_has_a_session_of_its_own(client: FlaskClient) -> None:
    first, second = (log_in(client).headers["Set-Cookie"] for _ in range(2))
    for cookie in (first, second):
        assert "HttpOnly" in cookie and "SameSite=Strict" in cookie and TOKEN not in cookie and WORDS not in cookie
        assert len(cookie.split("=")[1].split(";")[0]) >= 43
    assert first != second
    old = {"Cookie": first.split(";")[0], "Accept": "*/*"}
    other = client.application.test_client()
    assert ask(other, "/", **old).status_code == 403  # it ended when the same browser logged in again


def test_logging_out_ends_this_session_only(client: FlaskClient) -> None:
    other = client.application.test_client()
    for one, name in ((client, "Anna"), (other, "Bob")):
        log_in(one, name)
    cookie = client.get_cookie(next(c.key for c in client._cookies.values()), domain="192.168.0.7")
    assert cookie is not None
    out = client.post("/logout", base_url=HOME, headers={"Origin": HOME})
    assert out.status_code == 303 and out.headers["Location"] == "/login"
    kept = {"Cookie": f"{cookie.key}={cookie.value}", "Accept": "*/*"}  # a copy of the cookie does not help
    assert ask(client.application.test_client(), "/", **kept).status_code == 403
    assert ask(other, "/").status_code == 200 and "You: Bob" in ask(other, "/").text


def test_a_session_of_another_start_is_none(client: FlaskClient, folder: Path) -> None:
    cookie = log_in(create_app(folder, TOKEN, LAN).test_client()).headers["Set-Cookie"].split(";")[0]
    assert ask(client, "/", Cookie=cookie, Accept="*/*").status_code == 403


@pytest.mark.slow
@pytest.mark.parametrize("origin", ["http://evil.example", "null", "http://192.168.0.7:9999", ""])
def test_other_sites_cannot_log_anyone_in_or_out(client: FlaskClient, origin: str) -> None:
    assert log_in(client, Origin=origin).status_code == 403
    log_in(client)
    assert client.post("/logout", base_url=HOME, headers={"Origin": origin}).status_code == 403
    assert ask(client, "/").status_code == 200


@pytest.mark.parametrize(
    "next_",
    ["//evil.example", "https://evil.example", "/\\evil.example", "javascript:alert(1)", "/\n/evil.example", "x"],
)
def test_the_login_leads_nowhere_else(client: FlaskClient, next_: str) -> None:
    form = {"name": "Anna", "password": WORDS, "next": next_}
    assert client.post("/login", base_url=HOME, data=form, headers={"Origin": HOME}).headers["Location"] == "/"
    again = ask(client, "/login?" + urllib.parse.urlencode({"next": next_}))
    assert (again.status_code, again.headers["Location"]) == (303, "/")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("host", "code"),
    [
        ("192.168.0.7:8000", 303), ("[fd00::7]:8000", 303), ("lab.local:8000", 303), ("LAB.local", 303),
        ("127.0.0.1:8000", 303), ("evil.example", 400), ("192.168.0.8:8000", 400), ("[fd00::8]", 400), ("[", 400),
        ("lab.local.evil.example", 400), ("lab.local@evil.example", 400), ("192.168.0.7.", 400),
    ],
)  # fmt: skip
def test_it_answers_only_to_the_names_that_were_printed(client: FlaskClient, host: str, code: int) -> None:
    assert client.get("/", headers={"Host": host, **PAGE}).status_code == code


def test_a_link_opens_only_on_this_computer(folder: Path) -> None:
    near, far = "http://127.0.0.1:8000", {"REMOTE_ADDR": "192.168.0.20"}
    links = OneTimeTokens()
    client, token = create_app(folder, TOKEN, LAN, links=links).test_client(), links.new()
    asked = {"base_url": near, "headers": {"Accept": "*/*"}}
    assert client.get(f"/?token={token}", environ_overrides=far, **asked).status_code == 403
    assert client.get(f"/?token={token}", base_url=HOME, headers={"Accept": "*/*"}).status_code == 403
    owner = client.get(f"/?token={token}", **asked)  # those have not used it up
    assert owner.status_code == 302
    cookie = {"Cookie": owner.headers["Set-Cookie"].split(";")[0], "Accept": "*/*"}
    assert client.get("/", **asked).status_code == 200
    other = client.application.test_client()
    assert other.get("/", base_url=near, headers=cookie, environ_overrides=far).status_code == 403


# ---- wrong passwords ----


def test_after_five_wrong_ones_an_address_waits_and_the_others_do_not(client: FlaskClient) -> None:
    for _ in range(5):
        wrong = log_in(client, password="not this one")
        assert (
            wrong.status_code == 403 and "This is not the password" in wrong.text and "Set-Cookie" not in wrong.headers
        )
    told = log_in(client)  # the right one, but too early
    assert told.status_code == 429 and int(told.headers["Retry-After"]) in (1, 2)
    assert re.search(r"Wait [12] seconds?, then try again", told.text)
    assert log_in(client, address="192.168.0.21").status_code == 303


def test_tries_at_the_same_moment_do_not_pass_together(client: FlaskClient) -> None:
    codes: list[int] = []

    def guess() -> None:
        codes.append(log_in(client.application.test_client(), password="not this one").status_code)

    guessers = [threading.Thread(target=guess) for _ in range(12)]
    for one in guessers:
        one.start()
    for one in guessers:
        one.join()
    assert sorted(codes) == [403] * 5 + [429] * 7


@pytest.mark.slow
def test_a_flood_of_tries_neither_stalls_the_server_nor_locks_others_out(folder: Path) -> None:
    app = create_app(folder, TOKEN, Lan(Password(WORDS), ()))
    app.wsgi_app = _Elsewhere(app.wsgi_app)  # type: ignore[method-assign]
    server = make_server(app, bind(["127.0.0.1"], None))
    thread = threading.Thread(target=server.run, daemon=True)
    thread.start()
    home, over = f"127.0.0.1:{server.effective_port}", threading.Event()

    def send(password: str, address: str) -> tuple[int, float]:
        begun = time.monotonic()
        line = http.client.HTTPConnection(home, timeout=300)
        body = urllib.parse.urlencode({"name": "x", "password": password})
        headers = {"Origin": f"http://{home}", "X-From": address, "Content-Type": "application/x-www-form-urlencoded"}
        line.request("POST", "/login", body, headers)
        answer = line.getresponse()
        answer.read()
        line.close()
        return answer.status, time.monotonic() - begun

    def flood(number: int) -> None:
        count = 0
        while not over.is_set():
            count += 1
            send("not this one", f"10.{number}.{count % 250}.{count // 250}")

    floods = [threading.Thread(target=flood, args=(n,)) for n in range(6)]
    for one in floods:
        one.start()
    try:
        assert threading.Event().wait(1.0) is False
        span = Span()
        status, seconds = send(WORDS, "192.168.0.30")
        assert status == 303 and seconds < 15 * span.crowded()
    finally:
        over.set()
        for one in floods:
            one.join()
        server.close()
        server.task_dispatcher.shutdown(timeout=1)


class _Elsewhere:
    """Has requests come from other addresses, as a test can connect only from this computer."""

    def __init__(self, app: object) -> None:
        self.app = app

    def __call__(self, environ: dict[str, str], start: object) -> object:
        environ["REMOTE_ADDR"] = environ.get("HTTP_X_FROM", environ["REMOTE_ADDR"])
        return self.app(environ, start)  # type: ignore[operator]


# ---- names ----


@pytest.mark.parametrize("name", ["", "   ", "\u200b", "\x07"])
def test_a_name_is_needed(client: FlaskClient, name: str) -> None:
    answer = log_in(client, name)
    assert answer.status_code == 400 and "Type your name" in answer.text and "Set-Cookie" not in answer.headers


def test_two_of_one_name_are_told_apart(client: FlaskClient) -> None:
    clients = [client.application.test_client() for _ in range(3)]
    for one, address in zip(clients, ["192.168.0.20", "192.168.0.21", "192.168.0.20"], strict=True):
        log_in(one, "Anna", address=address)
    shown = [re.search(r"You: (.*?)<", ask(one, "/").text) for one in clients]
    assert [found and found[1] for found in shown] == ["Anna", "Anna (2)", "Anna"]


def test_nobody_speaks_for_another(client: FlaskClient) -> None:
    other = client.application.test_client()
    log_in(client, "Anna")
    log_in(other, "Bob", address="192.168.0.21")
    row = re.findall(r'<tr role="row" id="([^"]+)"', ask(client, book("good.md")).text)[0]

    def send(who: FlaskClient, action: str, **more: object) -> dict[str, object]:
        body = {"client": "c", "name": "Anna", "tag": "t", "sheet": "Tracking", **more}
        headers = {"X-RRP": "grid", "Origin": HOME}
        answer = who.post(f"/book/good.md/{action}", base_url=HOME, headers=headers, json=body)
        return dict(answer.get_json())

    cell = {"row": row, "column": 6, "text": "by Anna", "was": None}
    assert "rows" in send(client, "cells", cells=[cell])
    assert "nothing to undo" in str(send(other, "undo")["message"])
    assert "rows" in send(client, "undo")
