"""Bodies sent to the routes that change something: wrong, huge and endless ones."""

from __future__ import annotations

import http.client
import io
import json
import re
import socket
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from attack import _WHO, BOOK, FORMS, JSON, OURS, SOME, Way, _with_row, contents, enter, make_folder, ways
from browser import COOKIE, HOME, TOKEN
from busy import Span, within, work_within
from flask import Flask
from test_hostile_files import REFUSED

from rrp_sheets.web.app import create_app
from rrp_sheets.web.serving import MOST_OF_ADDRESS, bind, make_server

STRANGE: list[Any] = [
    None, True, 0, -1, 1.5, 1e308, 10**400, "", "x", "\ud800", "\0", "x" * 100_000, [], [[]], [None], {}, {"a": {}},
    {"__proto__": 1}, ["x"] * 10_000, float("nan"), float("inf"), 2**63, -(2**63) - 1, {"$ne": 1}, "%s%n{0}{{7*7}}",
]  # fmt: skip
GROWS = {"tabs.change add", "tabs.change duplicate"}
"""What makes the workbook larger each time that it is right: three other ways have the same reader."""
NO_OBJECTS: list[str | bytes] = [
    "", " ", "null", "true", "3", '"x"', "[]", "[{}]", "{", "{]", '{"a":}', "{'a': 1}", "[" * 100_000,
    '{"a":' * 50_000, "9" * 10_000, '{"client": "c", "client": 1, "sheet": {"a": [' + "[" * 50_000, "<x/>", "a=1&b=2",
    b"\xff\xfe{\x00}\x00", b"\x00", b"PK\x03\x04",
]  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_folder(tmp_path_factory.mktemp("bodies"))


@pytest.fixture(scope="module")
def app(folder: Path) -> Flask:
    return create_app(folder, TOKEN)


@pytest.fixture(scope="module")
def client(app: Flask) -> Any:
    return enter(app)


@pytest.fixture(scope="module")
def row(client: Any) -> str:
    return str(re.findall(r'<tr role="row" id="([^"]+)"', client.get(f"/book/{BOOK}", base_url=HOME).text)[0])


def json_ways(app: Flask) -> list[Way]:
    return [way for way in ways(app) if way.post and way.key in JSON]


def send(client: Any, way: Way, text: str | bytes) -> Any:
    headers = {**OURS, "Content-Type": "application/json"}
    return client.post(way.address(), base_url=HOME, headers=headers, data=text)


@SOME
def test_what_is_no_object_is_refused(app: Flask, client: Any, folder: Path, every: int) -> None:
    before = contents(folder)
    for place, way in enumerate(json_ways(app)):
        for text in NO_OBJECTS[place % every :: every]:
            answer = send(client, way, text)
            assert answer.status_code == 400, (way.key, text[:30], answer.status_code)
            assert "Traceback" not in answer.text
    assert contents(folder) == before


@SOME
def test_fields_of_the_wrong_kind_are_refused_or_do_no_harm(app: Flask, client: Any, row: str, every: int) -> None:
    for place, way in enumerate(json_ways(app)):
        right = _with_row(JSON[way.key], row)
        for strange in (*_strange(right, place, every, grows=way.key in GROWS), {}, {str(n): n for n in range(20_000)}):
            sent = strange
            if way.key == "run_panel.start" and all(isinstance(sent.get(n, ""), str) for n in ("mode", "until")):
                sent = {**sent, "mode": "x"}  # nothing is started here
            answer = send(client, way, json.dumps(sent))
            assert answer.status_code < 500, (way.key, str(sent)[:200])
            assert "Traceback" not in answer.text
    assert client.get(f"/book/{BOOK}", base_url=HOME).status_code == 200
    assert client.get("/", base_url=HOME).status_code == 200


def _strange(right: dict[str, Any], place: int, every: int, *, grows: bool) -> Iterator[dict[str, Any]]:
    """A valid body, with each of its fields in turn of an unexpected kind, beginning at another kind at each place.

    A strange name of who sends it is right, too: what then `grows` is asked for under such names elsewhere.
    """
    for field, (name, value) in enumerate(right.items()):
        for strange in STRANGE[(place + field) % every :: every]:
            if not (grows and name in _WHO and isinstance(strange, str)):
                yield {**right, name: strange}
        if isinstance(value, list) and value and isinstance(value[0], dict):
            for number, inner in enumerate(value[0]):
                for strange in STRANGE[(place + number) % every :: every]:
                    yield {**right, name: [{**value[0], inner: strange}]}


@pytest.mark.parametrize("every_route", [False, pytest.param(True, marks=pytest.mark.soak)])
def test_forms_of_the_wrong_kind_are_refused_or_do_no_harm(client: Any, app: Flask, every_route: bool) -> None:
    first = True
    for way in ways(app):
        if way.post and way.key in FORMS:
            many = 200_000 if every_route or first else 2_000  # all routes read their forms in the same way
            for kind, data in (
                ("application/json", b"{}"), ("multipart/form-data; boundary=x", b"--x\r\n" * 2_000), ("", b"x"),
                ("multipart/form-data", b"x"), ("multipart/form-data; boundary=" + "x" * 300, b"--x--"),
                ("application/x-www-form-urlencoded", b"&".join(b"a=1" for _ in range(many))),
                ("application/x-www-form-urlencoded", b"book=%ff%00&name=%ff%00&title=%ff&version=%ff"),
                ("multipart/form-data; boundary=x", b"".join(b"--x\r\nContent-Disposition: form-data; name=a\r\n\r\n1\r\n" for _ in range(5_000)) + b"--x--\r\n"),
            ):  # fmt: skip
                answer = client.post(way.address(), base_url=HOME, headers=OURS, data=data, content_type=kind)
                # nothing that is sent with Stop is read: it says that there is no run
                right = (409,) if way.key == "run_panel.stop" else (200, 303, 400, 404, 413, 415, 422)
                assert answer.status_code in right, (way.key, kind[:60], answer.status_code)
            first = False


