"""The table of routes in tests/golden/routes.md is what the server answers, and pages link only to routes that exist."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from attack import ways
from browser import COOKIE, GOOD, TOKEN, get, let_in, visit
from flask import Flask

from rrp_sheets.resources import bundled
from rrp_sheets.web.app import create_app
from rrp_sheets.web.password import Password
from rrp_sheets.web.requests import Lan

HOME, STRANGER = "http://192.168.0.7:8000", {"REMOTE_ADDR": "192.168.0.20"}
HERE = "http://127.0.0.1:8000"


@pytest.fixture(scope="module")
def app(tmp_path_factory: pytest.TempPathFactory) -> Flask:
    """A server with everything: with a password there are the pages of the login too."""
    return create_app(tmp_path_factory.mktemp("books"), TOKEN, Lan(Password("green otter"), ("192.168.0.7",)))


def table(app: Flask) -> Iterator[str]:
    """Give a line for each route: its method, address, what a request needs, and the function that answers it.

    What is needed is found by asking without it: `cookie` of a link or a login, `Origin` of our own pages, and the
    header `X-RRP`.
    """
    addresses = {(way.rule, way.post): way.address() for way in ways(app)}
    for rule in sorted(app.url_map.iter_rules(), key=lambda rule: (rule.rule, rule.endpoint)):
        method = "POST" if "POST" in (rule.methods or ()) else "GET"
        address = addresses[rule.rule, method == "POST"].replace("style.css", "grid/main.js")
        handler = app.view_functions[rule.endpoint]
        where = f"{handler.__module__.removeprefix('rrp_sheets.web.')}.{handler.__name__}"
        yield f"| {method} | `{rule.rule}` | {', '.join(_needs(app, method, address))} | `{where}` |"


def _needs(app: Flask, method: str, address: str) -> Iterator[str]:
    def is_refused(client: Any, base: str, headers: dict[str, str], place: dict[str, str]) -> bool:
        asked = {"base_url": base, "headers": headers, "environ_overrides": place}
        return bool(client.open(address, method=method, **asked).status_code == 403)

    if is_refused(app.test_client(), HOME, {"X-RRP": "grid", "Origin": HOME}, STRANGER):
        yield "cookie"
    if method == "POST":
        if is_refused(let_in(app), HERE, {"X-RRP": "grid"}, {}):
            yield "Origin"
        if is_refused(let_in(app), HERE, {"Origin": HERE}, {}):
            yield "X-RRP"


def test_routes_are_those_of_the_table(app: Flask, golden: Any) -> None:
    head = ["| Method | Address | Needs | Function |", "|---|---|---|---|"]
    golden("routes.md", "\n".join([*head, *table(app), ""]))


def test_only_the_login_and_the_language_need_no_cookie_and_their_forms_no_header(app: Flask) -> None:
    lines = [line.strip("| ").split(" | ") for line in table(app)]
    assert {where for *_, needs, where in lines if "cookie" not in needs} == {
        "`views.login.page`", "`views.login.enter`", "`requests.choose_language`",
    }  # fmt: skip
    posts = [(needs, where) for method, _, needs, where in lines if method == "POST"]
    assert all("Origin" in needs for needs, _ in posts)
    forms = {"`views.login.enter`", "`views.login.leave`", "`requests.choose_language`"}
    assert {where for needs, where in posts if "X-RRP" not in needs} == forms


@pytest.mark.slow
@pytest.mark.parametrize("template", sorted(bundled("templates", "web").glob("*.html")), ids=lambda path: path.name)
def test_pages_link_to_routes_that_exist(app: Flask, template: Path) -> None:
    calls = re.findall(r"url_for\(([^,)]*)", template.read_text(encoding="utf-8"))
    named = {name for call in calls for name in re.findall(r"[\"']([\w.]+)[\"']", call)}
    assert not named - app.view_functions.keys()


def test_two_servers_of_one_process_share_nothing(tmp_path: Path) -> None:
    for name in ("mine", "other"):
        (tmp_path / name).mkdir()
        (tmp_path / name / f"{name}.md").write_text(GOOD, encoding="utf-8")
    mine, other = visit(tmp_path / "mine"), visit(tmp_path / "other")
    assert [get(client, "/book/mine.md").status_code for client in (mine, other)] == [200, 404]
    assert [get(client, "/book/other.md").status_code for client in (mine, other)] == [404, 200]
    stranger = create_app(tmp_path / "mine", "another secret").test_client()
    stranger.set_cookie(*COOKIE.split("="), domain="127.0.0.1")
    assert get(stranger, "/").status_code == 403
