"""A server that is killed at any moment of editing: what it had acknowledged is there when it comes back."""

from __future__ import annotations

import http.client
import json
import random
import re
import shutil
import subprocess
import sys
import threading
import time
import urllib.error
import urllib.request
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import forked
import openpyxl
import pytest
from chromium import becomes
from playwright.sync_api import expect

from rrp_sheets.workbook.files import make_workbook, read_sheets

ROWS = 30
HEADER = ["On", "Input streams", "Connector", "Formula", "Output stream", "Notes"]
NOTES = 6


class Served:
    """A server in a process of its own, and a client of it."""

    def __init__(self, folder: Path, program: str = forked.PROGRAM, options: Sequence[str] = ()) -> None:
        command = [sys.executable, "-c", program, "serve", str(folder), "--no-browser", *options]
        self.process = forked.Forked(command, stdout=subprocess.PIPE, text=True)
        assert self.process.stdout
        line = next(line for line in self.process.stdout if "http://" in line).strip()
        self.address, self.home = line, line.split("/?")[0]
        jar = urllib.request.HTTPCookieProcessor()
        self.jar = jar.cookiejar
        self._opener = urllib.request.build_opener(jar)
        page = self.get(f"book/b.xlsx?{line.partition('?')[2]}")  # with the token, as any page may be opened
        self.rows = re.findall(r'<tr role="row" id="([^"]+)"', page)

    def page(self, browser: Any, address: str = "") -> Any:
        """A page in a browser that is let in."""
        context = browser.new_context(viewport={"width": 1280, "height": 800})
        context.add_cookies([{"name": c.name, "value": c.value, "url": self.home} for c in self.jar])
        page = context.new_page()
        page.goto(f"{self.home}/{address}")
        return page

    def put(self, row: int, text: str) -> bool:
        """Change a note; whether the server has acknowledged it."""
        return "rows" in self.answer(row, text)

    def answer(self, row: int, text: str, cells: int = 1) -> dict[str, object]:
        """Answer to a change of a note, or of several."""
        changed = [{"row": r, "column": NOTES, "text": text, "was": None} for r in self.rows[row : row + cells]]
        sent = {"sheet": "T", "client": "c", "name": "n", "tag": "t", "cells": changed}
        return dict(json.loads(self.post("book/b.xlsx/cells", sent)))

    def __enter__(self) -> Served:
        return self

    def __exit__(self, *_: object) -> None:
        self.process.kill()
        self.process.wait()
        assert self.process.stdout
        self.process.stdout.close()

    def post(self, address: str, sent: dict[str, object]) -> str:
        """Send JSON."""
        headers = {"Content-Type": "application/json"}
        return self.send(address, json.dumps(sent).encode(), headers)

    def post_or_refused(self, address: str, sent: dict[str, object]) -> str:
        """Answer to a request, also when it is refused."""
        try:
            return self.post(address, sent)
        except urllib.error.HTTPError as error:
            with error:
                return error.read().decode()

    def form(self, address: str, fields: dict[str, str], file: bytes = b"") -> str:
        """Send a form as our script does, perhaps with a file."""
        parts = [
            f'--x\r\nContent-Disposition: form-data; name="{n}"\r\n\r\n{v}\r\n'.encode() for n, v in fields.items()
        ]
        if file:
            head = b'--x\r\nContent-Disposition: form-data; name="file"; filename="up.xlsx"\r\n\r\n'
            parts.append(head + file + b"\r\n")
        return self.send(address, b"".join(parts) + b"--x--\r\n", {"Content-Type": "multipart/form-data; boundary=x"})

    def send(self, address: str, body: bytes, headers: dict[str, str]) -> str:
        """Change something, as our script does."""
        headers = {"X-RRP": "grid", "Origin": self.home, **headers}
        request = urllib.request.Request(f"{self.home}/{address}", body, headers)
        return str(self._opener.open(request, timeout=300).read().decode())

    def cookie(self) -> str:
        """Cookie that lets a client in."""
        return "; ".join(f"{c.name}={c.value}" for c in self.jar)

    def get(self, address: str) -> str:
        """A page."""
        return str(self._opener.open(f"{self.home}/{address}", timeout=300).read().decode())


