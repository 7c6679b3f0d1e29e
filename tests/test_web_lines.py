"""The lines on which pages are told what happens: how many there are, and pages that were away."""

from __future__ import annotations

import http.client
import json
import re
import threading
import time
import urllib.parse
from collections.abc import Iterator
from typing import Any

import pytest
from browser import COOKIE
from chromium import LATEST_ANSWER, GridPage, becomes, eventually, let_in, listening, serving

from rrp_sheets.web.password import Password
from rrp_sheets.web.requests import Lan
from rrp_sheets.web.workbook_session import MOST_HERE, MOST_LISTENERS, MOST_OF_LOGIN
from rrp_sheets.workbook.files import make_workbook

HEADER = ["On", "Input streams", "Connector", "Formula", "Output stream", "Notes"]
WORDS = "green otter lamp"
RECONNECT_MS = 5_000  # as in api.js


@pytest.fixture(scope="module")
def url(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    folder = tmp_path_factory.mktemp("lines")
    make_workbook({"T": [HEADER, *[["", "", "", "", "", "start"]] * 5]}, folder / "b.xlsx")
    with pytest.MonkeyPatch.context() as patch, serving(folder, Lan(Password(WORDS), ())) as url:
        patch.setattr("rrp_sheets.web.workbook_session._KEEP_ALIVE", 0.3)  # it soon notices who has left
        yield url


class Line:
    """One page's event stream."""

    def __init__(self, url: str, cookie: str, *, had: str = "", client: str = "x") -> None:
        self.http = http.client.HTTPConnection(url.removeprefix("http://"), timeout=300)
        headers = {"Cookie": cookie, **({"Last-Event-ID": had} if had else {})}
        self.http.request("GET", f"/book/b.xlsx/events?client={client}", headers=headers)
        self.answer = self.http.getresponse()

    def until(self, words: str) -> str:
        """Events until some words come."""
        text = ""
        while words not in text:
            line = self.answer.readline()
            if not line:
                break
            text += line.decode()
        return text

    def close(self) -> None:
        self.answer.close()
        self.http.close()


def ask(url: str, method: str, address: str, cookie: str = "", data: str = "", **headers: str) -> Any:
    line = http.client.HTTPConnection(url.removeprefix("http://"), timeout=300)
    line.request(method, address, data or None, {"Origin": url, "Cookie": cookie, **headers})
    answer = line.getresponse()
    answer.body = answer.read().decode()  # type: ignore[attr-defined]
    line.close()
    return answer


def owner(url: str) -> str:
    return COOKIE


def person(url: str, name: str) -> str:
    form = urllib.parse.urlencode({"name": name, "password": WORDS})
    kind = {"Content-Type": "application/x-www-form-urlencoded"}
    return str(ask(url, "POST", "/login", "", form, **kind).headers["Set-Cookie"]).split(";")[0]


JSON = {"X-RRP": "grid", "Content-Type": "application/json"}


def put(url: str, cookie: str, text: str, client: str = "other") -> None:
    row = re.findall(r'<tr role="row" id="([^"]+)"', ask(url, "GET", "/book/b.xlsx", cookie).body)[0]
    cells = [{"row": row, "column": 6, "text": text, "was": None}]
    body = json.dumps({"sheet": "T", "client": client, "name": "n", "tag": "t", "cells": cells})
    assert "rows" in json.loads(ask(url, "POST", "/book/b.xlsx/cells", cookie, body, **JSON).body)


@pytest.mark.slow
def test_one_who_logged_in_has_only_so_many_pages_and_the_others_theirs(url: str) -> None:
    anna, bob = person(url, "Anna"), person(url, "Bob")
    lines = [Line(url, anna, client=f"a{n}") for n in range(MOST_OF_LOGIN)]
    try:
        refused = Line(url, anna)
        assert refused.answer.status == 503 and refused.answer.headers["Retry-After"] == "5"
        assert refused.answer.read().decode().startswith(f"You have {MOST_OF_LOGIN} pages open here. Close one")
        other = Line(url, bob)
        assert other.answer.status == 200
        other.close()
    finally:
        for line in lines:
            line.close()


def test_nobody_acts_for_anothers_page_and_asking_for_heads_takes_no_line(url: str) -> None:
    anna, bob = person(url, "Anna"), person(url, "Bob")
    line = Line(url, anna, client="annas")
    line.until("id: ")
    kind = {"X-RRP": "grid", "Content-Type": "application/json"}
    for action in ("part", "unlock", "stand", "lock", "cells"):
        body = json.dumps({"client": "annas", "sheet": "T", "row": "x", "column": 6, "cells": []})
        assert ask(url, "POST", f"/book/b.xlsx/{action}", bob, body, **kind).status == 403
    assert Line(url, bob, client="annas").answer.status == 403
    for _ in range(MOST_LISTENERS + 1):
        assert ask(url, "HEAD", "/book/b.xlsx/events", bob).status == 405
    line.close()
    other = Line(url, bob, client="bobs")
    assert other.answer.status == 200
    other.close()


def test_logging_out_ends_ones_lines(url: str) -> None:
    anna, bob = person(url, "Anna"), person(url, "Bob")
    line = Line(url, anna)
    line.until("id: ")
    assert ask(url, "POST", "/logout", anna).status == 303
    put(url, bob, "after the logout")
    assert "after the logout" not in line.until("never comes")
    line.close()


def test_a_page_that_comes_back_gets_what_it_missed_and_only_that(url: str) -> None:
    cookie = owner(url)
    line = Line(url, cookie)
    put(url, cookie, "seen by all")
    told = line.until("seen by all")
    had = re.findall(r"id: (\S+)", told)[-1]
    line.close()
    put(url, cookie, "missed")
    put(url, cookie, "by oneself", client="x")
    back = Line(url, cookie, had=had)
    told = back.until("event: people")
    back.close()
    assert "missed" in told and "seen by all" not in told and "by oneself" not in told and "reload" not in told
    for strange in ("00000000.1", f"{had}9999", had.split(".")[0] + ".-1", "x", "1.1.1", "%s" * 50):
        lost = Line(url, cookie, had=strange)
        assert "event: reload" in lost.until("event: people"), strange
        lost.close()


@pytest.mark.parametrize(
    "rows", [[{"id": "row 1"}], [{"id": "wabcd-9", "texts": {"x": "y"}}], [{"id": "wabcd-9"}] * 2, [], "x", [1], None]
)
def test_rows_that_no_page_makes_are_refused(url: str, rows: object) -> None:
    sent = json.dumps({"client": "c", "tag": "t", "name": "Anna", "sheet": "T", "before": None, "rows": rows})
    assert ask(url, "POST", "/book/b.xlsx/insert", owner(url), sent, **JSON).status == 400


def late(route: Any) -> None:
    """Lets a file come only when everything else of the page is there."""
    route.request.frame.page.wait_for_timeout(500)
    route.continue_()


def free(url: str, cookie: str) -> bool:
    """True if there is room for another page."""
    line = Line(url, cookie, client="asks")
    line.close()
    return bool(line.answer.status == 200)


def people(url: str, cookie: str) -> str:
    """Return the server's event that lists the people with this workbook open."""
    ask(url, "GET", "/book/b.xlsx", cookie)  # the server then looks who has gone
    line = Line(url, cookie)
    try:
        return line.until("event: people") + line.until("\n")
    finally:
        line.close()


@pytest.mark.slow
def test_pages_in_the_background_and_one_page_too_many(browser: Any, url: str) -> None:
    cookie = owner(url)
    page = GridPage(browser, url, "b.xlsx", sheet="T", name="Anna")
    # what opens the line comes late, on a slow network: the page waits for it
    page.page.route("**/hx-sse.min.js", late)
    page.page.reload()
    listening(page.page)
    page.page.unroute("**/hx-sse.min.js")
    # in the background: the browser gives the line up, and takes it again when the page is looked at
    page.page.evaluate(
        "() => { window.kept = true; Object.defineProperty(document, 'hidden', {get: () => window.away, configurable: true});"
        "window.away = true; document.dispatchEvent(new Event('visibilitychange')); }"
    )
    eventually(lambda: "Anna" not in people(url, cookie))
    put(url, cookie, "while away")
    page.page.evaluate("() => { window.away = false; document.dispatchEvent(new Event('visibilitychange')); }")
    page.expect("F2", "while away")
    eventually(lambda: page.page.evaluate("window.kept"), "it was loaded again, and what one was typing would be lost")
    page.close()

    lines = [Line(url, cookie, client=f"l{n}") for n in range(MOST_HERE)]
    context = browser.new_context()
    let_in(context, url)
    another = context.new_page()
    another.clock.install()
    another.goto(f"{url}/book/b.xlsx")
    another.wait_for_selector(f"#line-lost:has-text('You have {MOST_HERE} pages open here. Close one')")
    becomes(lambda: another.get_attribute("#line-lost", "role"), "status")
    for line in lines:
        line.close()
    put(url, cookie, "shows that they are gone")
    eventually(lambda: free(url, cookie))
    another.clock.run_for(RECONNECT_MS)  # it goes on by itself
    another.wait_for_selector("#line-lost:empty", state="attached")
    put(url, cookie, "told again")
    another.wait_for_selector("td[data-v='told again']")
    another.context.close()


@pytest.mark.slow
def test_a_page_opened_in_the_background_takes_its_line_when_it_is_looked_at(browser: Any, url: str) -> None:
    cookie = owner(url)
    context = browser.new_context()
    let_in(context, url, "Ben")
    context.add_init_script(
        "window.away = true; Object.defineProperty(document, 'hidden', {get: () => window.away, configurable: true});"
        "addEventListener('htmx:sse:after:connection', () => { window.opened = true; }, true);"
    )
    page = context.new_page()
    page.goto(f"{url}/book/b.xlsx")
    page.wait_for_function("() => window.opened")
    eventually(lambda: "Ben" not in people(url, cookie))
    page.evaluate("() => { window.away = false; document.dispatchEvent(new Event('visibilitychange')); }")
    eventually(lambda: "Ben" in people(url, cookie))
    context.close()


def test_when_all_lines_are_taken_one_is_told_so_and_how_many_are_ones_own(url: str) -> None:
    zoe = person(url, "Zoe")
    lines = []
    # the server notices within seconds that those of other tests have left
    deadline = time.monotonic() + 300 + MOST_LISTENERS * LATEST_ANSWER
    for number in range(MOST_LISTENERS):
        if number % MOST_OF_LOGIN == 0:
            cookie = person(url, f"Person {number}")
        while (line := Line(url, cookie, client=f"o{number}")).answer.status != 200:
            line.close()
            assert time.monotonic() < deadline
            threading.Event().wait(0.1)
        lines.append(line)
    refused = Line(url, zoe)
    assert refused.answer.read().decode().startswith(f"{MOST_LISTENERS} pages are open on this server, 0 of them yours")
    for line in [*lines, refused]:
        line.close()
