"""Attacks on every route: without the token, from other sites, under other names, with other methods."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from attack import FORMS, JSON, OURS, SOME, Way, body, contents, enter, make_folder, ways
from browser import HOME, TOKEN
from flask import Flask

from rrp_sheets.web.app import create_app
from rrp_sheets.web.password import Password
from rrp_sheets.web.requests import Lan

FOREIGN: list[dict[str, str]] = [
    {},
    {"Origin": HOME},  # a form of our own page cannot send the other header, nor can one of another site
    {"X-RRP": "grid"},
    {"X-RRP": "grid", "Origin": "null"},
    {"X-RRP": "grid", "Origin": "http://evil.example"},
    {"X-RRP": "grid", "Origin": "http://127.0.0.1:9999"},
    {"X-RRP": "grid", "Origin": "http://localhost:8000"},
    {"X-RRP": "grid", "Origin": "https://127.0.0.1:8000"},
    {"X-RRP": "grid", "Origin": f"{HOME}.evil.example"},
    {"X-RRP": "grid", "Origin": f"{HOME}, http://evil.example"},
    {"X-RRP": "other", "Origin": HOME},
    {**OURS, "Sec-Fetch-Site": "cross-site"},
    {**OURS, "Sec-Fetch-Site": "same-site"},
    {**OURS, "Sec-Fetch-Site": "cross-site", "Sec-Fetch-Mode": "cors"},
]
LAN = Lan(Password("green otter"), ("192.168.0.7",))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_folder(tmp_path_factory.mktemp("attack"))


@pytest.fixture(scope="module")
def app(folder: Path) -> Flask:
    return create_app(folder, TOKEN)


@pytest.fixture(scope="module")
def all_ways(app: Flask) -> list[Way]:
    return ways(app)


@pytest.fixture(scope="module")
def client(app: Flask) -> Any:
    return enter(app)


def send(client: Any, way: Way, headers: dict[str, str], **more: Any) -> Any:
    sent = {"base_url": HOME, **(body(way) if way.post else {}), "headers": headers, **more}
    return client.open(way.address(), method="POST" if way.post else "GET", **sent)


def test_every_route_that_changes_something_is_attacked_here(all_ways: list[Way]) -> None:
    missing = [way.key for way in all_ways if way.post and way.key not in {**JSON, **FORMS}]
    assert not missing, f"give {missing} what they are sent in tests/support/attack.py"
    assert not {*JSON, *FORMS} - {way.key for way in all_ways if way.post}


@pytest.mark.slow
def test_without_the_token_there_is_nothing(app: Flask, all_ways: list[Way], folder: Path) -> None:
    before = contents(folder)
    for way in all_ways:
        for cookie in ("", f"rrp-sheets-12345678={TOKEN}", "rrp-sheets=x", f"token={TOKEN}"):
            headers = {**OURS, **({"Cookie": cookie} if cookie else {})}
            answer = send(app.test_client(), way, headers)
            assert answer.status_code == 403, (way, cookie)
            assert "good" not in answer.text and "Set-Cookie" not in answer.headers, way
            assert app.test_client().get(f"{way.address()}?token=wrong", base_url=HOME).status_code in (403, 405)
    assert contents(folder) == before


def test_a_link_with_the_token_changes_nothing(app: Flask, all_ways: list[Way], folder: Path) -> None:
    before = contents(folder)
    for way in all_ways:
        if way.post:
            headers = {"Content-Type": "text/plain"}
            answer = app.test_client().post(f"{way.address()}?token={TOKEN}", base_url=HOME, headers=headers)
            assert answer.status_code == 403 and "Set-Cookie" not in answer.headers, way
    assert contents(folder) == before


def test_other_sites_change_nothing(client: Any, all_ways: list[Way], folder: Path) -> None:
    before = contents(folder)
    for way in all_ways:
        if way.post:
            for headers in FOREIGN:
                if way.key == "language" and headers.get("Origin") == HOME:
                    continue  # a form without a script, which only our own pages send with their origin
                assert send(client, way, headers).status_code == 403, (way, headers)
            for kind in ("text/plain", "application/x-www-form-urlencoded", "multipart/form-data; boundary=x"):
                answer = send(client, way, {}, json=None, data=b'{"a": 1}', content_type=kind)
                assert answer.status_code == 403, (way, kind)
    assert contents(folder) == before


def test_other_sites_read_nothing(client: Any, all_ways: list[Way]) -> None:
    foreign = [h for h in FOREIGN if h.get("Origin", HOME) != HOME or "Sec-Fetch-Site" in h]
    for way in all_ways:
        for headers in [] if way.post else foreign:
            assert send(client, way, headers).status_code == 403, (way, headers)


@pytest.mark.slow
@pytest.mark.parametrize(
    "host",
    ["evil.example", "evil.example:8000", "127.0.0.1.evil.example", "127.0.0.1@evil.example", "evil@127.0.0.1", "localhost.", "0.0.0.0",
     "127.1", "2130706433", "[::1]:8000", "192.168.0.7", "evil.example, 127.0.0.1", "127.0.0.1#.evil.example", ""],
)  # fmt: skip
def test_other_names_for_this_computer_lead_nowhere(client: Any, app: Flask, all_ways: list[Way], host: str) -> None:
    for way in all_ways:
        for forwarded in ({}, {"X-Forwarded-Host": "127.0.0.1:8000", "Forwarded": "host=127.0.0.1:8000"}):
            answer = send(client, way, {**OURS, "Origin": f"http://{host}", "Host": host, **forwarded})
            assert answer.status_code == 400, (way, host)
            assert "good" not in answer.text
    answer = app.test_client().get(f"/?token={TOKEN}", headers={"Host": host})
    assert answer.status_code == 400 and "Set-Cookie" not in answer.headers


def test_headers_that_name_another_method_or_place_are_ignored(client: Any, all_ways: list[Way], folder: Path) -> None:
    before = contents(folder)
    for way in all_ways:
        if way.post:
            for name in ("X-HTTP-Method-Override", "X-Method-Override", "X-HTTP-Method"):
                headers = {**OURS, name: "POST"}
                answer = client.get(f"{way.address()}?_method=POST", base_url=HOME, headers=headers)
                assert answer.status_code in (404, 405) or way.key.startswith("run_panel.act"), way
    assert contents(folder) == before


@pytest.mark.slow
@SOME
@pytest.mark.parametrize("method", ["HEAD", "OPTIONS", "PUT", "DELETE", "PATCH", "TRACE", "CONNECT", "PROPFIND", "x"])
def test_other_methods_change_nothing(client: Any, all_ways: list[Way], folder: Path, method: str, every: int) -> None:
    before = contents(folder)
    of_whom: list[dict[str, str]] = [{}, {"Origin": HOME}, OURS]
    for number, way in enumerate(all_ways):
        # a page is made for HEAD as for GET, whoever asks
        for headers in of_whom if method != "HEAD" else of_whom[number % every :: every]:
            sent = body(way) if way.post and method != "HEAD" else {}
            answer = client.open(way.address(), method=method, base_url=HOME, headers=headers, **sent)
            if method == "HEAD":
                assert answer.status_code < 500 and answer.data == b"", way
            elif headers is not OURS:
                # who has no session yet chooses a language, and asks what may be done there
                asks = way.key == "language" and method == "OPTIONS" and headers
                assert answer.status_code == (200 if asks else 403), (way, headers)
            else:
                assert answer.status_code == (200 if method == "OPTIONS" else 405), way
                assert answer.data == b"" or "This cannot be done here" in answer.text
    assert contents(folder) == before


def test_every_answer_bears_the_protecting_headers(client: Any, app: Flask, all_ways: list[Way]) -> None:
    strangers = app.test_client()
    for way in all_ways:
        answers = [send(strangers, way, {}), client.open(way.address(), method="PUT", base_url=HOME, headers=OURS)]
        answers.append(client.get("/", headers={"Host": "evil.example"}))
        if not way.post and way.key != "sheet.events":
            answers.append(send(client, way, {}))
        for answer in answers:
            headers = answer.headers
            policy = headers["Content-Security-Policy"]
            assert policy.startswith("default-src 'none'; script-src 'self'; style-src 'self'"), way
            assert "unsafe" not in policy and "*" not in policy and "data:" not in policy, way
            assert headers["X-Content-Type-Options"] == "nosniff" and headers["X-Frame-Options"] == "DENY"
            assert headers["Cross-Origin-Opener-Policy"] == headers["Cross-Origin-Resource-Policy"] == "same-origin"
            assert headers["Referrer-Policy"] == "same-origin" and "Access-Control-Allow-Origin" not in headers
            kept = headers.get("Cache-Control", "")
            assert "no-store" in kept or (way.key in ("static", "run_panel.model") and answer.status_code == 200), way
            answer.close()


def test_with_a_password_strangers_get_nothing_either(folder: Path) -> None:
    before = contents(folder)
    app = create_app(folder, TOKEN, LAN)
    open_to_all = {"login.page", "login.enter", "language"}
    home = "http://192.168.0.7:8000"
    for way in ways(app):
        if way.key in open_to_all or (way.key == "static" and way.parts["filename"] == "style.css"):
            continue
        for cookie in ("", f"token={TOKEN}"):
            sent: dict[str, Any] = body(way) if way.post and way.key in {**JSON, **FORMS} else {}
            headers = {"X-RRP": "grid", "Origin": home, **({"Cookie": cookie} if cookie else {})}
            method = "POST" if way.post else "GET"
            place = {"REMOTE_ADDR": "192.168.0.20"}
            asked = {"base_url": home, "headers": headers, "environ_overrides": place, **sent}
            answer = app.test_client().open(way.address(), method=method, **asked)
            assert answer.status_code == 403 and "good" not in answer.text, way
    assert contents(folder) == before
