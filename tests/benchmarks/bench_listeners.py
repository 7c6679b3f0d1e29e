"""How much slower a run goes, and how much later, when 20 pages listen to it.

The real server in a process of its own, a real simulated run, 20 HTTP clients that read everything they are told.
Windows with and without listeners take turns on the same run, so that whatever else the machine does falls on both.
"""

from __future__ import annotations

import json
import os
import selectors
import shutil
import socket
import statistics
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1]))

from test_killed_server import Served

from rrp_sheets.resources import bundled

LISTENERS = 20
WINDOW = 4.0  # seconds
PAIRS = 5
MOST = 0.10  # of the speed


class Crowd:
    """Clients of a run's event stream: they read, and throw away."""

    def __init__(self, home: str, cookie: str) -> None:
        host = home.removeprefix("http://")
        self.bytes = 0
        self._over = threading.Event()
        self._ready = selectors.DefaultSelector()
        for number in range(LISTENERS):
            line = socket.create_connection(tuple(host.split(":")))  # type: ignore[arg-type]
            request = f"GET /book/b.xlsx/events?client=c{number} HTTP/1.1\r\nHost: {host}\r\nCookie: {cookie}\r\n\r\n"
            line.sendall(request.encode())
            self._ready.register(line, selectors.EVENT_READ)
        self._thread = threading.Thread(target=self._read)
        self._thread.start()

    def _read(self) -> None:
        while not self._over.is_set():
            for key, _ in self._ready.select(0.2):
                self.bytes += len(key.fileobj.recv(1_000_000))  # type: ignore[union-attr]

    def leave(self) -> None:
        self._over.set()
        self._thread.join()
        for key in list(self._ready.get_map().values()):
            key.fileobj.close()  # type: ignore[union-attr]


def wait_for(holds: Callable[[], object]) -> None:
    deadline = time.monotonic() + 90
    while not holds():
        assert time.monotonic() < deadline
        time.sleep(0.2)


def started(server: Served, speed: float) -> None:
    asked = {"client": "c", "name": "n", "mode": "simulated", "until": "stop", "speed": speed}
    wait_for(lambda: "where" in server.post_or_refused("book/b.xlsx/run/start", asked))
    wait_for(lambda: json.loads(server.get("run/now")).get("t", 0) > 0.5)


def computed(server: Served) -> float:
    """Seconds for which the server itself has computed; 0 where the system does not say."""
    stat = Path(f"/proc/{server.process.pid}/stat")
    if not stat.is_file():
        return 0.0
    fields = stat.read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def factor(server: Served) -> tuple[float, float]:
    """Seconds of the robot for a second of the clock, in a window; and seconds that the server computes for it."""
    begun, first, work = time.perf_counter(), json.loads(server.get("run/now"))["t"], computed(server)
    time.sleep(WINDOW)
    ended, last = time.perf_counter(), json.loads(server.get("run/now"))["t"]
    return float(last - first) / (ended - begun), (computed(server) - work) / (ended - begun)


@pytest.mark.parametrize("speed", [0, 1], ids=["fast", "in real time"])
def test_a_run_goes_on_as_fast_with_twenty_listeners(tmp_path: Path, speed: float) -> None:
    shutil.copy(bundled("workbooks", "simple-tracking.xlsx"), tmp_path / "b.xlsx")
    with Served(tmp_path) as server:
        started(server, speed)
        cookie = server.cookie()
        alone: list[float] = []
        heard: list[float] = []
        busy: tuple[list[float], list[float]] = ([], [])
        read = 0
        for _ in range(PAIRS):
            speed_now, work = factor(server)
            alone.append(speed_now)
            busy[0].append(work)
            crowd = Crowd(server.home, cookie)
            time.sleep(0.5)
            speed_now, work = factor(server)
            heard.append(speed_now)
            busy[1].append(work)
            crowd.leave()
            read += crowd.bytes
            time.sleep(0.5)
        server.post("book/b.xlsx/run/stop", {"name": "n"})
        wait_for(lambda: json.loads(server.get("run/now"))["phase"] == "none")
    falls = [1 - b / a for a, b in zip(alone, heard, strict=True)]
    fall = statistics.median(falls)
    print(
        f"\n{'as fast as it can' if speed == 0 else 'in real time'}: {statistics.median(alone):.2f} s a second alone, "
        f"{statistics.median(heard):.2f} with {LISTENERS} listeners ({read / PAIRS / LISTENERS / WINDOW / 1000:.0f} kB/s "
        f"each): {fall:+.1%} (each pair: {', '.join(f'{f:+.1%}' for f in falls)}); "
        f"the server computes {statistics.median(busy[0]):.1%} of a core alone, {statistics.median(busy[1]):.1%} with them"
    )
    assert read > LISTENERS * PAIRS * 1_000, "they were told nothing"
    assert fall < MOST
