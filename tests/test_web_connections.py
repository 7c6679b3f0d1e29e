"""Connections of one address: however many are open, half sent or idle, Stop gets through and nobody is shut out."""

from __future__ import annotations

import http.client
import re
import socket
import threading
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from typing import Any

import forked
import pytest
from busy import Span
from test_killed_server import HEADER, Served, wait_for

from rrp_sheets.web.serving import HEAD_SECONDS, MOST_OF_ADDRESS, THREADS, bind, make_server
from rrp_sheets.web.workbook_session import MOST_HERE
from rrp_sheets.workbook.files import make_workbook

STREAMS, HALF_SENT = 60, 40
LIMIT = 0.2  # seconds for the answer to Stop
SOON = "import rrp_sheets.web.workbook_session as s; s._KEEP_ALIVE = 0.3; "  # it soon notices which streams have left


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    """The real command in a process of its own."""
    folder = tmp_path_factory.mktemp("connections")
    make_workbook({"T": [HEADER, ["", "", "", "", "", "start"]]}, folder / "b.xlsx")
    with Served(folder, SOON + forked.PROGRAM) as served:
        yield served


def address(server: Served) -> tuple[str, int]:
    host, _, port = server.home.removeprefix("http://").partition(":")
    return host, int(port)


def sent(server: Served, data: bytes, opened: ExitStack) -> socket.socket:
    """A connection on which something was sent and nothing was read."""
    line = opened.enter_context(socket.create_connection(address(server), timeout=300))
    line.sendall(data)
    return line


def event_stream(server: Served, client: str) -> bytes:
    host, port = address(server)
    head = (
        f"GET /book/b.xlsx/events?client={client} HTTP/1.1\r\nHost: {host}:{port}\r\nCookie: {server.cookie()}\r\n\r\n"
    )
    return head.encode()


def all_left(server: Served) -> None:
    """Wait until no stream of an earlier test is open any more: the server notices that within seconds."""

    def alone() -> bool:
        with ExitStack() as opened:
            line = sent(server, event_stream(server, "alone"), opened)
            told = more = line.recv(12)
            while more and told.startswith(b"HTTP/1.1 200") and not re.search(rb"event: people\ndata: .*\n", told):
                told += (more := line.recv(65_536))
            server.post("book/b.xlsx/part", {"client": "alone"})
        return told.count(b'"client"') == 1

    wait_for(alone)


def half(server: Served) -> bytes:
    return b"POST /book/b.xlsx/cells HTTP/1.1\r\nHost: 127.0"


@contextmanager
def answering(app: Any) -> Iterator[int]:
    """A server in this process whose requests a function answers; gives its port."""
    made = make_server(app, bind(["127.0.0.1"], None))
    threading.Thread(target=made.run, daemon=True).start()
    try:
        yield made.effective_port
    finally:
        made.close()
        made.task_dispatcher.shutdown(timeout=1)


def stop(server: Served) -> tuple[int, float]:
    """Send Stop on a new connection, as a page does; the status, and the seconds until the answer."""
    host, port = address(server)
    headers = {"Cookie": server.cookie(), "X-RRP": "grid", "Origin": server.home}
    began = time.monotonic()
    line = http.client.HTTPConnection(host, port, timeout=300)
    line.request("POST", "/run/stop?name=n", headers=headers)
    answer = line.getresponse()
    answer.read()
    line.close()
    return answer.status, time.monotonic() - began


def closed_within(line: socket.socket, seconds: float) -> bool:
    """Read from a connection and return True when the server closes it within some seconds."""
    deadline = time.monotonic() + seconds
    try:
        while (left := deadline - time.monotonic()) > 0:
            line.settimeout(left)
            if not line.recv(65_536):
                return True
        return False
    except TimeoutError:
        return False
    except ConnectionError:
        pass
    return True


def closed_soon(line: socket.socket, seconds: float) -> bool:
    """Read from a connection and return True when the server closes it within some seconds, more on a crowded machine."""
    span = Span()
    while span.seconds() < seconds * span.crowded():
        if closed_within(line, 1):
            return True
    return False


def test_stop_is_answered_with_sixty_streams_and_forty_half_sent_requests_open(server: Served) -> None:
    with ExitStack() as opened:
        for number in range(STREAMS):
            sent(server, event_stream(server, f"page{number}"), opened)
        for _ in range(HALF_SENT):
            sent(server, half(server), opened)
        took, span = [], Span()
        for _ in range(5):
            status, seconds = stop(server)
            assert status == 409  # no run is going, which is an answer
            took.append(seconds)
        assert min(took) < LIMIT * span.crowded(), took