# ---- uploads ----


SLOW = {"a million cells", "400,000 texts"}  # to make; tests/test_hostile_files.py has them
FILES = sorted(case for case, (name, _, _) in REFUSED.items() if name == "x.xlsx" and case not in SLOW)


@pytest.mark.slow
@pytest.mark.parametrize("case", FILES)
def test_hostile_files_do_not_get_onto_the_shelf(client: Any, folder: Path, case: str) -> None:
    before = contents(folder)
    form = {"file": (io.BytesIO(REFUSED[case][1]()), "bad.xlsx")}
    with work_within(10):
        answer = client.post(
            "/shelf/upload", base_url=HOME, headers=OURS, data=form, content_type="multipart/form-data"
        )
    assert answer.status_code in (200, 413) and (answer.status_code == 413 or "is-error" in answer.text)
    assert "Traceback" not in answer.text
    assert contents(folder) == before and not list(folder.glob(".*.part"))


# ---- bodies and readers that take their time ----


@pytest.fixture
def served(app: Flask) -> Iterator[int]:
    server = make_server(app, bind(["127.0.0.1"], None))
    thread = threading.Thread(target=server.run, daemon=True)
    thread.start()
    yield server.effective_port
    server.close()
    server.task_dispatcher.shutdown(timeout=1)


def answered(port: int) -> int:
    line = http.client.HTTPConnection("127.0.0.1", port, timeout=300)
    line.request("GET", "/", headers={"Cookie": COOKIE})
    answer = line.getresponse()
    answer.read()
    line.close()
    return answer.status


def test_bodies_that_trickle_do_not_stop_the_others(served: int) -> None:
    head = b"POST /shelf/upload HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 1000000\r\n\r\n"
    begun = [
        head,
        head + b"x" * 1000,
        b"GET / HTTP/1.1\r\nHost: 127",
        b"",
        b"POST / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n5\r\n",
    ]
    slow = [socket.create_connection(("127.0.0.1", served)) for _ in range(MOST_OF_ADDRESS - 5)]
    try:
        for number, one in enumerate(slow):
            one.sendall(begun[number % len(begun)])
        with within(10):
            assert answered(served) == 200
    finally:
        for one in slow:
            one.close()


def test_a_request_must_arrive_in_time_however_lively_it_trickles(app: Flask) -> None:
    server = make_server(app, bind(["127.0.0.1"], None))
    server.adj.channel_timeout, server.adj.cleanup_interval = 1, 1
    thread = threading.Thread(target=server.run, daemon=True)
    thread.start()
    line = socket.create_connection(("127.0.0.1", server.effective_port))
    line.sendall(b"POST /shelf/upload HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 1000000\r\n\r\n")
    span, ended = Span(), False
    while not ended and span.seconds() < 20 * span.crowded():
        line.settimeout(0.2)
        try:
            line.sendall(b"x")
            ended = line.recv(100) == b""
        except TimeoutError:
            continue
        except OSError:
            ended = True
    line.close()
    server.close()
    server.task_dispatcher.shutdown(timeout=1)
    assert ended


def test_what_the_server_refuses_by_itself_bears_the_headers_too(served: int) -> None:
    for request, code in (
        (b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nX: " + b"x" * 40_000 + b"\r\n\r\n", b"431"),
        (b"POST / HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 99999999\r\n\r\n" + b"x" * 90_000, b"413"),
        (b"\x16\x03\x01\r\n\r\n", b"400"),
        (b"GET / HTTP/1.1\r\nContent-Length: -1\r\n\r\n", b"400"),
    ):
        with socket.create_connection(("127.0.0.1", served), timeout=300) as line:
            try:
                line.sendall(request)
                answer = line.recv(5_000)
            except ConnectionError:  # it did not wait for the rest
                continue
        assert answer.startswith(b"HTTP/1.") and answer.split(b" ")[1] == code, answer[:100]
        assert (
            b"Content-Security-Policy: default-src 'none'" in answer and b"waitress" not in answer.split(b"\r\n\r\n")[0]
        )


@pytest.mark.slow
def test_readers_that_do_not_read_do_not_stop_the_others(served: int, folder: Path) -> None:
    (folder / "large.md").write_text("## Tracking\n" + "| Input streams | Connector | Formula | Output stream |\n|---|---|---|---|\n"
                                     + "| Red ball | map | redBall.x | X |\n" * 3_000, encoding="utf-8")  # fmt: skip
    sleepers = []
    for _ in range(40):
        one = socket.create_connection(("127.0.0.1", served))
        one.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 2048)
        one.sendall(
            f"GET /static/vendor/js/three.core.js HTTP/1.1\r\nHost: 127.0.0.1:{served}\r\nCookie: {COOKIE}\r\n\r\n".encode()
        )
        sleepers.append(one)
    try:
        with within(10):
            assert answered(served) == 200
    finally:
        for one in sleepers:
            one.close()
