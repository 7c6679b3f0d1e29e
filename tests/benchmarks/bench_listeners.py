"""Slowdown and delay of a run to which 20 pages listen.

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
from dataclasses import dataclass, field
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from test_killed_server import Served

from rrp_sheets.resources import bundled

LISTENERS = 20
WINDOW = 4.0  # seconds
PAIRS = 5
ROUNDS = 3  # until the pairs agree
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


def wait(seconds: float) -> None:
    """Let time go by: it is what is measured."""
    threading.Event().wait(seconds)


def wait_for(holds: Callable[[], object]) -> None:
    deadline = time.monotonic() + 90
    while not holds():
        assert time.monotonic() < deadline
        wait(0.2)


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
    wait(WINDOW)
    ended, last = time.perf_counter(), json.loads(server.get("run/now"))["t"]
    return float(last - first) / (ended - begun), (computed(server) - work) / (ended - begun)


@dataclass
class Measured:
    """Windows in pairs: without listeners and with them."""

    alone: list[float] = field(default_factory=list)
    heard: list[float] = field(default_factory=list)
    work: tuple[list[float], list[float]] = field(default_factory=lambda: ([], []))
    read: int = 0

    def take(self, server: Served, cookie: str) -> None:
        """Measure a pair."""
        for listeners in (False, True):
            crowd = Crowd(server.home, cookie) if listeners else None
            wait(0.5)
            speed, work = factor(server)
            (self.heard if listeners else self.alone).append(speed)
            self.work[listeners].append(work)
            if crowd is not None:
                crowd.leave()
                self.read += crowd.bytes

    @property
    def falls(self) -> list[float]:
        """By what part the run is slower with listeners, pair by pair."""
        return [1 - b / a for a, b in zip(self.alone, self.heard, strict=True)]

    @property
    def noise(self) -> float:
        """Spread of the pairs; listeners make no run faster, so an apparent gain is noise as well."""
        return max(max(self.falls) - min(self.falls), -statistics.median(self.falls))

    def __str__(self) -> str:
        each = self.read / len(self.alone) / LISTENERS / WINDOW / 1000
        return (
            f"{statistics.median(self.alone):.2f} s a second alone, {statistics.median(self.heard):.2f} with {LISTENERS} "
            f"listeners ({each:.0f} kB/s each): {statistics.median(self.falls):+.1%} "
            f"(each pair: {', '.join(f'{f:+.1%}' for f in self.falls)}); "
            f"the server computes {statistics.median(self.work[0]):.1%} of a core alone, "
            f"{statistics.median(self.work[1]):.1%} with them"
        )


@pytest.mark.parametrize("speed", [0, 1], ids=["fast", "in real time"])
def test_a_run_goes_on_as_fast_with_twenty_listeners(tmp_path: Path, speed: float) -> None:
    shutil.copy(bundled("workbooks", "simple-tracking.xlsx"), tmp_path / "b.xlsx")
    with Served(tmp_path) as server:
        started(server, speed)
        cookie = server.cookie()
        for _ in range(ROUNDS):
            measured = Measured()
            for _ in range(PAIRS):
                measured.take(server, cookie)
            print(f"\n{'as fast as it can' if speed == 0 else 'in real time'}: {measured}")
            if measured.noise <= MOST:
                break
            print(f"too noisy: the pairs are {measured.noise:.1%} apart, more than the {MOST:.0%} to be seen")
        server.post("run/stop?name=n", {})
        wait_for(lambda: json.loads(server.get("run/now"))["phase"] == "none")
    assert measured.read > LISTENERS * PAIRS * 1_000, "they were told nothing"
    assert measured.noise <= MOST, "too noisy: nothing was measured. Let this machine do nothing else"
    assert statistics.median(measured.falls) < MOST