def kill_at_random(server: Served, chance: random.Random, expected: dict[int, list[str]], round_: int) -> None:
    """Two people edit until the server is killed; `expected`: by row, what may stand there."""

    def edit(first: int) -> None:
        for count in range(10_000):
            row = first + 2 * (count % (ROWS // 2))
            text = f"{round_} {count}"
            expected[row].append(text)  # asked for: it may be there
            try:
                if server.put(row, text):
                    del expected[row][:-1]  # acknowledged: it must be there
            except (OSError, http.client.HTTPException):
                return

    people = [threading.Thread(target=edit, args=(n,)) for n in (0, 1)]
    for one in people:
        one.start()
    threading.Event().wait(chance.uniform(0.05, 1.2))
    server.process.kill()
    for one in people:
        one.join()


def check_killing(folder: Path, times: int, seed: int) -> None:
    path = make_workbook({"T": [HEADER, *[["", "", "", "", "", "start"]] * ROWS]}, folder / "b.xlsx")
    expected = {row: ["start"] for row in range(ROWS)}
    chance = random.Random(seed)
    for round_ in range(times + 1):
        with Served(folder) as server:  # comes back, and stores what it had acknowledged
            sheet = read_sheets(path)[0]
            for row, allowed in expected.items():
                text = sheet.cells[row + 2, NOTES].typed
                assert text in allowed, (round_, row, text, allowed)
                expected[row] = [text]
            assert sorted(p.name for p in folder.iterdir()) == [".rrp-sheets", "b.xlsx"]
            assert openpyxl.load_workbook(path)["T"].cell(2, NOTES).value == expected[0][0]
            if round_ < times:
                kill_at_random(server, chance, expected, round_)
    assert any(texts != ["start"] for texts in expected.values())


def test_a_server_killed_twice_loses_nothing(tmp_path: Path, office: str) -> None:
    check_killing(tmp_path, 2, seed=1)
    if shutil.which("soffice"):
        out = tmp_path / "out"
        command = [
            "soffice",
            office,
            "--headless",
            "--convert-to",
            "csv",
            "--outdir",
            str(out),
            str(tmp_path / "b.xlsx"),
        ]
        subprocess.run(command, check=True, timeout=300, capture_output=True)
        assert len((out / "b.csv").read_text().splitlines()) == ROWS + 1


@pytest.mark.soak
def test_a_server_killed_fifty_times_loses_nothing(tmp_path: Path) -> None:
    check_killing(tmp_path, 50, seed=2)


# ---- killed while it does other things


def check_whole(folder: Path, allowed: set[str]) -> None:
    """The workbooks can be read, and nothing half is left; `allowed`: what the first note may be."""
    for path in folder.glob("*.xlsx"):
        assert str(openpyxl.load_workbook(path)["T"].cell(2, NOTES).value) in allowed
    names = {p.name for p in folder.iterdir()} - {".rrp-sheets", "b.xlsx", "up.xlsx", "archive"}
    assert not names, names


@pytest.mark.slow
@pytest.mark.parametrize("times", [1, pytest.param(10, marks=pytest.mark.soak)])
def test_a_server_killed_while_a_version_comes_back_or_a_file_is_uploaded(times: int, tmp_path: Path) -> None:
    rows = [["", "", "", "", "", "start"]] * ROWS
    path = make_workbook({"T": [HEADER, *rows]}, tmp_path / "b.xlsx")
    upload = path.read_bytes()
    chance = random.Random(3)
    with Served(tmp_path) as server:
        server.form("book/b.xlsx/versions/keep", {"title": "the first"})
        assert server.put(0, "changed")
    for _ in range(times):
        with Served(tmp_path) as server:
            check_whole(tmp_path, {"start", "changed"})

            def restore(server: Served = server) -> None:
                with suppress(OSError, http.client.HTTPException):
                    while True:
                        server.form("book/b.xlsx/versions/restore", {"version": "1"})
                        server.put(0, "changed")

            def shelve(server: Served = server) -> None:
                with suppress(OSError, http.client.HTTPException):
                    while True:
                        server.form("shelf/upload", {}, upload)
                        server.form("shelf/archive", {"book": "up.xlsx"})

            people = [threading.Thread(target=one) for one in (restore, shelve)]
            for one in people:
                one.start()
            threading.Event().wait(chance.uniform(0.1, 0.9))
            server.process.kill()
            for one in people:
                one.join()
    with Served(tmp_path) as server:
        server.get("")
        check_whole(tmp_path, {"start", "changed"})
        assert "the first" in server.get("book/b.xlsx/versions")


@pytest.mark.slow
def test_a_server_killed_during_a_run_leaves_a_record_that_can_be_read(tmp_path: Path, browser: Any) -> None:
    rows = [["", "Red ball", "map", "redBall.x", "X", ""], ["", "X", "subscribe", "", "Say", ""]]
    make_workbook({"T": [HEADER, *rows]}, tmp_path / "b.xlsx")
    with Served(tmp_path) as server:
        asked = {"client": "c", "name": "n", "mode": "simulated", "until": "stop", "speed": 1}
        wait_for(lambda: "where" in server.post_or_refused("book/b.xlsx/run/start", asked))
        wait_for(lambda: list(tmp_path.glob("runs/*/trace.jsonl")) and trace_of(tmp_path).count("\n") > 30)
        page = server.page(browser, "book/b.xlsx/run")
        page.wait_for_selector("body[data-run=running]")
        expect(page.locator("#run-phase")).to_have_text("Running")
        server.process.kill()
        server.process.wait()
        # whether it still runs cannot be known, nothing is offered that cannot work, and it is said what happens
        expect(page.locator("#run-phase")).to_have_text("Not known")
        expect(page.locator("#run-notice")).to_contain_text("the robot moves to its rest position by itself")
        becomes(
            lambda: page.locator("[data-run=pause]:enabled, #mark button:enabled, #things button:enabled").count(), 0
        )
        page.click("[data-run=stop]")
        expect(page.locator("#run-problem")).to_contain_text("This page has no connection to the program.")
        run = next(tmp_path.glob("runs/*"))
        wait_for(lambda: '"summary"' in trace_of(tmp_path).splitlines()[-1])
    with Served(tmp_path) as server:
        assert "b.xlsx" in server.get("runs")
        page = server.get(f"runs/{run.name}")
        assert "stopped because the program that started it ended" in page
        assert "cannot be read" not in page and server.get(f"runs/{run.name}/trace.csv").count("\n") > 10


def trace_of(folder: Path) -> str:
    return next(folder.glob("runs/*/trace.jsonl")).read_text(encoding="utf-8")


def wait_for(holds: Callable[[], object], seconds: float = 60) -> None:
    """Wait until something holds."""
    deadline = time.monotonic() + seconds
    while not holds():
        assert time.monotonic() < deadline
        threading.Event().wait(0.1)