@pytest.mark.parametrize("seconds", [0.5, pytest.param(HEAD_SECONDS, marks=pytest.mark.soak)])
def test_what_is_half_sent_or_silent_is_closed_after_its_time(monkeypatch: pytest.MonkeyPatch, seconds: float) -> None:
    assert HEAD_SECONDS <= 5
    whole_request = b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n"

    def app(environ: dict[str, Any], begin: Any) -> list[bytes]:
        begin("200 OK", [("Content-Length", "0")])
        return [b""]

    with answering(app) as port, ExitStack() as opened:

        def line(data: bytes) -> socket.socket:
            made = opened.enter_context(socket.create_connection(("127.0.0.1", port), timeout=300))
            made.sendall(data)
            return made

        silent, half_sent, trickles = (
            line(b""),
            line(b"POST /cells HTTP/1.1\r\nHost: 127.0"),
            line(b"GET / HTTP/1.1\r\n"),
        )
        whole, again = line(whole_request), line(whole_request + b"GET / HT")
        assert whole.recv(12) == again.recv(12) == b"HTTP/1.1 200"
        # from here on: what was whole has come whole
        monkeypatch.setattr("rrp_sheets.web.serving.HEAD_SECONDS", seconds)
        span = Span()
        while not closed_within(trickles, 0.1):
            assert span.seconds() < 20 * seconds * span.crowded()
            with suppress(ConnectionError):
                trickles.sendall(b"x")
        assert all(closed_soon(each, 20 * seconds) for each in (silent, half_sent, again))
        assert not closed_within(whole, 0.1)  # it waits for the next request, which may take longer


def test_one_address_has_only_so_many_connections_and_the_newest_gets_in(server: Served) -> None:
    with ExitStack() as opened:
        lines = [sent(server, b"", opened) for _ in range(MOST_OF_ADDRESS)]
        span = Span()
        lines += [sent(server, b"", opened) for _ in range(20)]
        assert [closed_within(line, 300) for line in lines[:20]] == [True] * 20  # the oldest
        assert stop(server)[0] == 409
        closed = [closed_within(line, 0.01) for line in lines[-20:]]
        if span.seconds() < HEAD_SECONDS:  # else they may have been silent for too long
            assert not any(closed)


@pytest.mark.slow
def test_who_is_let_in_keeps_a_connection_while_strangers_fill_the_places(server: Served) -> None:
    with ExitStack() as opened:
        host = server.home.removeprefix("http://")
        ours = sent(server, f"GET / HTTP/1.1\r\nHost: {host}\r\nCookie: {server.cookie()}\r\n\r\n".encode(), opened)
        assert ours.recv(12) == b"HTTP/1.1 200"
        for _ in range(MOST_OF_ADDRESS + 20):
            stranger = sent(server, f"GET / HTTP/1.1\r\nHost: {host}\r\n\r\n".encode(), opened)
            assert stranger.recv(12) == b"HTTP/1.1 403"
        ours.settimeout(300)
        ours.sendall(f"GET /none HTTP/1.1\r\nHost: {host}\r\nCookie: {server.cookie()}\r\n\r\n".encode())
        told = b""
        while b"HTTP/1.1 404" not in told:
            more = ours.recv(65_536)
            assert more, "it was closed"
            told += more


def test_streams_that_begin_at_the_same_moment_are_no_more_than_there_may_be(server: Served) -> None:
    all_left(server)
    with ExitStack() as opened:
        lines = [sent(server, event_stream(server, f"p{n}"), opened) for n in range(STREAMS)]
        answers = Counter(line.recv(12) for line in lines)
        assert answers == {b"HTTP/1.1 200": MOST_HERE, b"HTTP/1.1 503": STREAMS - MOST_HERE}


def test_a_page_has_one_stream_and_keeps_its_cell_when_it_opens_another(server: Served) -> None:
    row = re.findall(r'<tr role="row" id="([^"]+)"', server.get("book/b.xlsx"))[0]
    all_left(server)
    place = {"sheet": "T", "row": row, "column": 6, "tag": "1"}
    with ExitStack() as opened:
        first = sent(server, event_stream(server, "mine"), opened)
        assert first.recv(12) == b"HTTP/1.1 200"
        assert server.post("book/b.xlsx/lock", {**place, "client": "mine", "name": "Aya"}).strip() == "{}"
        again = [sent(server, event_stream(server, "mine"), opened) for _ in range(MOST_HERE + 5)]
        assert all(line.recv(12) == b"HTTP/1.1 200" for line in again)
        assert closed_within(first, 300)
        open_still, span = again, Span()
        while len(open_still) > 1:  # requests of one moment come in any order
            assert span.seconds() < 300
            open_still = [line for line in open_still if not closed_within(line, 0.01)]
        # it stays for longer than the server takes to notice something
        assert open_still and not closed_within(open_still[0], 1.5)
        assert "Aya is editing" in server.post("book/b.xlsx/lock", {**place, "client": "other", "name": "Ben"})


def test_stop_does_not_wait_for_a_thread() -> None:
    """All threads are busy with requests that do not end, and more wait: Stop is answered."""
    busy = threading.Event()
    entered = threading.Semaphore(0)

    def app(environ: dict[str, Any], begin: Any) -> list[bytes]:
        if environ["PATH_INFO"] != "/run/stop":
            entered.release()
            busy.wait(600)
        begin("200 OK", [("Content-Length", "0")])
        return [b""]

    with answering(app) as port, ExitStack() as opened:
        opened.callback(busy.set)
        for _ in range(THREADS + 10):
            line = opened.enter_context(socket.create_connection(("127.0.0.1", port)))
            line.sendall(b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n")
        for _ in range(THREADS):
            assert entered.acquire(timeout=300)
        asked = http.client.HTTPConnection("127.0.0.1", port, timeout=300)
        asked.request("POST", "/run/stop")
        assert asked.getresponse().status == 200
        asked.close()
