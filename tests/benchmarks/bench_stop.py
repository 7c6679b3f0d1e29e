"""Stop, by the wall clock: until the robot is on its way to rest, and until everything is written.

The real server, engine and simulator. Each figure is printed beside its bound.
"""

from __future__ import annotations

import os
import re
import signal
import socket
import sys
import time
from contextlib import ExitStack
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

import pytest
from browser import COOKIE
from chromium import GridPage, browsing, serving
from panel import BOOKS, LIVE, row, run, told_of_stop, trace
from playwright.sync_api import expect
from test_stop import FAST, Running, command, wait_until
from test_watchdog import EVENT_LOOP

from rrp_sheets.workbook.files import make_workbook

TIMES = 5
REST, ALONE, END = 200.0, 1000.0, 3000.0
"""Milliseconds: until the robot begins its rest; that without Stop, when the server has died; until all is over."""
TEXTS = "\n".join(f"| {n} | {'x' * 2000} |" for n in range(990))
TABLE = f"## Parts\n| Key | A |\n|---|---|\n{TEXTS}\n"
SLOW = "\n".join(
    f"| Red ball | map | LEN([PICK(Parts[A]) for i in RANGE(18)]) | L{n} |\n| L{n} | subscribe | | Print |"
    for n in range(40)
)


def tell(what: str, took: list[float], most: float) -> None:
    """Print figures beside their bound, and hold them."""
    print(f"\n{what}: {', '.join(f'{ms:.0f}' for ms in took)} ms (at most {most:.0f})")
    assert max(took) <= most


def test_stop_is_heard_within_a_fifth_of_a_second(tmp_path: Path) -> None:
    make_workbook(BOOKS["long.xlsx"], tmp_path / "long.xlsx")
    took: list[float] = []
    with serving(tmp_path) as url, browsing() as browser:
        for _ in range(TIMES):
            at = GridPage(browser, url, "long.xlsx", name="Aya")
            run(at.page)
            expect(row(at.page, 6).locator(LIVE)).to_have_text(re.compile(r"^\d"), timeout=15_000)
            told = told_of_stop(at.page)
            took.append(told.get("finishing", told.get("ended", float("inf"))))
            assert len(trace(tmp_path, "long")) > 100, "there was no flood"
            at.close()
    tell("Esc Esc on a flooded page until the robot goes to rest", took, REST)


def test_stop_beside_idle_connections(tmp_path: Path) -> None:
    """60 event streams and 40 requests of which only the beginning was sent, all from this computer."""
    make_workbook(BOOKS["long.xlsx"], tmp_path / "long.xlsx")
    took: list[float] = []
    with serving(tmp_path) as url, browsing() as browser:
        host, _, port = url.removeprefix("http://").partition(":")
        events = f"GET /book/long.xlsx/events?client=%s HTTP/1.1\r\nHost: {host}:{port}\r\nCookie: {COOKIE}\r\n\r\n"
        for _ in range(TIMES):
            at = GridPage(browser, url, "long.xlsx", name="Aya")
            run(at.page)
            expect(row(at.page, 6).locator(LIVE)).to_have_text(re.compile(r"^\d"), timeout=15_000)
            with ExitStack() as idle:
                for n in range(100):
                    line = idle.enter_context(socket.create_connection((host, int(port))))
                    line.sendall((events % f"idle{n}" if n < 60 else "POST /book/long").encode())
                told = told_of_stop(at.page)
            took.append(told.get("finishing", told.get("ended", float("inf"))))
            at.close()
    tell("Esc Esc beside 60 event streams and 40 half-sent requests until the robot goes to rest", took, REST)


def stop_ms(running: Running) -> float:
    """Stop a run; gives the time until it is closed with all its files, in ms."""
    before = time.monotonic()
    running.stop()
    return (time.monotonic() - before) * 1000


@pytest.mark.parametrize(("what", "body", "more"), [
    ("slow rows", SLOW, (TABLE,)), ("slow rows in the event loop", SLOW, (TABLE, EVENT_LOOP)),
    ("event loop", FAST, (EVENT_LOOP,)), ("frozen engine", FAST, ()),
])  # fmt: skip
def test_stop_whatever_the_engine_does(what: str, body: str, more: tuple[str, ...], tmp_path: Path) -> None:
    rest, end = [], []
    for n in range(TIMES):
        (tmp_path / str(n)).mkdir()
        running = Running(tmp_path / str(n), body, *more, film=True)
        wait_until(lambda r=running: r.panel.us > 1_000_000 or (r.panel.began and time.monotonic() > r.panel.began + 3))
        if what == "frozen engine":
            os.kill(running.run.pid, signal.SIGSTOP)
        before = time.monotonic()
        end.append(stop_ms(running))
        rest.append((running.panel.finished[0] - before) * 1000)
    tell(f"Stop, {what}, until the robot goes to rest", rest, REST)
    print(f"Stop, {what}, until all files are written: {', '.join(f'{ms:.0f}' for ms in end)} ms")


def test_stop_of_a_frozen_simulator(tmp_path: Path) -> None:
    took = []
    for n in range(TIMES):
        (tmp_path / str(n)).mkdir()
        running = Running(tmp_path / str(n), FAST, film=True)
        wait_until(lambda r=running: r.panel.us > 1_000_000)
        os.kill(running.run.simulator_pid, signal.SIGSTOP)
        took.append(stop_ms(running))
        assert running.panel.finished == [], "a rest was claimed"
    tell("Stop, frozen simulator, until the run is closed with its files", took, END)


def test_ctrl_c_until_the_end_of_the_process(tmp_path: Path) -> None:
    took = []
    for n in range(TIMES):
        (tmp_path / str(n)).mkdir()
        with command(tmp_path / str(n)) as running:
            before = time.monotonic()
            running.send_signal(signal.SIGINT)
            running.communicate(timeout=60)
            took.append((time.monotonic() - before) * 1000)
    tell("Ctrl-C until the end of the process, with all files", took, END)


def test_a_killed_server_without_stop(tmp_path: Path) -> None:
    took = []
    for n in range(TIMES):
        (tmp_path / str(n)).mkdir()
        with command(tmp_path / str(n)) as running:
            running.kill()
            killed = time.time()
        folder = tmp_path / str(n) / "out"
        wait_until(lambda f=folder: '"summary"' in (f / "trace.jsonl").read_text().splitlines()[-1])
        took.append(((folder / "poses.jsonl").stat().st_mtime - killed) * 1000)
    tell("The supervisor is killed, until the robot goes to rest", took, ALONE)
